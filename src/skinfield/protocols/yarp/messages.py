"""Messages out of a stream of bytes, lines or blocks, however they are cut into pieces."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from skinfield.errors import InputError
from skinfield.protocols.yarp.binary import bottle_from_bytes, from_octets
from skinfield.protocols.yarp.bottle import Value, bottle_from_text
from skinfield.protocols.yarp.carriers import HEADER, INDEX, Carrier

WITH_BOTTLE = ("d", "D", "a")  # first letters of the port commands that a bottle follows
LONGEST = 1 << 20  # bytes of a line or of a message
COMMAND_BLOCK = 8


@dataclass(frozen=True)
class Message:
    """What a port was told.

    Attributes
    ----------
    command : str
        Port command, such as ``D 12 1.5``.
    values : list of values
        The bottle behind it, where one is.
    """

    command: str
    values: list[Value]

    @property
    def envelope(self) -> str:
        """Stamp that came with data, as text; empty without one."""
        return self.command[2:].strip() if self.command[:1] in ("d", "D") else ""


class Messages(Protocol):
    """A reader of messages; iterating gives those that are complete."""

    def feed(self, data: bytes) -> None:
        """Take in what came."""
        ...

    def __iter__(self) -> Iterator[Message]:
        """Messages that are complete; raises InputError where the bytes are none."""
        ...

    def rest(self) -> bytes:
        """What came after the last message that was taken."""
        ...


class Lines:
    """Lines of text, without their ends.

    As in YARP's `InputStream.cpp`: CR and zero bytes are left out, and a backslash before the end
    of a line joins it with the next.

    Parameters
    ----------
    most : int, bytes
        Of one line.
    """

    def __init__(self, most: int = LONGEST) -> None:
        self._most = most
        self._rest = bytearray()
        self._looked = 0  # bytes of the rest in which no line ends

    def feed(self, data: bytes) -> None:
        """Take in what came."""
        self._rest += data

    def take(self) -> str | None:
        """The next line; None if none is complete.

        Raises
        ------
        InputError
            If it is longer than allowed.
        """
        while True:
            end = self._rest.find(b"\n", self._looked)
            if (len(self._rest) if end < 0 else end) > self._most:
                raise InputError(f"a line has more than {self._most} bytes, expected no more")
            if end < 0:
                self._looked = len(self._rest)
                return None
            line = bytes(self._rest[:end].replace(b"\r", b"").replace(b"\0", b""))
            if not (len(line) - len(line.rstrip(b"\\"))) % 2:
                del self._rest[: end + 1]
                self._looked = 0
                return from_octets(line)
            self._rest[: end + 1] = line[:-1]  # joined with the next
            self._looked = len(line) - 1

    def rest(self) -> bytes:
        """What came after the last line that was taken."""
        return bytes(self._rest)


class TextMessages:
    """See `Messages`: those of the text carrier."""

    def __init__(self) -> None:
        self._lines = Lines()
        self._command: str | None = None

    def feed(self, data: bytes) -> None:
        """Take in what came."""
        self._lines.feed(data)

    def __iter__(self) -> Iterator[Message]:
        """See `Messages`."""
        while (line := self._lines.take()) is not None:
            if self._command is not None:
                command, self._command = self._command, None
                yield Message(command, bottle_from_text(line))
            elif line[:1] in WITH_BOTTLE:
                self._command = line
            else:
                yield Message(line, [])

    def rest(self) -> bytes:
        """See `Messages`."""
        return self._lines.rest()


class BinaryMessages:
    """See `Messages`: those of the tcp carrier."""

    def __init__(self) -> None:
        self._rest = bytearray()

    def feed(self, data: bytes) -> None:
        """Take in what came."""
        self._rest += data

    def __iter__(self) -> Iterator[Message]:
        """See `Messages`."""
        while (body := self._body()) is not None:
            yield _understood(body)

    def rest(self) -> bytes:
        """See `Messages`."""
        return bytes(self._rest)

    def _body(self) -> bytes | None:
        """All blocks of the next message; None if it is not complete."""
        sizes = message_sizes(self._rest)
        if sizes is None or len(self._rest) < sum(sizes):
            return None
        head, length = sizes
        body = bytes(self._rest[head : head + length])
        del self._rest[: head + length]
        return body


def message_sizes(data: bytes | bytearray) -> tuple[int, int] | None:
    """Bytes of a message's index and of its blocks; None if the index is not complete.

    Raises
    ------
    InputError
        If it begins with no index, or is too long.
    """
    if len(data) < HEADER + INDEX:
        return None
    if yarp_number(data[:HEADER]) != INDEX:
        raise InputError(f"message begins with {bytes(data[:HEADER])!r}, expected an index")
    blocks = data[HEADER] + data[HEADER + 1]
    head = HEADER + INDEX + 4 * blocks
    if len(data) < head:
        return None
    sizes = [
        int.from_bytes(data[at : at + 4], "little", signed=True)
        for at in range(HEADER + INDEX, head, 4)
    ]
    if min(sizes, default=0) < 0 or sum(sizes) > LONGEST:
        raise InputError(f"message has blocks of {sizes} bytes, expected {LONGEST} in all at most")
    return head, sum(sizes)


def yarp_number(data: bytes | bytearray) -> int | None:
    """The number in eight bytes ``YA....RP``; None if they are others."""
    if len(data) != HEADER or data[:2] != b"YA" or data[6:] != b"RP":
        return None
    return int.from_bytes(data[2:6], "little", signed=True)


def _understood(body: bytes) -> Message:
    if len(body) < COMMAND_BLOCK or body[4:5] != b"~":
        raise InputError(f"message begins with {body[:8]!r}, expected a port command")
    command, rest = from_octets(body[5:6]), body[COMMAND_BLOCK:]
    if command == "\0":
        text, zero, rest = rest.partition(b"\0")
        if not zero:
            raise InputError("a port command does not end, expected a zero byte")
        command = from_octets(text)
    with_bottle = command[:1] in WITH_BOTTLE
    return Message(command, bottle_from_bytes(rest) if with_bottle else [])


def messages_of(carrier: Carrier) -> Messages:
    """Reader of a carrier's messages."""
    return TextMessages() if carrier.is_text else BinaryMessages()


class Acknowledgements:
    """Counts what the reader of our messages acknowledges; everything else it says is let go."""

    def __init__(self, carrier: Carrier) -> None:
        self._carrier = carrier
        self._lines = Lines()
        self._rest = bytearray()

    def feed(self, data: bytes) -> int:
        """Take in what came; how many messages it acknowledges.

        Raises
        ------
        InputError
            If the bytes are no acknowledgement, of the tcp carrier.
        """
        if not self._carrier.acknowledges:
            return 0
        if self._carrier.is_text:
            self._lines.feed(data)
            lines = iter(self._lines.take, None)
            return sum(line == "<ACK>" for line in lines)
        self._rest += data
        count = 0
        while len(self._rest) >= HEADER:
            more = yarp_number(self._rest[:HEADER])
            if more is None or not 0 <= more <= LONGEST:
                raise InputError(f"{bytes(self._rest[:8])!r} is no acknowledgement, expected one")
            if len(self._rest) < HEADER + more:
                break
            del self._rest[: HEADER + more]
            count += 1
        return count
