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
UNITS = {  # endings of keys, with the power of ten to SI
    "_mm": -3, "_ms": -3, "_s": 0, "_kpa": 3, "_n": 0, "_mn": -3, "_hz": 0, "_deg": 0, "_c": 0,
    "_counts": 0, "_pf": -12, "_ff": -15, "_counts_per_k": 0, "_counts_per_sqrt_s": 0, "_k": 0,
}  # fmt: skip
WORDS = {
    "_mm": "millimetres", "_ms": "milliseconds", "_s": "seconds", "_kpa": "kilopascals",
    "_n": "newtons", "_mn": "millinewtons", "_hz": "per second", "_deg": "degrees",
    "_c": "degrees Celsius", "_counts": "counts", "_pf": "picofarads", "_ff": "femtofarads",
    "_counts_per_k": "counts per kelvin", "_counts_per_sqrt_s": "counts per root second",
    "_k": "kelvin",
}  # fmt: skip


def ending_of(key: str) -> str:
    """Unit at the end of a key, the longest that fits; "" for a plain number."""
    fitting = [ending for ending in UNITS if key.endswith(ending)]
    return max(fitting, key=len, default="")


def unit_of(key: str) -> str:
    """In words."""
    return WORDS.get(ending_of(key), "no unit")


def si_from_number(key: str, number: int | float | Decimal) -> float:
    """Value in SI units, to the last digit."""
    if ending_of(key) == "_deg":
        return float(number) * DEGREE
    exact = number if isinstance(number, Decimal) else Decimal(repr(number))
    with localcontext() as context:
        context.prec = 60
        if ending_of(key) == "_c":
            return float(exact + CELSIUS)
        return float(exact.scaleb(UNITS.get(ending_of(key), 0)))


def number_from_si(key: str, value: float) -> Decimal:
    """Number that `si_from_number` turns into this very value."""
    if ending_of(key) == "_deg":
        return Decimal(repr(before_factor(float(value), DEGREE)))
    exact = Decimal(repr(float(value)))
    with localcontext() as context:
        context.prec = 60
        if ending_of(key) == "_c":
            exact -= CELSIUS
        else:
            exact = exact.scaleb(-UNITS.get(ending_of(key), 0))
    return Decimal(format(exact, "f"))  # without an exponent


def before_factor(value: float, factor: float) -> float:
    """Number that times `factor` is `value`; where none is, one that is off by the last digit."""
    guess = value / factor
    near = [guess, math.nextafter(guess, math.inf), math.nextafter(guess, -math.inf)]
    exact = [number for number in near if number * factor == value]
    return min(exact, key=lambda number: len(repr(number)), default=guess)


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
        shown = _shown(self.content[key]) if key in self.content else "missing"
        return FileError(f"{self.place(key)}: {key} is {shown}, expected {expected}")

    def number(self, key: str, default: float | None = None) -> float:
        """Value in SI units of a key that ends in its unit."""
        value = self._take(key)
        if value is None:
            if default is None:
                raise self.wrong(key, f"a number in {unit_of(key)}")
            return default
        return self._si(key, value)

    def numbers(self, key: str) -> tuple[float, ...]:
        """Values in SI units of a list; empty where there is none."""
        value = self._take(key)
        if value is None:
            return ()
        if not isinstance(value, list):
            raise self.wrong(key, f"a list of numbers in {unit_of(key)}, such as [0.5, 1]")
        return tuple(self._si(key, item) for item in value)

    def rows(self, key: str, width: int) -> tuple[tuple[float, ...], ...]:
        """Rows of `width` values in SI units; empty where there is none."""
        value = self._take(key)
        if value is None:
            return ()
        if not isinstance(value, list) or any(
            not isinstance(row, list) or len(row) != width for row in value
        ):
            raise self.wrong(key, f"rows of {width} numbers in {unit_of(key)}")
        return tuple(tuple(self._si(key, item) for item in row) for row in value)

    def integer(self, key: str, default: int) -> int:
        """Whole number."""
        value = self._take(key)
        return default if value is None else self._whole(key, value)

    def integers(self, key: str, width: int = 0) -> tuple[Any, ...]:
        """Whole numbers, or rows of `width` of them."""
        value = self._take(key)
        if value is None:
            return ()
        rows = f"rows of {width} " if width else ""
        if not isinstance(value, list):
            raise self.wrong(key, f"a list of {rows}whole numbers")
        if not width:
            return tuple(self._whole(key, item) for item in value)
        if any(not isinstance(row, list) or len(row) != width for row in value):
            raise self.wrong(key, f"a list of {rows}whole numbers")
        return tuple(tuple(self._whole(key, item) for item in row) for row in value)

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self._take(key)
        if value is None:
            return default
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false")
        return value

    def word(self, key: str, default: str | None = None) -> str:
        """Text."""
        value = self._take(key)
        if value is None and default is not None:
            return default
        if not isinstance(value, str):
            raise self.wrong(key, "a text in quotes")
        return value

    def choice(self, key: str, choices: Mapping[str, T], default: str | None = None) -> T:
        """One of some words."""
        word = self.word(key, default)
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
                f"{self.place(key)}: {_shown(key)} is not known, expected one of {listed}"
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

    def _si(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | Decimal):
            raise self.wrong(key, f"a number in {unit_of(key)}")
        try:
            found = si_from_number(key, value)
        except (ArithmeticError, ValueError):
            raise self.wrong(key, f"a number in {unit_of(key)} of a usual size") from None
        if not abs(found) < float("inf"):
            raise self.wrong(key, f"a finite number in {unit_of(key)}")
        return found

    def _whole(self, key: str, value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or abs(value) >= 2**63:
            raise self.wrong(key, "whole numbers of at most 63 bits")
        return value

    def place(self, key: str | None) -> str:
        """File, line where it can be found, and table."""
        line = line_of(self.text, self.where, key or "")
        head = f"{self.path}:{line}" if line else self.path
        return f"{head}: [{self.where}]" if self.where else head


def _plain(value: Any) -> Any:
    if isinstance(value, Decimal):
        return float(value)
    return [_plain(item) for item in value] if isinstance(value, list) else value


def _shown(value: object) -> str:
    if isinstance(value, Decimal):
        return str(value)[:40]
    try:
        text = repr(_plain(value))
    except ValueError:  # a whole number of more digits than Python prints
        return "a number without end"
    return text if len(text) <= 60 else text[:57] + "..."
