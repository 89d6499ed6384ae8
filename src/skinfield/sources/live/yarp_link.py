"""A connection to a port of YARP that sends: asked for, turned round, and never waited for.

The steps are those of YARP's own page "YARP without YARP": ask the name server where the port is,
connect there, say ``CONNECT`` and a name, be welcomed, say ``r``; from then on the port sends us
what it sends to all its readers.
"""

import errno
import os
import select
import socket
from collections.abc import Sequence
from enum import IntEnum
from time import monotonic

from skinfield.acquisition.block import Octets
from skinfield.errors import InputError
from skinfield.protocols.yarp import Answer, Carrier, greeting, message
from skinfield.protocols.yarp.messages import Lines
from skinfield.protocols.yarp.name_server import query, request
from skinfield.sources.buses.udp_sockets import Place, let_go, resolved
from skinfield.sources.live.packet_tcp import PATIENCE, watch_over

PIECE = 4096  # bytes
WELCOME = 1 << 16  # bytes of a line, at most


class Step(IntEnum):
    """How far a connection is."""

    NOTHING = 0
    ASKING = 1  # connecting to the name server, or waiting for its answer
    CONNECTING = 2
    GREETING = 3  # waiting to be welcomed
    READING = 4


class YarpLink:
    """One port that we read from.

    Parameters
    ----------
    port : str
        Of its name, to be asked for; or of its socket, as ``192.0.2.7:10012``.
    place : Place
        Of the name server, or of the socket.
    own : str
        Name that we give.
    """

    def __init__(self, port: str, place: Place, own: str) -> None:
        self._port, self._place, self._own = port, place, own
        self._socket: socket.socket | None = None
        self._poll = select.poll()
        self._step, self._begun = Step.NOTHING, 0.0
        self._answer, self._lines, self._rest = Answer(), Lines(WELCOME), b""
        self._to_send = b""
        self.fault = ""
        self.reopen()

    @property
    def up(self) -> bool:
        """Whether the port welcomed us."""
        return self._step == Step.READING

    def reopen(self) -> bool:
        """Begin to connect, unless that goes on already."""
        if self._step != Step.NOTHING and monotonic() - self._begun < PATIENCE:
            return self.advance()
        late = self._step != Step.NOTHING
        self.close()
        if late:
            self.fault = f"{self._port}: no answer within {PATIENCE:g} s"
        self._begun = monotonic()
        if self._port.startswith("/"):
            self._connect(self._place, Step.ASKING, request(query(self._port), self._own))
        else:
            self._greet(self._place)
        return self.advance()

    def _greet(self, place: Place) -> None:
        hello = greeting(Carrier.TEXT, self._own) + message(Carrier.TEXT, "r")
        self._connect(place, Step.CONNECTING, hello)

    def _connect(self, place: Place, step: Step, to_send: bytes) -> None:
        let_go(self._socket)
        self._socket = None
        try:
            sock = socket.socket(place.family, socket.SOCK_STREAM)
        except OSError as error:
            self._broke(error.strerror or str(error))
            return
        sock.setblocking(False)
        watch_over(sock)
        self._socket, self._step, self._to_send = sock, step, to_send
        self._poll = select.poll()
        self._poll.register(sock, select.POLLOUT)
        self.fault = self.fault or f"{self._port}: connecting"
        code = sock.connect_ex(place.address)
        if code not in (0, errno.EINPROGRESS):
            self._broke(os.strerror(code))

    def advance(self) -> bool:
        """Go on as far as it goes without waiting; whether it is up."""
        before = Step.NOTHING
        while self._step not in (before, Step.NOTHING, Step.READING):
            before = self._step
            if self._to_send and not self._is_connected():
                break
            data = self._received()
            if data and self._step == Step.ASKING:
                self._answered(data)
            elif self._step in (Step.CONNECTING, Step.GREETING):
                self._step = Step.GREETING
                self._welcomed(data)
        return self.up

    def settle(self, end: float) -> None:
        """Wait until it is up or has failed, but not beyond `end` of the monotonic clock."""
        while self._step not in (Step.NOTHING, Step.READING) and (left := end - monotonic()) > 0:
            assert self._socket is not None
            poll = select.poll()
            poll.register(self._socket, select.POLLOUT if self._to_send else select.POLLIN)
            poll.poll(1e3 * left)
            self.advance()

    def _is_connected(self) -> bool:
        """Whether the connection is there; then what is to be said first was sent."""
        if self._socket is None or not self._poll.poll(0):
            return False
        code = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            self._broke(os.strerror(code))
            return False
        self.send(self._to_send)  # some bytes into an empty buffer: all of them
        self._to_send = b""
        return self._socket is not None

    def _received(self) -> bytes:
        if self._socket is None:
            return b""
        try:
            data = self._socket.recv(PIECE)
        except (BlockingIOError, InterruptedError):
            return b""
        except OSError as error:
            self._broke(error.strerror or str(error))
            return b""
        if not data:
            asked = self._step == Step.ASKING
            self._broke("the name server closed the connection" if asked else "it was closed")
        return data

    def _answered(self, data: bytes) -> None:
        """Go on with where the port is, as the name server says it."""
        try:
            if not self._answer.feed(data):
                return
            there = self._answer.registration
            if there is None:
                self._broke("the name server does not know it: is it open, see `yarp name list`")
                return
            place = resolved(there.host, there.port, "host of the port")
        except InputError as error:
            self._broke(str(error))
            return
        self._greet(place)

    def _welcomed(self, data: bytes) -> None:
        """Wait for a line that begins with Welcome; what follows it are readings."""
        try:
            self._lines.feed(data)
            line = self._lines.take()
        except InputError as error:
            self._broke(str(error))
            return
        if line is None:
            return
        if not line.startswith("Welcome"):
            self._broke(f"it said {line!r:.60}, expected a welcome: is it a port of YARP?")
            return
        self._rest = self._lines.rest()
        self._step, self.fault = Step.READING, ""

    def receive(self, into: Octets) -> int:
        """Write what has arrived, as far as there is room; how many bytes. Never waits."""
        if not self.up:
            self.advance()  # what it brings is read once all know that it is up
            return 0
        if self._rest:
            count = min(len(self._rest), len(into))
            into[:count] = memoryview(self._rest)[:count]
            self._rest = self._rest[count:]
            return count
        assert self._socket is not None
        try:
            count = self._socket.recv_into(into.data)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            return self._broke(error.strerror or str(error))
        return count or self._broke("it was closed")

    def send(self, data: bytes) -> None:
        """Send a few bytes."""
        if self._socket is not None:
            try:
                self._socket.send(data)
            except (BlockingIOError, InterruptedError):
                return
            except OSError as error:
                self._broke(error.strerror or str(error))

    def ended(self) -> None:
        """Note that the port said goodbye."""
        self._broke("the port was closed")

    def _broke(self, why: str) -> int:
        self.close()
        self.fault = f"{self._port}: {why}"
        return 0

    def filenos(self) -> Sequence[int]:
        """Of the socket, once readings can come."""
        return (self._socket.fileno(),) if self._socket is not None and self.up else ()

    def close(self) -> None:
        """Let go of the connection."""
        let_go(self._socket)
        self._socket, self._step, self._to_send = None, Step.NOTHING, b""
        self._answer, self._lines, self._rest = Answer(), Lines(WELCOME), b""
