"""The times that an engine publishes: how late it wakes, and how old its estimates are."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import check_count
from skinfield.realtime.histogram import Quantiles, check_words, quantiles
from skinfield.realtime.layout import CYCLES, LATE, OVERRUN, SKIPPED, WORDS

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
        from skinfield.realtime.histogram_kernel import add_cycle

        check_count("period_ns", period_ns, 1, 1 << 40, "time from cycle to cycle in ns")
        self.period_ns = period_ns
        self.deadline_ns = period_ns if deadline_ns is None else deadline_ns
        check_count("deadline_ns", self.deadline_ns, 1, 1 << 40, "ns after the due time")
        self.times: Words = np.zeros((len(TIMES), WORDS), np.uint64) if times is None else times
        self.totals: Words = np.zeros(len(TOTALS), np.uint64) if totals is None else totals
        check_words("times", self.times, (len(TIMES), WORDS))
        check_words("totals", self.totals, (len(TOTALS),))
        self._skipped_before = int(self.totals[SKIPPED])  # by an engine that ran before
        self._add = add_cycle
        rehearsal = np.zeros_like(self.times), np.zeros_like(self.totals)
        self._add(*rehearsal, self.period_ns, self.deadline_ns, 0, 0, 0, 0, 0, 0)

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
        self._add(
            self.times,
            self.totals,
            self.period_ns,
            self.deadline_ns,
            due_ns,
            wake_ns,
            acquired_ns,
            ready_ns,
            done_ns,
            latency_ns,
        )

    def set_skipped(self, periods: int) -> None:
        """How many periods passed without a cycle, as the clock counted them since it was made."""
        self.totals[SKIPPED] = self._skipped_before + periods

    def timing(self, before: "tuple[Words, Words] | None" = None) -> "Timing":
        """See `Timing.of`."""
        return Timing.of(self.times, self.totals, before)


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
        gone = np.zeros_like(totals) if before is None else before[1]
        cycles, late, overrun, skipped = (
            int(totals[at]) - int(gone[at]) for at in (CYCLES, LATE, OVERRUN, SKIPPED)
        )
        return cls(wake, acquired, ready, latency, cycle, cycles, late, overrun, skipped)

    def as_dict(self) -> dict[str, object]:
        """Plain numbers in µs, for JSON: `wake_us` and so on, each of p50, p99, p999, max, mean."""
        found: dict[str, object] = {name: getattr(self, name) for name in TOTALS}
        for name in TIMES:
            each: Quantiles | None = getattr(self, name)
            found[f"{name}_us"] = None if each is None else each.as_micros()
        return found
