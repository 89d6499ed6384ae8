"""What the system gave to a loop that asked for real time, as a fact that is published."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any


@dataclass(frozen=True)
class Granted:
    """What was granted, what was not and why, and what disturbs.

    Attributes
    ----------
    scheduler : str
        "SCHED_FIFO" where granted; else the name of the policy, such as "SCHED_OTHER".
    priority : int
        1 to 99; 0 without SCHED_FIFO.
    cpu : int or None
        To which the process is pinned.
    isolated : bool
        Whether the system keeps other work off that processor.
    memory : str
        "locked" (also what is allocated later), "locked so far" or "not locked".
    heap_kept : bool
        Whether freed memory stays with the process.
    gc_frozen : bool
    timer_slack_ns : int or None, ns
        By which the system may delay wakes outside SCHED_FIFO; None where it cannot be set.
    kept_awake : bool
        Whether processors stay out of deep sleep.
    kernel : str
        Name and release, and how it is preempted where it says so.
    refused : tuple of str
        A sentence per thing that was not granted: which, why, and what to do.
    disturbances : tuple of str
        A sentence per property of this machine that makes times worse.
    """

    scheduler: str
    priority: int
    cpu: int | None
    isolated: bool
    memory: str
    heap_kept: bool
    gc_frozen: bool
    timer_slack_ns: int | None
    kept_awake: bool
    kernel: str
    refused: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()

    @property
    def real_time(self) -> bool:
        """Whether the loop goes before all ordinary work."""
        return self.priority > 0

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in asdict(self).items()
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "Granted":
        """Back from `as_dict`; keys of newer versions are passed over."""
        known: dict[str, Any] = {
            each.name: values[each.name] for each in fields(cls) if each.name in values
        }
        for name in ("refused", "disturbances"):
            known[name] = tuple(known.get(name, ()))
        return cls(**known)

    def sentences(self) -> tuple[str, ...]:
        """Everything as sentences: what was granted first."""
        return (self._summary(), *self.refused, *self.disturbances)

    def _summary(self) -> str:
        parts = [f"ordinary scheduling ({self.scheduler})"]
        if self.real_time:
            parts = [f"{self.scheduler} at priority {self.priority}"]
        if self.cpu is None:
            parts.append("on any processor")
        else:
            parts.append(f"pinned to {'the isolated ' if self.isolated else ''}CPU {self.cpu}")
        parts.append(f"memory {self.memory}")
        parts.append("garbage collector frozen" if self.gc_frozen else "garbage collector running")
        return f"{', '.join(parts)}; {self.kernel}"
