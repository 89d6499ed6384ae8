"""Layout of a ring's file: header, table of fields, status, slots and log, little-endian.

What lies where is a table in ``docs/reference/shared-memory.md``, and in C in ``skinfield_ring.h``.
What changes has cache lines of its own. Slot n lies at index n modulo the number of slots, byte p
of the log at p modulo its size.
"""

import json
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import zip_longest
from math import prod
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, InputError, check_count

LINE = 64  # bytes of a cache line
ENTRY = 128  # bytes of a field's entry in the table
DIMENSIONS, MOST_FIELDS = 6, 1024

_ENTRY = struct.Struct("<48s8s9Q")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,46}")
_DTYPE = re.compile(r"\|[biu]1|<[iu][248]|<f[248]")
_MOST_FIELDS = 1 << 36  # bytes of a field


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


class Span(NamedTuple):
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


def place(name: str, fields: Sequence[Field], start: int) -> tuple[tuple[Span, ...], int]:
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
    tuple of Span
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
    placed: dict[str, Span] = {}
    for field in fields:
        checked, itemsize = _checked(name, Field(*field))
        if checked.name in placed:
            raise InputError(f"{name} has two fields {checked.name}, expected different names")
        size = itemsize * prod(checked.shape)
        step = LINE if size >= LINE else 8
        start = -(-start // step) * step
        placed[checked.name] = Span(checked, start, size)
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
    room = 8 * prod(max(length, 1) for length in shape)  # NumPy makes even one of no elements
    if len(shape) > DIMENSIONS or min(shape, default=0) < 0 or room > _MOST_FIELDS:
        raise InputError(
            f"shape of field {field.name} is {shape}, expected up to {DIMENSIONS} lengths that "
            f"make less than {_MOST_FIELDS} bytes"
        )
    return Field(field.name, dtype.str, shape), dtype.itemsize


def table(placed: Sequence[Span]) -> bytes:
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
) -> tuple[Span, ...]:
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


def _entry(data: memoryview, at: int, first: int, limit: int, where: str) -> Span:
    name, dtype, offset, size, dimensions, *lengths = _ENTRY.unpack_from(data, at)
    text, kind = (part.rstrip(b"\0").decode("ascii", "replace") for part in (name, dtype))
    try:
        field, itemsize = _checked(where, Field(text, kind, tuple(lengths[:dimensions])))
        whole = field.dtype == kind and itemsize * prod(field.shape) == size
    except InputError:
        whole = False
    if not whole or dimensions > DIMENSIONS or offset % 8 or not first <= offset <= limit - size:
        raise FileError(
            f"{where} is damaged: its field at byte {at} has no name, type or place that can be"
        )
    return Span(field, offset, size)


MAGIC, VERSION, PAGE = b"SKINFLD\0", 1, 4096
MARKS = 64
SLOT_HEADER = LINE
# indices of 64-bit words of the file
HEAD, FUTEX, LOG_END, LOG_RESERVED, HEARTBEAT, WRITER, GENERATION = 16, 24, 32, 33, 40, 48, 49
MARK = 64
SLOT_LOG_END, SLOT_GENERATION = 1, 2  # of a slot; its lock is word 0

_HEADER = struct.Struct("<8sII14Q")
_MOST = 1 << 40  # bytes that a file can be meant to have


class State(IntEnum):
    """What the writer of a ring is doing, as it says itself."""

    STARTING = 0
    CALIBRATING = 1
    RUNNING = 2
    STOPPED = 3
    FAILED = 4


class Header(NamedTuple):
    """What does not change, as it stands in the file's first 128 bytes."""

    magic: bytes
    version: int
    header_bytes: int
    file_bytes: int
    fields_offset: int
    slot_fields: int
    status_fields: int
    description_offset: int
    description_bytes: int
    status_offset: int
    status_bytes: int
    slots_offset: int
    slot_bytes: int
    slots: int
    log_offset: int
    log_bytes: int
    created_ns: int

    def pack(self) -> bytes:
        """Its bytes."""
        return _HEADER.pack(*self)

    @classmethod
    def read(cls, data: memoryview, where: str) -> Self:
        """Read and check it, as `Layout.read`: every part lies within the file afterwards."""
        if len(data) < PAGE or data[:8] != MAGIC:
            raise FileError(f"{where} is no ring, expected {PAGE} bytes that begin with SKINFLD")
        header = cls(*_HEADER.unpack_from(data))
        if (header.version, header.header_bytes) != (VERSION, PAGE):
            raise FileError(
                f"{where} has version {header.version}, expected {VERSION}: "
                "writer and reader must be of one version of skinfield"
            )
        if not header._fits(len(data)):
            raise FileError(f"{where} is damaged: its parts do not fit into its {len(data)} bytes")
        return header

    def _fits(self, size: int) -> bool:
        entries = ENTRY * (self.slot_fields + self.status_fields)
        ends = (
            (PAGE, self.fields_offset),
            (self.fields_offset + entries, self.description_offset),
            (self.description_offset + self.description_bytes, self.status_offset),
            (self.status_offset + self.status_bytes, self.slots_offset),
            (self.slots_offset + self.slots * self.slot_bytes, self.log_offset),
            (self.log_offset + self.log_bytes, self.file_bytes),
        )
        aligned = self.status_offset | self.slots_offset | self.slot_bytes | self.log_offset
        return (
            self.file_bytes == size <= _MOST
            and all(end <= start for end, start in ends)
            and aligned % LINE == 0
            and self.slots >= 2
            and self.slot_bytes >= SLOT_HEADER
            and self.log_bytes >= PAGE
            and self.log_bytes & (self.log_bytes - 1) == 0
        )

    @property
    def mark_shift(self) -> int:
        """A position in the log, shifted right by this, is its segment."""
        return (self.log_bytes // MARKS).bit_length() - 1

    @property
    def slot_starts(self) -> range:
        """Offset of each slot."""
        return range(
            self.slots_offset, self.slots_offset + self.slots * self.slot_bytes, self.slot_bytes
        )


@dataclass(frozen=True)
class Layout:
    """Header, fields and description of a ring.

    Attributes
    ----------
    header : Header
    slot_fields, status_fields : tuples of Span
    description : bytes
        JSON.
    """

    header: Header
    slot_fields: tuple[Span, ...]
    status_fields: tuple[Span, ...]
    description: bytes

    @classmethod
    def plan(
        cls,
        slot_fields: Sequence[Field],
        status_fields: Sequence[Field],
        description: Mapping[str, Any],
        slots: int,
        log_bytes: int,
        created_ns: int = 0,
    ) -> Self:
        """Decide where everything lies; each part begins with a page.

        Raises
        ------
        InputError
            If a field, the description or a number cannot be used.
        """
        _check_sizes(slots, log_bytes)
        text = _json(description)
        in_slot, slot_bytes = place("slot_fields", slot_fields, SLOT_HEADER)
        in_status, status_bytes = place("status_fields", status_fields, 0)
        description_offset = _page(PAGE + ENTRY * (len(in_slot) + len(in_status)))
        status_offset = _page(description_offset + len(text))
        slots_offset = _page(status_offset + status_bytes)
        log_offset = _page(slots_offset + slots * slot_bytes)
        header = Header(
            magic=MAGIC,
            version=VERSION,
            header_bytes=PAGE,
            file_bytes=log_offset + log_bytes,
            fields_offset=PAGE,
            slot_fields=len(in_slot),
            status_fields=len(in_status),
            description_offset=description_offset,
            description_bytes=len(text),
            status_offset=status_offset,
            status_bytes=status_bytes,
            slots_offset=slots_offset,
            slot_bytes=slot_bytes,
            slots=slots,
            log_offset=log_offset,
            log_bytes=log_bytes,
            created_ns=created_ns,
        )
        return cls(header, in_slot, in_status, text)

    def beginning(self) -> bytes:
        """Everything up to the status, for a new file."""
        data = bytearray(self.header.status_offset)
        entries = table(self.slot_fields) + table(self.status_fields)
        for start, part in (
            (0, self.header.pack()),
            (self.header.fields_offset, entries),
            (self.header.description_offset, self.description),
        ):
            data[start : start + len(part)] = part
        return bytes(data)

    @classmethod
    def read(cls, data: memoryview, where: str) -> Self:
        """Read and check the layout of a file; every offset lies within it afterwards.

        Parameters
        ----------
        data : memoryview
            The whole file.
        where : str
            For errors.

        Raises
        ------
        FileError
            If it is no ring, of another version, or damaged.
        """
        header = Header.read(data, where)
        first, start = header.fields_offset, header.description_offset
        middle = first + ENTRY * header.slot_fields
        return cls(
            header,
            read_table(data, first, header.slot_fields, SLOT_HEADER, header.slot_bytes, where),
            read_table(data, middle, header.status_fields, 0, header.status_bytes, where),
            bytes(data[start : start + header.description_bytes]),
        )

    def described(self, where: str) -> dict[str, Any]:
        """Read the description.

        Raises
        ------
        FileError
            If it is no JSON object.
        """
        try:
            found = json.loads(self.description.decode())
        except (ValueError, RecursionError) as error:
            raise FileError(f"description of {where} is damaged, expected JSON: {error}") from error
        if not isinstance(found, dict):
            raise FileError(f"description of {where} is damaged, expected a JSON object")
        return found

    def difference(self, other: "Layout") -> str:
        """Say where another ring differs in fields or sizes; nothing where it does not."""
        asked, there = (
            [
                f"{each.header.slots} slots",
                f"{each.header.log_bytes} bytes of the log",
                *(str(placed.field) for placed in (*each.slot_fields, *each.status_fields)),
            ]
            for each in (self, other)
        )
        pairs = zip_longest(asked, there, fillvalue="nothing")
        return next((f"{ours} asked for, it has {its}" for ours, its in pairs if ours != its), "")


def _check_sizes(slots: int, log_bytes: int) -> None:
    check_count("slots", slots, 2, 1 << 20, "slots, so that readers have time to copy one")
    check_count("log_bytes", log_bytes, PAGE, 1 << 36, "bytes of the log")
    if log_bytes & (log_bytes - 1):
        raise InputError(
            f"log_bytes is {log_bytes}, expected a power of two: "
            f"take {1 << int(log_bytes).bit_length()}"
        )


def _json(description: Mapping[str, Any]) -> bytes:
    try:
        return json.dumps(dict(description), allow_nan=False).encode()
    except (TypeError, ValueError) as error:
        raise InputError(
            "description cannot be written as JSON, expected a mapping of plain finite values: "
            f"{error}"
        ) from error


def _page(offset: int) -> int:
    return -(-offset // PAGE) * PAGE
