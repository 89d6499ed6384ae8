r"""Bottles of YARP: values as text, both ways, and as the bytes of the tcp carrier.

Grammar of YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl/BottleImpl.cpp` and `Storable.cpp`, as far
as contacts and administrative messages need it. As text: values apart by blanks or commas; ``12``,
``0x1f`` whole; ``1.5``, ``1e-3``, ``inf``, ``nan`` floating; ``(a b)`` a list; ``[add]`` a vocab of
up to eight characters; ``true``, ``false``; everything else is text, in quotation marks where it
must be, with ``\\``, ``\"``, ``\n``, ``\r`` and ``\0`` within. A number with neither point nor
exponent is whole: floating ones always have one, as readers tell the types by it. As bytes, all
numbers little-endian: a list is its length and its values, each behind its tag (`Bottle.h`); where
all are of one type other than a list, the tag of that type is added to the list's and left out
before each. Bytes (``{1 2 255}``) and dictionaries are no part of it.
"""

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from skinfield.errors import InputError

LONGEST = 1 << 20  # characters or bytes of a bottle
DEEPEST = 16  # lists within lists
INT64 = 1 << 63
TOKEN = re.compile(
    r"""[\s,]*(?:(?P<open>\()|(?P<close>\))|"(?P<text>(?:[^"\\]|\\.)*)"|\[(?P<vocab>[^\]]*)\]"""
    r"""|(?P<word>[^\s,()"\[]+)|\Z)""",
    re.DOTALL,
)
WHOLE = re.compile(r"[+-]?(0|[1-9][0-9]*|0[xX][0-9a-fA-F]{1,8})")
FLOATING = re.compile(r"[+-]?([0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))([eE][+-]?[0-9]+)?|-?inf|nan")
VOCAB = re.compile(r"""[^\s\[\](){}",\\\x00-\x20\x7f-\U0010ffff]{1,8}""")
PLAIN = re.compile(r"[A-Za-z_][A-Za-z_0-9.\-]*")  # text that YARP writes without marks
RESERVED = ("true", "false", "null", "inf", "nan")  # words that would be read as something else
ESCAPED = {"\n": "\\n", "\r": "\\r", "\0": "\\0", "\\": "\\\\", '"': '\\"'}
ESCAPE = re.compile(r"\\(.)", re.DOTALL)
UNESCAPED = {"n": "\n", "r": "\r", "0": "\0"}

INT32, INT64_TAG, FLOAT64 = 1, 17, 20
VOCAB32, VOCAB64 = 9, 18
STRING, LIST = 4, 256
NUMBERS = {INT32: "<i", INT64_TAG: "<q", FLOAT64: "<d"}
VOCABS = {VOCAB32: 4, VOCAB64: 8}
TRUE, FALSE = b"1\0\0\0", bytes(4)


@dataclass(frozen=True)
class Vocab:
    """A word of up to eight characters that travels as a number, such as ``[add]``."""

    text: str

    def __post_init__(self) -> None:
        if not VOCAB.fullmatch(self.text):
            raise InputError(
                f"vocab is {self.text!r:.40}, expected 1 to 8 characters without blanks, brackets, "
                "commas, backslashes or quotation marks"
            )


Value = bool | int | float | str | Vocab | list["Value"]


def text_from_bottle(values: Sequence[Value]) -> str:
    """One line, without its end.

    Parameters
    ----------
    values : sequence of bool, int, float, str, Vocab, or lists of these

    Raises
    ------
    InputError
        For another type, or a whole number beyond 64 bits.
    """
    return " ".join(map(_written, values))


def _written(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(_in_range(value))
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Vocab):
        return f"[{value.text}]"
    if isinstance(value, list):
        return f"({text_from_bottle(value)})"
    raise _no_value(value)


def _no_value(value: object) -> InputError:
    return InputError(f"{value!r:.60} is no value of a bottle, expected number, text or list")


def _in_range(number: int) -> int:
    if not -INT64 <= number < INT64:
        raise InputError(f"{number!r:.30} does not fit into 64 bits, expected a number that does")
    return number


def quoted(text: str) -> str:
    """Text as YARP writes it: in quotation marks, unless it cannot be taken for anything else."""
    if PLAIN.fullmatch(text) and text not in RESERVED:
        return text
    return '"' + "".join(ESCAPED.get(letter, letter) for letter in text) + '"'


def bottle_from_text(text: str) -> list[Value]:
    """Values of one line.

    Raises
    ------
    InputError
        If a list, a text or a vocab does not end, a number does not fit, or limits are exceeded.
    """
    if len(text) > LONGEST:
        raise InputError(f"bottle has {len(text)} characters, expected {LONGEST} at most")
    lists: list[list[Value]] = [[]]
    at = 0
    while at < len(text):
        token = TOKEN.match(text, at)
        if token is None:
            raise _unreadable(text, at, "a text or a vocab does not end")
        at = token.end()
        kind, content = token.lastgroup, token.group(token.lastgroup or 0)
        if kind == "open":
            if len(lists) > DEEPEST:
                raise _unreadable(text, at, f"nested deeper than {DEEPEST} lists")
            inner: list[Value] = []
            lists[-1].append(inner)
            lists.append(inner)
        elif kind == "close":
            lists.pop()
            if not lists:
                raise _unreadable(text, at, "a list is closed that was not opened")
        elif kind == "text":
            lists[-1].append(ESCAPE.sub(lambda each: UNESCAPED.get(each[1], each[1]), content))
        elif kind == "vocab":
            lists[-1].append(Vocab(content))
        elif kind == "word":
            lists[-1].append(_of_word(content))
    if len(lists) > 1:
        raise _unreadable(text, at, "a list is not closed")
    return lists[0]


def _unreadable(text: str, at: int, what: str) -> InputError:
    near = text[max(at - 20, 0) : at + 20]
    return InputError(
        f"bottle cannot be read at character {at}, near {near!r}: {what}, expected values apart by "
        "blanks"
    )


def _of_word(word: str) -> Value:
    if word in ("true", "false"):
        return word == "true"
    if word == "null":
        return Vocab(word)
    if WHOLE.fullmatch(word):
        return _in_range(int(word[:24], 0 if "x" in word.lower() else 10))
    if FLOATING.fullmatch(word):
        return float(word)
    return word


def word_of(value: Value) -> str:
    """A command's word, whether it came as ``[add]`` or as ``add``; empty if it is none."""
    if isinstance(value, Vocab):
        return value.text
    return value if isinstance(value, str) else ""


def bytes_from_bottle(values: Sequence[Value]) -> bytes:
    """As the tcp carrier carries it.

    Raises
    ------
    InputError
        For something that is no value of a bottle, or that does not fit.
    """
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
    if isinstance(value, bool):
        return VOCAB32
    if isinstance(value, int):
        return INT32 if -(1 << 31) <= value < 1 << 31 else INT64_TAG
    if isinstance(value, float):
        return FLOAT64
    if isinstance(value, str):
        return STRING
    if isinstance(value, Vocab):
        return VOCAB32 if len(value.text) <= 4 else VOCAB64
    if isinstance(value, list):
        return LIST + _kind_of_all(value)
    raise _no_value(value)


def _payload(value: Value) -> bytes:
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, int | float):
        number = value if isinstance(value, float) else _in_range(value)
        return struct.pack(NUMBERS[_tag(value)], number)
    if isinstance(value, str):
        data = to_octets(value)
        return struct.pack("<i", len(data)) + data
    if isinstance(value, Vocab):
        return value.text.encode("ascii").ljust(VOCABS[_tag(value)], b"\0")
    return _content(value, _kind_of_all(value))


def to_octets(text: str) -> bytes:
    """Text as bytes; what was no UTF-8 when it came goes out as it came."""
    try:
        return text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError as error:
        raise InputError(f"text {text!r:.60} cannot be written as UTF-8: {error}") from None


def from_octets(data: bytes) -> str:
    """See `to_octets`."""
    return data.decode("utf-8", "surrogateescape")
