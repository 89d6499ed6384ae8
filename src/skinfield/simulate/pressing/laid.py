"""Bodies laid over the squares of windows, and a solution on them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.mechanics.contact import Contact, edge_softness
from skinfield.simulate.pressing.plane import Skin
from skinfield.simulate.pressing.responses import Indenting
from skinfield.simulate.pressing.window import Window


@dataclass(frozen=True, eq=False)
class Laid:
    """Bodies over the squares of windows; arrays (N,) run through the windows.

    Attributes
    ----------
    skin : Skin
    windows : list of Window
    each : (bodies, N) array, m
        Height of each body above its lowest point.
    coverages, grown : (bodies, N) array
        See `Cover`.
    bodies : (N,) int array
        The one that can touch.
    """

    skin: Skin
    windows: list[Window]
    each: Floats
    coverages: Floats
    grown: Floats
    bodies: NDArray[np.int64]

    @property
    def area(self) -> Floats:
        """Of each square, (N,) m²."""
        return np.concatenate(
            [np.full(window.size, self.skin.side(window) ** 2) for window in self.windows]
        )

    def chosen(self, values: Floats) -> Floats:
        """Of values (bodies, N) that of the body that can touch, (N,)."""
        return np.asarray(np.take_along_axis(values, self.bodies[None], axis=0)[0])

    def nearest(self, body: int) -> NDArray[np.bool_]:
        """The square (N,) under the lowest part of a body."""
        out = np.zeros(len(self.bodies), dtype=bool)
        out[self.each[body].argmin()] = True
        return out

    @property
    def coverage(self) -> Floats:
        """Fraction of each square below the body that can touch, (N,)."""
        return self.chosen(self.coverages)

    @property
    def softness(self) -> Floats:
        """Of sharp edges, (N,), see `edge_softness`."""
        return edge_softness(self.chosen(self.grown))


@dataclass(frozen=True, eq=False)
class Settled:
    """A solution on windows, beside the same bodies over the whole grid."""

    laid: Laid
    indenting: Indenting
    contact: Contact
    whole: Laid
