"""A clock that wakes at multiples of a period, whatever happened between them."""

import ctypes
import time
from typing import Protocol

from skinfield.errors import check_count
from skinfield.realtime import system

MONOTONIC, ABSOLUTE = 1, 1  # CLOCK_MONOTONIC and TIMER_ABSTIME of Linux
SECOND = 1_000_000_000


class Waiter(Protocol):
    """What a loop waits by, between two cycles."""

    @property
    def skipped(self) -> int:
        """Periods since the start in which no cycle began."""
        ...

    def wait(self) -> tuple[int, int]:
        """Sleep until the next cycle: when it was due and when it began, in ns."""
        ...


class Sleeper:
    """Sleep until a time of `time.monotonic_ns`, without drift and without slack of one's own."""

    def __init__(self) -> None:
        self._until = _Time()
        self._address = ctypes.byref(self._until)
        self._nanosleep = getattr(system.LIBRARY, "clock_nanosleep", None)

    def sleep_until(self, due_ns: int) -> None:
        """Return at once if that is past; signals are handled meanwhile and do not end it."""
        if self._nanosleep is None:
            while (left := due_ns - time.monotonic_ns()) > 0:
                time.sleep(1e-9 * left)
            return
        self._until.seconds, self._until.nanoseconds = divmod(due_ns, SECOND)
        while self._nanosleep(MONOTONIC, ABSOLUTE, self._address, None):
            pass  # EINTR: Python has handled the signal between two calls


class _Time(ctypes.Structure):
    """`struct timespec` of Linux on 64 bits."""

    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


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
        self._sleeper = Sleeper()
        self._due = None if first_ns is None else first_ns - period_ns
        self._grace = 0

    def early(self, lead_ns: int) -> bool:
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
        self._sleeper.sleep_until(due - lead_ns)
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
        self._sleeper.sleep_until(due)
        return due, time.monotonic_ns()
