"""Hysteresis: a loop of what a taxel shows between load and release, however slow they are."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from skinfield.errors import Floats
from skinfield.settings import Range, Section

FORGOTTEN = 0.02  # of the highest change: below it the loop is closed, and the next one begins


@dataclass(frozen=True, kw_only=True)
class Hysteresis(Section):
    """A taxel that is let go shows more than one that is pressed as hard for the first time.

    Parameters
    ----------
    width : float
        Of the loop at its widest, half-way, as a part of the highest change in it. 0: none.

    Notes
    -----
    The branch of release is a parabola over that of load: with the highest change p of the loop, a
    change x shows as x + 4 w x (1 - |x|/|p|), w the width. Both ends are those of the branch of
    load, as in cycles of filled rubber (Mullins, Rubber Chem. Technol. 42, 1969). The form is
    assumed; the width is what data sheets state.
    """

    width: Annotated[float, Range(0.0, 0.25, "a part of the highest change; 0 is off")] = 0.0

    def applied(self, change: Floats) -> Floats:
        """What taxels show, (T, L), of changes (T, L) one after the other, from rest."""
        if not self.width:
            return change
        peak = np.zeros(change.shape[1])
        return np.stack([self.step(row, peak) for row in change])

    def step(self, change: Floats, peak: Floats) -> Floats:
        """What taxels show of a change (L,), given the highest size `peak` (L,), which it updates.

        `peak` is 0 at rest.
        """
        size = np.abs(change)
        np.copyto(peak, size, where=(size > peak) | (size < FORGOTTEN * peak))
        part = np.divide(size, peak, out=np.ones_like(size), where=peak > 0)
        return np.asarray(change * (1.0 + 4.0 * self.width * (1.0 - part)))
