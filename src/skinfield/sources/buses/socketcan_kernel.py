"""Linux's struct can_frame, compiled: 4 octets of identifier, length, 3 of padding, 8 of data."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints

STRUCT = 16  # bytes of struct can_frame; CAN FD's is longer, and not asked for
ERROR, FLAGS, STANDARD = 0x20000000, 0xE0000000, 0x7FF
EXTENDED = 0x80000000
MALFORMED, ERRORS = 0, 1  # of `counts`


@njit(cache=True, nogil=True)
def messages_of_structs(
    octets: Octets,
    words: NDArray[np.uint32],
    lengths: Ints,
    stamps: Ints,
    count: int,
    first: int,
    ids: NDArray[np.uint32],
    sizes: Octets,
    data: Octets,
    stamp_ns: Ints,
    counts: Ints,
) -> int:
    """Read `count` structs into the arrays of `CanMessages` from row `first` on.

    Parameters
    ----------
    octets, words : arrays
        The structs, `STRUCT` bytes each, as uint8 and as uint32: the same memory.
    lengths, stamps : (N,) int64 arrays
        Bytes and stamp of each.
    counts : (2,) int64 array
        Written: see `MALFORMED` and `ERRORS`.

    Returns
    -------
    int
        First row that is free now.
    """
    for i in range(count):
        at, identifier = i * STRUCT, words[i * STRUCT // 4]
        size = octets[at + 4]
        if lengths[i] != STRUCT or size > 8 or first >= len(ids):
            counts[MALFORMED] += 1
        elif identifier & ERROR:
            counts[ERRORS] += 1
        else:
            ids[first], sizes[first], stamp_ns[first] = identifier, size, stamps[i]
            for j in range(8):
                data[first, j] = octets[at + 8 + j] if j < size else 0
            first += 1
    return first


@njit(cache=True, nogil=True)
def structs_of_messages(
    ids: NDArray[np.uint32],
    sizes: Octets,
    data: Octets,
    first: int,
    count: int,
    octets: Octets,
    words: NDArray[np.uint32],
    lengths: Ints,
) -> None:
    """Write `count` messages from row `first` on as structs of `STRUCT` bytes."""
    for i in range(count):
        at, row = i * STRUCT, first + i
        size = min(sizes[row], 8)
        words[at // 4] = ids[row]
        octets[at + 4] = size
        octets[at + 5], octets[at + 6], octets[at + 7] = 0, 0, 0
        for j in range(8):
            octets[at + 8 + j] = data[row, j] if j < size else 0
        lengths[i] = STRUCT
