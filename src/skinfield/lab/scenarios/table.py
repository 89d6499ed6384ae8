"""Tables of a settings file: keys with units, read into dataclasses, every key accounted for."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from decimal import Decimal
from functools import partial
from typing import Any, TypeVar, get_origin, get_type_hints

import numpy as np

from skinfield.errors import FileError
from skinfield.settings import line_of, nearest

T = TypeVar("T")
UNITS = {  # endings of keys, with the power of ten to SI
    "_mm": -3, "_ms": -3, "_s": 0, "_kpa": 3, "_n": 0, "_mn": -3, "_hz": 0, "_deg": 0, "_c": 0,
    "_counts": 0, "_pf": -12, "_ff": -15, "_counts_per_k": 0, "_counts_per_sqrt_s": 0, "_k": 0,
    "": 0,
}  # fmt: skip


UNIT = {  # of fields, where their keys end in one
    name: unit
    for unit, names in {
        "_mm": "thickness clearance extent cell depths positions within step place_error",
        "_s": "rest approach ramp hold release pause time_constant stuck_within open_time "
              "closed_time",
        "_ms": "delay jitter conversion_time",
        "_hz": "rate logged_at",
        "_n": "forces full_scale",
        "_mn": "noise offset resolution",
        "_kpa": "young_modulus",
        "_deg": "angle",
        "_c": "start end reference",
        "_counts": "baseline_spread white common flicker gain",
        "_counts_per_k": "converter_spread taxel_spread",
        "_counts_per_sqrt_s": "walk",
        "_pf": "rest_capacitance",
    }.items()
    for name in names.split()
}  # fmt: skip
OTHERWISE = {"per_kelvin": "mean_counts_per_k", "farads_per_count": "step_ff"}


def key_of(name: str) -> str:
    """Key of a field: its name with its unit."""
    return OTHERWISE.get(name, name + UNIT.get(name, ""))


def ending_of(key: str) -> str:
    """Unit at the end of a key, the longest that fits; "" for a plain number."""
    return max((ending for ending in UNITS if key.endswith(ending)), key=len)


def field_of(key: str) -> str:
    """A key without its unit, as fields are called."""
    return key.removesuffix(ending_of(key))


def si_from_value(key: str, value: Any) -> Any:
    """Numbers of a key in SI units, to the last digit, in lists too; what is no number as it is."""
    if isinstance(value, list):
        return [si_from_value(key, item) for item in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    ending = ending_of(key)
    if isinstance(value, int) and not ending:
        return value if abs(value) < 2**63 else math.inf
    if ending == "_deg":
        return math.radians(value)
    exact = Decimal(repr(value))
    return float(exact + Decimal("273.15") if ending == "_c" else exact.scaleb(UNITS[ending]))


@dataclass
class TomlTable:
    """One table of a file.

    Parameters
    ----------
    content : mapping
        As tomllib gives it.
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

    def read(self, usual: T, names: Iterable[str] | None = None, **others: Any) -> T:
        """Object like `usual` with what the table says.

        Parameters
        ----------
        usual : dataclass object
        names : iterable of str, optional
            Of the fields that it may hold, each under `key_of` its name. Default all.
        **others
            Fields that are made of what the table was asked for before.
        """
        kinds = get_type_hints(type(usual))
        chosen = [each.name for each in fields(usual)] if names is None else names  # type: ignore
        values = self.values({key_of(name): (name, kinds[name]) for name in chosen})
        return self.make(partial(replace, usual), **others, **values)  # type: ignore[type-var]

    def values(self, keys: Mapping[str, tuple[str, Any]]) -> dict[str, Any]:
        """What the table says under `keys`, by the field of each, of its kind; no other may be."""
        self.taken |= set(keys)
        for key in set(self.content) - self.taken:
            raise FileError(
                f"{self.place(key)}: {key!r} is not known, expected one of "
                f"{', '.join(sorted(self.taken))}{nearest(key, self.taken)}"
            )
        return {
            name: self.value(key, kind) for key, (name, kind) in keys.items() if key in self.content
        }

    def make(self, kind: Callable[..., T], key: str | None = None, /, **values: Any) -> T:
        """Object of some values; an error about them gets the place of the table or of a key."""
        try:
            return kind(**values)
        except (ValueError, ArithmeticError, OSError) as error:
            raise FileError(f"{self.place(key)}: {error}") from error

    def value(self, key: str, kind: Any, default: Any = None) -> Any:
        """Value of a key in SI units, if it is of a kind."""
        import msgspec

        self.taken.add(key)
        if key not in self.content:
            return default
        words = {bool: "true or false", str: "a text in quotes", int: "a whole number"}
        expected = words.get(kind, "a finite number")
        if get_origin(kind):
            expected = "a list of finite numbers, or of rows of them, such as [0.5, 1]"
        try:
            found = msgspec.convert(si_from_value(key, self.content[key]), kind)
            if np.isfinite(found).all() if isinstance(found, float | tuple) else True:
                return found
        except (msgspec.ValidationError, ArithmeticError):
            pass
        raise self.wrong(key, expected)

    def choice(self, key: str, choices: Mapping[str, T], default: str = "") -> T:
        """One of some words."""
        word = self.value(key, str, default)
        if word not in choices:
            raise self.wrong(key, f"one of {', '.join(choices)}{nearest(word, choices)}")
        return choices[word]

    def table(self, key: str) -> "TomlTable":
        """Table within; an empty one where there is none."""
        self.taken.add(key)
        value = self.content.get(key, {})
        if not isinstance(value, dict):
            raise self.wrong(key, f"a table: [{self._within(key)}]")
        return TomlTable(value, self._within(key), self.path, self.text)

    def tables(self, key: str) -> list["TomlTable"]:
        """Tables of an array; none where there is none."""
        self.taken.add(key)
        value = self.content.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.wrong(key, f"tables: [[{self._within(key)}]]")
        return [
            TomlTable(item, f"{self._within(key)}[{row}]", self.path, self.text)
            for row, item in enumerate(value)
        ]

    def wrong(self, key: str, expected: str) -> FileError:
        """Error about a value."""
        what = f"{self.content[key]!r:.60}" if key in self.content else "missing"
        return FileError(f"{self.place(key)}: {key} is {what}, expected {expected}")

    def place(self, key: str | None) -> str:
        """File, line where it can be found, and table."""
        line = line_of(self.text, self.where, key or "")
        head = f"{self.path}:{line}" if line else self.path
        return f"{head}: [{self.where}]" if self.where else head

    def _within(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key
