"""Moving median."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats, InputError, check_positive


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
        self._there = np.zeros((taxels, window), np.int64)  # 1 where the ring holds a number
        self._first = np.arange(taxels) * window
        self._numbers = np.zeros(taxels, np.int64)
        self._index = np.zeros(taxels, np.int64)
        self._low, self._high = np.empty(taxels), np.empty(taxels)
        self._mask = np.empty(taxels, bool)

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the median of the last readings into `out` (L,); NaN stays NaN."""
        self._remember(reading)
        np.copyto(self._sorted, self._ring)
        self._sorted.sort(axis=1)  # NaN comes last
        self._pick(-1, self._low)
        self._pick(0, self._high)
        np.add(self._low, self._high, out=self._low)
        np.multiply(self._low, 0.5, out=self._low)
        np.isnan(reading, out=self._mask)
        np.copyto(out, self._low)
        np.copyto(out, np.nan, where=self._mask)

    def _remember(self, reading: Floats) -> None:
        """Put the reading in place of the oldest, and keep count of the numbers in the ring."""
        ring, there = self._ring[:, self._next], self._there[:, self._next]
        self._next = (self._next + 1) % self._ring.shape[1]
        np.subtract(self._numbers, there, out=self._numbers)
        np.equal(reading, reading, out=self._mask)  # all but NaN
        np.copyto(there, self._mask)
        np.add(self._numbers, there, out=self._numbers)
        np.copyto(ring, reading)

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
        self._there.fill(0)
        self._numbers.fill(0)
        self._next = 0
