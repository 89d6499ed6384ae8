"""Stationary mean of a patch's readings: averaged for as long as nothing moves."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats

CLEAR = 5.0  # deviations from which a taxel reads something of a touch


@njit
def average(
    values: Floats, valid: Floats, end: int, held: int, noise: Floats, bounds: Floats, out: Floats
) -> int:
    """Write the mean of the newest readings that agree; returns how many these are.

    As many readings before them as there are by now are added if they agree, then half of these, a
    quarter, ... They agree if the oldest 1, 2, 4, ... of them and all of them do.

    Parameters
    ----------
    values, valid : (N, L) arrays
        Readings, 0 where `valid` is 0, else that is 1.
    end, held : int
        The newest reading is row `end` - 1, and the oldest that counts `end` - `held`.
    noise : (L,) array
        Of one reading.
    bounds : (3,) array
        See `BOUNDS`.
    out : (2, L) array
        Receives the means, and of how many readings they are.
    """
    taxels = len(noise)
    new, count = values[end - 1].copy(), valid[end - 1].copy()
    old, before = np.empty(taxels), np.empty(taxels)
    size = step = 1
    growing = True
    while step > 0:
        good = size + step <= held
        if good:
            old[:] = 0.0
            before[:] = 0.0
            first, part = end - size - step, 1
            for row in range(first, end - size):
                for taxel in range(taxels):
                    old[taxel] += values[row, taxel]
                    before[taxel] += valid[row, taxel]
                if row - first + 1 == part:
                    part = 2 * part
                    if not alike(new, count, old, before, noise, bounds):
                        good = False
                        break
        if good:
            good = alike(new, count, old, before, noise, bounds)
        if good:
            new += old
            count += before
            size += step
        else:
            growing = False
        step = size if growing else step // 2
    for taxel in range(taxels):
        out[0, taxel] = new[taxel] / count[taxel] if count[taxel] > 0.0 else 0.0
        out[1, taxel] = count[taxel]
    return size


@njit
def alike(
    new: Floats, count: Floats, old: Floats, before: Floats, noise: Floats, bounds: Floats
) -> bool:
    """Whether sums (L,) of so many readings each differ by no more than noise.

    Three things that noise seldom does: many taxels a little, one taxel much, and all that the new
    ones read of a touch more or less, which finds a faint one that began or ended.
    """
    squares, largest, taxels = 0.0, 0.0, 0
    less, all_of_it = 0.0, 0.0
    for i in range(len(noise)):
        if count[i] > 0.0 and before[i] > 0.0:
            mean, variance = new[i] / count[i], noise[i] * noise[i]
            off = mean - old[i] / before[i]
            expected = variance * (1.0 / count[i] + 1.0 / before[i])
            squares += off * off / expected
            largest = max(largest, off * off / expected)
            taxels += 1
            if mean * mean * count[i] > CLEAR * CLEAR * variance:
                less += off * mean / expected
                all_of_it += mean * mean / expected
    if taxels == 0:
        return False
    bound = taxels + bounds[0] * np.sqrt(2.0 * taxels)
    same = less * less <= bounds[2] * bounds[2] * all_of_it
    return bool(same and squares <= bound and largest <= bounds[1] * bounds[1])


MOST = 128  # readings, a power of two
GAP_NS = 500_000_000  # between readings, after which those before do not count any more
# Deviations: by which the squares of all taxels may exceed their number, of a single taxel, and of
# the touch as a whole.
BOUNDS = np.array([6.0, 5.2, 5.0])
Flags = NDArray[np.bool_]


class Mean(NamedTuple):
    """What the taxels read, of the newest readings that agree with each other.

    Attributes
    ----------
    values : (L,) array, in the quantity's unit
        0 where not valid.
    valid : (L,) bool array
    readings : int
        That were averaged.
    stamp_ns : int, ns
        Of the newest of them.
    """

    values: Floats
    valid: Flags
    readings: int
    stamp_ns: int


class StationaryMean:
    """The newest readings of a patch.

    Noise falls with the root of the readings that are averaged, as long as they are of the same
    touch. How many that are, the readings tell: the newest 1, 2, 4, ... are compared with as many
    before them, and where the means differ by more than noise, the average ends there, or so much
    before as half, a quarter, ... of those still agree (after Lepski 1990, On a problem of
    adaptive estimation in Gaussian white noise). So a touch that rests is weighed ever more
    finely, and one that moves is followed at once.

    Parameters
    ----------
    taxels : int

    Attributes
    ----------
    stamp_ns : int, ns
        Of the newest reading; 0 before the first.
    """

    def __init__(self, taxels: int) -> None:
        self._values, self._valid = np.zeros((2, 2 * MOST, taxels))
        self._out = np.zeros((2, taxels))
        self.stamp_ns = 0
        self._end = 0  # of the newest reading; rows before it are older, without a break
        self._held = 0

    def take(self, values: NDArray[Any], valid: NDArray[Any], stamp_ns: int) -> None:
        """Add a reading (L,); one that comes after a gap begins anew."""
        if stamp_ns - self.stamp_ns > GAP_NS or stamp_ns < self.stamp_ns:
            self._held = 0
        if self._end == len(self._values):
            kept = min(self._held, MOST)
            for rows in (self._values, self._valid):
                rows[:kept] = rows[self._end - kept : self._end]
            self._end, self._held = kept, kept
        self._values[self._end] = values
        self._valid[self._end] = valid
        self._values[self._end][self._valid[self._end] == 0.0] = 0.0
        self.stamp_ns = stamp_ns
        self._end += 1
        self._held = min(self._held + 1, MOST)

    def mean(self, noise: Floats) -> Mean | None:
        """Average of the newest readings that agree; None before the first.

        Parameters
        ----------
        noise : (L,) array, in the quantity's unit
            Of one reading.
        """
        if not self._held:
            return None
        size = average(self._values, self._valid, self._end, self._held, noise, BOUNDS, self._out)
        valid = (self._out[1] > 0) & (self._valid[self._end - 1] > 0)
        return Mean(np.where(valid, self._out[0], 0.0), valid, int(size), self.stamp_ns)
