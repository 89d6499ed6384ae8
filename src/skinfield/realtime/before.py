"""How a process was scheduled before it asked for real time."""

import gc
import os
from contextlib import suppress
from dataclasses import dataclass

from skinfield.realtime import requests, system


@dataclass(frozen=True)
class Before:
    """What `restore` goes back to.

    Attributes
    ----------
    policy, priority : int or None
        Of the calling thread; None where the system has no such thing.
    cpus : frozenset of int or None
    slack_ns : int or None, ns
    gc_enabled : bool
    """

    policy: int | None
    priority: int
    cpus: frozenset[int] | None
    slack_ns: int | None
    gc_enabled: bool

    @classmethod
    def now(cls) -> "Before":
        """How things are."""
        slack, policy, priority, cpus = None, None, 0, None
        with suppress(OSError):
            slack = system.call("prctl", system.PR_GET_TIMERSLACK, 0, 0, 0, 0)
        if system.LINUX:
            policy, priority = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
            cpus = frozenset(os.sched_getaffinity(0))
        return cls(policy, priority, cpus, slack, gc.isenabled())

    def restore(self) -> None:
        """Go back; what cannot be taken back, such as the layout of the heap, stays."""
        if self.policy is not None and self.cpus is not None:
            usual = os.sched_param(self.priority)
            try:
                os.sched_setscheduler(0, self.policy, usual)
            except PermissionError:  # only root may clear the flag
                os.sched_setscheduler(0, self.policy | os.SCHED_RESET_ON_FORK, usual)
            os.sched_setaffinity(0, self.cpus)
        with suppress(OSError):
            system.call("munlockall")
        with suppress(OSError):
            system.call("mallopt", system.M_TRIM_THRESHOLD, requests.TRIM_THRESHOLD)
            system.call("mallopt", system.M_MMAP_MAX, requests.MMAP_MAX)
        if self.slack_ns is not None:
            system.call("prctl", system.PR_SET_TIMERSLACK, self.slack_ns, 0, 0, 0)
        requests.let_sleep()
        gc.unfreeze()
        if self.gc_enabled:
            gc.enable()
