"""The machine that times are measured on, and who else was using it."""

import os
import platform
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("skinfield", "numpy", "scipy", "numba")
CPU_INFO, CPU_TIMES = Path("/proc/cpuinfo"), Path("/proc/stat")
TOO_MUCH = 0.15  # cores that others may use before it is worth a warning
CROWDED = 0.5  # load per core when it begins, from which it is


@dataclass(frozen=True)
class Machine:
    """What timed, by name and version.

    Attributes
    ----------
    processor : str
    cores : int
        That the system has.
    system, python : str
    packages : dict
        Version by name.
    blas : str
        Which NumPy multiplies matrices by.
    """

    processor: str
    cores: int
    system: str
    python: str
    packages: dict[str, str]
    blas: str


def this_machine() -> Machine:
    """Describe the machine and the programs."""
    return Machine(
        processor=_processor(),
        cores=os.cpu_count() or 1,
        system=f"{platform.system()} {platform.release()} {platform.machine()}",
        python=f"{platform.python_implementation()} {platform.python_version()}",
        packages={name: _version(name) for name in PACKAGES},
        blas=_blas(),
    )


@dataclass(frozen=True)
class Company:
    """What else the processor did while times were measured.

    Attributes
    ----------
    load : float or None
        Average number of running processes over the minute before; None where it is not known.
    others : float or None
        Cores that other processes used, on average; None where it is not known.
    stolen : float or None
        Cores that the host of a virtual machine kept to itself, on average.
    own : float
        Cores that this process used: near 1 where nothing held it up.
    interrupted : int or None
        How often the system gave the core to somebody else.
    """

    load: float | None
    others: float | None
    stolen: float | None
    own: float
    interrupted: int | None

    def warnings(self, cores: int) -> tuple[str, ...]:
        """What makes the times doubtful, in words."""
        found = []
        if self.others is not None and self.others > TOO_MUCH:
            found.append(
                f"other processes used {self.others:.1f} of {cores} cores meanwhile: times are "
                "longer than on a quiet machine, the highest percentiles most of all"
            )
        elif self.others is None and self.load is not None and self.load > CROWDED * cores:
            found.append(f"the load was {self.load:.1f} on {cores} cores: the machine was busy")
        if self.stolen is not None and self.stolen > TOO_MUCH:
            found.append(f"the host of this virtual machine kept {self.stolen:.1f} cores away")
        return tuple(found)


class Watch:
    """Sees who uses the processor, from when it is made until `company` is asked for."""

    def __init__(self) -> None:
        self._load = _load()
        self._start = _Usage.now()

    def company(self) -> Company:
        """Averages since the start."""
        start, end = self._start, _Usage.now()
        span = max(end.clock - start.clock, 1e-9)
        own = (end.own - start.own) / span
        others = stolen = None
        if start.busy is not None and end.busy is not None:
            others = max((end.busy - start.busy) / span - own, 0.0)
        if start.stolen is not None and end.stolen is not None:
            stolen = (end.stolen - start.stolen) / span
        interrupted = None
        if start.switches is not None and end.switches is not None:
            interrupted = end.switches - start.switches
        return Company(self._load, others, stolen, own, interrupted)


@dataclass(frozen=True)
class _Usage:
    """Seconds so far: of the clock, of this process, of all that is not idle, of the host."""

    clock: float
    own: float
    busy: float | None
    stolen: float | None
    switches: int | None

    @classmethod
    def now(cls) -> "_Usage":
        busy, stolen = _system_times()
        return cls(time.monotonic(), time.process_time(), busy, stolen, _switches())


def _system_times() -> tuple[float | None, float | None]:
    """Seconds that all cores were busy, and that the host took; by Linux, elsewhere unknown."""
    try:
        words = CPU_TIMES.read_text().splitlines()[0].split()
        user, nice, system, _, _, irq, soft, steal = map(int, words[1:9])
    except (OSError, ValueError, IndexError):
        return None, None
    tick = os.sysconf("SC_CLK_TCK")
    return (user + nice + system + irq + soft) / tick, steal / tick


def _switches() -> int | None:
    try:
        import resource
    except ImportError:  # not on Windows
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw


def _load() -> float | None:
    try:
        return os.getloadavg()[0]
    except (AttributeError, OSError):  # not on Windows
        return None


def _processor() -> str:
    try:
        for line in CPU_INFO.read_text(errors="replace").splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _blas() -> str:
    import numpy as np

    found = np.show_config(mode="dicts")
    blas = found.get("Build Dependencies", {}).get("blas", {}) if isinstance(found, dict) else {}
    return f"{blas.get('name', 'unknown')} {blas.get('version', '')}".strip()
