"""Kernels of timing, compiled: times into histograms, whose arrays `timing` has checked."""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit

Counts = NDArray[np.uint64]
ONE = np.uint64(1)

OCTAVE_BITS = 6  # 64 bins per power of two: a bin is at most 1/64 of its times wide
TOP = (1 << 34) - 1  # ns: the last bin ends with it, 17.2 s
BINS = (28 << OCTAVE_BITS) + (1 << OCTAVE_BITS)
LONGEST = BINS  # word of the longest time, ns, exact
SUM = BINS + 1  # word of the sum of all times, ns, exact
WORDS = BINS + 2

CYCLES, LATE, OVERRUN, SKIPPED = range(4)  # words of what an engine counts beside its times


@njit
def add_time(counts: Counts, time_ns: int) -> None:
    """Count one time; below 0 counts as 0, beyond the last bin as the last bin.

    Parameters
    ----------
    counts : (WORDS,) uint64 array
    time_ns : int, ns
    """
    time = max(time_ns, 0)
    rest, octave = min(time, TOP), 0
    while rest >= 2 << OCTAVE_BITS:
        rest >>= 1
        octave += 1
    exact = np.uint64(time)
    counts[(octave << OCTAVE_BITS) + rest] += ONE
    counts[SUM] += exact
    if exact > counts[LONGEST]:
        counts[LONGEST] = exact


@njit
def add_cycle(
    times: NDArray[np.uint64],
    totals: Counts,
    period_ns: int,
    deadline_ns: int,
    due_ns: int,
    wake_ns: int,
    acquired_ns: int,
    ready_ns: int,
    done_ns: int,
    latency_ns: int,
) -> None:
    """Count the times of one cycle.

    Parameters
    ----------
    times : (5, WORDS) uint64 array
        Rows as `timing.TIMES`.
    totals : (4,) uint64 array
        As `timing.TOTALS`.
    latency_ns : int, ns
        Below 0 where no new reading came: nothing is counted then.
    """
    add_time(times[0], wake_ns - due_ns)
    add_time(times[1], acquired_ns - wake_ns)
    add_time(times[2], ready_ns - wake_ns)
    if latency_ns >= 0:
        add_time(times[3], latency_ns)
    add_time(times[4], done_ns - wake_ns)
    totals[CYCLES] += ONE
    if ready_ns - due_ns > deadline_ns:
        totals[LATE] += ONE
    if done_ns - due_ns > period_ns:
        totals[OVERRUN] += ONE
