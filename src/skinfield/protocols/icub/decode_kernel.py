"""iCub's CAN messages to blocks, compiled.

Numba checks no bounds: indices are masked to the size of the tables, rows are below `count`, which
the caller checked, and blocks are begun by `begin_block`, which does.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets, Words
from skinfield.acquisition.kernel import begin_block
from skinfield.errors import Ints
from skinfield.protocols.icub.order_kernel import follow, has_same_data

BYTES, STATUS = 1, 4  # as `Kind`
OUT_OF_RANGE = 4  # as `Status`
RECEIVED, READINGS, MALFORMED, FOREIGN, OCTETS = 0, 1, 4, 5, 10  # as `Count`
HEAD, TAIL = 0x40, 0xC0
HIGHEST_ID = 0x7FF
MEANINGLESS, OF_OTHERS = -1, -2  # no head and no tail
TAIL_WORDS = 6  # a block of 5 counts and one of status


@njit(cache=True, nogil=True)
def decode_messages(
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    stamps: Ints,
    first: int,
    count: int,
    positions: Ints,
    classes: int,
    state: Octets,
    seen: Ints,
    boards: Ints,
    newest: Octets,
    words: Words,
    octets: Octets,
    end: Words,
    channel: int,
    counters: Ints,
) -> int:
    """Append the blocks of messages `first` to `count`; the first that does not fit, or `count`.

    Parameters
    ----------
    ids, lengths, data, stamps : arrays
        Of `CanMessages`.
    positions : (16,) int64 array
        Place of each board in the port, -1 of one that is not ours.
    classes : int
        Bit c is set if messages of class c are readings.
    state, seen, boards : arrays
        Of `follow`.
    newest : (512, 8) uint8 array
        Last data of each triangle's two parts.
    words, octets, end : arrays
        Of `Blocks`.
    channel : int
        Of the port's first taxel.
    counters : (len(Count),) int64 array
    """
    for i in range(first, count):
        identifier, length = int(ids[i]), min(int(lengths[i]), 8)
        head = is_head(identifier, lengths[i], data, i, classes)
        place = positions[(identifier >> 4) & 15]
        if head < 0 or place < 0:
            broken = head == MEANINGLESS and (place >= 0 or identifier > HIGHEST_ID)
            counters[MALFORMED if broken else FOREIGN] += 1
            counters[OCTETS] += length
            continue
        if end[0] + TAIL_WORDS > len(words):
            return i
        counters[RECEIVED] += 1
        counters[OCTETS] += length
        triangle = identifier & 255
        same = has_same_data(data, i, newest, 2 * triangle + 1 - head, length)
        if not follow(triangle, 2 - head, same, stamps[i], state, seen, boards, counters):
            continue
        at = channel + 192 * place + 12 * (triangle & 15)
        put_part(words, octets, end, stamps[i], at, head, length, data, i)
        counters[READINGS] += 1
    return count


@njit(cache=True, nogil=True)
def is_head(identifier: int, length: int, data: Octets, row: int, classes: int) -> int:
    """1 of a head, 0 of a tail; or `MEANINGLESS`, or `OF_OTHERS`."""
    if identifier & 0x80000000:
        return OF_OTHERS
    if identifier > HIGHEST_ID or length > 8:
        return MEANINGLESS
    if not (classes >> (identifier >> 8)) & 1:
        return OF_OTHERS
    if length == 8 and data[row, 0] == HEAD:
        return 1
    if length >= 6 and data[row, 0] == TAIL:
        return 0
    return MEANINGLESS


@njit(cache=True, nogil=True)
def put_part(
    words: Words,
    octets: Octets,
    end: Words,
    stamp_ns: int,
    channel: int,
    head: int,
    length: int,
    data: Octets,
    row: int,
) -> None:
    """Append a part's counts, and a tail's status; there is room for both."""
    first, taxels = (channel, 7) if head else (channel + 7, 5)
    at = begin_block(words, end, stamp_ns, first, taxels, BYTES, 0)
    if at < 0:
        return
    for k in range(taxels):
        octets[at + k] = data[row, 1 + k]
    if head or length < 8:
        return
    at = begin_block(words, end, stamp_ns, channel, 12, STATUS, data[row, 7] & 3)
    if at < 0:
        return
    beyond = (np.int64(data[row, 6]) << 4) | (np.int64(data[row, 7]) >> 4)
    octets[at] = beyond & 0xFF
    octets[at + 1] = beyond >> 8
