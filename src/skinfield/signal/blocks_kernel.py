"""Writing and applying blocks, compiled. The layout is that of `block`.

Kernels get the same memory twice: as words (int64) and as octets (uint8). Numba checks no bounds,
so each function checks before it writes.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.signal.block import BITS, NUMBERS, Octets, Words

BYTES, SHORTS, FLOATS, STATUS, SOURCE, LOST = 1, 2, 3, 4, 5, 6  # as `Kind`
OUT_OF_RANGE = 4  # as `Status`
HEADER_WORDS = 2
# Counts older than their channel's by less are late; by more, a clock was set.
LATE_NS = 1_000_000_000
FULL = -1


@inner(inline="always")
def payload_words(kind: int, count: int) -> int:
    """Words of a payload; -1 for an unknown kind."""
    if kind in NUMBERS:
        return 1
    return (int(BITS[kind]) * count + 63) >> 6 if 0 < kind < len(BITS) else -1


@inner(inline="always")
def count_at(
    octets: Octets,
    shorts: NDArray[np.uint16],
    singles: NDArray[np.float32],
    kind: int,
    payload: int,
    i: int,
) -> float:
    """Count `i` of a block whose payload begins at word `payload`."""
    if kind == BYTES:
        return np.float64(octets[8 * payload + i])
    if kind == SHORTS:
        return np.float64(shorts[4 * payload + i])
    return np.float64(singles[2 * payload + i])


@njit
def begin_block(
    words: Words, end: Words, stamp_ns: int, channel: int, count: int, kind: int, status: int
) -> int:
    """Begin a block at word `end[0]` and move that behind it; payload is all zeros.

    Parameters
    ----------
    words : (W,) int64 array
    end : (1,) int64 array
        Words used.

    Returns
    -------
    int
        Index of the payload's first octet, or -1 if the block does not fit; then nothing changed.
    """
    at, size = end[0], payload_words(kind, count)
    if size < 0 or at + HEADER_WORDS + size > len(words):
        return FULL
    words[at] = stamp_ns
    words[at + 1] = (
        (channel & 0xFFFFFFFF) | ((count & 0xFFFF) << 32) | ((kind & 0xFF) << 48) | (status << 56)
    )
    for i in range(at + HEADER_WORDS, at + HEADER_WORDS + size):
        words[i] = 0
    end[0] = at + HEADER_WORDS + size
    return int((at + HEADER_WORDS) * 8)


@njit
def apply_blocks(
    words: Words,
    octets: Octets,
    shorts: NDArray[np.uint16],
    singles: NDArray[np.float32],
    start: int,
    stop: int,
    counts: Floats,
    stamps: Ints,
    status: Octets,
    fresh: Octets,
) -> int:
    """Apply the blocks in `words[start:stop]`: the newest counts, stamps and status per channel.

    Parameters
    ----------
    words, octets, shorts, singles : arrays
        One memory, as int64, uint8, uint16 and float32.
    start, stop : int
        Words; whole blocks.
    counts : (C,) float64 array
        Written where a block brings counts, but for those that a later reading overtook; NaN
        where it says that a taxel did not answer.
    stamps : (C,) int64 array, ns
    status : (C,) uint8 array
        Of `Status`.
    fresh : (C,) uint8 array
        Set to 1 where a block brings counts.

    Returns
    -------
    int
        Blocks that were applied; minus the word at which something is no block, less 1.
    """
    at, applied, channels = start, 0, len(counts)
    while at < stop:
        if at + HEADER_WORDS > stop:
            return -at - 1
        head = words[at + 1]
        first, count = head & 0xFFFFFFFF, (head >> 32) & 0xFFFF
        kind, bits = (head >> 48) & 0xFF, (head >> 56) & 0xFF
        size = payload_words(kind, count)
        if size < 0 or at + HEADER_WORDS + size > stop:
            return -at - 1
        if kind <= STATUS:
            if first + count > channels:
                return -at - 1
            stamp, payload = words[at], at + HEADER_WORDS
            for i in range(count):
                to = first + i
                if kind == STATUS:
                    beyond = (octets[8 * payload + (i >> 3)] >> (i & 7)) & 1
                    status[to] = bits | (OUT_OF_RANGE if beyond else 0)
                elif not 0 < stamps[to] - stamp < LATE_NS:  # else it was overtaken on its way
                    counts[to] = count_at(octets, shorts, singles, kind, payload, i)
                    stamps[to] = stamp
                    fresh[to] = 1
                    if bits:
                        status[to] = bits
        applied += 1 if kind <= LOST else 0
        at += HEADER_WORDS + size
    return applied
