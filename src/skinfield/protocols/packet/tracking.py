"""Which packets are new, lost, doubled or late, from their sequence numbers; compiled.

Numbers are unwrapped to 64 bits, and each device has a table of the last `WINDOW` of them. A packet
that is further off than that is a late one, or the device began anew: the latter is believed when
the packet after it follows, or at once when it is a HELLO with the sequence number 0. Counts are
right in both cases; what a device sent before its first packet came through is not known.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Ints

WINDOW = 1024  # packets
FAR = 1 << 24  # packets ahead, beyond which a device is rather believed to have begun anew
LOST, DUPLICATED, SWAPPED = 2, 6, 7  # as `Count`
NEW, TWICE, LATE = 0, 1, 2

# columns of a device's state
OFFSET, CHANNELS, STARTED, NEWEST, FIRST, JUMP, OWED, RESTARTS = 0, 1, 2, 3, 4, 5, 6, 7
HELLO_TIME, TIME, MARKED, HELLOS, HELLO_LENGTH, READING, PACKETS = 8, 9, 10, 11, 12, 13, 14
COLUMNS = 15
NO_JUMP = -1

Row = NDArray[np.int64]


@njit(cache=True, nogil=True)
def track(row: Row, seen: Row, sequence: int, time: int, hello: bool, counters: Ints) -> int:
    """Number one packet; NEW, TWICE or LATE.

    Parameters
    ----------
    row : (COLUMNS,) int64 array
        State of the device.
    seen : (WINDOW,) int64 array
        Its last numbers.
    sequence, time : int
        As in the packet.
    hello : bool
        Whether it is a HELLO.
    counters : (len(Count),) int64 array
    """
    if row[STARTED] == 0:
        row[STARTED], row[HELLO_TIME] = 1, -1
        _begin(row, seen, (1 << 32) + sequence)
        _note_hello(row, sequence, time, hello)
        return NEW
    newest = row[NEWEST]
    step = (sequence - newest) & 0xFFFFFFFF
    if step >= 1 << 31:
        step -= 1 << 32
    number = newest + step
    far = step <= -WINDOW or step > FAR
    known = not far and step <= 0 and seen[number % WINDOW] == number
    if hello and sequence == 0 and (far or (known and time != row[HELLO_TIME])):
        _begin(row, seen, _epoch(newest))
        _note_hello(row, sequence, time, hello)
        row[RESTARTS] += 1
        return NEW
    if far:
        return _far(row, seen, sequence, number, counters)
    row[JUMP] = NO_JUMP
    if known:
        counters[DUPLICATED] += 1
        return TWICE
    seen[number % WINDOW] = number
    _note_hello(row, sequence, time, hello)
    if step > 0:
        counters[LOST] += step - 1
        row[NEWEST] = number
        return NEW
    _late(row, number, counters)
    return LATE


@njit(cache=True, nogil=True)
def _epoch(newest: int) -> int:
    """A number far above all before, for the sequence number 0 of a device that began anew."""
    return ((newest >> 32) + 2) << 32


@njit(cache=True, nogil=True)
def _begin(row: Row, seen: Row, number: int) -> None:
    row[NEWEST] = row[FIRST] = seen[number % WINDOW] = number
    row[JUMP] = NO_JUMP


@njit(cache=True, nogil=True)
def _note_hello(row: Row, sequence: int, time: int, hello: bool) -> None:
    if hello and sequence == 0:
        row[HELLO_TIME] = time


@njit(cache=True, nogil=True)
def _late(row: Row, number: int, counters: Ints) -> None:
    """Count a packet that came after a later one: it is lost no more, if it was counted so."""
    counters[SWAPPED] += 1
    if number < row[FIRST]:  # from before the first that came: those between are missing
        counters[LOST] += row[FIRST] - number - 1
        row[FIRST] = number
    else:
        counters[LOST] -= 1


@njit(cache=True, nogil=True)
def _far(row: Row, seen: Row, sequence: int, number: int, counters: Ints) -> int:
    """A packet out of the window: late, until the one after it follows."""
    if row[JUMP] == sequence:
        counters[SWAPPED] -= 1
        counters[LOST] += row[OWED]
        before = _epoch(row[NEWEST]) + ((sequence - 1) & 0xFFFFFFFF)
        _begin(row, seen, before)
        row[NEWEST] = seen[(before + 1) % WINDOW] = before + 1
        row[RESTARTS] += 1
        return NEW
    row[JUMP] = (sequence + 1) & 0xFFFFFFFF
    row[OWED] = 1 if row[FIRST] <= number < row[NEWEST] else 0
    counters[SWAPPED] += 1
    counters[LOST] -= row[OWED]
    return LATE
