"""Tables of a settings file, read key by key: units, kinds, and every key accounted for."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from typing import Any, TypeVar

from skinfield.errors import FileError, InputError
from skinfield.settings.text import line_of, nearest

T = TypeVar("T")
DEGREE = math.pi / 180.0
CELSIUS = Decimal("273.15")
UNITS = {  # endings of keys, with the power of ten to SI, and in words
    "_mm": (-3, "millimetres"), "_ms": (-3, "milliseconds"), "_s": (0, "seconds"),
    "_kpa": (3, "kilopascals"), "_n": (0, "newtons"), "_mn": (-3, "millinewtons"),
    "_hz": (0, "per second"), "_deg": (0, "degrees"), "_c": (0, "degrees Celsius"),
    "_counts": (0, "counts"), "_pf": (-12, "picofarads"), "_ff": (-15, "femtofarads"),
    "_counts_per_k": (0, "counts per kelvin"),
    "_counts_per_sqrt_s": (0, "counts per root second"), "_k": (0, "kelvin"),
    "": (0, "no unit"),
}  # fmt: skip


def ending_of(key: str) -> str:
    """Unit at the end of a key, the longest that fits; "" for a plain number."""
    return max((ending for ending in UNITS if key.endswith(ending)), key=len)


def unit_of(key: str) -> str:
    """In words."""
    return UNITS[ending_of(key)][1]


def si_from_number(key: str, number: int | float | Decimal) -> float:
    """Value in SI units, to the last digit."""
    if ending_of(key) == "_deg":
        return float(number) * DEGREE
    exact = number if isinstance(number, Decimal) else Decimal(repr(number))
    with localcontext() as context:
        context.prec = 60
        if ending_of(key) == "_c":
            return float(exact + CELSIUS)
        return float(exact.scaleb(UNITS[ending_of(key)][0]))


@dataclass
class Table:
    """One table: each key is taken once; `finish` objects to those that nobody took.

    Parameters
    ----------
    content : mapping
        As tomllib gives it, with Decimal for numbers with a point.
    where : str
        Such as "profile" or "places[1]"; "" for the file itself.
    path : str
        Of the file, for messages.
    text : str
        Of the file, to find lines in.
    """

    content: Mapping[str, Any]
    where: str
    path: str
    text: str = ""
    taken: set[str] = field(default_factory=set)
    known: list[str] = field(default_factory=list)

    def wrong(self, key: str, expected: str) -> FileError:
        """Error about a value."""
        shown = _excerpt(self.content[key]) if key in self.content else "missing"
        return FileError(f"{self.place(key)}: {key} is {shown}, expected {expected}")

    def value(self, key: str, default: Any = None) -> Any:
        """Text, switch, whole number, or number in SI units: what the default is.

        Without a default it is a text that has to be there.
        """
        value = self._take(key)
        if value is None and default is not None:
            return default
        return self._of_kind(key, value, "" if default is None else default)

    def items(self, key: str, kind: float, width: int = 0) -> tuple[Any, ...]:
        """Numbers in SI units, or whole ones, as `kind` is; of a list, or of rows of `width`."""
        value = self._take(key)
        if value is None:
            return ()
        rows = f"rows of {width} " if width else ""
        what = f"numbers in {unit_of(key)}" if isinstance(kind, float) else "whole numbers"
        listed = isinstance(value, list)
        if not listed or (width and any(not isinstance(r, list) or len(r) != width for r in value)):
            raise self.wrong(key, f"a list of {rows}{what}, such as [0.5, 1]")
        if not width:
            return tuple(self._of_kind(key, item, kind) for item in value)
        return tuple(tuple(self._of_kind(key, item, kind) for item in row) for row in value)

    def choice(self, key: str, choices: Mapping[str, T], default: str | None = None) -> T:
        """One of some words."""
        word = self.value(key, default)
        if word not in choices:
            raise self.wrong(key, f"one of {', '.join(choices)}{nearest(word, choices)}")
        return choices[word]

    def table(self, key: str) -> "Table":
        """Table within; an empty one where there is none."""
        value = self._take(key)
        if value is not None and not isinstance(value, dict):
            raise self.wrong(key, f"a table: [{self._within(key)}]")
        return Table(value or {}, self._within(key), self.path, self.text)

    def tables(self, key: str) -> list["Table"]:
        """Tables of an array; none where there is none."""
        value = self._take(key)
        if value is None:
            return []
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.wrong(key, f"tables: [[{self._within(key)}]]")
        return [
            Table(item, f"{self._within(key)}[{row}]", self.path, self.text)
            for row, item in enumerate(value)
        ]

    def finish(self) -> None:
        """Object to keys that nobody took."""
        for key in self.content:
            if key in self.taken:
                continue
            units = {name: f"{name} ({unit_of(name)})" for name in self.known if ending_of(name)}
            listed = ", ".join(units.get(name, name) for name in sorted(self.known))
            raise FileError(
                f"{self.place(key)}: {_excerpt(key)} is not known, expected one of {listed}"
                f"{nearest(key, self.known)}"
            )

    def made(self, make: Callable[..., T], **values: Any) -> T:
        """What is made of values; says which table they are from if they do not fit."""
        self.finish()
        try:
            return make(**values)
        except FileError:
            raise
        except InputError as error:
            raise FileError(f"{self.place(None)}: {error}") from error

    def plain(self) -> dict[str, Any]:
        """All of it, with floats for decimals: for readers that check for themselves."""
        self.taken |= set(self.content)
        return {key: _plain(value) for key, value in self.content.items()}

    def _within(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key

    def _take(self, key: str) -> Any:
        self.known.append(key)
        self.taken.add(key)
        return self.content.get(key)

    def _of_kind(self, key: str, value: Any, kind: Any) -> Any:
        """The value, in SI units, if it is of a kind."""
        if isinstance(kind, bool | str):
            if not isinstance(value, type(kind)):
                raise self.wrong(
                    key, "true or false" if isinstance(kind, bool) else "a text in quotes"
                )
            return value
        if isinstance(kind, int):
            if isinstance(value, bool) or not isinstance(value, int) or abs(value) >= 2**63:
                raise self.wrong(key, "whole numbers of at most 63 bits")
            return value
        if isinstance(value, bool) or not isinstance(value, int | Decimal):
            raise self.wrong(key, f"a number in {unit_of(key)}")
        try:
            found = si_from_number(key, value)
        except (ArithmeticError, ValueError):
            raise self.wrong(key, f"a number in {unit_of(key)} of a usual size") from None
        if not math.isfinite(found):
            raise self.wrong(key, f"a finite number in {unit_of(key)}")
        return found

    def place(self, key: str | None) -> str:
        """File, line where it can be found, and table."""
        line = line_of(self.text, self.where, key or "")
        head = f"{self.path}:{line}" if line else self.path
        return f"{head}: [{self.where}]" if self.where else head


def _plain(value: Any) -> Any:
    if isinstance(value, Decimal):
        return float(value)
    return [_plain(item) for item in value] if isinstance(value, list) else value


def _excerpt(value: object) -> str:
    if isinstance(value, Decimal):
        return str(value)[:40]
    try:
        text = repr(_plain(value))
    except ValueError:  # a whole number of more digits than Python prints
        return "a number without end"
    return text if len(text) <= 60 else text[:57] + "..."
