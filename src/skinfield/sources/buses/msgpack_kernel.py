"""One item of msgpack at a time, compiled; the format is public (msgpack/spec.md).

Every function is told where the octets end and reads nothing behind that.
"""

from typing import Any

import numpy as np
from numba import njit

from skinfield.acquisition.block import Octets

BAD, NIL, BOOL, INT, FLOAT, TEXT, BINARY, ARRAY, MAP, OTHER = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
HUGE = 1 << 62  # stands for whole numbers that int64 does not hold


@njit(cache=True, nogil=True, forceinline=True)
def big_endian(octets: Octets, at: int, width: int) -> int:
    """Unsigned number of 1 to 8 octets; of 8 as a signed one."""
    number: Any = np.int64(0)
    for i in range(width):
        number = (number << 8) | np.int64(octets[at + i])
    return int(number)


@njit(cache=True, nogil=True, forceinline=True)
def signed(number: int, width: int) -> int:
    """The same bits as a signed number of so many octets."""
    if width < 8 and number >> (8 * width - 1):
        return number - (1 << (8 * width))
    return number


@njit(cache=True, nogil=True, forceinline=True)
def item_at(octets: Octets, at: int, end: int) -> tuple[int, int, int, int]:
    """Kind, number, start and octets of the body of the item at `at`.

    The number of an INT, a BOOL and a FLOAT (here only whether it is other than zero) is its value;
    that of an ARRAY or a MAP counts its members, whose octets are not part of the body.
    """
    if at >= end:
        return BAD, 0, at, 0
    tag: Any = np.int64(octets[at])
    if tag < 0x80:
        return INT, tag, at + 1, 0
    if tag < 0x90:
        return MAP, tag & 15, at + 1, 0
    if tag < 0xA0:
        return ARRAY, tag & 15, at + 1, 0
    if tag < 0xC0:
        return sized(TEXT, tag & 31, at + 1, end)
    if tag >= 0xE0:
        return INT, tag - 256, at + 1, 0
    if tag == 0xC0:
        return NIL, 0, at + 1, 0
    if tag == 0xC2 or tag == 0xC3:
        return BOOL, tag & 1, at + 1, 0
    if tag == 0xC1:
        return BAD, 0, at, 0
    return item_of_width(octets, tag, at + 1, end)


@njit(cache=True, nogil=True, forceinline=True)
def sized(kind: int, size: int, at: int, end: int) -> tuple[int, int, int, int]:
    """An item whose body is `size` octets from `at` on, if they are there."""
    if size > end - at:
        return BAD, 0, at, 0
    return kind, size, at, size


@njit(cache=True, nogil=True)
def item_of_width(octets: Octets, tag: int, at: int, end: int) -> tuple[int, int, int, int]:
    """An item whose tag says how many octets its number has."""
    if 0xCA <= tag <= 0xD3:
        return number_of_width(octets, tag, at, end)
    if 0xD4 <= tag <= 0xD8:  # fixext: a type and 1, 2, 4, 8 or 16 octets
        return sized(OTHER, 1 + (1 << (tag - 0xD4)), at, end)
    if tag <= 0xC9:  # 8, 16 or 32 bits of size, of bin (C4) and ext (C7)
        width = 1 << ((tag - 0xC4) % 3)
    elif tag <= 0xDB:
        width = 1 << (tag - 0xD9)
    else:  # arrays (DC, DD) and maps (DE, DF)
        width = 2 << (tag & 1)
    if width > end - at:
        return BAD, 0, at, 0
    size = big_endian(octets, at, width)
    at += width
    if tag >= 0xDC:
        return (ARRAY if tag <= 0xDD else MAP), size, at, 0
    if tag >= 0xD9:
        return sized(TEXT, size, at, end)
    if tag >= 0xC7:
        return sized(OTHER, size + 1, at, end)
    return sized(BINARY, size, at, end)


@njit(cache=True, nogil=True)
def number_of_width(octets: Octets, tag: int, at: int, end: int) -> tuple[int, int, int, int]:
    """A float (CA, CB), an unsigned (CC to CF) or a signed number (D0 to D3)."""
    width = 4 << (tag & 1) if tag <= 0xCB else 1 << ((tag - 0xCC) & 3)
    if width > end - at:
        return BAD, 0, at, 0
    number = big_endian(octets, at, width)
    if tag <= 0xCB:
        sign_left_out = 0x7FFFFFFF if width == 4 else 0x7FFFFFFFFFFFFFFF
        return FLOAT, 1 if number & sign_left_out else 0, at, width
    if tag >= 0xD0:
        return INT, signed(number, width), at, width
    return INT, HUGE if number < 0 or number > HUGE else number, at, width


@njit(cache=True, nogil=True)
def behind(octets: Octets, at: int, end: int) -> int:
    """Where the item at `at` ends, with all its members; -1 if it is cut or none.

    Each member takes an octet at least, so this ends however many members are claimed.
    """
    open_items = 1
    while open_items > 0:
        kind, number, body, size = item_at(octets, at, end)
        if kind == BAD:
            return -1
        open_items += (number if kind == ARRAY else 2 * number if kind == MAP else 0) - 1
        at = body + size
    return at
