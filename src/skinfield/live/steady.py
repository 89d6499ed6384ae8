"""Readings of a patch, averaged for as long as nothing moves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

MOST = 128  # readings, a power of two
GAP_NS = 500_000_000  # between readings, after which those before do not count any more
# Deviations: by which the squares of all taxels may exceed their number, of a single taxel, and of
# the touch as a whole.
BOUNDS = np.array([6.0, 5.2, 5.0])
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Mean:
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


class Steady:
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
    most : int
        Readings that are averaged, at most; a power of two.
    """

    def __init__(self, taxels: int, most: int = MOST) -> None:
        self._most = most
        self._values = np.zeros((2 * most, taxels))
        self._valid = np.zeros((2 * most, taxels))
        self._out = np.zeros((2, taxels))
        self._stamp_ns = 0
        self._end = 0  # of the newest reading; rows before it are older, without a break
        self._held = 0

    @property
    def stamp_ns(self) -> int:
        """Of the newest reading; 0 before the first."""
        return self._stamp_ns

    def take(self, values: NDArray[Any], valid: NDArray[Any], stamp_ns: int) -> None:
        """Add a reading (L,); one that comes after a gap begins anew."""
        if stamp_ns - self._stamp_ns > GAP_NS or stamp_ns < self._stamp_ns:
            self._held = 0
        if self._end == len(self._values):
            kept = min(self._held, self._most)
            for rows in (self._values, self._valid):
                rows[:kept] = rows[self._end - kept : self._end]
            self._end, self._held = kept, kept
        self._values[self._end] = values
        self._valid[self._end] = valid
        self._values[self._end][self._valid[self._end] == 0.0] = 0.0
        self._stamp_ns = stamp_ns
        self._end += 1
        self._held = min(self._held + 1, self._most)

    def mean(self, noise: Floats) -> Mean | None:
        """Average of the newest readings that agree; None before the first.

        Parameters
        ----------
        noise : (L,) array, in the quantity's unit
            Of one reading.
        """
        from skinfield.live.steady_kernel import average

        if not self._held:
            return None
        size = average(self._values, self._valid, self._end, self._held, noise, BOUNDS, self._out)
        valid = (self._out[1] > 0) & (self._valid[self._end - 1] > 0)
        return Mean(np.where(valid, self._out[0], 0.0), valid, int(size), self._stamp_ns)
