"""Kalman filters of a taxel: one whose load keeps its rate, one whose load wanders."""

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
class ConstantVelocity:
    """Kalman filter per taxel: level and rate, the rate is pushed by white acceleration.

    It follows a ramp without lag, at the price of overshoot after a step (about a fifth of it)
    and of less noise taken away than a filter that lags; see `step_response`.

    Parameters
    ----------
    noise_std : float or (L,) array, counts
        Of one reading, such as ``calibration.noise_std``; NaN where a taxel is not alive.
    acceleration_std : float, counts/s^1.5
        How much the rate, counts/s, changes within a second (standard deviation).
    """

    noise_std: Floats | float
    acceleration_std: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "noise_std", noise_of_taxels(self.noise_std))
        check_positive("acceleration_std", self.acceleration_std, "change of the rate in a second")

    def delay(self, rate: float) -> float:
        """0: once run in, it does not lag behind a ramp. For a step ask `rise_time`."""
        check_positive("rate", rate, "readings per second")
        return 0.0

    def weights(self, rate: float, noise_std: float) -> tuple[float, float]:
        """Weights α of level and β of rate, per reading, once run in, at a noise of `noise_std`."""
        from scipy.linalg import solve_discrete_are

        check_positive("rate", rate, "readings per second")
        # in units of noise and readings, so that the equation is well scaled
        push = self.acceleration_std**2 / rate**3 / noise_std**2
        ahead = solve_discrete_are(
            np.array([[1.0, 0.0], [1.0, 1.0]]),
            np.array([[1.0], [0.0]]),
            push * np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]]),
            np.array([[1.0]]),
        )
        seen = float(ahead[0, 0]) + 1.0
        return float(ahead[0, 0]) / seen, float(ahead[0, 1]) / seen

    def noise_factor(self, rate: float) -> float:
        """For independent readings, of the taxel that gains least.

        √((2α² + β (2 - 3α)) / (α (4 - 2α - β))), with the weights in predictor-corrector form.
        """
        a, b = self.weights(rate, float(np.nanmin(self.noise_std)))
        return math.sqrt((2 * a * a + b * (2 - 3 * a)) / (a * (4 - 2 * a - b)))

    def prepare(self, taxels: int, rate: float) -> "ConstantVelocityState":
        """State for `taxels` taxels at `rate` readings per second."""
        check_positive("rate", rate, "readings per second")
        noise = variance_of_taxels(np.asarray(self.noise_std), taxels)
        return ConstantVelocityState(noise, self.acceleration_std**2, 1.0 / rate)


class ConstantVelocityState:
    """Level, rate and their covariance, per taxel."""

    def __init__(self, noise: Floats, push: float, period: float) -> None:
        taxels = len(noise)
        self._noise, self._period = noise, period
        self._push = push * period**3 / 3.0, push * period**2 / 2.0, push * period
        self._level, self._rate = np.full(taxels, np.nan), np.zeros(taxels)
        self._p, self._cross, self._p_rate = (np.empty(taxels) for _ in range(3))
        self._w, self._w_rate, self._step, self._scratch = (np.empty(taxels) for _ in range(4))
        self._mask = np.empty(taxels, bool)

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the filtered `reading` (L,) into `out` (L,); NaN stays NaN."""
        self._start(reading)
        self._predict()
        np.subtract(reading, self._level, out=self._step)
        np.isnan(self._step, out=self._mask)
        self._correct()
        np.copyto(out, self._level)
        np.copyto(out, np.nan, where=self._mask)

    def _start(self, reading: Floats) -> None:
        """Taxels that never answered take the reading for level; their rate is unknown."""
        np.isnan(self._level, out=self._mask)
        np.copyto(self._level, reading, where=self._mask)
        np.copyto(self._rate, 0.0, where=self._mask)
        np.copyto(self._p, self._noise, where=self._mask)
        np.copyto(self._cross, 0.0, where=self._mask)
        np.multiply(self._noise, 2.0 / self._period**2, out=self._scratch)
        np.copyto(self._p_rate, self._scratch, where=self._mask)

    def _predict(self) -> None:
        period, scratch = self._period, self._scratch
        np.multiply(self._rate, period, out=scratch)
        np.add(self._level, scratch, out=self._level)
        np.multiply(self._p_rate, period, out=scratch)
        np.add(self._cross, scratch, out=self._cross)  # halfway: cross + p_rate · period
        np.multiply(self._cross, 2.0, out=self._w)
        np.subtract(self._w, scratch, out=self._w)
        np.multiply(self._w, period, out=self._w)
        np.add(self._p, self._w, out=self._p)
        np.add(self._p, self._push[0], out=self._p)
        np.add(self._cross, self._push[1], out=self._cross)
        np.add(self._p_rate, self._push[2], out=self._p_rate)

    def _correct(self) -> None:
        w, w_rate, step, scratch = self._w, self._w_rate, self._step, self._scratch
        np.add(self._p, self._noise, out=scratch)
        np.divide(self._p, scratch, out=w)
        np.divide(self._cross, scratch, out=w_rate)
        for weightless in (w, w_rate, step):
            np.copyto(weightless, 0.0, where=self._mask)
        np.multiply(step, w, out=scratch)
        np.add(self._level, scratch, out=self._level)
        np.multiply(step, w_rate, out=scratch)
        np.add(self._rate, scratch, out=self._rate)
        np.multiply(w_rate, self._cross, out=scratch)
        np.subtract(self._p_rate, scratch, out=self._p_rate)
        np.subtract(1.0, w, out=w)
        np.multiply(self._p, w, out=self._p)
        np.multiply(self._cross, w, out=self._cross)

    def reset(self) -> None:
        """Forget all readings."""
        self._level.fill(np.nan)


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
