"""Taking readings in before a cycle is due, so that the cycle itself is short."""

import time
from collections.abc import Callable

from skinfield.realtime import PeriodicClock

FIRST_LEAD = 0.25  # of a period
MOST_LEAD = 0.5
SPARE_NS = 30_000  # between the end of the work and the cycle
COOLING = 0.999  # of the lead, from cycle to cycle


class Early:
    """Wakes shortly before each cycle is due and does some work, within a time that it learns.

    Parameters
    ----------
    clock : PeriodicClock
    work : function
        That would otherwise be done in the cycle.
    """

    def __init__(self, clock: PeriodicClock, work: Callable[[], None]) -> None:
        self._clock, self._work = clock, work
        self._most = MOST_LEAD * clock.period_ns
        self._lead = FIRST_LEAD * clock.period_ns

    def __call__(self) -> None:
        """Do it, if there is time before the next cycle."""
        if not self._clock.early(int(self._lead)):
            return
        start = time.monotonic_ns()
        self._work()
        took = time.monotonic_ns() - start + SPARE_NS
        self._lead = min(max(COOLING * self._lead, took), self._most)
