"""Time that is kept before a deadline for what follows a solver."""

import time
from dataclasses import dataclass

EARLIER, LATER = 0.998, 1.1  # changes of it: at rest one call of fifty is late
NEAR = 3  # times the reserve: an answer that is earlier by more tells nothing of lateness
PAUSE = 20_000  # ns late: the machine did something else, which no reserve prevents


@dataclass
class Reserve:
    """Learns from how late answers were.

    Attributes
    ----------
    kept : int, ns
    least, most : int, ns
        Between which it stays.
    """

    kept: int = 10_000
    least: int = 2_000
    most: int = 50_000

    def before(self, end: int | None) -> int | None:
        """When a solver should end so that all is done at `end` of `time.perf_counter_ns`."""
        return None if end is None else end - self.kept

    def learn(self, start: int, end: int | None) -> bool:
        """Take note that all is done now; whether that is in time.

        Of an end so near to the start that nothing was left for the solver nothing is learnt.
        """
        if end is None:
            return True
        now = time.perf_counter_ns()
        told = -NEAR * self.kept < now - end < max(PAUSE, 2 * self.kept)
        if told and end - self.kept > start:
            change = EARLIER if now <= end else LATER
            self.kept = int(min(max(change * self.kept, self.least), self.most))
        return now <= end
