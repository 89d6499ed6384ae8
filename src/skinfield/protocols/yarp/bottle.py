r"""Bottles as text: what YARP's ports say to each other, one list of values per line.

Grammar of YARP 4.0.0, `src/libYARP_os/src/yarp/os/impl/BottleImpl.cpp` (`fromString`, `smartAdd`)
and `Storable.cpp`: values apart by blanks or commas; ``12``, ``0x1f`` whole; ``1.5``, ``1e-3``,
``inf``, ``nan`` floating; ``(a b)`` a list; ``[add]`` a vocab of up to eight characters;
``{1 2 255}`` bytes; ``true``, ``false``; everything else is text, in quotation marks where it must
be, with ``\\``, ``\"``, ``\n``, ``\r`` and ``\0`` within. A number with neither point nor
exponent is whole: floating ones always have one, as readers tell the types by it.

Where YARP guesses (``09``, ``1-2``, ``a(b``), this reader takes text or refuses.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from skinfield.errors import InputError

LONGEST = 1 << 20  # characters of a bottle
DEEPEST = 16  # lists within lists
INT64 = 1 << 63
WHOLE = re.compile(r"[+-]?(0|[1-9][0-9]*)")
OCTAL = re.compile(r"[+-]?0[0-7]+")  # as C reads it
HEXADECIMAL = re.compile(r"[+-]?0[xX][0-9a-fA-F]{1,8}")
FLOATING = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|-?inf|nan")
VOCAB = re.compile(r"[!-~]{1,8}")
FORBIDDEN = set('[](){}",\\')  # within a vocab
SEPARATORS = " \t\r\n,"
PLAIN = re.compile(r"[A-Za-z_][A-Za-z_0-9.\-]*")  # text that YARP writes without marks
TAKEN = ("true", "false", "null", "inf", "nan")  # words that would be read as something else
ESCAPED = {"\n": "\\n", "\r": "\\r", "\0": "\\0", "\\": "\\\\", '"': '\\"'}
MEANT = {"n": "\n", "r": "\r", "0": "\0"}


@dataclass(frozen=True)
class Vocab:
    """A word of up to eight characters that travels as a number, such as ``[add]``."""

    text: str

    def __post_init__(self) -> None:
        if not VOCAB.fullmatch(self.text) or FORBIDDEN & set(self.text):
            raise InputError(
                f"vocab is {self.text!r:.40}, expected 1 to 8 characters without blanks, brackets, "
                "commas, backslashes or quotation marks"
            )


Value = bool | int | float | str | bytes | Vocab | list["Value"]


def text_from_bottle(values: Sequence[Value]) -> str:
    """One line, without its end.

    Parameters
    ----------
    values : sequence of bool, int, float, str, bytes, Vocab, or lists of these

    Raises
    ------
    InputError
        For another type, a whole number beyond 64 bits, or lists nested too deep.
    """
    return _joined(values, 0)


def _joined(values: Sequence[Value], depth: int) -> str:
    if depth > DEEPEST:
        raise InputError(f"bottle is nested deeper than {DEEPEST} lists, expected no more")
    return " ".join(_written(value, depth) for value in values)


def _written(value: Value, depth: int) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        if not -INT64 <= value < INT64:
            raise InputError(f"{value} does not fit into 64 bits, expected a number that does")
        return str(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Vocab):
        return f"[{value.text}]"
    if isinstance(value, bytes):
        return "{" + " ".join(str(octet) for octet in value) + "}"
    if isinstance(value, list):
        return f"({_joined(value, depth + 1)})"
    raise InputError(f"{value!r:.60} is no value of a bottle, expected number, text, bytes or list")


def quoted(text: str) -> str:
    """Text as YARP writes it: in quotation marks, unless it cannot be taken for anything else."""
    if PLAIN.fullmatch(text) and text not in TAKEN:
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
    return _Reader(text).read()


class _Reader:
    """Goes through a text once."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0

    def read(self) -> list[Value]:
        lists: list[list[Value]] = [[]]
        while self.at < len(self.text):
            letter = self.text[self.at]
            if letter in SEPARATORS:
                self.at += 1
            elif letter == "(":
                self._open(lists)
            elif letter == ")":
                self._close(lists)
            else:
                lists[-1].append(self._value(letter))
        if len(lists) > 1:
            raise self._error("a list is not closed")
        return lists[0]

    def _open(self, lists: list[list[Value]]) -> None:
        if len(lists) > DEEPEST:
            raise self._error(f"lists are nested deeper than {DEEPEST}")
        self.at += 1
        inner: list[Value] = []
        lists[-1].append(inner)
        lists.append(inner)

    def _close(self, lists: list[list[Value]]) -> None:
        if len(lists) == 1:
            raise self._error("a list is closed that was not opened")
        self.at += 1
        lists.pop()

    def _value(self, letter: str) -> Value:
        if letter == '"':
            return self._marked()
        if letter == "[":
            return Vocab(self._until("]"))
        if letter == "{":
            return self._octets(self._until("}"))
        return self._bare()

    def _until(self, end: str) -> str:
        stop = self.text.find(end, self.at)
        if stop < 0:
            raise self._error(f"no {end} follows")
        found = self.text[self.at + 1 : stop]
        self.at = stop + 1
        return found

    def _octets(self, inside: str) -> bytes:
        words = inside.replace(",", " ").split()
        if not all(word.isascii() and word.isdecimal() and int(word) < 256 for word in words):
            raise self._error("bytes between { and } are not numbers from 0 to 255")
        return bytes(int(word) for word in words)

    def _marked(self) -> str:
        parts: list[str] = []
        at = self.at + 1
        while at < len(self.text) and self.text[at] != '"':
            letter = self.text[at]
            if letter == "\\":
                at += 1
                letter = MEANT.get(self.text[at : at + 1], self.text[at : at + 1])
            parts.append(letter)
            at += 1
        if at >= len(self.text):
            raise self._error("a text has no closing quotation mark")
        self.at = at + 1
        return "".join(parts)

    def _bare(self) -> Value:
        start = self.at
        while self.at < len(self.text) and self.text[self.at] not in SEPARATORS + ")":
            if self.text[self.at] in '("':
                raise self._error("a list or a text begins within a word")
            self.at += 1
        return _of_word(self.text[start : self.at])

    def _error(self, what: str) -> InputError:
        near = self.text[max(self.at - 20, 0) : self.at + 20]
        return InputError(
            f"bottle cannot be read at character {self.at}, near {near!r}: {what}, expected values "
            "apart by blanks"
        )


def _of_word(word: str) -> Value:
    if word in ("true", "false"):
        return word == "true"
    if word == "null":
        return Vocab(word)
    if WHOLE.fullmatch(word):
        return _fits(int(word), word)
    if HEXADECIMAL.fullmatch(word):
        return int(word, 16)
    if OCTAL.fullmatch(word):
        return _fits(int(word, 8), word)
    if FLOATING.fullmatch(word):
        return float(word)
    return word


def _fits(number: int, word: str) -> int:
    if not -INT64 <= number < INT64:
        raise InputError(f"{word:.30} does not fit into 64 bits, expected a number that does")
    return number


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
