"""Cyclictest of rt-tests: how late the system itself wakes, beside which a loop is judged.

`cyclictest` (C. Williams, J. Kacir, wiki.linuxfoundation.org/realtime) is a loop in C that does
nothing but sleep. A loop that wakes as late at the same time on the same processor adds nothing.
"""

import json
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.loop.realtime import Quantiles

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
