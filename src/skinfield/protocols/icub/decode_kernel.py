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

BYTES, STATUS = 1, 4  # as `Kind`
OUT_OF_RANGE = 4  # as `Status`
RECEIVED, READINGS, LOST, MALFORMED, FOREIGN, DUPLICATED, SWAPPED, OCTETS = 0, 1, 2, 4, 5, 6, 7, 10
HEAD, TAIL = 0x40, 0xC0
NOTHING, HEAD_SEEN, TAIL_SEEN = 0, 1, 2  # state: the part that came last
HEAD_OWED, TAIL_OWED = 4, 8  # added to it: a part that should have come before the last one did
PART, OWED = 3, 12  # masks of the two
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
    window_ns: int,
    state: Octets,
    owed_ns: Ints,
    newest: Octets,
    last_ns: Ints,
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
    window_ns : int
        Within which a part that comes again or comes late belongs to the same reading.
    state, owed_ns : (256,) arrays
        Per board and triangle: see the constants; since when a part is owed.
    newest, last_ns : (512, 8) uint8 and (512,) int64 arrays
        Last data of each triangle's two parts, and when they came.
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
        kept = 2 * triangle + 1 - head
        equal = same(data, i, newest, kept, length)
        age = stamps[i] - last_ns[kept]
        if not equal or age > window_ns or (age == 0 and state[triangle] & PART != 2 - head):
            last_ns[kept] = stamps[i]
            part = HEAD_SEEN if head else TAIL_SEEN
            take_note(triangle, part, stamps[i], window_ns, state, owed_ns, counters)
        else:
            counters[DUPLICATED] += 1
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
def same(data: Octets, row: int, newest: Octets, kept: int, length: int) -> bool:
    """Whether a part has the data of the one before, which it replaces."""
    equal = True
    for k in range(8):
        value = data[row, k] if k < length else np.uint8(0)
        equal = equal and newest[kept, k] == value
        newest[kept, k] = value
    return equal


@njit(cache=True, nogil=True)
def take_note(
    triangle: int,
    part: int,
    stamp_ns: int,
    window_ns: int,
    state: Octets,
    owed_ns: Ints,
    counters: Ints,
) -> None:
    """Follow the order of a triangle's parts; count what is missing from it."""
    last, owed = state[triangle] & PART, state[triangle] & OWED
    other = HEAD_SEEN + TAIL_SEEN - part
    mine, others = part << 2, other << 2  # what is owed, of either kind
    in_time = stamp_ns - owed_ns[triangle] <= window_ns
    if owed == mine and in_time and (last == part or part == HEAD_SEEN):
        counters[SWAPPED] += 1
        state[triangle] = last
    elif last == part:  # one of the other kind is missing between them
        if owed:
            counters[LOST] += 1
        owed_ns[triangle] = stamp_ns
        state[triangle] = part | others
    elif owed and part == HEAD_SEEN:
        counters[LOST] += 1
        state[triangle] = part
    else:
        state[triangle] = part | owed


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
