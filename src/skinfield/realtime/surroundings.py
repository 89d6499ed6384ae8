"""What about this machine disturbs a loop that must wake on time."""

import os
import platform
import threading
from collections.abc import Iterator

from skinfield.realtime import system
from skinfield.realtime.rivals import rivals
from skinfield.realtime.system import cpus_of, read_text


def kernel() -> str:
    """Such as "Linux 6.1.0-18-rt-amd64, PREEMPT_RT"."""
    version = platform.version().split()
    words = [word for word in version if word.startswith("PREEMPT")]
    name = f"{platform.system()} {platform.release()}"
    return f"{name}, {' '.join(words)}" if words else name


def disturbances(cpu: int | None) -> tuple[str, ...]:
    """A sentence each.

    Parameters
    ----------
    cpu : int or None
        To which the loop is pinned.
    """
    return tuple(_disturbances(cpu))


def _disturbances(cpu: int | None) -> Iterator[str]:
    if (os.cpu_count() or 1) == 1:
        yield "this machine has one CPU: everything else shares it with the loop"
    if threading.active_count() > 1:
        yield (
            f"{threading.active_count() - 1} more Python threads run in this process: each may "
            "hold the interpreter for 5 ms; run the loop in a process of its own"
        )
    if not system.LINUX:
        return
    for rival in rivals():
        if rival.cpu == cpu:
            yield (
                f"CPU {cpu} is also that of {rival.name}, process {rival.process}, at real-time "
                f"priority {rival.priority}: give one of them another CPU"
            )
    yield from _throttling()
    yield from _governor(cpu)
    yield from _sibling(cpu)
    if _swap_used():
        yield (
            "swap is in use: memory that is not locked may have to be read from disk; "
            "run `sudo swapoff -a`"
        )
    if "hypervisor" in read_text("/proc/cpuinfo"):
        yield (
            "this is a virtual machine: its host may take a CPU away at any time; compare with "
            "a cyclictest beside it, `skinfield bench --jitter`"
        )


def _throttling() -> Iterator[str]:
    runtime = read_text("/proc/sys/kernel/sched_rt_runtime_us").strip()
    period = read_text("/proc/sys/kernel/sched_rt_period_us").strip()
    if runtime.isdigit() and period.isdigit() and int(runtime) < int(period):
        yield (
            f"real-time throttling is on: what computes for more than {int(runtime) / 1000:g} of "
            f"{int(period) / 1000:g} ms is stopped for the rest; a loop that sleeps in every "
            "cycle does not get there, `sudo sysctl kernel.sched_rt_runtime_us=-1` ends it"
        )


def _governor(cpu: int | None) -> Iterator[str]:
    found = read_text(f"/sys/devices/system/cpu/cpu{cpu or 0}/cpufreq/scaling_governor").strip()
    if found and found != "performance":
        yield (
            f"the governor of CPU {cpu or 0} is {found}: it slows down when there is little to "
            "do; run `sudo cpupower frequency-set -g performance`"
        )


def _sibling(cpu: int | None) -> Iterator[str]:
    if cpu is None:
        return
    topology = f"/sys/devices/system/cpu/cpu{cpu}/topology/thread_siblings_list"
    others = sorted(cpus_of(read_text(topology)) - {cpu})
    if others:
        yield (
            f"CPU {cpu} shares its core with CPU {', '.join(map(str, others))}: what runs there "
            "slows the loop down; turn off hyper-threading, or leave that one idle"
        )


def _swap_used() -> bool:
    """Whether any swap is used, from the fourth column of the system's table."""
    rows = [line.split() for line in read_text("/proc/swaps").splitlines()[1:]]
    return any(len(row) > 3 and row[3].isdigit() and int(row[3]) > 0 for row in rows)
