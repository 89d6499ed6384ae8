r"""Bottles of YARP, as far as contacts need them: values as text, and as bytes of the tcp carrier.

Grammar of YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl/BottleImpl.cpp` and `Storable.cpp`. As text:
values apart by blanks; ``12`` whole; ``1.5``, ``1e-3``, ``inf``, ``nan`` floating; ``(a b)`` a
list; everything else is text, in quotation marks where it must be, with ``\\``, ``\"``, ``\n``,
``\r`` and ``\0`` within. Floating numbers always have a point or an exponent, as readers tell the
types by it. As bytes, all numbers little-endian: a list is its length and its values, each behind
its tag (`Bottle.h`); where all are of one type other than a list, the tag of that type is added to
the list's and left out before each.
"""

import re
import struct
from collections.abc import Sequence

from skinfield.errors import InputError

WORD = re.compile(r'\[([^\]\s]*)\]|"((?:[^"\\]|\\.)*)"|([^\s"\[]+)')
PLAIN = re.compile(r"[A-Za-z_][A-Za-z_0-9.\-]*")  # text that YARP writes without marks
RESERVED = ("true", "false", "null", "inf", "nan")  # words that would be read as something else
ESCAPED = {"\n": "\\n", "\r": "\\r", "\0": "\\0", "\\": "\\\\", '"': '\\"'}

INT32, STRING, FLOAT64, LIST = 1, 4, 20, 256  # tags

Value = int | float | str | list["Value"]


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
