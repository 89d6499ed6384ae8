"""One socket of a port: bytes in and out, and nothing waits."""

import select
import socket
from contextlib import suppress
from time import monotonic

from skinfield.errors import InputError
from skinfield.protocols.yarp.carriers import HEADER, Carrier, greeting, message
from skinfield.protocols.yarp.messages import yarp_number
from skinfield.protocols.yarp.session import Output, Session

PIECE = 65536  # bytes read at once
GOODBYE = 0.5  # s for the last bytes of a connection
CONNECT = 2.0  # s for a connection to another port
SILENT = 30.0  # s that a party may take to say who it is
BEHIND = 1 << 22  # bytes that wait to be sent, at which a connection is given up


class Connection:
    """One socket of a port, that another party opened, or that we did."""

    def __init__(self, sock: socket.socket, session: Session | None, output: Output | None) -> None:
        sock.setblocking(False)
        with suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket, self.session, self._own = sock, session, output
        self._out = bytearray()
        self._began = monotonic()
        self.gone = False

    @property
    def output(self) -> Output | None:
        """Set where the other side reads from us."""
        return self._own if self.session is None else self.session.output

    @property
    def free(self) -> bool:
        """Whether another message may go out."""
        return not self._out and self.output is not None and self.output.free

    @property
    def silent(self) -> bool:
        """Whether it never said who it is, and had the time to."""
        unknown = self.session is not None and not self.session.welcomed
        return unknown and monotonic() - self._began > SILENT

    @property
    def waits(self) -> bool:
        """Whether something is to be sent."""
        return bool(self._out)

    def receive(self) -> None:
        """Take in what came, and send what is to be answered."""
        try:
            data = self.socket.recv(PIECE)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if not data:
            self.gone = True
        elif self.session is None:
            self._acknowledged(data)
        else:
            self.session.take(data)
            self.send(bytes(self.session.answer))
            self.session.answer.clear()
            self.gone = self.gone or (self.session.done and not self._out)

    def _acknowledged(self, data: bytes) -> None:
        assert self._own is not None
        try:
            self._own.take(data)
        except InputError:
            self.gone = True

    def send(self, data: bytes) -> None:
        """Send, as far as it goes now; the rest goes before the next."""
        self._out += data
        try:
            while self._out:
                del self._out[: self.socket.send(self._out)]
        except (BlockingIOError, InterruptedError):
            self.gone = self.gone or len(self._out) > BEHIND
        except OSError:
            self.gone = True

    def close(self) -> None:
        """Say goodbye to a reader, and close."""
        output = self.output
        if output is not None and not self.gone:
            self.send(message(output.carrier, "q"))
            end = monotonic() + GOODBYE
            while self._out and not self.gone and monotonic() < end:
                select.select([], [self.socket], [], 0.05)
                self.send(b"")
        self.socket.close()


def connected(carrier: Carrier, own: str, name: str, place: tuple[str, int]) -> Connection:
    """A connection to another port, welcomed by it.

    Raises
    ------
    OSError
        If it is not there, or does not answer in time.
    """
    sock = socket.create_connection(place, CONNECT)
    try:
        sock.sendall(greeting(carrier, own))
        output = Output(carrier, name)
        if carrier.is_text:
            if carrier.acknowledges:
                _line(sock)
        else:
            said = sock.recv(HEADER, socket.MSG_WAITALL)
            if yarp_number(said) is None:
                raise OSError(f"it answered {said!r}, expected eight bytes of YARP")
    except BaseException:
        sock.close()
        raise
    return Connection(sock, None, output)


def _line(sock: socket.socket) -> None:
    """Wait for the end of a line."""
    for _ in range(2048):
        if sock.recv(1) in (b"\n", b""):
            return
    raise OSError("it answered more than a line, expected a welcome")
