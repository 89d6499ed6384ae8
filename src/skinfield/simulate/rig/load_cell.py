"""The cell between actuator and indenter: force with an error of its own, by a clock of its own."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, check_positive, check_range


@dataclass(frozen=True, eq=False)
class LoadSeries:
    """What a load cell has recorded.

    Attributes
    ----------
    stamp_ns : (R,) int64 array, ns
    force : (R,) array, N
        Into the skin, as measured.
    saturated : (R,) bool array
        At the end of the cell's range: the true force is higher.
    """

    stamp_ns: NDArray[np.int64]
    force: Floats
    saturated: NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class LoadCell:
    """A cell for compression.

    Parameters
    ----------
    full_scale : float, N
        Beyond it, to either side, the cell says no more.
    rate : float, 1/s
    noise : float, N
        Standard deviation of a sample.
    offset : float, N
        What it says of no load.
    gain_error : float
        Relative: 0.01 says 1 % too much.
    resolution : float, N
        Step of its numbers; 0 for none.
    delay : float, s
        By which its stamps are late.
    """

    full_scale: float = 3.0
    rate: float = 100.0
    noise: float = 3e-3
    offset: float = 0.0
    gain_error: float = 0.0
    resolution: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        check_positive("full_scale", self.full_scale, "in newtons")
        check_positive("rate", self.rate, "samples per second")
        check_range("rate", self.rate, 0.0, 1e5, "samples per second")
        for name in ("noise", "resolution"):
            check_range(name, getattr(self, name), 0.0, self.full_scale, "in newtons; 0 is off")
        check_range("offset", self.offset, -self.full_scale, self.full_scale, "in newtons")
        check_range("gain_error", self.gain_error, -0.5, 0.5, "relative; 0 is off")
        check_range("delay", self.delay, 0.0, 10.0, "in seconds; 0 is off")

    def measure(
        self, time: Floats, force: Floats, rng: np.random.Generator, start_ns: int = 0
    ) -> LoadSeries:
        """Sample a force.

        Parameters
        ----------
        time, force : (T,) arrays, s and N
            Of the true force into the skin.
        rng : numpy Generator
        start_ns : int, ns
            Stamp of time 0.
        """
        own = np.arange(time[0], time[-1], 1.0 / self.rate)
        level = (1.0 + self.gain_error) * np.interp(own, time, force) + self.offset
        level = level + self.noise * rng.standard_normal(len(own))
        if self.resolution:
            level = self.resolution * np.rint(level / self.resolution)
        shown = np.clip(level, -self.full_scale, self.full_scale)
        stamps = start_ns + np.rint((own + self.delay) * 1e9).astype(np.int64)
        return LoadSeries(stamps, shown, np.abs(level) >= self.full_scale)
