"""In what order the parts of a triangle come, and what that tells, compiled.

A triangle sends head, tail, head, tail; only where that order breaks is anything counted, so that
nothing is where no message is missing, doubled or out of place, whatever rate the board has, and
however late or close together its messages are read.

Two parts belong to one reading if few messages of their board came between: less than half of what
a board sends in a reading. A board of one triangle has nothing in between; there it is the time
that tells: less than half of its period. Both are learned from the messages themselves.
"""

import numpy as np
from numba import njit

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints

LOST, DUPLICATED, SWAPPED = 2, 6, 7  # as `Count`
HEAD_SEEN, TAIL_SEEN = 1, 2  # state: the part that came last
HEAD_OWED, TAIL_OWED = 4, 8  # added to it: a part that should have come before the last one did
SUSPECT = 16  # added to it: the last part looks like a copy, but came when one was due
PART, OWED = 3, 12  # masks of the two
OWED_SINCE = 2  # row of `seen`, after those of head and tail
STAMP, NUMBER = 0, 1  # columns of `seen`
MESSAGES, ROUND, PERIOD = 0, 1, 2  # columns of `boards`
QUARTERS = 4  # of a message: the unit of `ROUND`
SEVERAL = 3 * QUARTERS  # more than the two messages of a single triangle
LONGEST = 16  # periods: an interval that is longer was a break
SLOWLY = 4  # power of two: of how many intervals the period is the mean
SHORTEST_NS, LONGEST_NS = 100_000, 10_000_000_000


@njit(cache=True, nogil=True)
def is_near(board: int, event: int, stamp_ns: int, number: int, seen: Ints, boards: Ints) -> bool:
    """Whether a message belongs to the same reading as an event of `seen`."""
    if boards[board, ROUND] >= SEVERAL:
        return bool((number - seen[event, NUMBER]) * 2 * QUARTERS < boards[board, ROUND])
    return bool(stamp_ns - seen[event, STAMP] < boards[board, PERIOD] >> 1)


@njit(cache=True, nogil=True)
def learn(board: int, event: int, stamp_ns: int, number: int, seen: Ints, boards: Ints) -> None:
    """Learn how many messages, and how much time, is between two heads of a triangle.

    The first is a running median, which a few lost messages do not move; the second a running mean,
    as of messages that come in heaps only the mean interval is right.
    """
    between = (number - seen[event, NUMBER]) * QUARTERS
    if boards[board, ROUND] == 0:
        boards[board, ROUND] = between
    elif between != boards[board, ROUND]:
        boards[board, ROUND] += 1 if between > boards[board, ROUND] else -1
    period = boards[board, PERIOD]
    interval = min(max(stamp_ns - seen[event, STAMP], 0), LONGEST * period)
    period += (interval - period) >> SLOWLY
    boards[board, PERIOD] = min(max(period, SHORTEST_NS), LONGEST_NS)


@njit(cache=True, nogil=True)
def follow(
    triangle: int,
    part: int,
    same: bool,
    stamp_ns: int,
    state: Octets,
    seen: Ints,
    boards: Ints,
    counters: Ints,
) -> bool:
    """Follow the order of a triangle's parts, and count what breaks it.

    Parameters
    ----------
    triangle : int
        Board and triangle, 0 to 255.
    part : int
        HEAD_SEEN or TAIL_SEEN.
    same : bool
        Whether its data is that of the part of this kind before.
    stamp_ns : int, ns
    state : (256,) uint8 array
        See the constants.
    seen : (768, 2) int64 array
        Stamp and number of the last head, of the last tail, and since when a part is owed; three
        rows of each triangle.
    boards : (16, 3) int64 array
        Messages of each board until now; how many make a reading, in quarters; its period, ns.
    counters : (len(Count),) int64 array

    Returns
    -------
    bool
        Whether it is a reading; else it is a copy of one.
    """
    board, first = triangle >> 4, 3 * triangle
    event, owed_since = first + part - 1, first + OWED_SINCE
    number = boards[board, MESSAGES] + 1
    last, owed = state[triangle] & PART, state[triangle] & OWED
    copy = same and is_near(board, event, stamp_ns, number, seen, boards)
    late = owed == part << 2 and is_near(board, owed_since, stamp_ns, number, seen, boards)
    if last != part:
        if last == TAIL_SEEN and not owed:
            learn(board, event, stamp_ns, number, seen, boards)
        state[triangle] = in_order(part, last, owed, copy, late, counters)
    elif copy and not (late and boards[board, ROUND] < SEVERAL):
        counters[DUPLICATED] += 1
        return False
    else:
        if not late and not state[triangle] & SUSPECT:
            seen[owed_since, STAMP], seen[owed_since, NUMBER] = stamp_ns, number
        state[triangle] = out_of_order(part, state[triangle], late, counters)
    boards[board, MESSAGES] = number
    seen[event, STAMP], seen[event, NUMBER] = stamp_ns, number
    return True


@njit(cache=True, nogil=True)
def in_order(part: int, last: int, owed: int, copy: bool, late: bool, counters: Ints) -> int:
    """State after a part that follows one of the other kind.

    A head ends the reading before it: what that still owes is lost, unless it is this very head,
    which came behind its tail.
    """
    if owed and part == HEAD_SEEN:
        counters[SWAPPED if late else LOST] += 1
        return last if late else part
    return part | owed | (SUSPECT if copy and not owed else 0)


@njit(cache=True, nogil=True)
def out_of_order(part: int, state: int, late: bool, counters: Ints) -> int:
    """State after a second part of one kind, which is no copy of the first."""
    if late:  # tail after tail, behind two heads: the first tail was late
        counters[SWAPPED] += 1
        return part
    if state & SUSPECT:  # the first was a copy, of an earlier one
        counters[DUPLICATED] += 1
        return part
    if state & OWED:
        counters[LOST] += 1
    return part | (HEAD_SEEN + TAIL_SEEN - part) << 2


@njit(cache=True, nogil=True)
def has_same_data(data: Octets, row: int, newest: Octets, kept: int, length: int) -> bool:
    """Whether a part has the data of the one before, which it replaces."""
    equal = True
    for k in range(8):
        value = data[row, k] if k < length else np.uint8(0)
        equal = equal and newest[kept, k] == value
        newest[kept, k] = value
    return equal
