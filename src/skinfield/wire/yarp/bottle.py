r"""Bottles of YARP, as text and bytes, and the lists of skin contacts that they carry.

Grammar of YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl/BottleImpl.cpp` and `Storable.cpp`, as far
as contacts and administrative messages need it. As text: values apart by blanks or commas; ``12``,
``0x1f`` whole; ``1.5``, ``1e-3``, ``inf``, ``nan`` floating; ``(a b)`` a list; ``[add]`` a vocab of
up to eight characters; ``true``, ``false``; everything else is text, in quotation marks where it
must be, with ``\\``, ``\"``, ``\n``, ``\r`` and ``\0`` within. A number with neither point nor
exponent is whole: floating ones always have one, as readers tell the types by it. As bytes, all
numbers little-endian: a list is its length and its values, each behind its tag (`Bottle.h`); where
all are of one type other than a list, the tag of that type is added to the list's and left out
before each. Bytes (``{1 2 255}``) and dictionaries are no part of it.

Contacts are as skinDynLib sends them. From robotology/icub-main 2.11.1, `src/libraries/skinDynLib`:
`include/iCub/skinDynLib/common.h`, `src/skinContact.cpp` and `skinContactList.cpp`, and
`app/skinGui/conf/skinManAll.ini` for the ports. A list of contacts, each a list of eight.
skinDynLib reads whole numbers and floating ones by their types, and refuses a contact without any
taxel, so both are kept to here. It does not read lists of contacts from the text carrier at all:
those readers need tcp; a Bottle, `yarp read` and everything else can be read over both. The legs'
skin has no link there: -1.
"""

import math
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_count

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

INT8, INT16, INT32, INT64_TAG = 32, 64, 1, 17
FLOAT32, FLOAT64 = 10, 20
VOCAB32, VOCAB64 = 9, 18
STRING, LIST, DICTIONARY = 4, 256, 512
SIMPLE = {INT8: "b", INT16: "<h", INT32: "<i", INT64_TAG: "<q", FLOAT32: "<f", FLOAT64: "<d"}
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
        For another type, a whole number beyond 64 bits, or lists nested too deep.
    """
    return _joined(values, 0)


def _joined(values: Sequence[Value], depth: int) -> str:
    _check_depth(depth)
    return " ".join(_written(value, depth) for value in values)


def _check_depth(depth: int) -> None:
    if depth > DEEPEST:
        raise InputError(f"bottle is nested deeper than {DEEPEST} lists, expected no more")


def _written(value: Value, depth: int) -> str:
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
        return f"({_joined(value, depth + 1)})"
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
            _check_depth(len(lists))
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


def same(one: Sequence[Value], other: Sequence[Value]) -> bool:
    """Whether two bottles are the same, types and not-a-numbers included."""
    return len(one) == len(other) and all(map(_same, one, other))


def _same(one: Value, other: Value) -> bool:
    if type(one) is not type(other):
        return False
    if isinstance(one, list) and isinstance(other, list):
        return same(one, other)
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    return one == other


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
    _check_depth(depth)
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


def _payload(value: Value, depth: int) -> bytes:
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, int):
        return struct.pack(SIMPLE[_tag(value)], _in_range(value))
    if isinstance(value, float):
        return struct.pack(SIMPLE[FLOAT64], value)
    if isinstance(value, str):
        data = to_octets(value)
        return struct.pack("<i", len(data)) + data
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
    """Values of a bottle; bytes and dictionaries are refused.

    Raises
    ------
    InputError
        If the bytes end too soon, go on behind it, or hold what is no bottle.
    """
    if len(data) > LONGEST:
        raise InputError(f"bottle has {len(data)} bytes, expected {LONGEST} at most")
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
        taken = self.data[self.at : self.at + count]
        self.at += count
        return taken

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
            number: Value = struct.unpack(form, self.take(struct.calcsize(form)))[0]
            return number
        if tag in VOCABS:
            return _vocab(self.take(VOCABS[tag]))
        if tag == STRING:
            return from_octets(self.take(self.number()))
        if LIST <= tag < DICTIONARY:
            return self.list_of(tag - LIST, depth + 1)
        raise InputError(f"value of a bottle has tag {tag}, expected that of a known type")


def _vocab(data: bytes) -> Value:
    word = data.rstrip(b"\0")
    if not word or word == b"1":
        return bool(word)
    return Vocab(word.decode("latin-1"))


TORSO, LEFT_ARM, RIGHT_ARM, LEFT_LEG, RIGHT_LEG = 1, 3, 4, 5, 6  # body parts
NO_LINK = -1
HIGHEST = 1 << 30
LARGEST = 1 << 31  # numbers of contacts come round: they have 32 bits


@dataclass(frozen=True)
class SkinPart:
    """Where a patch sits, in numbers of skinDynLib.

    Parameters
    ----------
    body, link, skin : int
        Of the body part, of its link, of the skin part; 0, -1 and 0 where it is unknown.
    """

    body: int = 0
    link: int = NO_LINK
    skin: int = 0

    def __post_init__(self) -> None:
        for name, lowest in (("body", 0), ("link", NO_LINK), ("skin", 0)):
            check_count(name, getattr(self, name), lowest, HIGHEST, "a number of skinDynLib")


UNKNOWN = SkinPart()
PARTS = {  # name in skinDynLib, and so in the files of taxel positions
    "l_hand": SkinPart(LEFT_ARM, 6, 1),
    "l_forearm": SkinPart(LEFT_ARM, 4, 2),
    "l_upper_arm": SkinPart(LEFT_ARM, 2, 3),
    "r_hand": SkinPart(RIGHT_ARM, 6, 4),
    "r_forearm": SkinPart(RIGHT_ARM, 4, 5),
    "r_upper_arm": SkinPart(RIGHT_ARM, 2, 6),
    "chest": SkinPart(TORSO, 2, 7),
    "l_upper_leg": SkinPart(LEFT_LEG, NO_LINK, 8),
    "l_lower_leg": SkinPart(LEFT_LEG, NO_LINK, 9),
    "l_foot": SkinPart(LEFT_LEG, NO_LINK, 10),
    "r_upper_leg": SkinPart(RIGHT_LEG, NO_LINK, 11),
    "r_lower_leg": SkinPart(RIGHT_LEG, NO_LINK, 12),
    "r_foot": SkinPart(RIGHT_LEG, NO_LINK, 13),
}
PORTS = {  # of these parts, behind /icub/skin/
    "l_upper_arm": "left_arm", "r_upper_arm": "right_arm", "chest": "torso",
    "l_upper_leg": "left_leg_upper", "r_upper_leg": "right_leg_upper",
    "l_lower_leg": "left_leg_lower", "r_lower_leg": "right_leg_lower",
}  # fmt: skip
OTHER_NAMES = {port: part for part, port in PORTS.items()} | {"front_torso": "chest"}
VARIANT = re.compile(r"_(mesh|nomesh|V[0-9]+(_[0-9]+)?)$")  # of a file of positions


def known_name(name: str) -> str:
    """Name in skinDynLib of a patch's name such as ``left_forearm_V2``; empty if it is none."""
    plain = VARIANT.sub("", name.strip().replace(" ", "_"))
    plain = OTHER_NAMES.get(plain, plain)
    for side in ("left", "right"):
        if plain.startswith(f"{side}_"):
            plain = f"{side[0]}_{plain.removeprefix(f'{side}_')}"
    return plain if plain in PARTS else ""


def part_of(name: str) -> SkinPart:
    """Where a patch of that name sits; `UNKNOWN` if the name does not tell."""
    return PARTS.get(known_name(name), UNKNOWN)


def port_of(name: str, robot: str = "icub") -> str:
    """Port on which a robot publishes the skin of that name."""
    known = known_name(name)
    if not known:
        return f"/{robot}/skin/{name}"
    side = {"l_": "left_", "r_": "right_"}.get(known[:2], "")
    return f"/{robot}/skin/{PORTS.get(known, side + known[2:])}"


def parts_of(names: Sequence[str], named: Mapping[str, Sequence[int]]) -> list[SkinPart]:
    """Where patches sit: as given, ``{"palm": [3, 6, 1]}``, else as their names tell.

    Raises
    ------
    InputError
        If something is given for a patch that is not there, or is not three numbers.
    """
    strange = sorted(set(named) - set(names))
    if strange:
        raise InputError(
            f"parts are given for {strange[0]!r}, expected patches among {', '.join(names)}"
        )
    parts = []
    for name in names:
        numbers = named.get(name)
        if numbers is None:
            parts.append(part_of(name))
        elif isinstance(numbers, str) or len(numbers) != 3:
            raise InputError(
                f"part of {name!r} is {numbers!r}, expected [body part, link, skin part]"
            )
        else:
            parts.append(SkinPart(*numbers))
    return parts


@dataclass(frozen=True, eq=False)
class SkinContact:
    """One contact; vectors (3,) in the link's frame.

    Parameters
    ----------
    number : int
        Of the contact, which it keeps while it goes on.
    part : SkinPart
    place : (3,) array, m
        Centre of pressure.
    force : (3,) array, N
        That acts on the robot: into the skin, against the normal.
    moment : (3,) array, N m
        That acts on the robot, about the centre of pressure.
    centre : (3,) array, m
        Mean place of the active taxels.
    normal : (3,) array
        Outward.
    taxels : sequence of int
        Active ones, by their channels in the port's vector; at least one.
    pressure : float, kPa
        Mean over the contact.
    """

    number: int
    part: SkinPart
    place: Floats
    force: Floats
    moment: Floats
    centre: Floats
    normal: Floats
    taxels: Sequence[int]
    pressure: float

    def __post_init__(self) -> None:
        if not len(self.taxels):
            raise InputError("contact has no taxel, expected one or more, as skinDynLib does")

    @property
    def values(self) -> list[Value]:
        """As a list of a bottle."""
        part = self.part
        vectors = (self.place, self.force, self.moment, self.centre, self.normal)
        return [
            [self.number % LARGEST, part.body, part.link, part.skin],
            *(_floats(vector) for vector in vectors),
            [int(taxel) for taxel in self.taxels],
            float(self.pressure),
        ]


def _floats(vector: Floats) -> list[Value]:
    return [float(number) for number in np.asarray(vector)]
