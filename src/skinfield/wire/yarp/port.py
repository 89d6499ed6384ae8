"""Output port of YARP on sockets, to which readers connect, and a client of its name server.

One thread, and nothing waits but for the two things that `yarp connect` asks of a port: where the
other port is, and a connection to it; both have a time limit. A reader that has not taken, or not
acknowledged, the message before gets the next one after it: newest wins, the others are counted.
Who connects speaks text, as YARP's own tools do to ports that they administer.

The receiver's side of a connection is as in YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl`:
`Protocol.cpp` (`expectHeader`), `PortCoreInputUnit.cpp` (port commands) and `PortCore.cpp`
(`adminBlock`). The words of the answers are those that YARP's own tools look at. Where ports are
the name server knows: `doc/020_nameserver_and_protocols/name_server.dox` and, for the bytes of its
answers, `src/libYARP_name/src/yarp/name/NameServerConnectionHandler.h`. It is a port: a request is
data to it, and lines come back, of which the last is ``*** end of message``.
"""

import select
import socket
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from time import monotonic

from skinfield.errors import InputError
from skinfield.wire.yarp.carriers import (
    HEADER,
    HEADERS,
    LONGEST,
    LONGEST_NAME,
    Carrier,
    Lines,
    Value,
    checked_name,
    greeting,
    line,
    message,
    text_from_bottle,
    words_from_text,
    yarp_number,
)

PORT = 10000
END = "*** end of message"
ANSWER_BYTES = 65536
PATIENCE = 2.0  # s for an answer
Place = tuple[str, int]  # host and port


def request_bytes(own: str, command: str, name: str, *more: Value) -> bytes:
    """All bytes of a connection that asks one thing about a port, from a party of the name `own`.

    Parameters
    ----------
    own : str
    command : str
        ``query``, ``register``, ``unregister`` or ``set``.
    name : str
        Of the port.
    more : values
        What belongs to the command.
    """
    checked_name(name)
    if not name.startswith("/"):
        raise InputError(f"name of a port is {name!r}, expected one that begins with a slash")
    return greeting(Carrier.TEXT, own) + message(Carrier.TEXT, "d", [command, name, *more])


def place_from_line(line: str) -> Place | None:
    """Where a port is, as a line of an answer says it; None if the line says something else."""
    words = line.replace('"', "").split()
    if words[:1] != ["registration"] or words[1:8:2] != ["name", "ip", "port", "type"]:
        return None
    if not (words[6].isascii() and words[6].isdecimal() and 0 < int(words[6]) < 65536):
        return None  # a port without a socket says "none"
    return words[4], int(words[6])


class NameReply:
    """An answer of the name server, as it comes in.

    Attributes
    ----------
    lines : list of str
        Without the welcome and the end.
    complete : bool
    """

    def __init__(self) -> None:
        self._in = Lines(ANSWER_BYTES)
        self.lines: list[str] = []
        self.complete = False

    def feed(self, data: bytes) -> bool:
        """Take in what came; whether it is complete."""
        self._in.feed(data)
        while not self.complete and (line := self._in.take()) is not None:
            if line.startswith(END):
                self.complete = True
            elif not line.startswith("Welcome "):
                self.lines.append(line)
        return self.complete

    @property
    def place(self) -> Place | None:
        """The first in it: where a port is."""
        return next(filter(None, map(place_from_line, self.lines)), None)


@dataclass(frozen=True)
class NameServer:
    """Where a name server is; each question is a connection of its own, and waits.

    Parameters
    ----------
    host : str
    port : int
    """

    host: str = "127.0.0.1"
    port: int = PORT

    def ask(self, own: str, command: str, name: str, *more: Value) -> NameReply:
        """Send a command as in `request_bytes`, and wait for the answer.

        Raises
        ------
        InputError
            If it does not answer in time, or what comes is no answer.
        """
        request = request_bytes(own, command, name, *more)
        answer, end = NameReply(), monotonic() + PATIENCE
        try:
            with socket.create_connection((self.host, self.port), PATIENCE) as link:
                link.sendall(request)
                while not answer.complete:
                    link.settimeout(max(end - monotonic(), 1e-3))
                    data = link.recv(4096)
                    if not data:
                        raise OSError("it closed the connection")
                    answer.feed(data)
        except (OSError, UnicodeError) as error:
            raise InputError(
                f"name server at {self.host}:{self.port} does not answer: {error}, expected a "
                "running `yarp server`: see `yarp where`"
            ) from None
        return answer

    def where(self, own: str, name: str) -> Place | None:
        """Where a port is; None if nobody knows. Raises as `ask`."""
        return self.ask(own, "query", name).place


ACK = "<ACK>"
WITH_BOTTLE = ("d", "D", "a")  # first letters of the port commands that a bottle follows
MOST = 64  # connections
PIECE = 65536  # bytes read at once
GOODBYE = 0.5  # s for the last bytes of a connection
CONNECT = 2.0  # s for a connection to another port
BEHIND = 1 << 22  # bytes that wait to be sent, at which a connection is given up
UNKNOWN = b"* Error. Protocol not found.\r\n* Try CONNECT and a name.\r\n"


class Connection:
    """One socket of a port: what the party says there, and what is answered.

    Parameters
    ----------
    sock : socket
    port : Port
    carrier : Carrier, optional
        Of a connection that the port opened itself, to a reader of the name `peer`; otherwise the
        party says it.
    peer : str

    Attributes
    ----------
    peer : str
        Name of the party; empty until it gave it.
    reads : bool
        Whether the party reads from the port.
    unread : int
        Messages that were sent to it and not acknowledged.
    gone : bool
        Whether it is to be closed.
    """

    def __init__(
        self, sock: socket.socket, port: "Port", carrier: Carrier | None = None, peer: str = ""
    ) -> None:
        sock.setblocking(False)
        with suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket, self._port, self.carrier, self.peer = sock, port, carrier, peer
        self.reads, self.unread, self.gone = carrier is not None, 0, False
        self._ended = False  # it is gone once all was sent
        self._out = bytearray()
        self._head, self._lines = b"", Lines(LONGEST if peer else LONGEST_NAME)
        self._command = ""  # whose bottle is still to come

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
            return
        try:
            if self.reads:
                self.unread = max(self.unread - self._acknowledged(data), 0)
            elif self.carrier is None:
                self._open(data)
            else:
                self._listen(data)
        except InputError as error:
            self._ended = True
            if self.carrier is not Carrier.TCP:
                self._out += line(str(error))
        self.send(b"")

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
        if self._ended and not self._out:
            self.gone = True

    def close(self) -> None:
        """Say goodbye to a reader, and close."""
        if self.reads and not self.gone:
            self.socket.settimeout(GOODBYE)
            with suppress(OSError):
                self.socket.sendall(self._out + message(self.carrier or Carrier.TEXT, "q"))
        self.socket.close()

    def _acknowledged(self, data: bytes) -> int:
        """Messages that a reader acknowledges; everything else it says is let go."""
        if self.carrier is not Carrier.TCP:
            self._lines.feed(data)
            return sum(each == ACK for each in iter(self._lines.take, None))
        self._head += data
        count = 0
        while len(self._head) >= HEADER:
            more = yarp_number(self._head[:HEADER])
            if more is None or not 0 <= more <= LONGEST:
                raise InputError(f"{self._head[:8]!r} is no acknowledgement, expected one")
            if len(self._head) < HEADER + more:
                break
            self._head = self._head[HEADER + more :]
            count += 1
        return count

    def _open(self, data: bytes) -> None:
        """Wait for the eight bytes of a carrier."""
        self._head += data
        if len(self._head) < HEADER:
            return
        for carrier in (Carrier.TEXT, Carrier.TEXT_ACK):
            if self._head.startswith(HEADERS[carrier]):
                self.carrier = carrier
                self._listen(self._head[HEADER:])
                return
        self._out += UNKNOWN
        self._ended = True

    def _listen(self, data: bytes) -> None:
        """Obey the messages behind the party's name, which comes first."""
        self._lines.feed(data)
        if not self.peer:
            name = self._lines.take()
            if name is None:
                return
            self.peer, self._lines.most = name.strip(), LONGEST
            checked_name(self.peer)
            self._out += line(f"Welcome {self.peer}")
        while not (self.reads or self._ended) and (text := self._lines.take()) is not None:
            if self._command:
                self._obey(self._command, words_from_text(text))
                self._command = ""
            elif text[:1] in WITH_BOTTLE:
                self._command = text[:1]
            else:
                self._obey(text[:1], [])

    def _obey(self, letter: str, words: Sequence[str]) -> None:
        if letter == "q":
            self._ended = True
            return
        if letter == "a":
            self._out += line(self._administered(words))
        elif letter == "r":
            self.reads = True
        elif letter not in WITH_BOTTLE:  # data has no taker here
            self._out += line("Port command not understood.")
        if self.carrier is Carrier.TEXT_ACK:
            self._out += line(ACK)

    def _administered(self, words: Sequence[str]) -> str:
        command, first, second = [*words, "", "", ""][:3]
        port = self._port
        match command:
            case "ver":
                return "[ver] 1 2 3"  # of the administrative commands
            case "list":
                there = {} if first == "in" else port.outputs
                if not second:
                    return text_from_bottle(list(there))
                if second not in there:
                    return ""
                facts = {"from": port.name, "to": second, "carrier": there[second]}
                return text_from_bottle([[key, value] for key, value in facts.items()])
            case "add" | "del":
                wanted = f"{second}:/{first}" if second else first
                outcome = port.add(wanted) if command == "add" else port.remove(first)
                good = outcome.startswith(("Added", "Removed"))
                return text_from_bottle([0 if good else -1, outcome])
        return '[fail] "expected [ver], [add], [del] or [list]"'


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
        self, name: str, host: str = "", socket_port: int = 0, server: NameServer | None = None
    ) -> None:
        checked_name(name)
        self.name, self.server = name, server
        self.skipped = 0
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
        if there.place is None:
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
                    self._connections.append(Connection(sock, self))
                else:
                    sock.close()
        for each in [each for each in self._connections if each.gone]:
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
        for each in self._readers():
            carrier = each.carrier
            assert carrier is not None  # of whoever reads
            if each.waits or each.unread:
                self.skipped += 1
                continue
            if carrier.is_text not in made:
                made[carrier.is_text] = message(carrier, command, values)
            each.unread += carrier.acknowledges
            each.send(made[carrier.is_text])
            count += 1
        return count

    def _readers(self) -> list[Connection]:
        return [each for each in self._connections if each.reads and not each.gone]

    @property
    def readers(self) -> int:
        """How many read from it."""
        return len(self._readers())

    @property
    def outputs(self) -> Mapping[str, str]:
        """Carriers by the names of the readers."""
        return {each.peer: each.carrier.value for each in self._readers() if each.carrier}

    def add(self, wanted: str) -> str:
        """Send to another port from now on; the outcome, which begins with "Added" if that is so.

        The name server says where the other port is.
        """
        carrier_name, _, name = wanted.rpartition(":/")
        name = name if carrier_name else wanted
        known = [each.value for each in Carrier]
        if carrier_name and carrier_name not in known:
            return (
                f"Cannot connect to {wanted}: carrier is {carrier_name!r:.60}, expected one of "
                f"{', '.join(known)}"
            )
        if self.server is None:
            return f"Do not know how to connect to {wanted}: there is no name server"
        try:
            there = self.server.where(self.name, name)
            if there is None:
                return f"Do not know how to connect to {wanted}"
            self.remove(name)
            connection = self._connected(Carrier(carrier_name or "tcp"), name, there)
        except (InputError, OSError) as error:
            return f"Cannot connect to {wanted}: {error}"
        self._connections.append(connection)
        return f"Added connection from {self.name} to {wanted}"

    def _connected(self, carrier: Carrier, name: str, place: tuple[str, int]) -> Connection:
        """A connection to another port, welcomed by it; OSError where it is not, or not in time."""
        with ExitStack() as undo:
            sock = undo.enter_context(socket.create_connection(place, CONNECT))
            sock.sendall(greeting(carrier, self.name))
            if carrier == Carrier.TEXT_ACK:
                with sock.makefile("rb") as answers:
                    answers.readline(PIECE)
            elif carrier == Carrier.TCP:
                answer = sock.recv(HEADER, socket.MSG_WAITALL)
                if yarp_number(answer) is None:
                    raise OSError(f"it answered {answer!r}, expected eight bytes of YARP")
            undo.pop_all()
        return Connection(sock, self, carrier, name)

    def remove(self, name: str) -> str:
        """Send to a port no more; the outcome, which begins with "Removed" if that is so."""
        for each in self._readers():
            if each.peer == name:
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
