"""Port of YARP on sockets: others connect to it, and it connects to others when asked to.

One thread, and nothing waits but for the two things that `yarp connect` asks of a port: where the
other port is, and a connection to it; both have a time limit. A reader that has not taken, or not
acknowledged, the message before gets the next one after it: newest wins, the others are counted.

The receiver's side of a connection is as in YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl`:
`Protocol.cpp` (`expectHeader`), `PortCoreInputUnit.cpp` (port commands) and `PortCore.cpp`
(`adminBlock`). The words of the answers are those that YARP's own tools look at.
"""

import select
import socket
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from time import monotonic

from skinfield.errors import InputError
from skinfield.wire.yarp.bottle import Value, Vocab, to_octets, word_of
from skinfield.wire.yarp.carriers import (
    HEADER,
    LINE_END,
    LONGEST_NAME,
    Acknowledgements,
    Carrier,
    Lines,
    Message,
    Messages,
    acknowledgement,
    carrier_from_header,
    carrier_named,
    checked_name,
    greeting,
    message,
    messages_of,
    reply,
    welcome,
    yarp_number,
)
from skinfield.wire.yarp.name_server import NameServer, query, register, set_property, unregister

MOST = 64  # connections
PIECE = 65536  # bytes read at once
GOODBYE = 0.5  # s for the last bytes of a connection
CONNECT = 2.0  # s for a connection to another port
SILENT = 30.0  # s that a party may take to say who it is
BEHIND = 1 << 22  # bytes that wait to be sent, at which a connection is given up
UNKNOWN = b"* Error. Protocol not found.\r\n* Try CONNECT and a name.\r\n"
NOT_UNDERSTOOD = ("Port command not understood.",)
VERSION: tuple[Value, ...] = (Vocab("ver"), 1, 2, 3)  # of the administrative commands


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
    acknowledged: Acknowledgements = field(init=False)

    def __post_init__(self) -> None:
        self.acknowledged = Acknowledgements(self.carrier)

    @property
    def free(self) -> bool:
        """Whether another message may be sent."""
        return not self.unread

    def sent(self) -> None:
        """Note that a message was sent."""
        self.unread += self.carrier.acknowledges

    def take(self, data: bytes) -> None:
        """Take in what the reader says."""
        self.unread = max(self.unread - self.acknowledged.feed(data), 0)


class Session:
    """What one party says to a port, and what is answered.

    Parameters
    ----------
    port : Port

    Attributes
    ----------
    carrier : Carrier or None
        None until its eight bytes are there.
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
        self._head = bytearray()
        self._messages: Messages | None = None
        self.carrier: Carrier | None = None
        self.peer = ""
        self.output: Output | None = None
        self.ended = False
        self.answer = bytearray()

    @property
    def welcomed(self) -> bool:
        """Whether the party said who it is."""
        return self._messages is not None

    def take(self, data: bytes) -> None:
        """Take in what came; never raises for what a party says."""
        try:
            if self.output is not None:
                self.output.take(data)
            elif self._messages is None:
                self._open(data)
            else:
                self._listen(data)
        except InputError as error:
            self.ended = True
            if self.carrier is not None and self.carrier.is_text:
                self.answer += to_octets(f"{error}") + LINE_END

    def _open(self, data: bytes) -> None:
        """Wait for the header and the name, then welcome the party."""
        self._head += data
        if self.carrier is None and len(self._head) >= HEADER:
            self.carrier = carrier_from_header(bytes(self._head[:HEADER]))
            if self.carrier is None:
                self.answer += UNKNOWN
                self.ended = True
                return
        if self.carrier is None:
            return
        parsed = name_behind_header(self.carrier, bytes(self._head[HEADER:]))
        if parsed is None:
            return
        self.peer, rest = parsed
        self.answer += welcome(self.carrier, self.peer, self._port.socket_port)
        self._messages = messages_of(self.carrier)
        self._listen(rest)

    def _listen(self, data: bytes) -> None:
        assert self._messages is not None
        assert self.carrier is not None
        self._messages.feed(data)
        for each in self._messages:
            self._obey(each)
            if each.command[:1] == "q":
                self.ended = True
                return
            self.answer += acknowledgement(self.carrier)
            if self.output is not None:
                self.output.take(self._messages.rest())
                return

    def _obey(self, message: Message) -> None:
        """As a port command says; those that are none are answered with how to get help."""
        letter, command = message.command[:1], message.command
        if letter == "a":
            self._put(*self._administer(message.values))
        elif letter == "r":
            assert self.carrier is not None
            self.output = Output(self.carrier, self.peer)
        elif letter not in ("d", "D", "q"):  # data has no taker here
            self._put_lines(self._lines_for(letter, command))

    def _lines_for(self, letter: str, command: str) -> Sequence[str]:
        if letter == "/":
            return (self._port.add(command),)
        if letter == "!":
            return (self._port.remove(command[1:]),)
        if letter == "~":
            return (f"Could not find an incoming connection from {command[1:]}",)
        return self._port.describe() if letter == "*" else NOT_UNDERSTOOD

    def _put_lines(self, lines: Sequence[str]) -> None:
        """Lines for people, of whom those with the tcp carrier get none."""
        if self.carrier is not None and self.carrier.is_text:
            self.answer += b"".join(to_octets(line) + LINE_END for line in lines)

    def _put(self, *values: Value) -> None:
        assert self.carrier is not None
        self.answer += reply(self.carrier, values)

    def _administer(self, values: Sequence[Value]) -> Sequence[Value]:
        words = [word_of(value) for value in values]
        commands: dict[str, Callable[[list[str]], Sequence[Value]]] = {
            "ver": lambda _: VERSION,
            "add": self._add,
            "del": self._remove,
            "list": self._list,
        }
        known = commands.get(words[0]) if words else None
        if known is None:
            return (Vocab("fail"), "expected [ver], [add], [del] or [list]")
        return known(words[1:])

    def _add(self, words: list[str]) -> Sequence[Value]:
        wanted = words[0] if words else ""
        if len(words) > 1 and words[1]:
            wanted = f"{words[1]}:/{wanted}"
        outcome = self._port.add(wanted)
        return (0 if outcome.startswith("Added") else -1, outcome)

    def _remove(self, words: list[str]) -> Sequence[Value]:
        outcome = self._port.remove(words[0] if words else "")
        return (0 if outcome.startswith("Removed") else -1, outcome)

    def _list(self, words: list[str]) -> Sequence[Value]:
        direction = words[0] if words else ""
        there = self._port.connections(direction != "in")
        if len(words) < 2 or not words[1]:
            return tuple(there)
        if words[1] not in there:
            return ()
        ends = [self._port.name, words[1]][:: 1 if direction != "in" else -1]
        return (["from", ends[0]], ["to", ends[1]], ["carrier", there[words[1]]])


def name_behind_header(carrier: Carrier, data: bytes) -> tuple[str, bytes] | None:
    """Name that a party gives, and what comes after it; None if it is not complete.

    Raises
    ------
    InputError
        If it is too long.
    """
    if carrier.is_text:
        lines = Lines(LONGEST_NAME)
        lines.feed(data)
        line = lines.take()
        return None if line is None else (line.strip(), lines.rest())
    size = int.from_bytes(data[:4], "little", signed=True)
    if len(data) < 4 or not 0 < size <= LONGEST_NAME or len(data) < 4 + size:
        if len(data) >= 4 and not 0 < size <= LONGEST_NAME:
            raise InputError(f"name has {size} bytes, expected 1 to {LONGEST_NAME}")
        return None
    name = data[4 : 4 + size].rstrip(b"\0").decode("utf-8", "surrogateescape")
    return name, data[4 + size :]


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
            self.gone = self.gone or (self.session.ended and not self._out)

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
            answer = sock.recv(HEADER, socket.MSG_WAITALL)
            if yarp_number(answer) is None:
                raise OSError(f"it answered {answer!r}, expected eight bytes of YARP")
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
        That is told of the port, and asked for others.

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
        machine = self.host if self.host not in ("", "0.0.0.0", "::") else "..."
        there = self.server.request(register(self.name, machine, self.socket_port), self.name)
        if there.registration is None:
            raise InputError(
                f"name server at {self.server.host}:{self.server.port} did not take {self.name}: "
                f"it said {there.lines!r:.200}, expected a registration"
            )
        names = [each.value for each in Carrier]
        for key in ("offers", "accepts"):
            self.server.request(set_property(self.name, key, *names), self.name)

    def unregister(self) -> None:
        """Tell the name server that the port is gone."""
        if self.server is not None:
            self.server.request(unregister(self.name), self.name)

    def filenos(self) -> list[int]:
        """Sockets that become readable when something is said."""
        return [self._listener.fileno(), *(each.socket.fileno() for each in self._connections)]

    def step(self, timeout: float = 0.0) -> None:
        """Listen and answer; waits for something to do, `timeout` s at most."""
        waiting = [each.socket for each in self._connections if each.waits]
        sockets = [self._listener, *(each.socket for each in self._connections)]
        ready, writable, _ = select.select(sockets, waiting, [], timeout)
        for each in self._connections:
            if each.socket in writable:
                each.send(b"")
                each.gone = each.gone or (
                    each.session is not None and each.session.ended and not each.waits
                )
        for each in list(self._connections):
            if each.socket in ready and not each.gone:
                each.receive()
        if self._listener in ready:
            self._accept()
        self._drop_gone()

    def _accept(self) -> None:
        with suppress(OSError):
            sock, _ = self._listener.accept()
            if len(self._connections) >= MOST:
                sock.close()
                return
            self._connections.append(Connection(sock, Session(self), None))

    def _drop_gone(self) -> None:
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
            if not each.free:
                self.skipped += 1
                continue
            is_text = output.carrier.is_text
            if is_text not in made:
                made[is_text] = message(output.carrier, command, values)
            output.sent()
            each.send(made[is_text])
            count += 1
        self.sent += count
        return count

    @property
    def readers(self) -> int:
        """How many read from it."""
        return sum(each.output is not None for each in self._connections)

    def describe(self) -> list[str]:
        """Lines about its connections."""
        lines = [f"This is {self.name} at tcp://{self.host or '0.0.0.0'}:{self.socket_port}/"]
        for outgoing, what in ((True, "output"), (False, "input")):
            for name, carrier in self.connections(outgoing).items():
                ends = (self.name, name) if outgoing else (name, self.name)
                lines.append(
                    f"There is an {what} connection from {ends[0]} to {ends[1]} using {carrier}"
                )
            if not self.connections(outgoing):
                lines.append(f"There are no {'outgoing' if outgoing else 'incoming'} connections")
        return lines

    def connections(self, outgoing: bool) -> Mapping[str, str]:
        """Carriers by the names of the ports that it sends to, or that are connected to it."""
        if outgoing:
            outputs = [each.output for each in self._connections if each.output is not None]
            return {output.name: output.carrier.value for output in outputs}
        sessions = [each.session for each in self._connections if each.output is None]
        return {
            session.peer: session.carrier.value
            for session in sessions
            if session is not None and session.carrier is not None and session.peer
        }

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
            there = self.server.request(query(name), self.name).registration
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
        """Say goodbye to all readers and let go; the name server is told by `unregister`."""
        for each in self._connections:
            each.close()
        self._connections.clear()
        self._listener.close()
