"""A connection that somebody made to a port of ours, byte by byte, without any socket.

The receiver's side of a connection as in YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl/Protocol.cpp`
(`expectHeader`), `PortCoreInputUnit.cpp` (port commands) and `PortCore.cpp` (`adminBlock`): the
words of the answers are those that YARP's own tools look at.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from skinfield.errors import InputError
from skinfield.protocols.yarp.answers import ADMIN_HELP, HELP, NOT_UNDERSTOOD, UNKNOWN, VERSION
from skinfield.protocols.yarp.binary import to_octets
from skinfield.protocols.yarp.bottle import Value, Vocab, word_of
from skinfield.protocols.yarp.carriers import (
    HEADER,
    LINE_END,
    LONGEST_NAME,
    Carrier,
    acknowledgement,
    carrier_from_header,
    reply,
    welcome,
)
from skinfield.protocols.yarp.messages import (
    Acknowledgements,
    Lines,
    Message,
    Messages,
    messages_of,
)


class Owner(Protocol):
    """The port that connections are made to."""

    @property
    def name(self) -> str:
        """Of the port."""
        ...

    @property
    def socket_port(self) -> int:
        """Of its socket."""
        ...

    def describe(self) -> Sequence[str]:
        """Lines about its connections."""
        ...

    def add(self, wanted: str) -> str:
        """Send to another port from now on; a sentence that begins with "Added" if that is so."""
        ...

    def remove(self, name: str) -> str:
        """Send to it no more; a sentence that begins with "Removed" if that is so."""
        ...

    def connections(self, outgoing: bool) -> Mapping[str, str]:
        """Carriers by the names of the ports that it sends to, or that are connected to it."""
        ...

    def data(self, values: list[Value]) -> Sequence[str] | None:
        """Take in data; lines to answer, None for no answer."""
        ...


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
    owner : Owner

    Attributes
    ----------
    carrier : Carrier or None
        None until its eight bytes are there.
    peer : str
        Name that the party gave; empty until then.
    output : Output or None
        Set once the party became a reader.
    done : bool
        Whether the connection is to be closed, when what is in `answer` was sent.
    answer : bytearray
        Bytes to send; whoever sends them takes them out.
    """

    def __init__(self, owner: Owner) -> None:
        self._owner = owner
        self._head = bytearray()
        self._messages: Messages | None = None
        self.carrier: Carrier | None = None
        self.peer = ""
        self.output: Output | None = None
        self.done = False
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
            self.done = True
            if self.carrier is not None and self.carrier.is_text:
                self.answer += to_octets(f"{error}") + LINE_END

    def _open(self, data: bytes) -> None:
        """Wait for the header and the name, then welcome the party."""
        self._head += data
        if self.carrier is None and len(self._head) >= HEADER:
            self.carrier = carrier_from_header(bytes(self._head[:HEADER]))
            if self.carrier is None:
                self.answer += UNKNOWN
                self.done = True
                return
        if self.carrier is None:
            return
        found = name_behind_header(self.carrier, bytes(self._head[HEADER:]))
        if found is None:
            return
        self.peer, rest = found
        self.answer += welcome(self.carrier, self.peer, self._owner.socket_port)
        self._messages = messages_of(self.carrier)
        self._listen(rest)

    def _listen(self, data: bytes) -> None:
        assert self._messages is not None
        assert self.carrier is not None
        self._messages.feed(data)
        for message in self._messages:
            self._obey(message)
            if message.command[:1] == "q":
                self.done = True
                return
            self.answer += acknowledgement(self.carrier)
            if self.output is not None:
                self.output.take(self._messages.rest())
                return

    def _obey(self, message: Message) -> None:
        """As a port command says; those that are none are answered with how to get help."""
        letter, command = message.command[:1], message.command
        if letter == "a":
            self._say(*self._administer(message.values))
        elif letter in ("d", "D"):
            lines = self._owner.data(message.values)
            if lines is not None and letter == "d" and command[:2] != "do":
                self._answer_data(lines)
        elif letter == "r":
            assert self.carrier is not None
            self.output = Output(self.carrier, self.peer)
        elif letter != "q":
            self._tell(self._told(letter, command))

    def _told(self, letter: str, command: str) -> Sequence[str]:
        if letter == "/":
            return (self._owner.add(command),)
        if letter == "!":
            return (self._owner.remove(command[1:]),)
        if letter == "~":
            return (f"Could not find an incoming connection from {command[1:]}",)
        if letter == "*":
            return self._owner.describe()
        return HELP if letter in ("?", "h") else NOT_UNDERSTOOD

    def _tell(self, lines: Sequence[str]) -> None:
        """Lines for people, of whom those with the tcp carrier get none."""
        if self.carrier is not None and self.carrier.is_text:
            self.answer += b"".join(to_octets(line) + LINE_END for line in lines)

    def _answer_data(self, lines: Sequence[str]) -> None:
        """Lines of text as they are; over tcp one bottle with a text for each."""
        assert self.carrier is not None
        if self.carrier.is_text:
            self._tell(lines)
        else:
            self._say(*lines)

    def _say(self, *values: Value) -> None:
        assert self.carrier is not None
        self.answer += reply(self.carrier, values)

    def _administer(self, values: Sequence[Value]) -> Sequence[Value]:
        words = [word_of(value) for value in values]
        commands: dict[str, Callable[[list[str]], Sequence[Value]]] = {
            "ver": lambda _: VERSION,
            "help": lambda _: (Vocab("many"), *ADMIN_HELP),
            "add": self._add,
            "del": self._remove,
            "list": self._list,
        }
        known = commands.get(words[0]) if words else None
        if known is None:
            return (Vocab("fail"), "send [help] for list of valid commands")
        return known(words[1:])

    def _add(self, words: list[str]) -> Sequence[Value]:
        wanted = words[0] if words else ""
        if len(words) > 1 and words[1]:
            wanted = f"{words[1]}:/{wanted}"
        said = self._owner.add(wanted)
        return (0 if said.startswith("Added") else -1, said)

    def _remove(self, words: list[str]) -> Sequence[Value]:
        said = self._owner.remove(words[0] if words else "")
        return (0 if said.startswith("Removed") else -1, said)

    def _list(self, words: list[str]) -> Sequence[Value]:
        direction = words[0] if words else ""
        there = self._owner.connections(direction != "in")
        if len(words) < 2 or not words[1]:
            return tuple(there)
        if words[1] not in there:
            return ()
        ends = [self._owner.name, words[1]][:: 1 if direction != "in" else -1]
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
