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
388    4     state: 0 starting, 1 calibrating, 2 running, 3 stopped, 4 failed (uint32)
392    4     generation: 1 for the first writer, one more for each that went on (uint32)
512    512   marks: 64 ends of batches (uint64), see below
====== ===== ==========================================================================

What changes has cache lines of its own. Entries of the table of fields have 128 bytes:

====== ===== ==========================================================================
offset bytes what
====== ===== ==========================================================================
0      48    name, filled up with zeros
48     8     type as in NumPy: ``<f8``, ``<i4``, ...; ``u1`` and ``b1`` have a bar before
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

import struct
from enum import IntEnum
from typing import NamedTuple, Self

from skinfield.errors import FileError
from skinfield.ring.fields import ENTRY, LINE

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
        """Read and check it: every part lies within the file afterwards.

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
