"""Arrays of an NPZ file, each asked for by key, kind and shape."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, check_shape

Shape = tuple[int | None, ...]


@dataclass(frozen=True, eq=False)
class Stored:
    """Arrays by key; every error names file, key, what is there and what was expected."""

    path: Path
    arrays: dict[str, NDArray[Any]]
    used: set[str] = field(default_factory=set)

    def __contains__(self, key: str) -> bool:
        return key in self.arrays

    def check_all_used(self) -> None:
        """Raise FileError if there is a key that nobody asked for: it may be a mistyped one."""
        left = sorted(set(self.arrays) - self.used)
        if left:
            raise FileError(
                f"{self.path}: the key {left[0]!r} is not known ({len(left)} are not), expected "
                "only those of the format: see docs/cases.md"
            )

    def floats(self, key: str, shape: Shape | None) -> Floats:
        """Numbers of the given shape, any where it is None."""
        values = self._array(key)
        if values.dtype.kind not in "fiu":
            raise self._wrong(key, f"of type {values.dtype}", "numbers")
        if shape is not None:
            self._check_shape(key, values, shape)
        return values.astype(np.float64)

    def optional(self, key: str, shape: Shape) -> Any:
        """As `floats`, None where the key is missing."""
        return self.floats(key, shape) if key in self.arrays else None

    def optional_integers(self, key: str, count: int) -> Any:
        """Whole numbers (count,), None where the key is missing."""
        if key not in self.arrays:
            return None
        values = self._array(key)
        if values.dtype.kind not in "iu":
            raise self._wrong(key, f"of type {values.dtype}", "whole numbers")
        self._check_shape(key, values, (count,))
        return values

    def number(self, key: str, default: float | None = None) -> float:
        """One number."""
        if default is not None and key not in self.arrays:
            return default
        return float(self.floats(key, ()))

    def integer(self, key: str) -> int:
        """One whole number."""
        values = self._array(key)
        if values.dtype.kind not in "iu" or values.ndim:
            raise self._wrong(key, f"{values.dtype} of shape {values.shape}", "one whole number")
        return int(values)

    def flag(self, key: str, default: bool | None = None) -> bool:
        """True or false."""
        if default is not None and key not in self.arrays:
            return default
        values = self._array(key)
        if values.dtype.kind != "b" or values.ndim:
            raise self._wrong(key, f"{values.dtype} of shape {values.shape}", "true or false")
        return bool(values)

    def text(self, key: str, default: str | None = None) -> str:
        """One text."""
        if default is not None and key not in self.arrays:
            return default
        values = self._array(key)
        if values.dtype.kind != "U" or values.ndim:
            raise self._wrong(key, f"{values.dtype} of shape {values.shape}", "one text")
        return str(values)

    def words(self, key: str, count: int, default: str) -> list[str]:
        """Texts (count,)."""
        if key not in self.arrays:
            return [default] * count
        values = self._array(key)
        if values.dtype.kind != "U":
            raise self._wrong(key, f"of type {values.dtype}", "texts")
        self._check_shape(key, values, (count,))
        return [str(word) for word in values]

    def _array(self, key: str) -> NDArray[Any]:
        if key not in self.arrays:
            raise FileError(f"{self.path}: no array {key!r}, expected it: see docs/cases.md")
        self.used.add(key)
        return self.arrays[key]

    def _check_shape(self, key: str, values: NDArray[Any], shape: Shape) -> None:
        try:
            check_shape(key, values, shape, "see docs/cases.md")
        except ValueError as error:
            raise FileError(f"{self.path}: {error}") from error

    def _wrong(self, key: str, found: str, expected: str) -> FileError:
        return FileError(f"{self.path}: {key} is {found}, expected {expected}: see docs/cases.md")
