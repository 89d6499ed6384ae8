"""Blocks: what sources deliver and what is recorded.

A block is one run of channels that were read together: half a triangle of iCub, a burst of CySkin,
a whole patch. It is the unit in which nothing is lost: every reading that arrives becomes blocks,
blocks are logged as they come, and the counts that a cycle works on are what all blocks before it
left behind.

Layout, little-endian, each block a multiple of 8 bytes:

====== ===== ==========================================================================
offset bytes what
====== ===== ==========================================================================
0      8     stamp, ns since the epoch (int64): when the host took the reading in
8      4     first channel (uint32)
12     2     channels (uint16)
14     1     `Kind`
15     1     `Status` bits, of all these channels
16     ...   payload, see `Kind`; zeros up to a multiple of 8 bytes
====== ===== ==========================================================================

Channels are counted over all ports of all sources, in the order in which they were given.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from struct import unpack_from

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError

HEADER = 16  # bytes
WORD = 8  # bytes, of which every block is a multiple
LONGEST = 65535  # channels in one block

Words = NDArray[np.int64]
Octets = NDArray[np.uint8]


class Kind(IntEnum):
    """What a block's payload is."""

    BYTES = 1  # counts, uint8 each
    SHORTS = 2  # counts, uint16 each
    FLOATS = 3  # numbers in the port's unit, float32 each; NaN where a taxel did not answer
    STATUS = 4  # no counts: the status bits, and payload uint8 per 8 channels: out of range
    SOURCE = 5  # a source went down or came up; channel: its index; payload int64: 1 up, 0 down
    LOST = 6  # messages known to be lost; channel: the source's index; payload int64: how many


class Status(IntFlag):
    """What a source says of channels beside their counts."""

    OK = 0
    NO_ACK = 1  # a converter did not answer: the board's own flag
    NOT_CONNECTED = 2  # nothing is plugged in: the counts mean nothing
    OUT_OF_RANGE = 4  # further beyond a clamp than its byte can tell
    INVALID = 8  # must not be used, for another reason


UNUSABLE = int(Status.NOT_CONNECTED | Status.INVALID)
NUMBERS = int(Kind.SOURCE), int(Kind.LOST)  # kinds whose payload is one word
# Of payload per channel, by kind; from 7 on of settings in older recordings.
BITS = np.array([0, 8, 16, 32, 1, 0, 0, 384, 64, 128, 8])
DTYPES = ("", "<u1", "<u2", "<f4", "<u1", "<i8", "<i8")  # of the payload, by kind


@dataclass(frozen=True, eq=False)
class Block:
    """One block, read back.

    Attributes
    ----------
    stamp_ns : int, ns
    channel, count : int
        First channel and how many.
    kind : Kind
    status : Status
    payload : array
        (count,) of counts; (ceil(count / 8),) uint8 bits of STATUS; (1,) int64 of SOURCE and LOST.
    """

    stamp_ns: int
    channel: int
    count: int
    kind: Kind
    status: Status
    payload: NDArray[np.generic]


def _payload_bytes(kind: int, count: int) -> int:
    """Bytes of a block's payload, without the zeros that fill it up."""
    if not 0 < kind < len(BITS):
        raise InputError(
            f"kind of a block is {kind}, expected one of "
            f"{', '.join(str(int(each)) for each in Kind)}: the bytes are damaged, or of a newer "
            "version"
        )
    return WORD if kind in NUMBERS else (int(BITS[kind]) * count + 7) // 8


def block_bytes(kind: int, count: int) -> int:
    """Bytes of a whole block.

    Raises
    ------
    InputError
        If `kind` is none of `Kind`, nor of an older recording.
    """
    return HEADER + -(-_payload_bytes(kind, count) // WORD) * WORD


def blocks_of(data: bytes | memoryview | Octets) -> Iterator[Block]:
    """Read blocks one after the other, but for settings of older recordings; for tools.

    Raises
    ------
    InputError
        If the bytes end within a block, or a kind is unknown: what was yielded before is good.
    """
    view, at = np.frombuffer(data, np.uint8), 0
    while at < len(view):
        if len(view) - at < HEADER:
            raise InputError(
                f"blocks end after {len(view) - at} bytes of a header at byte {at}, expected "
                f"{HEADER}: the data was cut"
            )
        stamp, channel, count, kind, status = unpack_from("<qIHBB", view.data, at)
        size = block_bytes(kind, count)
        if len(view) - at < size:
            raise InputError(
                f"blocks end after {len(view) - at} bytes of the block at byte {at}, expected "
                f"{size}: the data was cut"
            )
        if kind < len(DTYPES):
            end = at + HEADER + _payload_bytes(kind, count)
            payload = view[at + HEADER : end].view(DTYPES[kind])
            yield Block(stamp, channel, count, Kind(kind), Status(status), payload)
        at += size
