"""Measuring how late a loop wakes, beside busy processes and a cyclictest."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skinfield.cli.jitter_loops import Loop, bare_loop, engine_loop, skin_loop
from skinfield.errors import Floats, InputError, check_choice, check_count, check_range
from skinfield.experiments.bench.machine import Company, Watch
from skinfield.inverse import NonNegative, Solver
from skinfield.realtime import Granted, Quantiles, RealTime, Timing
from skinfield.realtime.cyclictest import Cyclictest, Running
from skinfield.realtime.histogram import LAST_NS

LOADS = ("skin", "engine", "none")
PAIRS = ("same", "other")
SETTLE = 1.0  # s of company before times count
BEFORE = 0.25  # s before a whole second at which cyclictest is started: it begins at the second
SPIN = "import time\nend = time.monotonic() + {seconds}\nwhile time.monotonic() < end: pass"

WAKE_RATIO = 1.25  # p99.9 over that of the paired cyclictest
READY_P50, READY_P99 = 100e-6, 200e-6  # s after the wake, at 1 kHz


@dataclass(frozen=True)
class JitterSettings:
    """What is measured.

    Parameters
    ----------
    seconds : float, s
    rate : float, 1/s
    busy : int
        Processes that compute all the time beside it.
    load : str
        "skin": the engine reads a virtual skin over UDP; "engine": its readings were made before;
        "none": it only wakes.
    solver : Solver
        Of the engine.
    pair : str
        Which processor cyclictest runs on: the "same" as the loop, or an "other".
    real_time : RealTime
    """

    seconds: float = 20.0
    rate: float = 1000.0
    busy: int = 2
    load: str = "skin"
    solver: Solver = field(default_factory=NonNegative)
    pair: str = "same"
    real_time: RealTime = field(default_factory=RealTime)

    def __post_init__(self) -> None:
        check_range("seconds", self.seconds, 1.0, 86_400.0, "of measuring")
        check_range("rate", self.rate, 1.0, 20_000.0, "cycles per second")
        check_count("busy", self.busy, 0, 1024, "processes that compute all the time")
        check_choice("load", self.load, LOADS, "what a cycle does")
        check_choice("pair", self.pair, PAIRS, "the processor of cyclictest")


@dataclass(frozen=True)
class Target:
    """One thing that is aimed at.

    Attributes
    ----------
    name : str
    limit, value : float
        In the unit; no value where it was not measured.
    unit : str
        "s", or empty for a ratio.
    why : str
        Why it was not measured.
    """

    name: str
    limit: float
    value: float | None
    unit: str = ""
    why: str = ""

    @property
    def met(self) -> bool | None:
        """Whether the value is within the limit."""
        return None if self.value is None else self.value <= self.limit


@dataclass(frozen=True)
class Jitter:
    """What was found.

    Attributes
    ----------
    settings : JitterSettings
    granted : Granted
    timing : Timing
        Of the loop.
    paired : Quantiles or None
        Of the cyclictest beside it.
    no_pair : str
        Why there is none.
    company : Company
    faults, interruptions : int or None
        Page faults of the loop's process, and times that it had to give its CPU away; None where
        the system does not tell.
    late, paired_late : pairs of arrays (B,)
        Time (s) and share of wakes that were later: of the loop, and of cyclictest if there is one.
    """

    settings: JitterSettings
    granted: Granted
    timing: Timing
    paired: Quantiles | None
    no_pair: str
    company: Company
    faults: int | None
    interruptions: int | None
    late: tuple[Floats, Floats]
    paired_late: tuple[Floats, Floats] | None

    def ratio(self, name: str) -> float | None:
        """Of the wakes' quantile to that of the cyclictest."""
        if self.paired is None or self.timing.wake is None:
            return None
        return float(getattr(self.timing.wake, name) / max(getattr(self.paired, name), 1e-9))

    def targets(self) -> tuple[Target, ...]:
        """What is aimed at, and whether it is reached."""
        ready, settings = self.timing.ready, self.settings
        idle = "" if settings.load != "none" else "the loop ran without an engine"
        other = "" if settings.rate == 1000 else "it is meant for 1000 cycles per second"
        why = idle or other or ("" if self.granted.real_time else "the loop ran without SCHED_FIFO")
        pair = self.no_pair or ("" if self.granted.real_time else why)
        ratio = None if pair else self.ratio("p999")
        p50, p99 = (None, None) if why or ready is None else (ready.p50, ready.p99)
        return (
            Target("wake p99.9 over that of cyclictest", WAKE_RATIO, ratio, why=pair),
            Target("ready p50", READY_P50, p50, "s", why),
            Target("ready p99", READY_P99, p99, "s", why),
        )


def run_jitter(settings: JitterSettings, tell: Callable[[str], None]) -> Jitter:
    """Measure.

    Parameters
    ----------
    tell : function of str
        Is told what happens.
    """
    tell("starting the loop")
    with _loop(settings) as loop, _busy(settings):
        time.sleep(SETTLE)
        tell(f"measuring for {settings.seconds:g} s")
        return _measured(settings, loop)


def _loop(settings: JitterSettings) -> AbstractContextManager[Loop]:
    if settings.load == "none":
        return bare_loop(settings.rate, settings.real_time)
    make = skin_loop if settings.load == "skin" else engine_loop
    return make(settings.rate, settings.solver, settings.real_time)


def _measured(settings: JitterSettings, loop: Loop) -> Jitter:
    """Both in the same seconds: cyclictest begins at a whole second of the clock."""
    second = time.monotonic_ns() // 10**9 + 2
    _sleep_until(second - BEFORE)
    running, missing = _paired(settings, loop.granted)
    try:
        _sleep_until(second)
        before, watch, usage = loop.snapshot(), Watch(), _usage(loop.pid)
        _sleep_until(second + settings.seconds)
        after, company, used = loop.snapshot(), watch.company(), _usage(loop.pid)
        lateness = None if running is None else running.finish()
    except InputError as error:
        lateness, missing = None, str(error)
    finally:
        if running is not None:
            running.stop()
    timing = Timing.of(*after, before=before)
    if loop.failure() or not timing.cycles:
        raise InputError(
            f"the loop ended while it was measured, after {timing.cycles} cycles, expected it to "
            f"run on: {loop.failure() or 'it did not say why'}"
        )
    wakes = (after[0][0] - before[0][0])[: len(LAST_NS)].astype(np.float64)
    ends = LAST_NS.astype(np.float64) / 1e9
    return Jitter(
        settings,
        loop.granted,
        timing,
        None if lateness is None else lateness.quantiles(),
        missing,
        company,
        None if usage is None or used is None else used[0] - usage[0],
        None if usage is None or used is None else used[1] - usage[1],
        _later(ends, wakes),
        None if lateness is None else lateness.later(),
    )


def _usage(pid: int) -> tuple[int, int] | None:
    """Page faults and involuntary switches of a process so far, by Linux; else unknown."""
    folder = Path("/proc") / str(pid)
    try:
        fields = (folder / "stat").read_text().rpartition(")")[2].split()
        status = (folder / "status").read_text().splitlines()
        switches = next(line for line in status if line.startswith("nonvoluntary_ctxt_switches"))
        return int(fields[7]) + int(fields[9]), int(switches.split()[1])
    except (OSError, ValueError, IndexError, StopIteration):
        return None


def _later(ends: Floats, counts: Floats) -> tuple[Floats, Floats]:
    """Share of all that is beyond the end of each bin, from the first bin with any to the last."""
    used = np.flatnonzero(counts)
    some = slice(used[0], used[-1] + 1) if len(used) else slice(0, 0)
    return ends[some], 1.0 - np.cumsum(counts[some]) / max(counts.sum(), 1.0)


def _paired(settings: JitterSettings, granted: Granted) -> tuple[Running | None, str]:
    """A cyclictest half a period apart, on the same processor just above in priority.

    It then never waits for the loop's computation, and neither finds the processor taken by the
    other as long as a cycle lasts less than half a period.
    """
    period = int(1e9 / settings.rate)
    priority = min(granted.priority + 1, 99) if granted.real_time else 0
    try:
        cpu = granted.cpu if settings.pair == "same" else _other_cpu(granted.cpu)
        locked = granted.memory == "locked"
        wanted = Cyclictest(cpu, priority, period, settings.seconds, period // 2, locked)
        return wanted.start(), ""
    except InputError as error:
        return None, str(error)


def _other_cpu(cpu: int | None) -> int | None:
    """The last processor that is not the loop's; none is chosen where the loop is not pinned."""
    if cpu is None:
        return None
    others = os.sched_getaffinity(0) - {cpu}
    if not others:
        raise InputError("there is no other CPU, expected two: run it with --pair same")
    return max(others)


def _sleep_until(second: float) -> None:
    time.sleep(max(second - time.monotonic(), 0.0))


@contextmanager
def _busy(settings: JitterSettings) -> Iterator[None]:
    """Processes that compute all the time; they end by themselves if nobody ends them."""
    words = [sys.executable, "-c", SPIN.format(seconds=settings.seconds + 30.0)]
    children = [subprocess.Popen(words) for _ in range(settings.busy)]
    try:
        yield
    finally:
        for child in children:
            child.kill()
        for child in children:
            child.wait()
