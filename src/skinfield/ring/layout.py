"""Bytes of a ring's file, little-endian.

====== ===== ==========================================================================
offset bytes what
====== ===== ==========================================================================
0      8     ``SKINFLD`` and a zero
8      4     version of this layout (uint32)
12     4     bytes of this header, 4096 (uint32)
16     8     bytes of the file (uint64, as all that follows)
24     8     offset of the table of fields: first those of a slot, then those of the status
32     8     how many fields a slot has
40     8     how many fields the status has
48     8     offset of the description, a JSON object in UTF-8
56     8     bytes of the description
64     8     offset of the status
72     8     bytes of the status
80     8     offset of the slots
88     8     bytes of a slot, a multiple of 64
96     8     slots
104    8     offset of the log
112    8     bytes of the log, a power of two
120    8     when the ring was made, ns since the epoch
128    8     head: number of the newest complete slot, 0 before the first
192    4     futex: the lower half of head; written after head, woken on after that
256    8     log end: bytes ever appended, always the end of a batch
264    8     log reserved: bytes that may have been written; never below log end
320    8     heartbeat, ns of CLOCK_MONOTONIC
384    4     process of the writer (uint32)
388    4     `State` (uint32)
392    4     generation: 1 for the first writer, one more for each that went on (uint32)
512    512   marks: 64 ends of batches (uint64), see below
====== ===== ==========================================================================

What changes has cache lines of its own. Entries of the table of fields have 128 bytes:

====== ===== ==========================================================================
offset bytes what
====== ===== ==========================================================================
0      48    name, filled up with zeros
48     8     type as in NumPy: ``<f8``, ``<f4``, ``<i8``, ``<u4``, ``|u1``, ``|b1``, ...
56     8     offset from the beginning of the slot, or of the status
64     8     bytes
72     8     dimensions, 0 to 6
80     48    shape, six uint64
====== ===== ==========================================================================

A slot begins with 64 bytes of its own; fields lie behind:

====== ===== ==========================================================================
offset bytes what
====== ===== ==========================================================================
0      8     lock: 2 n + 1 while slot n is written, 2 n + 2 when it is complete
8      8     log end when the slot was complete
16     8     generation of its writer
====== ===== ==========================================================================

Slot n lies at index n modulo the number of slots. Byte p of the log lies at p modulo its size.
The log is divided into 64 segments; mark i is the first end of a batch in the newest segment that
is i modulo 64 in the endless row of segments. A reader that was too slow goes on at a mark.
"""

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from skinfield.errors import FileError, InputError, check_count
from skinfield.ring.fields import ENTRY, LINE, Field, Placed, place, read_table, table

MAGIC, VERSION, PAGE = b"SKINFLD\0", 1, 4096
MARKS = 64
SLOT_HEADER = LINE
# indices of 64-bit words
HEAD, FUTEX, LOG_END, LOG_RESERVED, HEARTBEAT, WRITER, GENERATION = 16, 24, 32, 33, 40, 48, 49
MARK = 64
LOCK, SLOT_LOG_END, SLOT_GENERATION = 0, 1, 2  # within a slot

_HEADER = struct.Struct("<8sII14Q")
_MOST = 1 << 40  # bytes of a file that can be meant


class State(IntEnum):
    """What the writer of a ring is doing, as it says itself."""

    STARTING = 0
    CALIBRATING = 1
    RUNNING = 2
    STOPPED = 3
    FAILED = 4


@dataclass(frozen=True)
class Layout:
    """Where everything lies in a ring's file; offsets and sizes in bytes.

    Attributes
    ----------
    slot_fields, status_fields : tuples of Placed
    description : bytes
        JSON.
    """

    slot_fields: tuple[Placed, ...]
    status_fields: tuple[Placed, ...]
    description: bytes
    file_bytes: int
    fields_offset: int
    description_offset: int
    status_offset: int
    status_bytes: int
    slots_offset: int
    slot_bytes: int
    slots: int
    log_offset: int
    log_bytes: int

    @classmethod
    def plan(
        cls,
        slot_fields: Sequence[Field],
        status_fields: Sequence[Field],
        description: Mapping[str, Any],
        slots: int,
        log_bytes: int,
    ) -> "Layout":
        """Decide where everything lies.

        Raises
        ------
        InputError
            If a field, the description or a number cannot be used.
        """
        check_count("slots", slots, 2, 1 << 20, "slots that readers may still be copying")
        check_count("log_bytes", log_bytes, PAGE, 1 << 36, "bytes of the log")
        if log_bytes & (log_bytes - 1):
            raise InputError(
                f"log_bytes is {log_bytes}, expected a power of two: "
                f"take {1 << log_bytes.bit_length()}"
            )
        text = _json(description)
        in_slot, slot_bytes = place("slot_fields", slot_fields, SLOT_HEADER)
        in_status, status_bytes = place("status_fields", status_fields, 0)
        fields_offset = PAGE
        description_offset = _page(PAGE + ENTRY * (len(in_slot) + len(in_status)))
        status_offset = _page(description_offset + len(text))
        slots_offset = _page(status_offset + status_bytes)
        log_offset = _page(slots_offset + slots * slot_bytes)
        return cls(
            in_slot,
            in_status,
            text,
            log_offset + log_bytes,
            fields_offset,
            description_offset,
            status_offset,
            status_bytes,
            slots_offset,
            slot_bytes,
            slots,
            log_offset,
            log_bytes,
        )

    def beginning(self, created_ns: int) -> bytes:
        """Everything up to the status, for a new file."""
        header = _HEADER.pack(
            MAGIC,
            VERSION,
            PAGE,
            self.file_bytes,
            self.fields_offset,
            len(self.slot_fields),
            len(self.status_fields),
            self.description_offset,
            len(self.description),
            self.status_offset,
            self.status_bytes,
            self.slots_offset,
            self.slot_bytes,
            self.slots,
            self.log_offset,
            self.log_bytes,
            created_ns,
        )
        data = bytearray(self.status_offset)
        entries = table(self.slot_fields) + table(self.status_fields)
        for start, part in (
            (0, header),
            (self.fields_offset, entries),
            (self.description_offset, self.description),
        ):
            data[start : start + len(part)] = part
        return bytes(data)

    @classmethod
    def read(cls, data: memoryview, where: str) -> "Layout":
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
            If it is no ring, or of another version, or damaged.
        """
        if len(data) < PAGE or data[:8] != MAGIC:
            raise FileError(f"{where} is no ring, expected {PAGE} bytes that begin with SKINFLD")
        (_, version, header, size, fields, n_slot, n_status, text, text_bytes) = (
            _HEADER.unpack_from(data)[:9]
        )
        status, status_bytes, slots_at, slot_bytes, slots, log, log_bytes, _ = _HEADER.unpack_from(
            data
        )[9:]
        if (version, header) != (VERSION, PAGE):
            raise FileError(
                f"{where} has version {version}, expected {VERSION}: "
                "writer and reader must be of one version of skinfield"
            )
        good = (
            size == len(data) <= _MOST
            and PAGE <= fields <= text <= status <= slots_at <= log <= size
            and fields + ENTRY * (n_slot + n_status) <= text
            and text + text_bytes <= status
            and status + status_bytes <= slots_at
            and slots >= 2
            and slot_bytes >= SLOT_HEADER
            and slots_at + slots * slot_bytes <= log
            and log_bytes >= PAGE
            and log_bytes & (log_bytes - 1) == 0
            and log + log_bytes <= size
            and not (status | slots_at | slot_bytes | log) % LINE
        )
        if not good:
            raise FileError(f"{where} is damaged: its parts do not fit into its {len(data)} bytes")
        middle = fields + ENTRY * n_slot
        in_slot = read_table(data, fields, n_slot, SLOT_HEADER, slot_bytes, where)
        in_status = read_table(data, middle, n_status, 0, status_bytes, where)
        description = bytes(data[text : text + text_bytes])
        return cls(
            in_slot,
            in_status,
            description,
            size,
            fields,
            text,
            status,
            status_bytes,
            slots_at,
            slot_bytes,
            slots,
            log,
            log_bytes,
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

    @property
    def mark_shift(self) -> int:
        """Position in the log, shifted right by this, is the segment."""
        return (self.log_bytes // MARKS).bit_length() - 1

    def shape(self) -> tuple[object, ...]:
        """What must be equal for another writer to go on: fields, slots, log."""
        return (self.slot_fields, self.status_fields, self.slots, self.log_bytes)

    def difference(self, other: "Layout") -> str:
        """Say in a few words where another differs."""
        for what, ours, theirs in (
            ("slots", self.slots, other.slots),
            ("bytes of the log", self.log_bytes, other.log_bytes),
        ):
            if ours != theirs:
                return f"{ours} {what} are asked for, it has {theirs}"
        ours_fields = (*self.slot_fields, *self.status_fields)
        fields = {*ours_fields} ^ {*other.slot_fields, *other.status_fields}
        first = min(fields, default=None)
        if first is None:
            return "the fields stand in another order"
        return f"field {first.field} is only {'asked for' if first in ours_fields else 'there'}"


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
