"""Output port of YARP on sockets: readers connect to it, and it to readers when asked to.

One thread, and nothing waits but for the two things that `yarp connect` asks of a port: where the
other port is, and a connection to it; both have a time limit. A reader that has not taken, or not
acknowledged, the message before gets the next one after it: newest wins, the others are counted.
Who connects speaks text, as YARP's own tools do to ports that they administer.

The receiver's side of a connection is as in YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl`:
`Protocol.cpp` (`expectHeader`), `PortCoreInputUnit.cpp` (port commands) and `PortCore.cpp`
(`adminBlock`). The words of the answers are those that YARP's own tools look at.
"""

import select
import socket
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from time import monotonic

from skinfield.errors import InputError
from skinfield.wire.yarp.bottle import Value, Vocab, text_from_bottle, word_of
from skinfield.wire.yarp.carriers import (
    ACK,
    HEADER,
    HEADERS,
    LONGEST,
    LONGEST_NAME,
    Acknowledgements,
    Carrier,
    Lines,
    Messages,
    carrier_named,
    checked_name,
    greeting,
    line,
    message,
    yarp_number,
)
from skinfield.wire.yarp.name_server import NameServer

MOST = 64  # connections
PIECE = 65536  # bytes read at once
GOODBYE = 0.5  # s for the last bytes of a connection
CONNECT = 2.0  # s for a connection to another port
SILENT = 30.0  # s that a party may take to say who it is
BEHIND = 1 << 22  # bytes that wait to be sent, at which a connection is given up
UNKNOWN = b"* Error. Protocol not found.\r\n* Try CONNECT and a name.\r\n"
VERSION: list[Value] = [Vocab("ver"), 1, 2, 3]  # of the administrative commands


@dataclass(eq=False)
class Output:
    """Readings that go out over one connection: at most one message that is not acknowledged.

    Attributes
    ----------
    carrier : Carrier
    name : str
        Of the reader.
    unread : int
        Messages that were sent and not acknowledged.
    """

    carrier: Carrier
    name: str
    unread: int = 0
    _acknowledged: Acknowledgements = field(init=False)

    def __post_init__(self) -> None:
        self._acknowledged = Acknowledgements(self.carrier)

    def take(self, data: bytes) -> None:
        """Take in what the reader says."""
        self.unread = max(self.unread - self._acknowledged.feed(data), 0)


class Session:
    """What one party says to a port, and what is answered.

    Parameters
    ----------
    port : Port

    Attributes
    ----------
    peer : str
        Name that the party gave; empty until then.
    output : Output or None
        Set once the party became a reader.
    ended : bool
        Whether the connection is to be closed, when what is in `answer` was sent.
    answer : bytearray
        Bytes to send; whoever sends them takes them out.
    """

    def __init__(self, port: "Port") -> None:
        self._port = port
        self._head = b""
        self._lines = Lines(LONGEST_NAME)
        self._messages = Messages(self._lines)
        self._carrier: Carrier | None = None
        self.peer = ""
        self.output: Output | None = None
        self.ended = False
        self.answer = bytearray()

    def take(self, data: bytes) -> None:
        """Take in what came; never raises for what a party says."""
        try:
            if self.output is not None:
                self.output.take(data)
            elif self._carrier is None:
                self._open(data)
            else:
                self._listen(data)
        except InputError as error:
            self.ended = True
            self.answer += line(str(error))

    def _open(self, data: bytes) -> None:
        """Wait for the eight bytes of a carrier."""
        self._head += data
        if len(self._head) < HEADER:
            return
        for carrier in (Carrier.TEXT, Carrier.TEXT_ACK):
            if self._head.startswith(HEADERS[carrier]):
                self._carrier = carrier
                self._listen(self._head[HEADER:])
                return
        self.answer += UNKNOWN
        self.ended = True

    def _listen(self, data: bytes) -> None:
        """Obey the messages behind the party's name, which comes first."""
        assert self._carrier is not None
        self._lines.feed(data)
        if not self.peer:
            name = self._lines.take()
            if name is None:
                return
            self.peer, self._lines.most = name.strip(), LONGEST
            checked_name(self.peer)
            self.answer += line(f"Welcome {self.peer}")
        for each in self._messages:
            if each.command.startswith("q"):
                self.ended = True
                return
            self._obey(each.command[:1], each.values)
            if self._carrier.acknowledges:
                self.answer += line(ACK)
            if self.output is not None:
                return

    def _obey(self, letter: str, values: Sequence[Value]) -> None:
        if letter == "a":
            self.answer += line(text_from_bottle(self._administered(values)))
        elif letter == "r":
            assert self._carrier is not None
            self.output = Output(self._carrier, self.peer)
        elif letter not in ("d", "D"):  # data has no taker here
            self.answer += line("Port command not understood.")

    def _administered(self, values: Sequence[Value]) -> list[Value]:
        command, first, second = ([word_of(value) for value in values] + [""] * 3)[:3]
        if command == "ver":
            return VERSION
        if command == "list":
            return self._listed(first, second)
        if command == "add":
            outcome = self._port.add(f"{second}:/{first}" if second else first)
            return [0 if outcome.startswith("Added") else -1, outcome]
        if command == "del":
            outcome = self._port.remove(first)
            return [0 if outcome.startswith("Removed") else -1, outcome]
        return [Vocab("fail"), "expected [ver], [add], [del] or [list]"]

    def _listed(self, direction: str, name: str) -> list[Value]:
        there = {} if direction == "in" else self._port.outputs
        if not name:
            return list(there)
        if name not in there:
            return []
        return [["from", self._port.name], ["to", name], ["carrier", there[name]]]


class Connection:
    """One socket of a port, that another party opened (`session`), or that we did (`output`)."""

    def __init__(self, sock: socket.socket, session: Session | None, output: Output | None) -> None:
        sock.setblocking(False)
        with suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket, self._session, self._own = sock, session, output
        self._out = bytearray()
        self._began = monotonic()
        self.gone = False

    @property
    def output(self) -> Output | None:
        """Set where the other side reads from us."""
        return self._own if self._session is None else self._session.output

    @property
    def silent(self) -> bool:
        """Whether it never said who it is, and had the time to."""
        unknown = self._session is not None and not self._session.peer
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
        elif self._session is not None:
            self._session.take(data)
            self.send(bytes(self._session.answer))
            self._session.answer.clear()
        elif self._own is not None:
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
        if self._session is not None and self._session.ended and not self._out:
            self.gone = True

    def close(self) -> None:
        """Say goodbye to a reader, and close."""
        if self.output is not None and not self.gone:
            self.send(message(self.output.carrier, "q"))
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
        if carrier == Carrier.TEXT_ACK:
            with sock.makefile("rb") as answers:
                answers.readline(PIECE)
        elif carrier == Carrier.TCP:
            answer = sock.recv(HEADER, socket.MSG_WAITALL)
            if yarp_number(answer) is None:
                raise OSError(f"it answered {answer!r}, expected eight bytes of YARP")
    except BaseException:
        sock.close()
        raise
    return Connection(sock, None, Output(carrier, name))


class Port:
    """See above.

    Parameters
    ----------
    name : str
        Of the port, as /skinfield/left_arm/skin_events:o.
    host : str
        Address to listen at; empty for all of this machine.
    socket_port : int
        0: any that is free.
    server : NameServer, optional
        That gets to know of the port, and is asked for others.

    Attributes
    ----------
    skipped : int
        Messages that a reader did not get because it had not taken the one before.

    Raises
    ------
    InputError
        If the name cannot be used, or the address is taken.
    """

    def __init__(
        self,
        name: str,
        host: str = "",
        socket_port: int = 0,
        server: NameServer | None = None,
    ) -> None:
        checked_name(name)
        self.name, self.server = name, server
        self.skipped = self.sent = 0
        self._connections: list[Connection] = []
        try:
            self._listener = socket.create_server((host, socket_port), backlog=MOST)
        except OSError as error:
            raise InputError(
                f"port {name} cannot listen at {host or 'any address'}:{socket_port}: {error}, "
                "expected an address of this machine that is free"
            ) from None
        self._listener.setblocking(False)
        self.host = host
        self.socket_port: int = self._listener.getsockname()[1]

    def register(self) -> None:
        """Tell the name server where the port is.

        Raises
        ------
        InputError
            If it does not answer, or does not know the port afterwards.
        """
        if self.server is None:
            return
        machine = self.host if self.host not in ("", "0.0.0.0", "::") else "..."  # as it sees us
        there = self.server.ask(self.name, "register", self.name, "tcp", machine, self.socket_port)
        if there.registration is None:
            raise InputError(
                f"name server at {self.server.host}:{self.server.port} did not take {self.name}: "
                f"it said {there.lines!r:.200}, expected a registration"
            )
        for key in ("offers", "accepts"):
            self.server.ask(self.name, "set", self.name, key, *(each.value for each in Carrier))

    def unregister(self) -> None:
        """Tell the name server that the port is gone."""
        if self.server is not None:
            self.server.ask(self.name, "unregister", self.name)

    def step(self, timeout: float = 0.0) -> None:
        """Listen and answer; waits for something to do, `timeout` s at most."""
        waiting = [each.socket for each in self._connections if each.waits]
        sockets = [self._listener, *(each.socket for each in self._connections)]
        ready, writable, _ = select.select(sockets, waiting, [], timeout)
        for each in self._connections:
            if each.socket in writable:
                each.send(b"")
            if each.socket in ready and not each.gone:
                each.receive()
        if self._listener in ready:
            with suppress(OSError):
                sock, _ = self._listener.accept()
                if len(self._connections) < MOST:
                    self._connections.append(Connection(sock, Session(self), None))
                else:
                    sock.close()
        for each in [each for each in self._connections if each.gone or each.silent]:
            self._connections.remove(each)
            each.close()

    def write(self, values: Sequence[Value], stamp: str = "") -> int:
        """Send a bottle to all readers that are free; how many got it.

        Parameters
        ----------
        values : sequence of values
        stamp : str
            Of `carriers.envelope`.
        """
        made: dict[bool, bytes] = {}
        command, count = f"D {stamp}" if stamp else "D", 0
        for each in self._connections:
            output = each.output
            if output is None or each.gone:
                continue
            if each.waits or output.unread:
                self.skipped += 1
                continue
            is_text = output.carrier.is_text
            if is_text not in made:
                made[is_text] = message(output.carrier, command, values)
            output.unread += output.carrier.acknowledges
            each.send(made[is_text])
            count += 1
        self.sent += count
        return count

    @property
    def readers(self) -> int:
        """How many read from it."""
        return sum(each.output is not None for each in self._connections)

    @property
    def outputs(self) -> Mapping[str, str]:
        """Carriers by the names of the readers."""
        outputs = [each.output for each in self._connections]
        return {output.name: output.carrier.value for output in outputs if output is not None}

    def add(self, wanted: str) -> str:
        """Send to another port from now on; the outcome, which begins with "Added" if that is so.

        The name server says where the other port is.
        """
        carrier_name, _, name = wanted.rpartition(":/")
        name = name if carrier_name else wanted
        try:
            carrier = carrier_named(carrier_name or Carrier.TCP.value)
            if self.server is None:
                return f"Do not know how to connect to {wanted}: there is no name server"
            there = self.server.where(self.name, name)
            if there is None:
                return f"Do not know how to connect to {wanted}"
            self.remove(name)
            connection = connected(carrier, self.name, name, (there.host, there.port))
        except (InputError, OSError) as error:
            return f"Cannot connect to {wanted}: {error}"
        self._connections.append(connection)
        return f"Added connection from {self.name} to {wanted}"

    def remove(self, name: str) -> str:
        """Send to a port no more; the outcome, which begins with "Removed" if that is so."""
        for each in self._connections:
            if each.output is not None and each.output.name == name and not each.gone:
                self._connections.remove(each)
                each.close()
                return f"Removed connection from {self.name} to {name}"
        return f"Could not find an outgoing connection to {name}"

    def close(self) -> None:
        """Say goodbye to all readers and let go; `unregister` is for the name server."""
        for each in self._connections:
            each.close()
        self._connections.clear()
        self._listener.close()
