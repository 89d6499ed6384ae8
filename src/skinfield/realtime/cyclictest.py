"""The kernel's own measure of lateness, beside which that of a loop is judged.

`cyclictest` of rt-tests (C. Williams, J. Kacir, wiki.linuxfoundation.org/realtime) is a loop in C
that does nothing but sleep. How late it wakes is the system's doing; a loop that wakes as late at
the same time on the same processor adds nothing.
"""

import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from skinfield.errors import FileError, Floats, InputError, Ints, check_count, check_positive
from skinfield.realtime.histogram import Quantiles

HIGHEST = 20_000  # µs: what is later is only counted
INSTALL = "install rt-tests, such as by `sudo apt install rt-tests`"
PATIENCE = 15.0  # s that it may take beyond its time


@dataclass(frozen=True)
class Cyclictest:
    """How to run it.

    Parameters
    ----------
    cpu : int or None
        To which it is pinned.
    priority : int
        Of SCHED_FIFO; 0 for ordinary scheduling.
    period_ns : int, ns
        Whole µs.
    seconds : float, s
    offset_ns : int, ns
        From the whole seconds of the clock, at which it begins.
    lock_memory : bool
        It fails where that is not permitted.
    """

    cpu: int | None
    priority: int
    period_ns: int = 1_000_000
    seconds: float = 20.0
    offset_ns: int = 0
    lock_memory: bool = True

    def __post_init__(self) -> None:
        check_count("priority", self.priority, 0, 99, "of SCHED_FIFO, 0 for ordinary scheduling")
        check_count("period_ns", self.period_ns, 1000, 10**9, "ns between two wakes")
        check_positive("seconds", self.seconds, "of measuring")

    def command(self) -> list[str]:
        """Words of the command line."""
        where = [] if self.cpu is None else ["-a", str(self.cpu)]
        how = ["-p", str(self.priority)] if self.priority else ["--policy=other"]
        times = ["-i", str(self.period_ns // 1000), "-D", str(max(round(self.seconds), 1))]
        aligned = f"--secaligned={self.offset_ns // 1000}"
        lock = ["-m"] if self.lock_memory else []
        return ["cyclictest", "-q", *lock, "-t", "1", *where, *how, *times, aligned, *HISTOGRAM]

    def start(self) -> "Running":
        """Run it beside this process.

        Raises
        ------
        InputError
            If it is not installed.
        """
        program = shutil.which("cyclictest")
        if program is None:
            raise InputError(f"cyclictest is not installed, expected it on the path: {INSTALL}")
        child = subprocess.Popen(
            [program, *self.command()[1:]],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        return Running(self, child)


HISTOGRAM = ("-h", str(HIGHEST))


@dataclass(frozen=True, eq=False)
class Running:
    """A cyclictest that runs.

    Attributes
    ----------
    settings : Cyclictest
    child : Popen
    """

    settings: Cyclictest
    child: "subprocess.Popen[str]"

    def finish(self) -> "Lateness":
        """Wait for its end and read what it found.

        Raises
        ------
        InputError
            If it failed, with what it said.
        """
        try:
            out, said = self.child.communicate(timeout=self.settings.seconds + PATIENCE)
        except subprocess.TimeoutExpired as error:
            self.stop()
            raise InputError(
                f"cyclictest did not end within {self.settings.seconds + PATIENCE:g} s, expected "
                f"{self.settings.seconds:g} s: run `{' '.join(self.settings.command())}` by hand"
            ) from error
        if self.child.returncode:
            lines = [line for line in said.splitlines() if line.strip()] or ["it said nothing"]
            raise InputError(f"cyclictest failed: {' '.join(lines[-2:])}")
        return lateness_of(out.splitlines())

    def stop(self) -> None:
        """End it now."""
        self.child.kill()
        self.child.communicate()


@dataclass(frozen=True, eq=False)
class Lateness:
    """What it found.

    Attributes
    ----------
    counts : (B,) array
        Wakes that were from b to b + 1 µs late.
    beyond : int
        Wakes that were later than all of these.
    max : float, s
    """

    counts: Ints
    beyond: int
    max: float

    @property
    def count(self) -> int:
        """Of all wakes."""
        return int(self.counts.sum()) + self.beyond

    def quantiles(self) -> Quantiles:
        """Its quantiles, each in the middle of its bin of 1 µs; among those beyond, `max`."""
        below = np.cumsum(self.counts)

        def middle(thousandths: int) -> float:
            place = int(np.searchsorted(below, -(-self.count * thousandths // 1000)))
            return self.max if place == len(below) else min((place + 0.5) * 1e-6, self.max)

        middles = (np.arange(len(self.counts)) + 0.5) * 1e-6
        mean = float(self.counts @ middles + self.beyond * self.max) / self.count
        return Quantiles(middle(500), middle(990), middle(999), self.max, mean, self.count)

    def later(self) -> tuple[Floats, Floats]:
        """Ends of the bins (s), and the share of all wakes that were later than each."""
        used = np.flatnonzero(self.counts)
        some = slice(used[0], used[-1] + 1) if len(used) else slice(0, 0)
        ends = np.arange(1, len(self.counts) + 1, dtype=np.float64)[some]
        return ends / 1e6, 1.0 - np.cumsum(self.counts[some]) / self.count


def lateness_of(lines: Iterable[str]) -> Lateness:
    """Read the histogram that it prints with -h.

    Raises
    ------
    FileError
        If that is not there, or cannot be.
    """
    bins: dict[int, int] = {}
    said = {"Max Latencies": -1, "Histogram Overflows": 0}
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if len(words) == 2 and all(word.isascii() and word.isdigit() for word in words):
            place, count = (int(word[:19]) for word in words)
            if place >= HIGHEST or place in bins:
                raise FileError(f"cyclictest line {number} has bin {place}, expected a new one")
            bins[place] = count
        name, _, value = line.removeprefix("#").strip().partition(":")
        first = value.split()[:1]
        if name in said and first and first[0].isascii() and first[0].isdigit():
            said[name] = int(first[0][:19])
    total = sum(bins.values()) + said["Histogram Overflows"]
    if said["Max Latencies"] < 0 or not 0 < total < 1 << 62:
        raise FileError(
            f"cyclictest printed {len(bins)} bins of {total} wakes, expected a histogram and its "
            "maximum, as version 1.0 and later print with -h"
        )
    counts = np.zeros(max(bins, default=0) + 1, np.int64)
    counts[list(bins)] = list(bins.values())
    return Lateness(counts, said["Histogram Overflows"], 1e-6 * said["Max Latencies"])
