"""Other real-time programs on this machine, which a loop would have to share a processor with."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from skinfield.realtime.system import cpus_of

PROCESSES = Path("/proc")
KERNEL_THREAD = 0x0020_0000  # PF_KTHREAD of linux/sched.h
FLAGS, PRIORITY = 6, 37  # fields of /proc/PID/stat behind the name, see proc(5)


@dataclass(frozen=True)
class Rival:
    """A thread with a real-time priority that may run on one processor only.

    Attributes
    ----------
    process : int
    name : str
    priority : int
    cpu : int
    """

    process: int
    name: str
    priority: int
    cpu: int


def rivals() -> tuple[Rival, ...]:
    """Those of other processes; the kernel's own threads are not among them."""
    return tuple(_rivals())


def _rivals() -> Iterator[Rival]:
    for process in PROCESSES.glob("[0-9]*"):
        if int(process.name) == os.getpid():
            continue
        for thread in process.glob("task/[0-9]*"):
            try:
                name, _, rest = (thread / "stat").read_text(errors="replace").rpartition(")")
                fields = rest.split()
                if int(fields[FLAGS]) & KERNEL_THREAD or not int(fields[PRIORITY]):
                    continue
                cpus = _allowed((thread / "status").read_text(errors="replace"))
            except (OSError, ValueError, IndexError):  # it has ended meanwhile
                continue
            if len(cpus) == 1:
                name = name.partition("(")[2]
                yield Rival(int(process.name), name, int(fields[PRIORITY]), cpus.pop())


def _allowed(status: str) -> set[int]:
    for line in status.splitlines():
        if line.startswith("Cpus_allowed_list:"):
            return cpus_of(line.partition(":")[2])
    return set()
