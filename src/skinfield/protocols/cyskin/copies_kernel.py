"""CAN messages of CySkin that came twice, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.protocols.cyskin.checksum_kernel import is_summed

FIRST, LAST = 1, 4  # as `Part`
IDLE = -1  # instead of how many octets of a packet came

Table = NDArray[np.int64]


@njit(cache=True, nogil=True)
def is_copy(
    packet: Octets, so_far: int, done: int, part: int, data: Octets, message: int, length: int
) -> bool:
    """Whether a first or last message is the one before it, once more."""
    if part == FIRST and so_far == length:
        at = 0
    elif part == LAST and so_far == IDLE and done > 8 and length == ((done - 1) & 7) + 1:
        at = done - length
    else:
        return False
    same = True
    for k in range(length):
        same = same and packet[at + k] == data[message, k]
    return same


@njit(cache=True, nogil=True)
def repeats(packet: Octets, at: int, to: int) -> bool:
    """Whether the eight octets from `at` on are the eight that end before `to`."""
    same = True
    for k in range(8):
        same = same and packet[at + k] == packet[to - 8 + k]
    return same


@njit(cache=True, nogil=True)
def drop_copies(
    packet: Octets, length: int, stated: int, tail: int, check: Table, table: Table
) -> bool:
    """Take out messages that came twice, where length and checksum are right without them.

    Where as many messages repeat the one before as there are too many, it is all of these; else
    one too many is looked for among those that repeat.
    """
    many, found = (length - stated) >> 3, 0
    for at in range(8, length - 8, 8):
        found += repeats(packet, at, at)
    if found == many:
        to = 8
        for at in range(8, length, 8):
            if at >= length - 8 or not repeats(packet, at, to):
                for k in range(min(8, length - at)):
                    packet[to + k] = packet[at + k]
                to += 8
        return is_summed(packet, 0, stated - tail, check, table)
    for at in range(8, length - 8, 8):
        if many == 1 and repeats(packet, at, at) and sums_without(packet, at, length, check, table):
            return True
    return False


@njit(cache=True, nogil=True)
def sums_without(packet: Octets, at: int, length: int, check: Table, table: Table) -> bool:
    """Take out the eight octets from `at` on, which repeat those before, if the sum is right."""
    for k in range(at, length - 8):
        packet[k] = packet[k + 8]
    if is_summed(packet, 0, length - 8 - check[1], check, table):
        return True
    for k in range(length - 9, at - 1, -1):
        packet[k + 8] = packet[k]
    for k in range(at, at + 8):
        packet[k] = packet[k - 8]
    return False
