"""The requests, one by one: what each got, and a sentence where it got nothing."""

import errno
import gc
import os
import struct
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinfield.realtime import system
from skinfield.realtime.rivals import rivals
from skinfield.realtime.system import cpus_of, read_text

if TYPE_CHECKING:
    from skinfield.realtime.settings import RealTime

TRIM_THRESHOLD, MMAP_MAX = 128 * 1024, 65536  # defaults of the GNU C library
CAP_IPC_LOCK = 14  # number of the capability, of linux/capability.h
LATENCY = Path("/dev/cpu_dma_latency")
_awake: list[int] = []  # the descriptor that keeps processors awake for as long as it is open


@dataclass(eq=False)
class Found:
    """What was granted, by the names of `Granted`, and what was refused."""

    granted: dict[str, Any] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)


def ask(wanted: "RealTime") -> Found:
    """Make all requests of `wanted`."""
    found = Found()
    if not system.LINUX:
        found.refused.append(
            f"real time not granted: it is asked for on Linux only and this is {sys.platform}; "
            "run the engine on a Linux machine for times that hold"
        )
    _pin(wanted, found)
    _collect(wanted, found)
    _lock(wanted, found)
    _stay_awake(wanted, found)
    _slack(found)
    _schedule(wanted, found)  # last: the requests before may take milliseconds
    return found


def _schedule(wanted: "RealTime", found: Found) -> None:
    found.granted.update(scheduler="of this system", priority=0)
    if not system.LINUX:
        return
    found.granted.update(scheduler=_policy(), priority=os.sched_getparam(0).sched_priority)
    if not wanted.priority:
        return
    error: OSError | None = None
    for priority in dict.fromkeys((wanted.priority, min(_permitted_priority(), wanted.priority))):
        if not priority:
            continue
        try:  # what this process starts later is ordinary again
            os.sched_setscheduler(
                0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority)
            )
        except OSError as refused:
            error = refused
            continue
        found.granted.update(scheduler="SCHED_FIFO", priority=priority)
        if priority < wanted.priority:
            found.refused.append(
                f"priority {wanted.priority} not granted, {priority} is: the limit `rtprio` is "
                f"{priority}; {_remedy('rtprio 90', 'SYS_NICE')}"
            )
        return
    reason = "no reason given" if error is None else error.strerror
    found.refused.append(f"SCHED_FIFO not granted: {reason}; {_remedy('rtprio 90', 'SYS_NICE')}")


def _remedy(limit: str, capability: str) -> str:
    """How to get a limit, or the capability that stands for it."""
    if hasattr(os, "geteuid") and os.geteuid() == 0:  # whom no limit binds
        return f"root lacks CAP_{capability} here: start the container with --cap-add {capability}"
    return (
        f"put `@realtime - {limit}` into /etc/security/limits.d/skinfield.conf, join that group by "
        "`sudo groupadd -f realtime` and `sudo usermod -aG realtime $USER`, and log in again"
    )


def _policy() -> str:
    number = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
    names = ("SCHED_OTHER", "SCHED_FIFO", "SCHED_RR", "SCHED_BATCH", "SCHED_IDLE")
    known = {getattr(os, name): name for name in names}
    return known.get(number, f"policy {number}")


def _permitted_priority() -> int:
    """The highest that the limits of the process permit, once raised as far as they may be."""
    soft, _ = _raise_limit("RLIMIT_RTPRIO")
    return 99 if soft < 0 or soft > 99 else soft


def _raise_limit(name: str) -> tuple[int, int]:
    """Soft and hard limit after raising the soft one; below 0 for none."""
    import resource

    limit = getattr(resource, name)
    soft, hard = resource.getrlimit(limit)
    if soft != hard:
        with suppress(OSError, ValueError):
            resource.setrlimit(limit, (hard, hard))
    return resource.getrlimit(limit)


def _pin(wanted: "RealTime", found: Found) -> None:
    found.granted.update(cpu=None, isolated=False)
    if not system.LINUX:
        return
    allowed = os.sched_getaffinity(0)
    isolated = cpus_of(read_text("/sys/devices/system/cpu/isolated"))
    if wanted.cpu is not None:
        choices = [wanted.cpu]
    else:
        wished = _isolated_choices(allowed, isolated)
        taken = {each.cpu for each in rivals()}
        choices = sorted(wished, reverse=True) + sorted(allowed - wished, reverse=True)
        choices.sort(key=lambda cpu: (cpu in taken, cpu not in wished))  # else it stays as it is
    for cpu in choices:
        try:
            os.sched_setaffinity(0, {cpu})
        except OSError as error:
            reason = error.strerror
            continue
        found.granted.update(cpu=cpu, isolated=cpu in isolated)
        return
    found.refused.append(
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


def _collect(wanted: "RealTime", found: Found) -> None:
    if wanted.freeze_gc:
        gc.collect()
        gc.freeze()
        gc.disable()
    found.granted["gc_frozen"] = wanted.freeze_gc


def _lock(wanted: "RealTime", found: Found) -> None:
    found.granted.update(memory="not locked", heap_kept=False)
    if not wanted.lock_memory or not system.LINUX:
        return
    try:
        for name, value in ((system.M_TRIM_THRESHOLD, -1), (system.M_MMAP_MAX, 0)):
            if not system.call("mallopt", name, value):
                raise OSError(0, "the C library refuses the setting")
        found.granted["heap_kept"] = True
    except OSError as error:
        found.refused.append(f"freed memory goes back to the system: {error.strerror}")
    # Under a limit, memory that is locked as it is allocated would make allocations fail.
    free = _may_lock_all()
    try:
        _lock_all(system.MCL_CURRENT | (system.MCL_FUTURE if free else 0))
    except OSError as error:
        remedy = _remedy("memlock unlimited", "IPC_LOCK")
        found.refused.append(f"memory not locked: {error.strerror}; {remedy}")
        return
    found.granted["memory"] = "locked" if free else "locked so far"
    if not free:
        remedy = _remedy("memlock unlimited", "IPC_LOCK")
        found.refused.append(f"later memory not locked: the limit `memlock` is finite; {remedy}")


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


def _may_lock_all() -> bool:
    soft, _ = _raise_limit("RLIMIT_MEMLOCK")
    return soft < 0 or bool(capabilities() >> CAP_IPC_LOCK & 1)


def _stay_awake(wanted: "RealTime", found: Found) -> None:
    found.granted["kept_awake"] = bool(_awake)
    if not wanted.keep_awake or _awake or not system.LINUX:
        return
    try:
        held = os.open(LATENCY, os.O_WRONLY | os.O_CLOEXEC)
        os.write(held, struct.pack("i", 0))  # µs that waking may take; holds while it is open
    except OSError as error:
        found.refused.append(
            f"processors may sleep deeply: {LATENCY} cannot be written ({error.strerror}); run "
            f"`sudo chmod o+w {LATENCY}`, or start Linux with `processor.max_cstate=1 "
            "intel_idle.max_cstate=0`; on a virtual machine the host decides"
        )
        return
    _awake.append(held)
    found.granted["kept_awake"] = True


def let_sleep() -> None:
    """Let processors sleep again."""
    while _awake:
        os.close(_awake.pop())


def _slack(found: Found) -> None:
    found.granted["timer_slack_ns"] = None
    if not system.LINUX:
        return
    try:
        system.call("prctl", system.PR_SET_TIMERSLACK, 1, 0, 0, 0)
        slack = system.call("prctl", system.PR_GET_TIMERSLACK, 0, 0, 0, 0)
        found.granted["timer_slack_ns"] = slack
    except OSError as error:
        found.refused.append(f"timer slack not set: {error.strerror}; wakes come up to 50 µs late")


def capabilities() -> int:
    """Bits of the capabilities that this process has; 0 where that is not known."""
    for line in read_text("/proc/self/status").splitlines():
        if line.startswith("CapEff:"):
            return int(line.split()[1], 16)
    return 0
