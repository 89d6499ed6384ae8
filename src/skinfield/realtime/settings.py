"""Asking the system for what a loop on time needs: each where permitted, none required."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from skinfield.errors import check_count
from skinfield.realtime.granted import Granted


@dataclass(frozen=True)
class RealTime:
    """What a process asks for that must wake on time.

    Each request is made where the system permits it. What is not granted is reported, with the
    reason and the remedy, and the loop runs without it.

    Parameters
    ----------
    priority : int
        Of SCHED_FIFO, 1 to 99; a lower one is taken where only that is permitted. 0: not asked for.
    cpu : int, optional
        To pin the process to. By default an isolated one where the system has any, else the last
        of those that the process may use; in either case, if it can be, one that no other program
        is pinned to at real-time priority.
    lock_memory : bool
        Keep all memory in RAM, also what is allocated later, and freed memory in the process.
    freeze_gc : bool
        Collect garbage once, then never: a loop that allocates nothing leaves none.
    keep_awake : bool
        Keep the processors out of deep sleep, from which they take long to wake. Costs power.
    """

    priority: int = 80
    cpu: int | None = None
    lock_memory: bool = True
    freeze_gc: bool = True
    keep_awake: bool = True

    def __post_init__(self) -> None:
        check_count("priority", self.priority, 0, 99, "of SCHED_FIFO, 99 the highest; 0 for none")
        if self.cpu is not None:
            check_count("cpu", self.cpu, 0, 1 << 16, "number of a processor; None lets it choose")

    def apply(self) -> Granted:
        """Ask for everything, for this process and the thread that calls.

        Call it last, when everything is loaded, prepared and compiled: memory is locked and the
        garbage collector frozen as they are then. Processes and threads that are started later are
        not real-time themselves; they do inherit the processor.
        """
        from skinfield.realtime.requests import ask
        from skinfield.realtime.surroundings import disturbances, kernel

        found = ask(self)
        return Granted(
            **found.granted,
            kernel=kernel(),
            refused=tuple(found.refused),
            disturbances=disturbances(found.granted["cpu"]),
        )

    @contextmanager
    def during(self) -> Iterator[Granted]:
        """Ask, and give everything back at the end: for measurements within a longer process."""
        from skinfield.realtime.before import Before

        before = Before.now()
        try:
            yield self.apply()
        finally:
            before.restore()
