r"""Carriers and bottles of YARP: how a connection between ports begins, and its messages.

As in YARP 4.0.0: `doc/020_nameserver_and_protocols/yarp_protocol.dox` and, below
`src/libYARP_os/src/yarp/os/impl`, `TextCarrier.cpp`, `TcpCarrier.cpp`, `PortCommand.cpp` and
`../AbstractCarrier.cpp`. Whoever connects sends eight bytes that name the carrier, and its own
name; the port answers with a line of welcome (text) or with eight bytes (tcp). Then messages
follow: a port command, and for ``d``, ``D`` and ``a`` a bottle. Text is written and read; tcp is
only written, as it carries what we send to readers that somebody told us to connect to.

======== ============================================================================
carrier  first eight bytes; messages are
======== ============================================================================
text     ``CONNECT``, blank; lines that end in CR LF, and are read with or without CR
text_ack ``CONNACK``, blank; the same, each message acknowledged by ``<ACK>``
tcp      ``YA E4 1E 00 00 RP``; blocks of bytes with their lengths, acknowledged
======== ============================================================================

A bottle, as far as contacts need it, is after the grammar of `BottleImpl.cpp` and `Storable.cpp`.
As text: values apart by blanks; ``12`` whole; ``1.5``, ``1e-3``, ``inf``, ``nan`` floating;
``(a b)`` a list; everything else is text, in quotation marks where it must be, with ``\\``,
``\"``, ``\n``, ``\r`` and ``\0`` within. Floating numbers always have a point or an exponent, as
readers tell the types by it. As bytes, all numbers little-endian: a list is its length and its
values, each behind its tag (`Bottle.h`); where all are of one type other than a list, the tag of
that type is added to the list's and left out before each.
"""

import re
import struct
from collections.abc import Sequence
from enum import Enum

from skinfield.errors import InputError

HEADER = 8  # bytes
LINE_END = b"\r\n"
INDEX = 10  # bytes of an index, of which the first is the number of blocks, the second of replies
LONGEST_NAME = 1000  # bytes, as YARP reads it
LONGEST = 1 << 20  # bytes of a line

WORD = re.compile(r'\[([^\]\s]*)\]|"((?:[^"\\]|\\.)*)"|([^\s"\[]+)')
TOKEN = re.compile(r'"((?:[^"\\]|\\.)*)"|([()"]|[^\s()"]+)')
WHOLE = re.compile(r"[+-]?[0-9]{1,19}")
FLOATING = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|[+-]?(inf|nan)")
DEEPEST = 16  # lists in lists
PLAIN = re.compile(r"[A-Za-z_][A-Za-z_0-9.\-]*")  # text that YARP writes without marks
RESERVED = ("true", "false", "null", "inf", "nan")  # words that would be read as something else
ESCAPED = {"\n": "\\n", "\r": "\\r", "\0": "\\0", "\\": "\\\\", '"': '\\"'}
UNESCAPED = {mark[1]: letter for letter, mark in ESCAPED.items()}

INT32, STRING, FLOAT64, LIST = 1, 4, 20, 256  # tags

Value = int | float | str | list["Value"]


def number(value: int) -> bytes:
    """A number in YARP's eight bytes."""
    return b"YA" + struct.pack("<i", value) + b"RP"


class Carrier(Enum):
    """By YARP's own name."""

    TEXT = "text"
    TEXT_ACK = "text_ack"
    TCP = "tcp"

    @property
    def is_text(self) -> bool:
        """Whether messages are lines."""
        return self is not Carrier.TCP

    @property
    def acknowledges(self) -> bool:
        """Whether each message is acknowledged by whoever reads it."""
        return self is not Carrier.TEXT


HEADERS = {
    Carrier.TEXT: b"CONNECT ",
    Carrier.TEXT_ACK: b"CONNACK ",
    Carrier.TCP: number(7777 + 3 + 128),
}


def greeting(carrier: Carrier, own: str) -> bytes:
    """What a connection begins with.

    Parameters
    ----------
    carrier : Carrier
    own : str
        Our port's name; one that does not begin with a slash belongs to no port.
    """
    name = checked_name(own)
    if carrier.is_text:
        return HEADERS[carrier] + name + LINE_END
    return HEADERS[carrier] + struct.pack("<i", len(name) + 1) + name + b"\0"


def message(carrier: Carrier, command: str, values: Sequence[Value] | None = None) -> bytes:
    """A whole message.

    Parameters
    ----------
    carrier : Carrier
    command : str
        Port command, such as ``d``, ``D 12 1.5``, ``a`` or ``r``.
    values : sequence of values, optional
        The bottle behind ``d``, ``D`` or ``a``.
    """
    if carrier.is_text:
        return line(command) + (b"" if values is None else line(text_from_bottle(values)))
    if len(command) == 1:
        block = bytes(4) + b"~" + to_octets(command) + b"\0\x01"
    else:
        data = to_octets(command) + b"\0"
        block = struct.pack("<i", len(data)) + b"~\0\0\x01" + data
    blocks = [block] if values is None else [block, bytes_from_bottle(values)]
    sizes = b"".join(struct.pack("<i", len(each)) for each in blocks)
    index = number(INDEX) + bytes([len(blocks), 1]) + b"\xff" * 8 + sizes + bytes(4)
    return index + b"".join(blocks)


def line(text: str) -> bytes:
    """A line of text."""
    return to_octets(text) + LINE_END


def checked_name(name: str) -> bytes:
    """A port's name as bytes."""
    data = to_octets(name)
    if not 0 < len(data) <= LONGEST_NAME or any(octet <= 32 or octet == 92 for octet in data):
        raise InputError(
            f"name of a port is {name!r:.60}, expected up to {LONGEST_NAME} characters without "
            "blanks, backslashes and control characters, as /skinfield/left_arm"
        )
    return data


def envelope(sequence: int, seconds: float) -> str:
    """Stamp of a message as text: its number, and s since the epoch.

    As `src/libYARP_os/src/yarp/os/Stamp.cpp` writes it, with 16 digits in place of 15, so that
    microseconds are kept.
    """
    return f"{sequence} {seconds:.16g}"


class Lines:
    """Lines of text, without their ends.

    As in YARP's `InputStream.cpp`: CR and zero bytes are left out, and a backslash before the end
    of a line joins it with the next.

    Parameters
    ----------
    most : int, bytes
        Of one line; may be set at any time.
    """

    def __init__(self, most: int = LONGEST) -> None:
        self.most = most
        self._rest = bytearray()
        self._searched = 0  # bytes of the rest in which no line ends

    def feed(self, data: bytes) -> None:
        """Take in what came."""
        self._rest += data

    def take(self) -> str | None:
        """The next line; None if none is complete."""
        while True:
            end = self._rest.find(b"\n", self._searched)
            if (len(self._rest) if end < 0 else end) > self.most:
                raise InputError(f"a line has more than {self.most} bytes, expected no more")
            if end < 0:
                self._searched = len(self._rest)
                return None
            line = bytes(self._rest[:end].replace(b"\r", b"").replace(b"\0", b""))
            if not (len(line) - len(line.rstrip(b"\\"))) % 2:
                del self._rest[: end + 1]
                self._searched = 0
                return from_octets(line)
            self._rest[: end + 1] = line[:-1]  # joined with the next
            self._searched = len(line) - 1


def yarp_number(data: bytes | bytearray) -> int | None:
    """The number in eight bytes ``YA....RP``; None if they are others."""
    if len(data) != HEADER or data[:2] != b"YA" or data[6:] != b"RP":
        return None
    return int.from_bytes(data[2:6], "little", signed=True)


def text_from_bottle(values: Sequence[Value]) -> str:
    """One line, without its end.

    Parameters
    ----------
    values : sequence of int, float, str, or lists of these
    """
    return " ".join(map(_written, values))


def _written(value: Value) -> str:
    if isinstance(value, list):
        return f"({text_from_bottle(value)})"
    return _quoted(value) if isinstance(value, str) else repr(value)


def _quoted(text: str) -> str:
    """Text as YARP writes it: in quotation marks, unless it cannot be taken for anything else."""
    if PLAIN.fullmatch(text) and text not in RESERVED:
        return text
    return '"' + "".join(ESCAPED.get(letter, letter) for letter in text) + '"'


def values_from_text(text: str) -> list[Value]:
    """Values of a bottle's line, as `text_from_bottle` writes them.

    Raises
    ------
    InputError
        If brackets or quotation marks do not match, or lists nest deeper than `DEEPEST`.
    """
    lists: list[list[Value]] = [[]]
    for found in TOKEN.finditer(text):
        quoted, plain = found.groups()
        if quoted is not None:
            lists[-1].append(re.sub(r"\\(.)", lambda mark: UNESCAPED.get(mark[1], mark[1]), quoted))
        elif plain == "(":
            lists.append([])
            if len(lists) > DEEPEST:
                raise InputError(f"lists nest deeper than {DEEPEST}, expected no deeper")
        elif plain == ")":
            if len(lists) == 1:
                raise InputError("a list ends that did not begin, expected '(' before ')'")
            inner = lists.pop()
            lists[-1].append(inner)
        elif plain == '"':
            raise InputError("a text has no end, expected a second quotation mark")
        else:
            lists[-1].append(_read(plain))
    if len(lists) > 1:
        raise InputError("a list has no end, expected ')'")
    return lists[0]


def _read(word: str) -> Value:
    for form, kind in ((WHOLE, int), (FLOATING, float)):
        if form.fullmatch(word):
            return kind(word)
    return word


def words_from_text(text: str) -> list[str]:
    """Words of a command, whether they came as ``add``, as ``[add]`` or as ``"add"``."""
    return ["".join(parts).replace("\\", "") for parts in WORD.findall(text)]


def bytes_from_bottle(values: Sequence[Value]) -> bytes:
    """As the tcp carrier carries it; whole numbers are of 32 bits."""
    kind = _kind_of_all(values)
    return struct.pack("<i", LIST + kind) + _content(values, kind)


def _content(values: Sequence[Value], kind: int) -> bytes:
    parts = [struct.pack("<i", len(values))]
    for value in values:
        if not kind:
            parts.append(struct.pack("<i", _tag(value)))
        parts.append(_payload(value))
    return b"".join(parts)


def _kind_of_all(values: Sequence[Value]) -> int:
    """Tag that all values share; 0 if they do not, or are lists, or there are none."""
    tags = {_tag(value) for value in values}
    return tags.pop() if len(tags) == 1 and max(tags) < LIST else 0


def _tag(value: Value) -> int:
    if isinstance(value, list):
        return LIST + _kind_of_all(value)
    return INT32 if isinstance(value, int) else FLOAT64 if isinstance(value, float) else STRING


def _payload(value: Value) -> bytes:
    if isinstance(value, list):
        return _content(value, _kind_of_all(value))
    if isinstance(value, str):
        data = to_octets(value)
        return struct.pack("<i", len(data)) + data
    return struct.pack("<i" if isinstance(value, int) else "<d", value)


def to_octets(text: str) -> bytes:
    """Text as bytes; what was no UTF-8 when it came goes out as it came."""
    try:
        return text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError as error:
        raise InputError(f"text {text!r:.60} cannot be written as UTF-8: {error}") from None


def from_octets(data: bytes) -> str:
    """See `to_octets`."""
    return data.decode("utf-8", "surrogateescape")
