"""Bottles as bytes, as YARP's tcp carrier carries them.

Layout of YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl/BottleImpl.cpp` (`synch`, `read`),
`Storable.cpp`, and the tags of `Bottle.h`; all numbers little-endian. A list is its length and its
values, each behind its tag; where all are of one type other than a list, the tag of that type is
added to the list's and left out before each.
"""

import struct
from collections.abc import Sequence

from skinfield.errors import InputError
from skinfield.protocols.yarp.bottle import DEEPEST, Value, Vocab

INT8, INT16, INT32, INT64 = 32, 64, 1, 17
FLOAT32, FLOAT64 = 10, 20
VOCAB32, VOCAB64 = 9, 18
STRING, BLOB = 4, 12
LIST, DICTIONARY = 256, 512
SIMPLE = {INT8: "b", INT16: "<h", INT32: "<i", INT64: "<q", FLOAT32: "<f", FLOAT64: "<d"}
VOCABS = {VOCAB32: 4, VOCAB64: 8}
MOST = 1 << 20  # bytes of a bottle, and values in it
TRUE, FALSE = b"1\0\0\0", bytes(4)


def bytes_from_bottle(values: Sequence[Value]) -> bytes:
    """As the tcp carrier carries it.

    Raises
    ------
    InputError
        For something that is no value of a bottle, or that does not fit.
    """
    kind = _kind_of_all(values)
    return struct.pack("<i", LIST + kind) + _content(values, kind, 0)


def _content(values: Sequence[Value], kind: int, depth: int) -> bytes:
    if depth > DEEPEST:
        raise InputError(f"bottle is nested deeper than {DEEPEST} lists, expected no more")
    parts = [struct.pack("<i", len(values))]
    for value in values:
        if not kind:
            parts.append(struct.pack("<i", _tag(value)))
        parts.append(_payload(value, depth))
    return b"".join(parts)


def _kind_of_all(values: Sequence[Value]) -> int:
    """Tag that all values share; 0 if they do not, or are lists, or there are none."""
    tags = {_tag(value) for value in values}
    return tags.pop() if len(tags) == 1 and max(tags) < LIST else 0


def _tag(value: Value) -> int:
    if isinstance(value, bool):
        return VOCAB32
    if isinstance(value, int):
        return INT32 if -(1 << 31) <= value < 1 << 31 else INT64
    if isinstance(value, float):
        return FLOAT64
    if isinstance(value, str):
        return STRING
    if isinstance(value, bytes):
        return BLOB
    if isinstance(value, Vocab):
        return VOCAB32 if len(value.text) <= 4 else VOCAB64
    if isinstance(value, list):
        return LIST + _kind_of_all(value)
    raise InputError(f"{value!r:.60} is no value of a bottle, expected number, text, bytes or list")


def _payload(value: Value, depth: int) -> bytes:
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, (int, float)):
        try:
            return struct.pack(SIMPLE[_tag(value)], value)
        except struct.error:
            raise InputError(
                f"{value} does not fit into 64 bits, expected a number that does"
            ) from None
    if isinstance(value, str):
        data = to_octets(value)
        return struct.pack("<i", len(data)) + data
    if isinstance(value, bytes):
        return struct.pack("<i", len(value)) + value
    if isinstance(value, Vocab):
        return value.text.encode("ascii").ljust(VOCABS[_tag(value)], b"\0")
    return _content(value, _kind_of_all(value), depth + 1)


def to_octets(text: str) -> bytes:
    """Text as bytes; what was no UTF-8 when it came goes out as it came."""
    try:
        return text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError as error:
        raise InputError(f"text {text!r:.60} cannot be written as UTF-8: {error}") from None


def from_octets(data: bytes) -> str:
    """See `to_octets`."""
    return data.decode("utf-8", "surrogateescape")


def bottle_from_bytes(data: bytes) -> list[Value]:
    """Values of a bottle; dictionaries are refused.

    Raises
    ------
    InputError
        If the bytes end too soon, go on behind it, or hold what is no bottle.
    """
    if len(data) > MOST:
        raise InputError(f"bottle has {len(data)} bytes, expected {MOST} at most")
    reader = _Reader(data)
    tag = reader.number()
    if not LIST <= tag < DICTIONARY:
        raise InputError(f"bottle begins with {tag}, expected the tag of a list, {LIST} or more")
    values = reader.list_of(tag - LIST, 0)
    if reader.at != len(data):
        raise InputError(f"{len(data) - reader.at} bytes follow the bottle, expected none")
    return values


class _Reader:
    """Goes through bytes once."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, count: int) -> bytes:
        if count < 0 or self.at + count > len(self.data):
            raise InputError(
                f"bottle asks for {count} bytes at byte {self.at} of {len(self.data)}, expected "
                "no more than there are"
            )
        found = self.data[self.at : self.at + count]
        self.at += count
        return found

    def number(self) -> int:
        return int.from_bytes(self.take(4), "little", signed=True)

    def list_of(self, kind: int, depth: int) -> list[Value]:
        count = self.number()
        if depth > DEEPEST or not 0 <= count <= len(self.data):
            raise InputError(f"list of {count} values at depth {depth}, expected fewer")
        return [self.value(kind or self.number(), depth) for _ in range(count)]

    def value(self, tag: int, depth: int) -> Value:
        if tag in SIMPLE:
            form = SIMPLE[tag]
            found: Value = struct.unpack(form, self.take(struct.calcsize(form)))[0]
            return found
        if tag in VOCABS:
            return _vocab(self.take(VOCABS[tag]))
        if tag == STRING:
            return from_octets(self.take(self.number()))
        if tag == BLOB:
            return self.take(self.number())
        if LIST <= tag < DICTIONARY:
            return self.list_of(tag - LIST, depth + 1)
        raise InputError(f"value of a bottle has tag {tag}, expected that of a known type")


def _vocab(data: bytes) -> Value:
    word = data.rstrip(b"\0")
    if not word or word == b"1":
        return bool(word)
    return Vocab(word.decode("latin-1"))
