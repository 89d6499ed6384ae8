"""Arrays of CAN messages inside the Ethernet of iCub's boards, compiled.

Numba checks no bounds: sizes are checked here before anything is read or written.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints

HEAD_BYTES, ITEM_BYTES = 4, 10
NO_ARRAY, NO_ROOM = -1, -2


@njit(cache=True, nogil=True)
def messages_of_array(
    octets: Octets,
    length: int,
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    stamps: Ints,
    first: int,
    stamp_ns: int,
) -> int:
    """Row behind the last message written, `NO_ARRAY` or `NO_ROOM`; then nothing was written."""
    if length < HEAD_BYTES or length > len(octets):
        return NO_ARRAY
    capacity, item, size = int(octets[0]), int(octets[1]), int(octets[2])
    if item != ITEM_BYTES or size > capacity or HEAD_BYTES + ITEM_BYTES * size > length:
        return NO_ARRAY
    for k in range(size):
        if octets[HEAD_BYTES + ITEM_BYTES * k + 1] >> 4 > 8:
            return NO_ARRAY
    if first + size > len(ids):
        return NO_ROOM
    for k in range(size):
        at, row = HEAD_BYTES + ITEM_BYTES * k, first + k
        ids[row] = octets[at] | (np.uint32(octets[at + 1] & 15) << 8)
        lengths[row] = octets[at + 1] >> 4
        stamps[row] = stamp_ns
        for i in range(8):
            data[row, i] = octets[at + 2 + i] if i < lengths[row] else 0
    return int(first + size)
