"""Decoder of the messages of an iCub's skin boards, compiled.

A triangle sends head, tail, head, tail; only where that order breaks is anything counted, so that
nothing is where no message is missing or doubled, whatever rate the board has, and however late or
close together its messages are read. That messages of a triangle change places, CAN does not do.

Two parts belong to one reading if few messages of their board came between: less than half of what
a board sends in a reading. A board of one triangle has nothing in between; there it is the time
that tells: less than half of its period. Both are learned from the messages themselves.

Numba checks no bounds: indices are masked to the size of the tables, rows are below `count`, which
the caller checked, as the shapes, and blocks are begun by `begin_block`, which does.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Ints
from skinfield.signal.block import Octets, Words
from skinfield.signal.blocks_kernel import begin_block

LOST, DUPLICATED = 2, 6  # as `Count`
HEAD_LAST, TAIL_LAST = 1, 2  # state: the part that came last
STAMP, NUMBER = 0, 1  # columns of `events`
MESSAGES, ROUND, PERIOD = 0, 1, 2  # columns of `boards`
QUARTERS = 4  # of a message: the unit of `ROUND`
SEVERAL = 3 * QUARTERS  # more than the two messages of a single triangle
LONGEST = 16  # periods: an interval that is longer was a break
SLOWLY = 4  # power of two: of how many intervals the period is the mean
SHORTEST_NS, LONGEST_NS = 100_000, 10_000_000_000
BYTES, STATUS = 1, 4  # as `Kind`
OUT_OF_RANGE = 4  # as `Status`
RECEIVED, READINGS, MALFORMED, FOREIGN, OCTETS = 0, 1, 4, 5, 10  # as `Count`
HEAD, TAIL = 0x40, 0xC0
HIGHEST_ID = 0x7FF
ANALOG, SKIN = 3, 4  # as `MessageClass`
MEANINGLESS, OF_OTHERS = -1, -2  # no head and no tail
Messages = tuple[NDArray[np.uint32], Octets, Octets, Ints]  # ids, lengths, data, stamps
Into = tuple[Words, Octets, Words]  # words, octets, end of `Blocks`
Learned = tuple[Octets, Ints, Ints]  # see `follow`
TAIL_WORDS = 6  # a block of 5 counts and one of status


@inner
def is_near(board: int, event: int, stamp_ns: int, number: int, events: Ints, boards: Ints) -> bool:
    """Whether a message belongs to the same reading as an event of `events`."""
    if boards[board, ROUND] >= SEVERAL:
        return bool((number - events[event, NUMBER]) * 2 * QUARTERS < boards[board, ROUND])
    return bool(stamp_ns - events[event, STAMP] < boards[board, PERIOD] >> 1)


@njit
def learn(board: int, event: int, stamp_ns: int, number: int, events: Ints, boards: Ints) -> None:
    """Learn how many messages, and how much time, is between two heads of a triangle.

    The first is a running median, which a few lost messages do not move; the second a running mean,
    as of messages that come in heaps only the mean interval is right.
    """
    between = (number - events[event, NUMBER]) * QUARTERS
    if boards[board, ROUND] == 0:
        boards[board, ROUND] = between
    elif between != boards[board, ROUND]:
        boards[board, ROUND] += 1 if between > boards[board, ROUND] else -1
    period = boards[board, PERIOD]
    interval = min(max(stamp_ns - events[event, STAMP], 0), LONGEST * period)
    period += (interval - period) >> SLOWLY
    boards[board, PERIOD] = min(max(period, SHORTEST_NS), LONGEST_NS)


@njit
def follow(
    triangle: int, part: int, same: bool, stamp_ns: int, learned: Learned, counters: Ints
) -> bool:
    """Follow the order of a triangle's parts, and count what breaks it.

    Parameters
    ----------
    triangle : int
        Board and triangle, 0 to 255.
    part : int
        HEAD_LAST or TAIL_LAST.
    same : bool
        Whether its data is that of the part of this kind before.
    stamp_ns : int, ns
    learned : arrays
        The part that came last of each triangle (256,), 0 at first; stamp and number of the last
        head and of the last tail, two rows of each triangle (512, 2); messages of each board until
        now, how many make a reading, in quarters, and its period, ns (16, 3).
    counters : (len(Count),) int64 array

    Returns
    -------
    bool
        Whether it is a reading; else it is a copy of one.
    """
    state, events, boards = learned
    board, event = triangle >> 4, 2 * triangle + part - 1
    number = boards[board, MESSAGES] + 1
    if state[triangle] == part:
        if same and is_near(board, event, stamp_ns, number, events, boards):
            counters[DUPLICATED] += 1
            return False
        counters[LOST] += 1
    elif state[triangle] == TAIL_LAST and events[event, NUMBER]:
        learn(board, event, stamp_ns, number, events, boards)
    state[triangle] = part
    boards[board, MESSAGES] = number
    events[event, STAMP], events[event, NUMBER] = stamp_ns, number
    return True


@inner
def has_same_data(data: Octets, row: int, newest: Octets, slot: int, length: int) -> bool:
    """Whether a part has the data of the one before, which it replaces."""
    equal = True
    for k in range(8):
        value = data[row, k] if k < length else np.uint8(0)
        equal = equal and newest[slot, k] == value
        newest[slot, k] = value
    return equal


@njit
def decode_messages(
    messages: Messages,
    first: int,
    count: int,
    positions: Ints,
    learned: Learned,
    newest: Octets,
    into: Into,
    channel: int,
    counters: Ints,
) -> int:
    """Append the blocks of messages `first` to `count`; the first that does not fit, or `count`.

    Parameters
    ----------
    messages : arrays
        Identifiers, lengths, data, stamps of `CanMessages`.
    positions : (16,) int64 array
        Place of each board in the port, -1 of one that is not ours.
    learned : arrays
        Of `follow`.
    newest : (512, 8) uint8 array
        Last data of each triangle's two parts.
    into : arrays
        Of `Blocks`.
    channel : int
        Of the port's first taxel.
    counters : (len(Count),) int64 array
    """
    ids, lengths, data, stamps = messages
    for i in range(first, count):
        identifier, length = int(ids[i]), min(int(lengths[i]), 8)
        head = is_head(identifier, lengths[i], data, i)
        place = positions[(identifier >> 4) & 15]
        if head < 0 or place < 0:
            broken = head == MEANINGLESS and (place >= 0 or identifier > HIGHEST_ID)
            counters[MALFORMED if broken else FOREIGN] += 1
            counters[OCTETS] += length
            continue
        if into[2][0] + TAIL_WORDS > len(into[0]):
            return i
        counters[RECEIVED] += 1
        counters[OCTETS] += length
        triangle = identifier & 255
        same = has_same_data(data, i, newest, 2 * triangle + 1 - head, length)
        if not follow(triangle, 2 - head, same, stamps[i], learned, counters):
            continue
        at = channel + 192 * place + 12 * (triangle & 15)
        put_part(into, stamps[i], at, head, length, data, i)
        counters[READINGS] += 1
    return count


@inner
def is_head(identifier: int, length: int, data: Octets, row: int) -> int:
    """1 of a head, 0 of a tail; or `MEANINGLESS`, or `OF_OTHERS`."""
    if identifier & 0x80000000:
        return OF_OTHERS
    if identifier > HIGHEST_ID or length > 8:
        return MEANINGLESS
    if identifier >> 8 not in (ANALOG, SKIN):
        return OF_OTHERS
    if length == 8 and data[row, 0] == HEAD:
        return 1
    if length >= 6 and data[row, 0] == TAIL:
        return 0
    return MEANINGLESS


@inner
def put_part(
    into: Into, stamp_ns: int, channel: int, head: int, length: int, data: Octets, row: int
) -> None:
    """Append a part's counts, and a tail's status; there is room for both."""
    words, octets, end = into
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
