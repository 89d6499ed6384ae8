"""What the firmware of iCub's boards makes of converter counts, compiled and bit-exact.

`mtb3/main_V3.c` and mtb4's `embot_app_application_theSkin.cpp` of robotology/icub-firmware, in
whole numbers without overflow. Numba checks no bounds: the caller checked the shapes.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints

Shorts = NDArray[np.uint16]
Bools = NDArray[np.bool_]
HEAD, TAIL = 0x40, 0xC0
NO_ACK, NOT_CONNECTED = 1, 2


@njit(cache=True, nogil=True)
def encode_messages(
    raw: Shorts,
    base: Shorts,
    sends: Bools,
    no_load: Ints,
    shift: Ints,
    gains: Ints,
    pad: Ints,
    negated_first: Bools,
    raw_test: Bools,
    identifiers: NDArray[np.uint32],
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    stamps: Ints,
    first: int,
    stamp_ns: int,
) -> int:
    """Write both messages of each triangle that sends; the row behind the last, or -1 if full.

    Parameters
    ----------
    raw, base : (T, 12) uint16 arrays, converter counts
    sends : (T,) bool array
    no_load, shift, pad : (T,) int64 arrays
    gains : (T, 12) int64 array
        Of the correction of drift, 128ths.
    negated_first : (T,) bool array
        True where a negative drift is shifted after its sign was taken.
    raw_test : (T,) bool array
        True where the low octets of `raw` are sent as they are.
    identifiers : (T,) uint32 array
        Of the messages.
    ids, lengths, data, stamps : arrays
        Of `CanMessages`.
    """
    row = first
    for t in range(len(raw)):
        if not sends[t]:
            continue
        if row + 2 > len(ids):
            return -1
        if raw_test[t]:
            encode_raw(raw[t], data, row)
        else:
            encode_triangle(
                raw[t], base[t], no_load[t], shift[t], gains[t], pad[t], negated_first[t], data, row
            )
        for part in range(2):
            ids[row + part] = identifiers[t]
            lengths[row + part] = 8
            stamps[row + part] = stamp_ns
        row += 2
    return row


@njit(cache=True, nogil=True)
def encode_triangle(
    raw: Shorts,
    base: Shorts,
    no_load: int,
    shift: int,
    gains: Ints,
    pad: int,
    negated_first: bool,
    data: Octets,
    row: int,
) -> None:
    """Write the data of a triangle's head and tail into rows `row` and `row` + 1."""
    low, high = -((255 - no_load) << shift), no_load << shift
    warmth = np.int64(raw[pad]) - np.int64(base[pad])
    beyond, unplugged, errors = 0, 0, 0
    data[row, 0], data[row + 1, 0] = HEAD, TAIL
    for i in range(12):
        drift = (abs(warmth) >> 2) * gains[i]
        if warmth >= 0:
            drift = drift >> 5
        elif negated_first:
            drift = (-drift) >> 5
        else:
            drift = -(drift >> 5)
        value = np.int64(raw[i]) - np.int64(base[i]) - drift
        byte = 255 if value <= low else 0 if value >= high else no_load - (value >> shift)
        if value <= 2 * low or value >= 2 * high:
            beyond |= 1 << i
        unplugged += raw[i] == 0xFFFF
        if raw[i] == 0 and base[i] != 0:
            errors = NO_ACK
        if i < 7:
            data[row, 1 + i] = byte
        else:
            data[row + 1, i - 6] = byte
    if unplugged == 12:
        errors = NOT_CONNECTED
    data[row + 1, 6] = (beyond >> 4) & 0xFF
    data[row + 1, 7] = ((beyond & 15) << 4) | errors


@njit(cache=True, nogil=True)
def encode_raw(raw: Shorts, data: Octets, row: int) -> None:
    """Write a triangle's low octets into rows `row` and `row` + 1, without diagnostics."""
    data[row, 0], data[row + 1, 0] = HEAD, TAIL
    for i in range(12):
        if i < 7:
            data[row, 1 + i] = raw[i] & 0xFF
        else:
            data[row + 1, i - 6] = raw[i] & 0xFF
    data[row + 1, 6] = data[row + 1, 7] = 0
