"""System calls and processors of a real-time loop, its competitors, and what disturbs it."""

import ctypes
import os
import platform
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

MCL_CURRENT, MCL_FUTURE, MCL_ONFAULT = 1, 2, 4
PR_SET_TIMERSLACK = 29
M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4
LINUX = sys.platform == "linux"
LIBRARY = ctypes.CDLL(None, use_errno=True) if LINUX else None  # the C library of this process


def call(name: str, *arguments: int) -> int:
    """Result of a function of whole numbers.

    Raises
    ------
    OSError
        If it says -1, or the system does not have it.
    """
    function = getattr(LIBRARY, name, None)
    if function is None:
        raise OSError(0, f"this system has no {name}")
    found = int(function(*(ctypes.c_long(value) for value in arguments)))
    if found == -1:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return found


def cpus_of(text: str) -> set[int]:
    """Processors of a list such as "0-3,6"; empty for what is no such list."""
    found: set[int] = set()
    for part in filter(None, text.strip().split(",")):
        first, _, last = part.partition("-")
        if not first.isdigit() or not (last or first).isdigit():
            return set()
        found.update(range(int(first), int(last or first) + 1))
    return found


def read_text(path: str) -> str:
    """A file that the system writes; empty where there is none."""
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def values_of(path: Path | str) -> dict[str, str]:
    """Values by their names of a file such as /proc/self/status."""
    rows = (line.partition(":") for line in read_text(str(path)).splitlines())
    return {name: value.strip() for name, _, value in rows}


PROCESSES = Path("/proc")
KERNEL_THREAD = 0x0020_0000  # PF_KTHREAD of linux/sched.h
FLAGS, PRIORITY = 6, 37  # fields of /proc/PID/stat behind the name, see proc(5)


class Competitor(NamedTuple):
    """A thread with a real-time priority that may run on one processor only."""

    process: int
    name: str
    priority: int
    cpu: int


def competitors() -> Iterator[Competitor]:
    """Those of other processes; the kernel's own threads are not among them."""
    for process in PROCESSES.glob("[0-9]*"):
        if int(process.name) == os.getpid():
            continue
        for thread in process.glob("task/[0-9]*"):
            try:
                name, _, rest = (thread / "stat").read_text(errors="replace").rpartition(")")
                fields = rest.split()
                if int(fields[FLAGS]) & KERNEL_THREAD or not int(fields[PRIORITY]):
                    continue
                cpus = cpus_of(values_of(thread / "status").get("Cpus_allowed_list", ""))
            except (OSError, ValueError, IndexError):  # it has ended meanwhile
                continue
            if len(cpus) == 1:
                name = name.partition("(")[2]
                yield Competitor(int(process.name), name, int(fields[PRIORITY]), cpus.pop())


def kernel() -> str:
    """Such as "Linux 6.1.0-18-rt-amd64, PREEMPT_RT"."""
    version = platform.version().split()
    words = [word for word in version if word.startswith("PREEMPT")]
    name = f"{platform.system()} {platform.release()}"
    return f"{name}, {' '.join(words)}" if words else name


SOON_OVER = "prepare"  # name of threads that end before long


def disturbances(cpu: int | None) -> Iterator[str]:
    """What makes a loop on this processor late, or on any: a sentence each."""
    if (os.cpu_count() or 1) == 1:
        yield "this machine has one CPU: everything else shares it with the loop"
    others = sum(each.name != SOON_OVER for each in threading.enumerate()) - 1
    if others > 0:
        yield (
            f"{others} more Python threads run in this process: each may "
            "hold the interpreter for 5 ms; run the loop in a process of its own"
        )
    if not LINUX:
        return
    for competitor in competitors():
        if competitor.cpu == cpu:
            yield (
                f"CPU {cpu} is also that of {competitor.name}, process {competitor.process}, at "
                f"real-time priority {competitor.priority}: give one of them another CPU"
            )
    runtime = read_text("/proc/sys/kernel/sched_rt_runtime_us").strip()
    period = read_text("/proc/sys/kernel/sched_rt_period_us").strip()
    if runtime.isdigit() and period.isdigit() and int(runtime) < int(period):
        yield (
            f"real-time throttling is on: what computes for more than {int(runtime) / 1000:g} of "
            f"{int(period) / 1000:g} ms is stopped for the rest; a loop that sleeps in every "
            "cycle does not get there, `sudo sysctl kernel.sched_rt_runtime_us=-1` ends it"
        )
    folder = "/sys/devices/system/cpu/cpu"
    governor = read_text(f"{folder}{cpu or 0}/cpufreq/scaling_governor").strip()
    if governor and governor != "performance":
        yield (
            f"the governor of CPU {cpu or 0} is {governor}: it slows down when there is little to "
            "do; run `sudo cpupower frequency-set -g performance`"
        )
    siblings = cpus_of(read_text(f"{folder}{cpu}/topology/thread_siblings_list")) - {cpu}
    if siblings:
        yield (
            f"CPU {cpu} shares its core with CPU {', '.join(map(str, sorted(siblings)))}: what "
            "runs there slows the loop down; turn off hyper-threading, or leave that one idle"
        )
    used = [row.split()[3:4] for row in read_text("/proc/swaps").splitlines()[1:]]
    if any(each not in ([], ["0"]) for each in used):
        yield (
            "swap is in use: memory that is not locked may have to be read from disk; "
            "run `sudo swapoff -a`"
        )
    if "hypervisor" in read_text("/proc/cpuinfo"):
        yield (
            "this is a virtual machine: its host may take a CPU away at any time; compare with "
            "a cyclictest beside it, `skinfield bench --jitter`"
        )
