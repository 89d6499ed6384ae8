"""Named arrays at fixed places of a slot, or of the status."""

import re
import struct
from collections.abc import Sequence
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, InputError

LINE = 64  # bytes of a cache line
ENTRY = 128  # bytes of a field's entry in the table
DIMENSIONS, MOST_FIELDS = 6, 1024

_ENTRY = struct.Struct("<48s8s9Q")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,46}")
_DTYPE = re.compile(r"\|[biu]1|<[iu][248]|<f[248]")
_MOST = 1 << 36  # bytes of a field


class Field(NamedTuple):
    """An array that each slot has, or the status.

    Parameters
    ----------
    name : str
        Letters, digits and underscores, at most 47.
    dtype : str
        Whole or floating-point numbers of up to 8 bytes, or bool, as NumPy names them.
    shape : tuple of int
        () is a single number.
    """

    name: str
    dtype: str
    shape: tuple[int, ...] = ()


class Placed(NamedTuple):
    """A field at its place: bytes from the beginning of the slot, or of the status."""

    field: Field
    offset: int
    size: int

    def view(self, octets: NDArray[np.uint8], start: int) -> NDArray[Any]:
        """The array in a file, or in a copy of a slot, which begins at byte `start`.

        NumPy does not hold the memory of a buffer, only that of an array: so the bytes must be one.
        """
        field = self.field
        return np.ndarray(field.shape, np.dtype(field.dtype), octets.data, start + self.offset)


def place(name: str, fields: Sequence[Field], start: int) -> tuple[tuple[Placed, ...], int]:
    """Give each field its place.

    Parameters
    ----------
    name : str
        Of the argument, for errors.
    fields : sequence of Field
    start : int, bytes
        Taken before the first.

    Returns
    -------
    tuple of Placed
        What has a cache line or more begins with one.
    int
        Bytes in all, a multiple of 64.

    Raises
    ------
    InputError
        If a field cannot be used, or two have one name.
    """
    if len(fields) > MOST_FIELDS:
        raise InputError(f"{name} has {len(fields)} fields, expected at most {MOST_FIELDS}")
    placed: dict[str, Placed] = {}
    for field in fields:
        checked, itemsize = _checked(name, Field(*field))
        if checked.name in placed:
            raise InputError(f"{name} has two fields {checked.name}, expected different names")
        size = itemsize * prod(checked.shape)
        step = LINE if size >= LINE else 8
        start = -(-start // step) * step
        placed[checked.name] = Placed(checked, start, size)
        start += size
    return tuple(placed.values()), max(LINE, -(-start // LINE) * LINE)


def _checked(name: str, field: Field) -> tuple[Field, int]:
    if not isinstance(field.name, str) or not _NAME.fullmatch(field.name):
        raise InputError(
            f"a field of {name} is called {field.name!r}, expected a letter, then letters, digits "
            "and underscores, at most 47"
        )
    try:
        dtype = np.dtype(field.dtype)
        shape = tuple(int(length) for length in field.shape)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"field {field.name} of {name} is {field}, expected a type and a shape: {error}"
        ) from error
    if not _DTYPE.fullmatch(dtype.str):
        raise InputError(
            f"dtype of field {field.name} is {field.dtype!r}, expected little-endian numbers of up "
            "to 8 bytes, or bool"
        )
    if len(shape) > DIMENSIONS or min(shape, default=0) < 0 or not _small(shape):
        raise InputError(
            f"shape of field {field.name} is {shape}, expected up to {DIMENSIONS} lengths that "
            f"make less than {_MOST} bytes"
        )
    return Field(field.name, dtype.str, shape), dtype.itemsize


def table(placed: Sequence[Placed]) -> bytes:
    """Entries of the table of fields."""
    return b"".join(
        _ENTRY.pack(
            field.name.encode(),
            field.dtype.encode(),
            offset,
            size,
            len(field.shape),
            *(*field.shape, *([0] * (DIMENSIONS - len(field.shape)))),
        )
        for field, offset, size in placed
    )


def read_table(
    data: memoryview, at: int, count: int, first: int, limit: int, where: str
) -> tuple[Placed, ...]:
    """Read and check entries of the table of fields.

    Parameters
    ----------
    data : memoryview
        The whole file; the table lies within it.
    at : int
        Offset of the first entry.
    count : int
    first, limit : int, bytes
        Of a slot or of the status, between which fields may lie.
    where : str
        For errors.

    Raises
    ------
    FileError
        If an entry makes no sense.
    """
    if count > MOST_FIELDS:
        raise FileError(f"{where} is damaged: {count} fields, expected at most {MOST_FIELDS}")
    found = [_entry(data, at + ENTRY * i, first, limit, where) for i in range(count)]
    if len({placed.field.name for placed in found}) < count:
        raise FileError(f"{where} is damaged: two of its fields have one name")
    return tuple(found)


def _entry(data: memoryview, at: int, first: int, limit: int, where: str) -> Placed:
    name, dtype, offset, size, dimensions, *lengths = _ENTRY.unpack_from(data, at)
    text, kind = (part.rstrip(b"\0").decode("ascii", "replace") for part in (name, dtype))
    good = _NAME.fullmatch(text) and _DTYPE.fullmatch(kind) and dimensions <= DIMENSIONS
    if good:
        shape = tuple(lengths[:dimensions])
        whole = int(kind[2]) * prod(shape) == size and _small(shape)
        good = whole and first <= offset and offset + size <= limit and offset % 8 == 0
    if not good:
        raise FileError(
            f"{where} is damaged: its field at byte {at} has no name, type or place that can be"
        )
    return Placed(Field(text, kind, shape), offset, size)


def _small(shape: tuple[int, ...]) -> bool:
    """Whether NumPy can make such an array, even one of no elements."""
    return prod(max(length, 1) for length in shape) * 8 <= _MOST
