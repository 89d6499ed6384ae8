"""Rendering of atoms on a grid: pressure and displacement."""

from collections.abc import Hashable
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Layer, Mechanics
from skinfield.elastic.lattice import displacement_kernel
from skinfield.errors import Floats, InputError, check_finite
from skinfield.skin import Grid
from skinfield.solve.atoms.render_kernels import GridMesh, mesh_of, pressure_table, render
from skinfield.solve.atoms.rows_kernel import GRID, RowGrid
from skinfield.solve.atoms.table import BALL, FLAT
from skinfield.solve.packed import Packed

FINENESS = 8.0  # cells to a thickness, of pressure that moves the surface
MOST_FINE = 400  # of them along a side of the patch
MARGIN = 2.0  # thicknesses around the nodes in which pressure moves them

Family = NDArray[np.int64]


class AtomRenderer:
    """Fields of atoms on one grid, prepared once.

    Atoms are (N, 6) arrays of x m, y m (in the patch's plane), force N, radius m, half-length m
    and angle rad; their families are (N,) int arrays of `profiles.BALL` or `profiles.FLAT`. Radii
    are rendered from 0.15 to 8 thicknesses; others as the nearest of these.

    Parameters
    ----------
    grid : Grid
    layer : Layer
    mechanics : Mechanics
    """

    def __init__(self, grid: Grid, layer: Layer, mechanics: Mechanics) -> None:
        self.grid, self._layer, self._mechanics = grid, layer, mechanics
        self._surface = pressure_table(layer, cast(Hashable, mechanics))
        self._mesh = mesh_of(grid)

    @cached_property
    def rows(self) -> Packed:
        """What rows of contacts are written by."""
        grid = self.grid
        places = np.array(grid.positions, order="C"), np.array(grid.normals, order="C")
        thickness = self._layer.thickness
        return Packed(RowGrid(self._mesh, *places, self._surface, thickness, grid.spread), GRID)

    @cached_property
    def _fine(self) -> tuple[GridMesh, int, int, Floats]:
        """Cells finer than the grid's, that have its nodes among their middles.

        As a mesh; how many lie from node to node, and on each side beyond the nodes; and the
        displacement of what is so many rows and columns away from one of 1 Pa,
        (3, 2 rows - 1, 2 columns - 1) m.
        """
        mesh, thickness = self._mesh, self._layer.thickness
        wanted = FINENESS * mesh.pitch / thickness
        step = max(int(np.ceil(min(wanted, MOST_FINE / max(mesh.rows, mesh.columns)))), 1)
        pitch = mesh.pitch / step
        beyond = int(np.ceil(MARGIN * thickness / pitch))
        rows, columns = (step * (n - 1) + 1 + 2 * beyond for n in (mesh.rows, mesh.columns))
        kernel = displacement_kernel(self._mechanics, self._layer, pitch, rows - 1, columns - 1)
        first = mesh.x - beyond * pitch, mesh.y - beyond * pitch
        return GridMesh(*first, pitch, rows, columns), step, beyond, -kernel

    def pressure(self, atoms: Floats, family: Family, out: Floats) -> None:
        """Write the mean pressure on each cell into `out` (K,), Pa.

        The cells share the whole force of an atom as far as they lie on the grid. Means over cells
        move the centre of pressure a little; the shares are tilted to bring it back, as far as the
        atom covers several cells.
        """
        _check(atoms, family)
        render(atoms, family, self._surface, self._mesh, out)
        out /= self.grid.spread

    def displacement(self, atoms: Floats, family: Family) -> Floats:
        """Displacement of the nodes in the patch's frame, (K, 3) m.

        That of their mean pressure on fine cells: within some per cent of the deepest, but at the
        edge of a flat end.
        """
        _check(atoms, family)
        mesh, step, beyond, kernel = self._fine
        cells = np.empty(mesh.rows * mesh.columns)
        render(atoms, family, self._surface, mesh, cells)
        local = np.zeros((3, *self.grid.shape))
        last = [step * (n - 1) + 1 for n in self.grid.shape]
        for cell in np.flatnonzero(cells):
            row, column = divmod(int(cell), mesh.columns)
            down, right = mesh.rows - 1 + beyond - row, mesh.columns - 1 + beyond - column
            moved = kernel[:, down : down + last[0] : step, right : right + last[1] : step]
            local += cells[cell] * moved
        return np.asarray(np.einsum("kij,jk->ki", self.grid.frames, local.reshape(3, -1)))


def _check(atoms: Floats, family: Family) -> None:
    """Raise InputError for atoms that cannot be drawn."""
    if not np.isfinite(atoms.sum()):
        check_finite("atoms", atoms, "of these nothing can be drawn")
    if family.max(initial=BALL) > FLAT:
        raise InputError(f"family is {family}, expected {BALL} (ball) or {FLAT} (flat end)")
