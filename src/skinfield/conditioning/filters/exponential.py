"""Exponential smoothing."""

import math
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive


@dataclass(frozen=True, kw_only=True)
class Exponential:
    """y += a (x - y), with a = 1 - exp(-1 / (time_constant · rate)); starts at the first reading.

    Parameters
    ----------
    time_constant : float, s
        After which 63 % of a step has come through.
    """

    time_constant: float = 0.05

    def __post_init__(self) -> None:
        check_positive("time_constant", self.time_constant, "in seconds")

    def weight(self, rate: float) -> float:
        """Weight a of a new reading at `rate` readings per second."""
        check_positive("rate", rate, "readings per second")
        return -math.expm1(-1.0 / (self.time_constant * rate))

    def delay(self, rate: float) -> float:
        """Lag behind a ramp, s: (1 - a) / a readings."""
        weight = self.weight(rate)
        return (1.0 - weight) / weight / rate

    def noise_factor(self, rate: float) -> float:
        """√(a / (2 - a)) for independent readings."""
        weight = self.weight(rate)
        return math.sqrt(weight / (2.0 - weight))

    def prepare(self, taxels: int, rate: float) -> "ExponentialState":
        """State for `taxels` taxels at `rate` readings per second."""
        return ExponentialState(self.weight(rate), taxels)


class ExponentialState:
    """Memory of an exponential filter."""

    def __init__(self, weight: float, taxels: int) -> None:
        self._weight = weight
        self._level = np.full(taxels, np.nan)
        self._step = np.empty(taxels)
        self._mask = np.empty(taxels, bool)

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the smoothed `reading` (L,) into `out` (L,); NaN stays NaN."""
        level, step, mask = self._level, self._step, self._mask
        np.isnan(level, out=mask)
        np.copyto(level, reading, where=mask)
        np.subtract(reading, level, out=step)
        np.multiply(step, self._weight, out=step)
        np.isnan(step, out=mask)
        np.copyto(step, 0.0, where=mask)
        np.add(level, step, out=level)
        np.copyto(out, level)
        np.copyto(out, np.nan, where=mask)

    def reset(self) -> None:
        """Forget all readings."""
        self._level.fill(np.nan)
