"""Packing CAN messages as python-can's `udp_multicast` does, octet for octet, compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Floats, Ints
from skinfield.sources.buses.can_map_kernel import (
    DATA,
    DLC,
    ERROR_FRAME,
    EXTENDED_ID,
    ID,
    KEYS,
    LONGEST,
    NAMES,
    REMOTE,
    REMOTE_FRAME,
    flag_of,
)

HEAD = 0x80 | len(NAMES)  # a map of so many pairs
TIMESTAMP, CHANNEL = 0, 5
ENCODED = 192  # bytes that no encoded message exceeds


@njit(cache=True, nogil=True)
def put_big_endian(octets: Octets, at: int, tag: int, number: int, width: int) -> int:
    """Write a tag and a number behind it; where that ends."""
    octets[at] = tag
    for i in range(width):
        octets[at + 1 + i] = (number >> (8 * (width - 1 - i))) & 0xFF
    return at + 1 + width


@njit(cache=True, nogil=True)
def put_number(octets: Octets, at: int, number: int) -> int:
    """Write a number from 0 on in the fewest octets; where that ends."""
    if number < 0x80:
        octets[at] = number
        return at + 1
    if number <= 0xFF:
        return put_big_endian(octets, at, 0xCC, number, 1)
    if number <= 0xFFFF:
        return put_big_endian(octets, at, 0xCD, number, 2)
    return put_big_endian(octets, at, 0xCE, number, 4)


@njit(cache=True, nogil=True)
def pack_message(
    octets: Octets, at: int, identifier: int, length: int, data: Octets, time_bits: int
) -> int:
    """Write one message at `at`, where `ENCODED` bytes must be free; where it ends."""
    octets[at] = HEAD
    at += 1
    for key in range(len(KEYS)):
        size: Any = np.int64(KEYS[key, 0])
        octets[at] = 0xA0 | size
        for i in range(size):
            octets[at + 1 + i] = KEYS[key, 1 + i]
        at += 1 + size
        if key == TIMESTAMP:
            at = put_big_endian(octets, at, 0xCB, time_bits, 8)
        elif key == ID:
            at = put_number(octets, at, identifier & 0x1FFFFFFF)
        elif key == DLC:
            at = put_number(octets, at, length)
        elif key == DATA:
            present = 0 if identifier & REMOTE else length
            octets[at], octets[at + 1] = 0xC4, present
            for i in range(present):
                octets[at + 2 + i] = data[i]
            at += 2 + present
        elif key == CHANNEL:
            octets[at] = 0xC0
            at += 1
        else:
            octets[at] = 0xC3 if identifier & flag_of(key) and is_flag(key) else 0xC2
            at += 1
    return at


@njit(cache=True, nogil=True)
def is_flag(key: int) -> bool:
    """Whether the key's value is a bit of the identifier."""
    return key in (EXTENDED_ID, REMOTE_FRAME, ERROR_FRAME)


@njit(cache=True, nogil=True)
def pack_messages(
    ids: NDArray[np.uint32],
    sizes: Octets,
    data: Octets,
    stamp_ns: Ints,
    first: int,
    count: int,
    octets: Octets,
    stride: int,
    lengths: Ints,
    seconds: Floats,
    bits: Ints,
) -> None:
    """Write `count` messages from row `first` on, one per row of `stride` bytes.

    Parameters
    ----------
    seconds, bits : (1,) float64 and int64 arrays
        The same memory, for the timestamp's bits.
    """
    for i in range(count):
        row = first + i
        seconds[0] = stamp_ns[row] * 1e-9
        at = i * stride
        identifier: Any = np.int64(ids[row])
        length: Any = np.int64(sizes[row])
        end = pack_message(octets, at, identifier, min(length, LONGEST), data[row], bits[0])
        lengths[i] = end - at
