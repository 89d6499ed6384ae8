"""Filters of readings over time: exponential, moving median, chains of filters."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape


class FilterState(Protocol):
    """A prepared filter of L taxels, with its memory."""

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write into `out` (L,) the filtered `reading` (L,). Allocates nothing.

        NaN marks a taxel that is invalid in this reading: it comes out as NaN and spoils nothing
        of what was remembered. `reading` and `out` may be the same array.
        """
        ...

    def reset(self) -> None:
        """Forget all readings."""
        ...


class Filter(Protocol):
    """Settings of a filter. Delay and noise hold once it has run in."""

    def prepare(self, taxels: int, rate: float) -> FilterState:
        """State for `taxels` taxels and `rate` readings per second."""
        ...

    def delay(self, rate: float) -> float:
        """Seconds by which the output lags behind a steady ramp."""
        ...

    def noise_factor(self, rate: float) -> float:
        """Standard deviation of the output over that of the input, for independent readings.

        A port that repeats each value n times gives noise that is not independent: less of it is
        taken away, about as much as at rate / n where the settings are times, and next to nothing
        by a median of fewer than 2n readings.
        """
        ...


@dataclass(frozen=True)
class NoFilter:
    """Passes every reading on."""

    def delay(self, rate: float) -> float:
        """0 s."""
        return 0.0

    def noise_factor(self, rate: float) -> float:
        """1."""
        return 1.0

    def prepare(self, taxels: int, rate: float) -> "NoFilter":
        """Itself: it has no memory."""
        return self

    def apply(self, reading: Floats, out: Floats) -> None:
        """Copy `reading` (L,) to `out` (L,)."""
        np.copyto(out, reading)

    def reset(self) -> None:
        """Nothing to forget."""


@dataclass(frozen=True)
class Chain:
    """Filters one after the other, such as a median against outliers and then a smoother.

    Parameters
    ----------
    filters : tuple of Filter
    """

    filters: tuple[Filter, ...]

    def __post_init__(self) -> None:
        if not self.filters:
            raise InputError("filters is empty, expected at least one: NoFilter() does nothing")
        flat: list[Filter] = []
        for each in self.filters:
            flat += each.filters if isinstance(each, Chain) else [each]
        object.__setattr__(self, "filters", tuple(flat))

    def delay(self, rate: float) -> float:
        """Sum of the delays, s."""
        return sum(each.delay(rate) for each in self.filters)

    def noise_factor(self, rate: float) -> float:
        """Measured on white noise, to about 2 %: a filter leaves coloured noise to the next."""
        memory = int(50 * (1 + self.delay(rate) * rate))
        noise = np.random.default_rng(0).standard_normal((memory + max(memory, 1000), 200))
        return float(filtered(self, noise, rate)[memory:].std())

    def prepare(self, taxels: int, rate: float) -> "ChainState":
        """The states of all filters."""
        return ChainState([each.prepare(taxels, rate) for each in self.filters])


class ChainState:
    """The memories of all filters."""

    def __init__(self, states: list[FilterState]) -> None:
        self._states = states

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the filtered `reading` (L,) into `out` (L,); NaN stays NaN."""
        for state in self._states:
            state.apply(reading, out)
            reading = out

    def reset(self) -> None:
        """Forget all readings."""
        for state in self._states:
            state.reset()


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


@dataclass(frozen=True)
class MovingMedian:
    """Median of the last `window` readings: removes single outliers, keeps edges sharp.

    Until the window is full, and where readings of a taxel were invalid, the median of those that
    are there. A port that repeats each value n times needs a window of more than 2n.

    Parameters
    ----------
    window : int
        Odd number of readings.
    """

    window: int = 5

    def __post_init__(self) -> None:
        if self.window != int(self.window) or self.window < 1 or self.window % 2 == 0:
            raise InputError(
                f"window is {self.window!r}, expected an odd number of readings, 1 or more: "
                "an odd one has a reading in its middle"
            )

    def delay(self, rate: float) -> float:
        """(window - 1) / 2 readings, s: exact for steps and for ramps."""
        check_positive("rate", rate, "readings per second")
        return (self.window - 1) / 2.0 / rate

    def noise_factor(self, rate: float) -> float:
        """For independent Gaussian readings: standard deviation of the median of so many."""
        check_positive("rate", rate, "readings per second")
        return self._median_std

    @cached_property
    def _median_std(self) -> float:
        from scipy.special import gammaln, log_ndtr

        k = self.window // 2
        x = np.linspace(-9.0, 9.0, 20001)
        # density of the middle of 2k+1: (2k+1)!/(k!)² Φᵏ (1-Φ)ᵏ φ
        log_density = (
            gammaln(2 * k + 2)
            - 2 * gammaln(k + 1)
            + k * (log_ndtr(x) + log_ndtr(-x))
            - x**2 / 2
            - math.log(2 * math.pi) / 2
        )
        return math.sqrt(float(np.sum(x**2 * np.exp(log_density)) * (x[1] - x[0])))

    def prepare(self, taxels: int, rate: float) -> "MovingMedianState":
        """State for `taxels` taxels; the rate does not matter."""
        check_positive("rate", rate, "readings per second")
        return MovingMedianState(self.window, taxels)


class MovingMedianState:
    """The last readings of each taxel, in a ring."""

    def __init__(self, window: int, taxels: int) -> None:
        self._ring = np.full((taxels, window), np.nan)
        self._sorted = np.empty((taxels, window))
        self._next = 0
        self._there = np.zeros((taxels, window), np.int64)  # 1 where there is a number
        self._first = np.arange(taxels) * window
        self._numbers = np.zeros(taxels, np.int64)
        self._index = np.zeros(taxels, np.int64)
        self._low, self._high = np.empty(taxels), np.empty(taxels)
        self._mask = np.empty(taxels, bool)

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the median of the last readings into `out` (L,); NaN stays NaN."""
        np.copyto(self._ring[:, self._next], reading)
        self._next = (self._next + 1) % self._ring.shape[1]
        np.copyto(self._sorted, self._ring)
        self._sorted.sort(axis=1)  # NaN comes last
        np.equal(self._sorted, self._sorted, out=self._there)  # all but NaN
        np.sum(self._there, axis=1, out=self._numbers)
        self._pick(-1, self._low)
        self._pick(0, self._high)
        np.add(self._low, self._high, out=self._low)
        np.multiply(self._low, 0.5, out=self._low)
        np.isnan(reading, out=self._mask)
        np.copyto(out, self._low)
        np.copyto(out, np.nan, where=self._mask)

    def _pick(self, offset: int, out: Floats) -> None:
        """Sorted number (numbers + offset) // 2 of each taxel."""
        index = self._index
        np.add(self._numbers, offset, out=index)
        np.floor_divide(index, 2, out=index)
        np.maximum(index, 0, out=index)
        np.add(index, self._first, out=index)
        self._sorted.ravel().take(index, out=out, mode="clip")

    def reset(self) -> None:
        """Forget all readings."""
        self._ring.fill(np.nan)


def filtered(settings: Filter, counts: ArrayLike, rate: float) -> Floats:
    """All readings (T, L) of a recording through a fresh filter, as streaming would.

    Parameters
    ----------
    settings : Filter
    counts : (T, L) array
        NaN where a taxel is invalid.
    rate : float, 1/s
    """
    counts = as_floats("counts", counts)
    check_shape("counts", counts, (None, None), "one row per reading, one column per taxel")
    state, out = settings.prepare(counts.shape[1], rate), np.empty(counts.shape)
    for reading, row in zip(counts, out, strict=True):
        state.apply(reading, row)
    return out
