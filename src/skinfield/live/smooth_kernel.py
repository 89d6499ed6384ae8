"""A low-pass of what taxels read, and what is told of contacts, compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

NS = 1e-9
Flags = NDArray[np.bool_]
Rows = NDArray[Any]


@njit(cache=True, nogil=True)
def smooth(
    channel: Ints,
    stamps: Ints,
    valid: Flags,
    given: Flags,
    stale_ns: int,
    seconds: float,
    values: Floats,
    state: Floats,
    at_ns: Ints,
) -> None:
    """First-order low-pass of each taxel: y += (x - y) dt / (T + dt), which is stable for any dt.

    Parameters
    ----------
    channel : (L,) array
        Of each taxel, among the `stamps` of all channels.
    valid, given : (L,) arrays
        As `condition` writes them.
    stale_ns : int, ns
        A taxel that was away for longer begins anew.
    seconds : float, s
        The time constant T.
    values : (L,) array
        Readings, which become smoothed ones; of taxels that are not to be answered now, the last.
    state, at_ns : (L,) arrays
        Smoothed readings, and stamps of what came last; 0: nothing yet.
    """
    for taxel in range(len(values)):
        if not valid[taxel]:
            continue
        if given[taxel]:
            stamp = stamps[channel[taxel]]
            since = stamp - at_ns[taxel]
            if at_ns[taxel] == 0 or since < 0 or since > stale_ns:
                state[taxel] = values[taxel]
            else:
                step = NS * since
                state[taxel] += step / (seconds + step) * (values[taxel] - state[taxel])
            at_ns[taxel] = stamp
        if at_ns[taxel] > 0:
            values[taxel] = state[taxel]


@njit(cache=True, nogil=True)
def drop_weak(
    rows: Rows, words: NDArray[np.int64], width: int, count: int, threshold: float
) -> int:
    """Move the contacts of at least this force to the front of `rows`; how many there are.

    `words` (R width,) is the memory of the rows, of `width` words each.
    """
    kept = 0
    for place in range(count):
        if rows[place].normal_force >= threshold:
            if kept < place:
                for word in range(width):
                    words[kept * width + word] = words[place * width + word]
            kept += 1
    return kept


@njit(cache=True, nogil=True)
def presses_within(rows: Rows, count: int, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether one of the contacts lies in a window of the patch's plane."""
    found = False
    for place in range(count):
        found |= x0 <= rows[place].x <= x1 and y0 <= rows[place].y <= y1
    return found
