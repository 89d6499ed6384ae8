"""When each board of a bus was heard last, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Ints

UNCONFIGURED, CONFIGURED = 3, 4  # classes of readings, as `MessageClass`
HIGHEST_ID = 0x7FF


@njit(cache=True, nogil=True)
def note_boards(
    ids: NDArray[np.uint32], stamp_ns: Ints, count: int, heard_ns: Ints, classes: Ints
) -> None:
    """Note the newest stamp and class of each board's readings.

    Parameters
    ----------
    ids, stamp_ns : (N,) arrays
        Of `CanMessages`.
    heard_ns, classes : (16,) int64 arrays
        Written.
    """
    for i in range(count):
        if ids[i] <= HIGHEST_ID:
            kind, board = ids[i] >> 8, (ids[i] >> 4) & 15
            if kind in (UNCONFIGURED, CONFIGURED):
                heard_ns[board] = stamp_ns[i]
                classes[board] = kind


@njit(cache=True, nogil=True)
def note_senders(
    ids: NDArray[np.uint32], stamp_ns: Ints, count: int, mask: int, numbers: Ints, heard_ns: Ints
) -> None:
    """Note the newest stamp of each sender: `numbers` (B,) are what the identifiers' `mask` holds.

    Parameters
    ----------
    ids, stamp_ns : (N,) arrays
        Of `CanMessages`.
    heard_ns : (B,) int64 array
        Written.
    """
    for i in range(count):
        for k in range(len(numbers)):
            if ids[i] & mask == numbers[k]:
                heard_ns[k] = stamp_ns[i]
