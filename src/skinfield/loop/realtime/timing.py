"""Timing of a loop: histograms that any process can read meanwhile, and the times of an engine.

The bins are those of HDR histograms (G. Tene, hdrhistogram.org): 64 equal ones per power of two,
so that the bin of a time follows from shifts of an integer. In nanoseconds, a time below 128 has
a bin of its own; above, with n the number of its binary digits and s = n - 7, its bin is
64 s + (time >> s), which is between 1/128 and 1/64 of the time wide. 1856 bins reach to 17.2 s.
Two words follow: the longest time and the sum of all, both exact. A word is written at once and
only grows, so a reader needs no lock; the words of one time are written one after the other.

`TimingTable` holds how late an engine wakes, and how old its estimates are.
"""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, check_count
from skinfield.loop.realtime.timing_kernel import BINS, LONGEST, OCTAVE_BITS, SKIPPED, SUM, WORDS

Counts = NDArray[np.uint64]
NS = 1e-9


@dataclass(frozen=True)
class Quantiles:
    """What a histogram says of its times.

    Attributes
    ----------
    p50, p99, p999 : float, s
        The time that 50 %, 99 % and 99.9 % do not exceed, given as the upper edge of its bin:
        at most 1/64 too long, never too short, and never beyond `max`.
    max : float, s
        Exact since the start; of a difference of two histograms the upper edge of the bin.
    mean : float, s
        Exact.
    count : int
    """

    p50: float
    p99: float
    p999: float
    max: float
    mean: float
    count: int

    def as_micros(self) -> dict[str, float]:
        """Such as {"p50": 12.3, ..., "count": 1000}, times in µs to a ns, for JSON."""
        times = {name: round(1e6 * each, 3) for name, each in vars(self).items()}
        return times | {"count": self.count}


def quantiles(counts: Counts, before: Counts | None = None) -> Quantiles | None:
    """Quantiles of what a histogram counted, in all or since an earlier copy of it.

    Parameters
    ----------
    counts : (WORDS,) uint64 array
    before : (WORDS,) uint64 array, optional
        A copy of the same histogram, from which on times count: such as a second ago.

    Returns
    -------
    Quantiles or None
        None where nothing was counted.
    """
    bins = counts[:BINS].astype(np.int64)
    total, longest = int(counts[SUM]), int(counts[LONGEST])
    if before is not None:
        bins -= before[:BINS].astype(np.int64)
        total -= int(before[SUM])
        if (bins < 0).any():
            raise InputError(
                "before counts more than counts, expected an earlier copy of the same histogram: "
                "take a new copy after the engine has started anew"
            )
    below = np.cumsum(bins)
    count = int(below[-1])
    if count == 0:
        return None
    edges = [_edge(below, count, share, longest) for share in (500, 990, 999, 1000)]
    if before is None:
        edges[-1] = longest
    p50, p99, p999, longest_s = (NS * edge for edge in edges)
    return Quantiles(p50, p99, p999, longest_s, NS * total / count, count)


def _edge(below: NDArray[np.int64], count: int, share: int, longest: int) -> int:
    """Last ns of the bin of the time that `share` thousandths of all times do not exceed."""
    rank = -(-count * share // 1000)
    return min(int(LAST_NS[int(np.searchsorted(below, rank))]), longest)


OCTAVE = np.maximum((np.arange(BINS) >> OCTAVE_BITS) - 1, 0)  # (BINS,) of each bin
LAST_NS = ((np.arange(BINS) - (OCTAVE << OCTAVE_BITS) + 1) << OCTAVE) - 1  # its longest time, ns


TIMES = ("wake", "acquired", "ready", "latency", "cycle")
TOTALS = ("cycles", "late", "overrun", "skipped")
FIELDS = (  # name, dtype, shape: for the status of a ring
    ("times", "<u8", (len(TIMES), WORDS)),
    ("totals", "<u8", (len(TOTALS),)),
)

Words = NDArray[np.uint64]


class TimingTable:
    """Times of an engine's cycles, counted into arrays that may lie in shared memory.

    Parameters
    ----------
    period_ns : int, ns
        Of the cycles; in event mode the longest wait.
    deadline_ns : int, ns, optional
        After the due time by which an estimate must be published; by default the period.
    times : (5, WORDS) uint64 array, optional
        One histogram each: `wake` (from due to awake), `acquired` (from awake until all readings
        that waited are taken in), `ready` (from awake until the estimate is published), `latency`
        (from the arrival of the newest reading until the estimate is published; cycles without a
        new reading have none) and `cycle` (from awake until everything is done).
    totals : (4,) uint64 array, optional
        `cycles`; `late`: estimates published after the deadline; `overrun`: cycles that ended
        after the next was due; `skipped`: periods in which therefore no cycle began.
    """

    def __init__(
        self,
        period_ns: int,
        deadline_ns: int | None = None,
        times: Words | None = None,
        totals: Words | None = None,
    ) -> None:
        from skinfield.loop.realtime.timing_kernel import add_cycle

        check_count("period_ns", period_ns, 1, 1 << 40, "time from cycle to cycle in ns")
        self.period_ns = period_ns
        self.deadline_ns = period_ns if deadline_ns is None else deadline_ns
        check_count("deadline_ns", self.deadline_ns, 1, 1 << 40, "ns after the due time")
        self.times: Words = np.zeros((len(TIMES), WORDS), np.uint64) if times is None else times
        self.totals: Words = np.zeros(len(TOTALS), np.uint64) if totals is None else totals
        self._skipped_before = int(self.totals[SKIPPED])  # by an engine that ran before
        periods = self.period_ns, self.deadline_ns
        self._add = partial(add_cycle, self.times, self.totals, *periods)
        rehearsal = np.zeros_like(self.times), np.zeros_like(self.totals)
        add_cycle(*rehearsal, *periods, 0, 0, 0, 0, 0, 0)

    def add(
        self,
        due_ns: int,
        wake_ns: int,
        acquired_ns: int,
        ready_ns: int,
        done_ns: int,
        latency_ns: int = -1,
    ) -> None:
        """Count one cycle.

        Parameters
        ----------
        due_ns, wake_ns, acquired_ns, ready_ns, done_ns : int, ns
            Of the same clock, such as `time.monotonic_ns`.
        latency_ns : int, ns
            Age of the newest reading when the estimate was published; below 0 where none came.
        """
        self._add(due_ns, wake_ns, acquired_ns, ready_ns, done_ns, latency_ns)

    def set_skipped(self, periods: int) -> None:
        """How many periods passed without a cycle, as the clock counted them since it was made."""
        self.totals[SKIPPED] = self._skipped_before + periods


class Timing(NamedTuple):
    """What an engine's histograms and totals say.

    Attributes
    ----------
    wake, acquired, ready, latency, cycle : Quantiles or None
        See `TimingTable`; None where nothing was counted.
    cycles, late, overrun, skipped : int
    """

    wake: Quantiles | None
    acquired: Quantiles | None
    ready: Quantiles | None
    latency: Quantiles | None
    cycle: Quantiles | None
    cycles: int
    late: int
    overrun: int
    skipped: int

    @classmethod
    def of(
        cls, times: Words, totals: Words, before: "tuple[Words, Words] | None" = None
    ) -> "Timing":
        """Read the arrays of a `TimingTable`.

        Parameters
        ----------
        times : (5, WORDS) uint64 array
        totals : (4,) uint64 array
        before : pair of such arrays, optional
            Copies, since which times count: such as of a second ago.
        """
        earliers = [None] * len(TIMES) if before is None else list(before[0])
        wake, acquired, ready, latency, cycle = (
            quantiles(row, earlier) for row, earlier in zip(times, earliers, strict=True)
        )
        counted = totals.astype(np.int64)
        if before is not None:
            counted -= before[1].astype(np.int64)
        return cls(wake, acquired, ready, latency, cycle, *counted.tolist())

    def as_dict(self) -> dict[str, object]:
        """Plain numbers in µs, for JSON: `wake_us` and so on, each of p50, p99, p999, max, mean."""
        found: dict[str, object] = {name: getattr(self, name) for name in TOTALS}
        for name in TIMES:
            each: Quantiles | None = getattr(self, name)
            found[f"{name}_us"] = None if each is None else each.as_micros()
        return found
