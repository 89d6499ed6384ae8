"""CRC-16/CCITT-FALSE, eight bytes at a time: polynomial 0x1021, begins with 0xFFFF, not reflected.

Of the ASCII digits 123456789 it is 0x29B1. `binascii.crc_hqx(data, 0xFFFF)` is the same sum.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets

BEGIN = 0xFFFF


def _tables() -> NDArray[np.uint16]:
    """What a byte contributes (8, 256), after which 0 to 7 others follow."""
    crc = np.arange(256, dtype=np.uint32) << 8
    for _ in range(8):
        crc = ((crc << 1) ^ np.where(crc & 0x8000, 0x1021, 0).astype(np.uint32)) & 0xFFFF
    rows = [crc]
    for _ in range(7):
        last = rows[-1]
        rows.append(((last << 8) ^ crc[last >> 8]) & 0xFFFF)
    return np.array(rows, np.uint16)


TABLES = _tables()


@njit(cache=True, nogil=True)
def crc_ccitt(octets: Octets, start: int, stop: int) -> int:
    """Sum of `octets[start:stop]`."""
    crc, at = np.uint32(BEGIN), start
    while at + 8 <= stop:
        crc = np.uint32(
            TABLES[7, octets[at] ^ (crc >> 8)]
            ^ TABLES[6, octets[at + 1] ^ (crc & 0xFF)]
            ^ TABLES[5, octets[at + 2]]
            ^ TABLES[4, octets[at + 3]]
            ^ TABLES[3, octets[at + 4]]
            ^ TABLES[2, octets[at + 5]]
            ^ TABLES[1, octets[at + 6]]
            ^ TABLES[0, octets[at + 7]]
        )
        at += 8
    while at < stop:
        crc = np.uint32(((crc << 8) & 0xFFFF) ^ TABLES[0, (crc >> 8) ^ octets[at]])
        at += 1
    return int(crc)
