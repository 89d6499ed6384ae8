"""Jitter of a live loop: how late it wakes beside busy processes and a paired cyclictest.

`cyclictest` (C. Williams, J. Kacir, wiki.linuxfoundation.org/realtime) is a loop in C that does
nothing but sleep. A loop that wakes as late at the same time on the same processor adds nothing.
"""

import json
import shutil
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.lab.bench.machine import Watch
from skinfield.loop.realtime import Quantiles, RealTime, RealTimeStatus, Timing
from skinfield.skin import Skin
from skinfield.solve import Auto, Solver

HIGHEST = 20_000  # µs: what is later is only counted
PATIENCE = 15.0  # s that it may take beyond its time


class Cyclictest:
    """A cyclictest that runs beside this process.

    Parameters
    ----------
    cpu : int or None
        To which it is pinned.
    priority : int
        Of SCHED_FIFO; 0 for ordinary scheduling.
    period_ns : int, ns
        Whole µs.
    seconds : float, s
        That it measures.
    offset_ns : int, ns
        From the whole seconds of the clock, at which it begins.
    lock_memory : bool
        It fails where that is not permitted.

    Raises
    ------
    InputError
        If it is not installed.
    """

    def __init__(
        self,
        cpu: int | None,
        priority: int,
        *,
        period_ns: int = 1_000_000,
        seconds: float = 20.0,
        offset_ns: int = 0,
        lock_memory: bool = True,
    ) -> None:
        program = shutil.which("cyclictest")
        if program is None:
            raise InputError(
                "cyclictest is not installed, expected version 2.0 or later on the path: install "
                "rt-tests, such as by `sudo apt install rt-tests`"
            )
        with tempfile.NamedTemporaryFile(prefix="cyclictest-", delete=False) as made:
            self.file = Path(made.name)
        words = ["-q", "-t", "1", "-h", str(HIGHEST), f"--json={self.file}"]
        words += ["-i", str(period_ns // 1000), "-D", str(max(round(seconds), 1))]
        words += ["-p", str(priority)] if priority else ["--policy=other"]
        words += [] if cpu is None else ["-a", str(cpu)]
        words += ["-m"] if lock_memory else []
        self.seconds = seconds
        self.child = subprocess.Popen(
            [program, *words, f"--secaligned={offset_ns // 1000}"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def finish(self) -> Quantiles:
        """Wait for its end and read what it measured.

        Raises
        ------
        InputError
            If it failed, with its own words.
        FileError
            If it printed no histogram.
        """
        try:
            _, complaint = self.child.communicate(timeout=self.seconds + PATIENCE)
            text = self.file.read_text(encoding="utf-8", errors="replace")
        except subprocess.TimeoutExpired as error:
            raise InputError(
                f"cyclictest did not end within {self.seconds + PATIENCE:g} s, expected "
                f"{self.seconds:g} s: run it by hand"
            ) from error
        finally:
            self.stop()
        if self.child.returncode:
            lines = [line for line in complaint.splitlines() if line.strip()]
            raise InputError(f"cyclictest failed: {' '.join(lines[-2:]) or 'it gave no reason'}")
        return quantiles_from_json(text)

    def stop(self) -> None:
        """End it now, and take its file away."""
        self.child.kill()
        self.child.wait()
        if self.child.stderr is not None:
            self.child.stderr.close()
        self.file.unlink(missing_ok=True)


def quantiles_from_json(text: str) -> Quantiles:
    """Read what `cyclictest --json` printed of one thread, in the middle of its bins of 1 µs.

    Raises
    ------
    FileError
        If it has no histogram.
    """
    try:
        thread = json.loads(text)["thread"]["0"]
        bins = sorted((int(late), int(count)) for late, count in thread["histogram"].items())
        cycles, longest, mean = int(thread["cycles"]), int(thread["max"]), float(thread["avg"])
        beyond = cycles - sum(count for _, count in bins)
        if cycles < 1 or beyond < 0 or (bins and bins[0][0] < 0):
            raise ValueError(f"{cycles} cycles and {beyond} beyond the histogram")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise FileError(
            f"cyclictest printed {text[:60]!r} ({type(error).__name__}: {error}), expected JSON "
            "with a histogram of one thread, as version 2.0 and later print"
        ) from error
    late, counts = np.array([*bins, *([(longest, beyond)] if beyond else [])], np.int64).T
    places = np.searchsorted(np.cumsum(counts), [-(-cycles * m // 1000) for m in (500, 990, 999)])
    p50, p99, p999 = np.minimum((late[places] + 0.5) * 1e-6, 1e-6 * longest).tolist()
    return Quantiles(p50, p99, p999, 1e-6 * longest, 1e-6 * mean, cycles)


Boards = Callable[[Skin, float, int], AbstractContextManager[tuple[Any, Callable[[str], Any]]]]
Row = dict[str, Any]
QUANTILES = ("p50", "p99", "p999", "max")
STARTS = 600.0  # s until a loop runs: what must be compiled may take long
RUNGS = (10, 20, 40)  # nodes on a side
SETTLE = 1.0  # s of company before times count
BEFORE = 0.25  # s before a whole second at which cyclictest is started: it begins at the second
SPIN = "import time\nend = time.monotonic() + {seconds}\nwhile time.monotonic() < end: pass"


@dataclass(frozen=True)
class JitterSettings:
    """What is measured.

    Parameters
    ----------
    duration : float, s
    rate_hz : float, 1/s
    busy : int
        Processes that compute all the time beside it.
    solver : Solver
        Of the engine.
    real_time : RealTime
    """

    duration: float = 20.0
    rate_hz: float = 1000.0
    busy: int = 2
    solver: Solver = field(default_factory=Auto)
    real_time: RealTime = field(default_factory=RealTime)


def run_jitter(settings: JitterSettings, say: Callable[[str], None], boards: Boards) -> Row:
    """Measure how late the live loop wakes.

    Parameters
    ----------
    settings : JitterSettings
    say : function of str
        Called with what happens.
    boards : function of skin, rate and priority
        Starts a virtual skin of iCub's boards on UDP in a process of its own, which sends so many
        readings per second, as a context; it gives the live source that reads them, and a function
        that plays a scene. The engine of the paper's hexagon reads them on 40 x 40 nodes.

    Returns
    -------
    dict
        See `result`.

    Raises
    ------
    InputError
        If the loop does not start, or ends while it is measured.
    """
    from skinfield.loop.settings import LiveSettings
    from skinfield.loop.supervisor import Supervisor
    from skinfield.signal import ICubByte
    from skinfield.skin.generators import hexagon72

    say("starting the loop")
    skin, real_time = Skin((hexagon72(),)), settings.real_time
    with ExitStack() as stack:
        priority = max(real_time.priority - 10, 0)
        source, play = stack.enter_context(boards(skin, settings.rate_hz, priority))
        live = LiveSettings(
            skin=skin,
            sources=(source,),
            name=f"bench-{uuid.uuid4().hex[:8]}",
            board=ICubByte(),
            solver=settings.solver,
            rungs=RUNGS,
            rate=settings.rate_hz,
            tare_seconds=0.5,
            real_time=real_time,
        )
        supervisor = stack.enter_context(Supervisor(live))
        reader = supervisor.wait(STARTS)
        stack.callback(reader.close)
        _until_prepared(reader)
        play("slide")  # once it has its baseline
        granted = _granted(reader)
        stack.enter_context(_busy(settings))
        time.sleep(SETTLE)
        say(f"measuring for {settings.duration:g} s")
        return measure(settings, granted, reader, supervisor)


def _until_prepared(reader: Any) -> None:
    """Wait until the solver that was asked for answers, not a linear one in its place."""
    from skinfield.loop.status_text import read_notes, start_in_words

    end = time.monotonic() + STARTS
    while time.monotonic() < end:
        notes = read_notes(reader.status["notes"])
        if notes is not None and not start_in_words(notes):
            return
        time.sleep(0.05)
    raise InputError(f"the solver was not prepared within {STARTS:g} s, expected it to be")


def measure(settings: JitterSettings, granted: RealTimeStatus, reader: Any, supervisor: Any) -> Row:
    """Both in the same seconds: cyclictest begins at a whole second of the clock.

    Parameters
    ----------
    settings : JitterSettings
    granted : RealTimeStatus
        To the engine.
    reader : LiveReader
        Of the engine's ring.
    supervisor : Supervisor
        Of the engine.
    """
    second = int(time.monotonic() + 2 * BEFORE) + 1
    _sleep_until(second - BEFORE)
    running, missing = _paired(settings, granted)
    try:
        _sleep_until(second)
        before, watch, usage = _counts(reader), Watch(), _usage(reader.pid)
        _sleep_until(second + settings.duration)
        after, stolen, used = _counts(reader), watch.company()["stolen"], _usage(reader.pid)
        paired = None if running is None else running.finish()
    except InputError as error:
        paired, missing = None, str(error)
    finally:
        if running is not None:
            running.stop()
    timing = Timing.of(*after, before=before)
    if supervisor.failure or not timing.cycles:
        raise InputError(
            f"the loop ended while it was measured, after {timing.cycles} cycles, expected it to "
            f"run on: {supervisor.failure or 'it did not say why'}"
        )
    faults, interruptions = (
        None if usage is None or used is None else used[which] - usage[which] for which in (0, 1)
    )
    about: Row = {"no_cyclictest": missing or None, "page_faults": faults}
    about |= {"interruptions": interruptions, "stolen_cores": stolen}
    return result(settings, granted, timing, paired, about)


def result(
    settings: JitterSettings,
    granted: RealTimeStatus,
    timing: Timing,
    paired: Quantiles | None,
    about: Row,
) -> Row:
    """Plain numbers, times in µs: of the loop, of a cyclictest beside it, and their ratio.

    `about` says why there is no cyclictest, how many cores the host of a virtual machine kept to
    itself on average, and how many page faults the loop's process had and how often it had to give
    its CPU away; None where the system does not tell.
    """
    loop = timing.as_dict()
    other = None if paired is None else paired.as_micros()
    ratio: dict[str, float | None] = dict.fromkeys(QUANTILES)
    if other is not None and timing.wake is not None:
        wake = timing.wake.as_micros()
        ratio = {name: wake[name] / max(other[name], 1e-3) for name in QUANTILES}
    return {
        "seconds": settings.duration,
        "rate_hz": settings.rate_hz,
        "busy": settings.busy,
        "solver": type(settings.solver).__name__,
        "granted": granted.as_dict(),
        "loop": loop,
        "cyclictest_us": other,
        "ratio": ratio,
        **about,
    }


def _counts(reader: Any) -> tuple[Any, Any]:
    """Copies of the engine's histograms and totals."""
    status = reader.status
    return status["times"].copy(), status["totals"].copy()


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


def _paired(settings: JitterSettings, granted: RealTimeStatus) -> tuple[Cyclictest | None, str]:
    """A cyclictest half a period apart, on the same processor just above in priority.

    It then never waits for the loop's computation, and neither finds the processor taken by the
    other as long as a cycle lasts less than half a period.
    """
    period = int(1e9 / settings.rate_hz)
    try:
        running = Cyclictest(
            granted.cpu,
            min(granted.priority + 1, 99) if granted.real_time else 0,
            period_ns=period,
            seconds=settings.duration,
            offset_ns=period // 2,
            lock_memory=granted.memory == "locked",
        )
    except InputError as error:
        return None, str(error)
    return running, ""


def _sleep_until(second: float) -> None:
    time.sleep(max(second - time.monotonic(), 0.0))


@contextmanager
def _busy(settings: JitterSettings) -> Iterator[None]:
    """Processes that compute all the time; they end by themselves if nobody ends them."""
    words = [sys.executable, "-c", SPIN.format(seconds=settings.duration + 30.0)]
    children = [subprocess.Popen(words) for _ in range(settings.busy)]
    try:
        yield
    finally:
        for child in children:
            child.kill()
        for child in children:
            child.wait()


def _granted(reader: Any) -> RealTimeStatus:
    """From the engine's notes, which it may be writing just now."""
    from skinfield.loop.status_text import read_notes

    end = time.monotonic() + STARTS
    while time.monotonic() < end:
        notes = read_notes(reader.status["notes"])
        if notes is not None and "granted" in notes:
            return RealTimeStatus.from_dict(notes["granted"])
        time.sleep(0.02)
    raise InputError(
        "the engine runs and does not say what was granted to it, expected that it did"
    )
