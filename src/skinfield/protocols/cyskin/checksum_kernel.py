"""Checksums of CySkin's packets, compiled; numbers and tables are those of `checksum`."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets

SUM, UNCHECKED = 0, 2
HOW, WIDTH, BEGIN, FINAL, REFLECTED, HIGH_FIRST = 0, 1, 2, 3, 4, 5  # of `numbers`

Table = NDArray[np.int64]


@njit(cache=True, nogil=True)
def summed(octets: Octets, start: int, stop: int, numbers: Table, table: Table) -> int:
    """Checksum of `octets[start:stop]` as a number, in the order of its octets on the wire.

    Parameters
    ----------
    octets : (L,) uint8 array
    numbers : (6,) int64 array
    table : (256,) int64 array
    """
    how, width, crc = numbers[HOW], numbers[WIDTH], numbers[BEGIN]
    if how == UNCHECKED:
        return 0
    if how == SUM:
        total = 0
        for i in range(start, stop):
            total += int(octets[i])
        return -total & 0xFF if numbers[FINAL] else total & 0xFF
    mask, top = (1 << (8 * width)) - 1, 8 * width - 8
    for i in range(start, stop):
        octet = int(octets[i])
        if numbers[REFLECTED]:
            crc = (crc >> 8) ^ table[(crc ^ octet) & 0xFF]
        else:
            crc = ((crc << 8) & mask) ^ table[((crc >> top) ^ octet) & 0xFF]
    crc ^= numbers[FINAL]
    if width == 2 and numbers[HIGH_FIRST]:
        crc = ((crc & 0xFF) << 8) | (crc >> 8)
    return int(crc)


@njit(cache=True, nogil=True)
def is_summed(octets: Octets, start: int, stop: int, numbers: Table, table: Table) -> bool:
    """Whether the checksum behind `octets[start:stop]` is right."""
    if numbers[HOW] == UNCHECKED:
        return True
    crc = summed(octets, start, stop, numbers, table)
    right = True
    for i in range(numbers[WIDTH]):
        right = right and octets[stop + i] == (crc >> (8 * i)) & 0xFF
    return right
