"""Kalman filter of a taxel whose load wanders at random."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_positive


def noise_of_taxels(noise_std: ArrayLike) -> Floats:
    """Checked noise: a number or (L,), above zero; NaN for a taxel that is not alive.

    Raises
    ------
    InputError
        If a value is zero, negative or infinite, or none is a number.
    """
    noise = np.array(as_floats("noise_std", noise_std))
    bad = ~((noise > 0) & np.isfinite(noise) | np.isnan(noise))
    if noise.ndim > 1 or bad.any() or np.isnan(noise).all():
        raise InputError(
            f"noise_std is {noise_std!r}, expected one number above 0 or one per taxel, such as "
            "calibration.noise_std: the filter weighs every reading by it"
        )
    noise.setflags(write=False)
    return noise


def variance_of_taxels(noise: Floats, taxels: int) -> Floats:
    """Variance of each of `taxels` taxels, (L,)."""
    if noise.ndim == 1 and len(noise) != taxels:
        raise InputError(
            f"noise_std has {len(noise)} values, expected 1 or {taxels}: one per taxel"
        )
    return np.array(np.broadcast_to(noise**2, (taxels,)))


@dataclass(frozen=True, kw_only=True, eq=False)
class RandomWalk:
    """Kalman filter per taxel: the level walks at random, every reading adds noise.

    Run in, it is an exponential filter whose weight follows from the two figures; before that, and
    after invalid readings, it weighs new readings more, as it knows less.

    Parameters
    ----------
    noise_std : float or (L,) array, counts
        Of one reading, such as ``calibration.noise_std``; NaN where a taxel is not alive.
    process_std : float, counts/√s
        How far the level walks within a second (standard deviation).
    """

    noise_std: Floats | float
    process_std: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "noise_std", noise_of_taxels(self.noise_std))
        check_positive("process_std", self.process_std, "how far the level walks in a second")

    def weights(self, rate: float) -> Floats:
        """Weight of a new reading once run in, per entry of `noise_std`."""
        check_positive("rate", rate, "readings per second")
        walk, noise = self.process_std**2 / rate, np.square(self.noise_std)
        ahead = (walk + np.sqrt(walk**2 + 4.0 * walk * noise)) / 2.0
        return np.asarray(ahead / (ahead + noise))

    def delay(self, rate: float) -> float:
        """Lag behind a ramp, s, of the slowest taxel: (1 - K) / K readings at weight K."""
        weight = float(np.nanmin(self.weights(rate)))
        return (1.0 - weight) / weight / rate

    def noise_factor(self, rate: float) -> float:
        """√(K / (2 - K)) for independent readings, of the taxel that gains least."""
        weight = float(np.nanmax(self.weights(rate)))
        return math.sqrt(weight / (2.0 - weight))

    def prepare(self, taxels: int, rate: float) -> "RandomWalkState":
        """State for `taxels` taxels at `rate` readings per second."""
        check_positive("rate", rate, "readings per second")
        noise = variance_of_taxels(np.asarray(self.noise_std), taxels)
        return RandomWalkState(noise, self.process_std**2 / rate)


class RandomWalkState:
    """Level and its variance, per taxel."""

    def __init__(self, noise: Floats, walk: float) -> None:
        self._noise, self._walk = noise, walk
        self._level = np.full(len(noise), np.nan)
        self._variance = noise.copy()
        self._weight, self._step = np.empty(len(noise)), np.empty(len(noise))
        self._mask = np.empty(len(noise), bool)

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the filtered `reading` (L,) into `out` (L,); NaN stays NaN."""
        level, variance, weight, step = self._level, self._variance, self._weight, self._step
        np.isnan(level, out=self._mask)
        np.copyto(level, reading, where=self._mask)
        np.copyto(variance, self._noise, where=self._mask)
        np.add(variance, self._walk, out=variance)
        np.add(variance, self._noise, out=weight)
        np.divide(variance, weight, out=weight)
        np.subtract(reading, level, out=step)
        np.isnan(step, out=self._mask)
        np.copyto(weight, 0.0, where=self._mask)
        np.copyto(step, 0.0, where=self._mask)
        np.multiply(step, weight, out=step)
        np.add(level, step, out=level)
        np.subtract(1.0, weight, out=weight)
        np.multiply(variance, weight, out=variance)
        np.copyto(out, level)
        np.copyto(out, np.nan, where=self._mask)

    def reset(self) -> None:
        """Forget all readings."""
        self._level.fill(np.nan)
        np.copyto(self._variance, self._noise)
