"""Real-time set-up of a process: what it requests of the system, what it got, and the way back.

Each request is made where it is permitted; none is required.
"""

import errno
import gc
import os
import struct
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skinfield.errors import check_count
from skinfield.loop.realtime import system
from skinfield.loop.realtime.system import competitors, cpus_of, read_text, values_of


@dataclass(frozen=True)
class RealTimeStatus:
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
    gc_frozen : bool
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
    gc_frozen: bool
    kernel: str
    refused: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()

    @property
    def real_time(self) -> bool:
        """Whether the loop goes before all ordinary work."""
        return self.priority > 0

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return vars(self) | {"refused": list(self.refused), "disturbances": list(self.disturbances)}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "RealTimeStatus":
        """Back from `as_dict`."""
        lists = {name: tuple(values[name]) for name in ("refused", "disturbances")}
        return cls(**{**values, **lists})

    def sentences(self) -> tuple[str, ...]:
        """Everything as sentences: what was granted first."""
        scheduling = f"ordinary scheduling ({self.scheduler})"
        if self.real_time:
            scheduling = f"{self.scheduler} at priority {self.priority}"
        cpu = f"pinned to {'the isolated ' if self.isolated else ''}CPU {self.cpu}"
        where = "on any processor" if self.cpu is None else cpu
        gc = f"garbage collector {'frozen' if self.gc_frozen else 'running'}"
        granted = f"{scheduling}, {where}, memory {self.memory}, {gc}; {self.kernel}"
        return (granted, *self.refused, *self.disturbances)


POLICIES = ("SCHED_OTHER", "SCHED_FIFO", "SCHED_RR", "SCHED_BATCH", "SCHED_IDLE")
CAP_IPC_LOCK = 14  # number of the capability, of linux/capability.h
LATENCY = Path("/dev/cpu_dma_latency")
_awake: list[int] = []  # the descriptor that keeps processors awake for as long as it is open


@dataclass(eq=False)
class Outcome:
    """What was granted, by the names of `RealTimeStatus`, and what was refused."""

    granted: dict[str, Any] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)


def _schedule(wanted: "RealTime", outcome: Outcome) -> None:
    number = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
    policies = {getattr(os, name): name for name in POLICIES}
    policy, priority = policies.get(number, f"policy {number}"), os.sched_getparam(0).sched_priority
    outcome.granted.update(scheduler=policy, priority=priority)
    if not wanted.priority:
        return
    error: OSError | None = None
    permitted, _ = _raise_limit("RLIMIT_RTPRIO")
    lower = wanted.priority if permitted < 0 else min(permitted, wanted.priority)
    for priority in filter(None, dict.fromkeys((wanted.priority, lower))):
        try:  # what this process starts later is ordinary again
            os.sched_setscheduler(
                0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority)
            )
        except OSError as refused:
            error = refused
            continue
        outcome.granted.update(scheduler="SCHED_FIFO", priority=priority)
        if priority < wanted.priority:
            outcome.refused.append(
                f"priority {wanted.priority} not granted, {priority} is: the limit `rtprio` is "
                f"{priority}; {_remedy('rtprio 90', 'SYS_NICE')}"
            )
        return
    reason = "no reason given" if error is None else error.strerror
    outcome.refused.append(f"SCHED_FIFO not granted: {reason}; {_remedy('rtprio 90', 'SYS_NICE')}")


def _remedy(limit: str, capability: str) -> str:
    """How to get a limit, or the capability that stands for it."""
    if hasattr(os, "geteuid") and os.geteuid() == 0:  # whom no limit binds
        return f"root lacks CAP_{capability} here: start the container with --cap-add {capability}"
    return (
        f"put `@realtime - {limit}` into /etc/security/limits.d/skinfield.conf, join that group by "
        "`sudo groupadd -f realtime` and `sudo usermod -aG realtime $USER`, and log in again"
    )


def _raise_limit(name: str) -> tuple[int, int]:
    """Soft and hard limit after raising the soft one; below 0 for none."""
    import resource

    limit = getattr(resource, name)
    soft, hard = resource.getrlimit(limit)
    if soft != hard:
        with suppress(OSError, ValueError):
            resource.setrlimit(limit, (hard, hard))
    return resource.getrlimit(limit)


def _pin(wanted: "RealTime", outcome: Outcome) -> None:
    allowed = os.sched_getaffinity(0)
    isolated = cpus_of(read_text("/sys/devices/system/cpu/isolated"))
    if wanted.cpu is not None:
        choices = [wanted.cpu]
    else:
        wished = _isolated_choices(allowed, isolated)
        taken = {each.cpu for each in competitors()}
        choices = sorted(wished, reverse=True) + sorted(allowed - wished, reverse=True)
        choices.sort(key=lambda cpu: (cpu in taken, cpu not in wished))  # else it stays as it is
    for cpu in choices:
        try:
            os.sched_setaffinity(0, {cpu})
        except OSError as error:
            reason = error.strerror
            continue
        outcome.granted.update(cpu=cpu, isolated=cpu in isolated)
        return
    outcome.refused.append(
        f"CPU {choices[-1]} not granted: {reason}; this process may use "
        f"{', '.join(map(str, sorted(allowed)))}: choose one of them, or widen the set by "
        "`taskset` or the container's `--cpuset-cpus`"
    )


def _isolated_choices(allowed: set[int], isolated: set[int]) -> set[int]:
    """Isolated processors that the process may want.

    The system leaves them out of what a process may use by default; if that is all that is left
    out, they may be asked for. A narrower set is somebody's wish, and is kept to.
    """
    online = cpus_of(read_text("/sys/devices/system/cpu/online"))
    return isolated if allowed | isolated >= online else isolated & allowed


def _lock(wanted: "RealTime", outcome: Outcome) -> None:
    if not wanted.lock_memory:
        return
    try:
        for name, value in ((system.M_TRIM_THRESHOLD, -1), (system.M_MMAP_MAX, 0)):
            if not system.call("mallopt", name, value):
                raise OSError(0, "the C library refuses the setting")
    except OSError as error:
        outcome.refused.append(f"freed memory goes back to the system: {error.strerror}")
    # Under a limit, memory that is locked as it is allocated would make allocations fail.
    soft, _ = _raise_limit("RLIMIT_MEMLOCK")
    free = soft < 0 or bool(capabilities() >> CAP_IPC_LOCK & 1)
    try:
        _lock_all(system.MCL_CURRENT | (system.MCL_FUTURE if free else 0))
    except OSError as error:
        remedy = _remedy("memlock unlimited", "IPC_LOCK")
        outcome.refused.append(f"memory not locked: {error.strerror}; {remedy}")
        return
    outcome.granted["memory"] = "locked" if free else "locked so far"
    if not free:
        remedy = _remedy("memlock unlimited", "IPC_LOCK")
        outcome.refused.append(f"later memory not locked: the limit `memlock` is finite; {remedy}")


def _lock_all(flags: int) -> None:
    """Lock every page that was touched, and each other one when it is touched for the first time.

    By then a rehearsal has touched what a cycle needs. Without the flag, which Linux has since 4.4,
    libraries and rooms would be locked in whole, which takes twice as much memory.
    """
    try:
        system.call("mlockall", flags | system.MCL_ONFAULT)
    except OSError as error:
        if error.errno != errno.EINVAL:
            raise
        system.call("mlockall", flags)


def _stay_awake(wanted: "RealTime", outcome: Outcome) -> None:
    if not wanted.keep_awake or _awake:
        return
    try:
        held = os.open(LATENCY, os.O_WRONLY | os.O_CLOEXEC)
        os.write(held, struct.pack("i", 0))  # µs that waking may take; holds while it is open
    except OSError as error:
        outcome.refused.append(
            f"processors may sleep deeply: {LATENCY} cannot be written ({error.strerror}); run "
            f"`sudo chmod o+w {LATENCY}`, or start Linux with `processor.max_cstate=1 "
            "intel_idle.max_cstate=0`; on a virtual machine the host decides"
        )
        return
    _awake.append(held)


def _slack(_: "RealTime", outcome: Outcome) -> None:
    try:
        system.call("prctl", system.PR_SET_TIMERSLACK, 1, 0, 0, 0)
    except OSError as error:
        outcome.refused.append(
            f"timer slack not set: {error.strerror}; wakes come up to 50 µs late"
        )


def capabilities() -> int:
    """Bits of the capabilities that this process has; 0 where that is not known."""
    return int(values_of("/proc/self/status").get("CapEff", "0"), 16)


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

    def apply(self) -> RealTimeStatus:
        """Ask for everything, for this process and the thread that calls.

        Call it last, when everything is loaded, prepared and compiled: memory is locked and the
        garbage collector frozen as they are then. Processes and threads that are started later are
        not real-time themselves; they do inherit the processor.
        """
        granted = {"scheduler": "of this system", "priority": 0, "cpu": None, "isolated": False}
        outcome = Outcome(granted | {"memory": "not locked", "gc_frozen": self.freeze_gc})
        if self.freeze_gc:
            gc.collect()
            gc.freeze()
            gc.disable()
        if system.LINUX:
            for request in (_pin, _lock, _stay_awake, _slack, _schedule):
                request(self, outcome)  # the last of them last: the others may take milliseconds
        else:
            outcome.refused.append(
                f"real time not granted: it is asked for on Linux only and this is {sys.platform}; "
                "run the engine on a Linux machine for times that hold"
            )
        return RealTimeStatus(
            **outcome.granted,
            kernel=system.kernel(),
            refused=tuple(outcome.refused),
            disturbances=tuple(system.disturbances(outcome.granted["cpu"])),
        )
