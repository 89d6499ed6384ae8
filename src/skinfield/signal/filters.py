"""Filters of readings over time."""

import math
from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats, check_positive, check_shape
from skinfield.settings import Positive, Section


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
        taken away, about as much as at rate / n where the settings are times.
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


@dataclass(frozen=True, kw_only=True)
class Exponential(Section):
    """y += a (x - y), with a = 1 - exp(-1 / (time_constant · rate)); starts at the first reading.

    Parameters
    ----------
    time_constant : float, s
        After which 63 % of a step has come through.
    """

    time_constant: Annotated[float, Positive("in seconds")] = 0.05

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
