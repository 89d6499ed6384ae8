"""Contact fit of one reading as it is kept: rows of contacts, and the atoms that are drawn."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.estimate.row_contacts import moved_rows
from skinfield.skin import Grid
from skinfield.solve.atoms.render import AtomRenderer


@dataclass(frozen=True, eq=False)
class AtomFit:
    """What a contact fit makes of one reading; the displacement is drawn when it is asked for.

    Attributes
    ----------
    renderer : AtomRenderer
    grid : Grid
        On which the contacts stand.
    rows : (N,) array of CONTACT
        By falling force.
    atoms : (M, 8) array
        As they are drawn; see `rows_kernel.Drawing`.
    family : (M,) int array
    predicted : (L,) array, in the quantity's unit
        What the taxels would read of them, with an offset that all share.
    parameters : int
        Numbers that were fitted.
    """

    renderer: AtomRenderer
    grid: Grid
    rows: NDArray[np.void]
    atoms: Floats
    family: Ints
    predicted: Floats
    parameters: int

    def keep(self) -> "AtomFit":
        """Itself: nothing overwrites it."""
        return self

    def on(self, grid: Grid, shift: Floats) -> "AtomFit":
        """The same on a patch of equal geometry, whose plane is shifted by (2,) m."""
        return replace(self, grid=grid, rows=moved_rows(self.rows, grid, shift))

    @property
    def displacement(self) -> Floats:
        """Of the nodes in the patch's frame, (K, 3) m."""
        return self.renderer.displacement(self.atoms, self.family)
