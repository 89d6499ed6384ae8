"""Clocks of a real-time loop: a periodic one, and one that waits for file descriptors."""

import select
import time
from collections.abc import Callable, Iterable
from contextlib import suppress

from skinfield.errors import check_count

NS = 1e-9


def sleep_until(due_ns: int) -> None:
    """Sleep until a time of `time.monotonic_ns`; a signal is handled and does not end it."""
    while (left := due_ns - time.monotonic_ns()) > 0:
        time.sleep(NS * left)


class PeriodicClock:
    """Cycles at a fixed rate.

    A cycle that lasts beyond the next due time is not made up for: the periods that it covered are
    skipped and counted, and the next cycle begins at the first multiple of the period after it.
    Cycles so keep their places in time and never follow each other in a burst. Due times are whole
    multiples of the period, so that the loops of several processes keep their distances.

    Parameters
    ----------
    period_ns : int, ns
    first_ns : int, ns, optional
        When the first cycle is due, by `time.monotonic_ns`; by default at the first multiple of the
        period after `wait` is first called.

    Attributes
    ----------
    skipped : int
        Periods since the start in which no cycle began.
    """

    def __init__(self, period_ns: int, first_ns: int | None = None) -> None:
        check_count("period_ns", period_ns, 1000, 1 << 40, "time from cycle to cycle in ns")
        self.period_ns = period_ns
        self.skipped = 0
        self._due = None if first_ns is None else first_ns - period_ns
        self._grace = 0

    def wake_before(self, lead_ns: int) -> bool:
        """Sleep until `lead_ns` before the next cycle is due, to prepare for it.

        What is done then may end somewhat late: `wait` then begins the cycle at once, rather than
        skip it.

        Returns
        -------
        bool
            Whether there was time; else nothing should be done before `wait`.
        """
        if self._due is None:
            return False
        due = self._due + self.period_ns
        if time.monotonic_ns() > due - lead_ns:
            return False
        self._grace = self.period_ns // 2
        sleep_until(due - lead_ns)
        return True

    def wait(self) -> tuple[int, int]:
        """Sleep until the next cycle is due.

        Returns
        -------
        due_ns, wake_ns : int, ns
            When it was due and when it is, by `time.monotonic_ns`.
        """
        now = time.monotonic_ns()
        last = now - now % self.period_ns if self._due is None else self._due
        due = last + self.period_ns
        behind, self._grace = now - due - self._grace, 0
        if behind > 0:
            behind = now - due
            missed = -(-behind // self.period_ns)
            self.skipped += missed
            due += missed * self.period_ns
        self._due = due
        sleep_until(due)
        return due, time.monotonic_ns()


AGAIN_NS = 1_000_000_000  # between two looks at which descriptors there are
REST = 10  # a rest after each cycle is one of so many parts of its time


class EventWaiter:
    """Cycles as readings arrive, and at the latest after `longest_ns`.

    What arrived stays reported until it is read. A descriptor that nobody reads, or that the other
    end has closed, therefore wakes again and again; `shortest_ns` keeps such cycles, and those of
    a source that sends more often than anyone needs, apart from each other. After a cycle it rests
    for at least a tenth of what that took: under SCHED_FIFO nobody else would get the processor,
    and Linux would stop a loop that never sleeps.

    Parameters
    ----------
    filenos : function that returns an iterable of int
        Descriptors that readings arrive at; asked again once a second, for sources that are opened
        anew.
    longest_ns : int, ns
        After the cycle before, when a cycle begins though nothing came; to a millisecond.
    shortest_ns : int, ns
        From cycle to cycle.

    Attributes
    ----------
    skipped : int
        Always 0: there are no periods to skip.
    """

    skipped = 0

    def __init__(
        self,
        filenos: Callable[[], Iterable[int]],
        longest_ns: int = 10_000_000,
        shortest_ns: int = 200_000,
    ) -> None:
        check_count("longest_ns", longest_ns, 1000, 1 << 40, "longest time between cycles in ns")
        check_count("shortest_ns", shortest_ns, 0, longest_ns, "shortest time between cycles in ns")
        self.longest_ns, self.shortest_ns = longest_ns, shortest_ns
        self._poll = select.poll()
        self._watched: tuple[int, ...] = ()
        self._woke = self._asked = time.monotonic_ns()
        self._ask = filenos
        self._watch()

    def _watch(self) -> None:
        wanted = tuple(self._ask())
        for gone in set(self._watched) - set(wanted):
            self._forget(gone)
        for each in wanted:
            self._poll.register(each, select.POLLIN)
        self._watched = wanted

    def _forget(self, fileno: int) -> None:
        with suppress(KeyError):  # it was closed, and is forgotten already
            self._poll.unregister(fileno)

    def wait(self) -> tuple[int, int]:
        """Sleep until something arrives, or the longest wait is over.

        Returns
        -------
        due_ns, wake_ns : int, ns
            By `time.monotonic_ns`. Where something arrived, both are the time of waking: when it
            arrived is known to the source alone, and counts in the latency. Otherwise the first is
            when the longest wait was over.
        """
        due = self._woke + self.longest_ns
        now = time.monotonic_ns()
        if now - self._asked > AGAIN_NS:
            self._asked = now
            self._watch()
        rested = now + (now - self._woke) // REST
        sleep_until(max(self._woke + self.shortest_ns, rested))
        events = self._poll.poll(max((due - time.monotonic_ns()) * 1e-6, 0.0))
        for fileno, event in events:
            if event & select.POLLNVAL:
                self._forget(fileno)
        self._woke = now = time.monotonic_ns()
        return (now if events else min(due, now)), now


Waiter = PeriodicClock | EventWaiter  # what a loop waits by, between two cycles
