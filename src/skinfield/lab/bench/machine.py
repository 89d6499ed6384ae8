"""Machine that times are measured on, who else was using it, and laps of its clock."""

import gc
import os
import platform
import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats

CPU_INFO, CPU_TIMES = Path("/proc/cpuinfo"), Path("/proc/stat")
TOO_MUCH = 0.15  # cores that others may use before it is worth a warning


def this_machine() -> dict[str, Any]:
    """Processor, cores, system, Python, versions of packages, and NumPy's BLAS."""
    found = np.show_config(mode="dicts")
    blas = found.get("Build Dependencies", {}).get("blas", {}) if isinstance(found, dict) else {}
    return {
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": versions("skinfield", "numpy", "scipy", "numba"),
        "blas": f"{blas.get('name', 'unknown')} {blas.get('version', '')}".strip(),
    }


def versions(*packages: str) -> dict[str, str]:
    """Of packages, by name."""
    found = {}
    for name in packages:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


class Watch:
    """Sees who uses the processor, from when it is made until `company` is asked for."""

    def __init__(self) -> None:
        self._start = self._usage()

    def company(self) -> dict[str, float | None]:
        """Cores used on average since the start; None where the system does not tell.

        By other processes (`others`), by this one (`own`, near 1 where nothing held it up), and by
        the host of a virtual machine for itself (`stolen`).
        """
        span, own, busy, stolen = (np.array(self._usage()) - self._start).tolist()
        span = max(span, 1e-9)
        known = np.isfinite(busy)
        others = max((busy - own) / span, 0.0) if known else None
        return {"others": others, "stolen": stolen / span if known else None, "own": own / span}

    @staticmethod
    def _usage() -> tuple[float, float, float, float]:
        """Seconds so far: of the clock, of this process, of all that is not idle, of the host.

        The last two are Linux's, for all cores; elsewhere NaN.
        """
        clock, own = time.monotonic(), time.process_time()
        try:
            words = CPU_TIMES.read_text().splitlines()[0].split()
            user, nice, system, _, _, irq, soft, steal = map(int, words[1:9])
        except (OSError, ValueError, IndexError):
            return clock, own, np.nan, np.nan
        tick = os.sysconf("SC_CLK_TCK")
        return clock, own, (user + nice + system + irq + soft) / tick, steal / tick


def warnings(company: Mapping[str, float | None], cores: int) -> list[str]:
    """What makes times doubtful that were measured in such company, in words."""
    found = []
    others, stolen = (company[name] or 0.0 for name in ("others", "stolen"))
    if others > TOO_MUCH:
        found.append(
            f"other processes used {others:.1f} of {cores} cores meanwhile: times are "
            "longer than on a quiet machine, the highest percentiles most of all"
        )
    if stolen > TOO_MUCH:
        found.append(f"the host of this virtual machine kept {stolen:.1f} cores away")
    return found


def _processor() -> str:
    try:
        found = re.search(r"^model name\s*: (.*)$", CPU_INFO.read_text(errors="replace"), re.M)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine()


PERCENTILES = (10, 50, 90, 99)
Spread = dict[str, float]  # count, mean, std, min, p10, p50, p90, p99, max


@contextmanager
def undisturbed() -> Iterator[None]:
    """Without garbage collection, which would fall into some lap and not into others."""
    was = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def laps(function: Callable[[], object], count: int, idle: int = 0) -> Floats:
    """Seconds of each of `count` calls, after `idle` ones that do not count."""
    for _ in range(idle):
        function()
    out = np.empty(count)
    for index in range(count):
        start = time.perf_counter_ns()
        function()
        out[index] = time.perf_counter_ns() - start
    return out * 1e-9


def spread(values: ArrayLike, scale: float = 1.0) -> Spread | None:
    """Mean, deviation, ends and percentiles of the numbers among `values`, times `scale`.

    None if there is no number among them.
    """
    found = np.asarray(values, dtype=np.float64).ravel() * scale
    found = found[np.isfinite(found)]
    if not len(found):
        return None
    named = zip(PERCENTILES, np.percentile(found, PERCENTILES).tolist(), strict=True)
    return {
        "count": len(found),
        "mean": float(found.mean()),
        "std": float(found.std()),
        "min": float(found.min()),
        **{f"p{percent}": value for percent, value in named},
        "max": float(found.max()),
    }
