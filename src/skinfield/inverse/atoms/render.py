"""From fitted atoms to fields on a grid and to contacts."""

from collections.abc import Hashable, Sequence
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_finite
from skinfield.fields import Contact
from skinfield.inverse.atoms import outline, render_moved, render_std
from skinfield.inverse.atoms.contacts import ContactBuilder
from skinfield.inverse.atoms.profiles import BALL, FLAT
from skinfield.inverse.atoms.render_kernels import mesh_of, surface_of
from skinfield.inverse.atoms.render_moved import Moves, moves_of
from skinfield.inverse.atoms.render_pressure import render
from skinfield.inverse.atoms.render_tables import LARGEST, displacement_table, pressure_table
from skinfield.inverse.atoms.render_workspace import Workspace
from skinfield.layout import Grid
from skinfield.mechanics import Layer, Mechanics

Family = NDArray[np.int64]


class AtomRenderer:
    """Fields and contacts of atoms on one grid, prepared once; for one thread at a time.

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
        self._surface = surface_of(pressure_table(layer, cast(Hashable, mechanics)))
        self._mesh = mesh_of(grid)
        self._space = Workspace(len(grid))
        self._builder = ContactBuilder(grid, self._surface, self._space)

    @cached_property
    def _moves(self) -> Moves:
        """What displacements are made of: tabulated when the first one is asked for."""
        return moves_of(displacement_table(self._layer, cast(Hashable, self._mechanics)))

    @cached_property
    def _frames(self) -> Floats:
        """Of all nodes (K, 3, 3), or (1, 3, 3) where all are the same."""
        flat = self.grid.patch.surface.is_flat
        return np.array(self.grid.frames[:1] if flat else self.grid.frames)

    def pressure(self, atoms: Floats, family: Family, out: Floats) -> None:
        """Write the mean pressure on each cell into `out` (K,), Pa.

        The cells share the whole force of an atom as far as they lie on the grid. Means over cells
        move the centre of pressure a little; the shares are tilted to bring it back, as far as the
        atom covers several cells.
        """
        space = self._prepared(atoms, family)
        render(
            atoms, family, self._surface, self._mesh, out, space.boxes[0], space.cells, space.room
        )

    def displacement(self, atoms: Floats, family: Family, out: Floats) -> None:
        """Write the displacement of the nodes in the patch's frame into `out` (K, 3), m."""
        space = self._prepared(atoms, family)
        render_moved.displacement(
            atoms,
            family,
            self._surface,
            self._moves,
            self._mesh,
            self._frames,
            out,
            space.boxes[0],
            space.terms,
            space.room,
        )

    def pressure_std(self, atoms: Floats, family: Family, covariance: Floats, out: Floats) -> None:
        """Write one standard deviation of each cell's pressure into `out` (K,), Pa.

        `covariance` (N, 6, 6) is of the parameters of each atom.
        """
        longer = LARGEST * self._surface.thickness + 3.0 * _largest(np.sqrt(covariance[:, 4, 4]))
        space = self._prepared(atoms, family, longer)
        render_std.pressure_std(
            atoms,
            family,
            covariance,
            self._surface,
            self._mesh,
            out,
            space.boxes,
            space.cells,
            space.room,
            space.pictures,
            space.small,
        )

    def contacts(
        self,
        atoms: Floats,
        family: Family,
        covariance: Floats,
        groups: Sequence[Sequence[int]] | None = None,
    ) -> tuple[Contact, ...]:
        """Contacts of atoms, by falling normal force.

        Parameters
        ----------
        atoms : (N, 6) array
        family : (N,) int array
        covariance : (N, 6, 6) or (6 N, 6 N) array
            Of the parameters of each atom, or of all of them together.
        groups : sequence of sequences of int, optional
            Atoms of each contact; by default those that overlap belong to one.
        """
        self._prepared(atoms, family)
        found = []
        for group in outline.bodies(atoms) if groups is None else groups:
            rows = np.asarray(group)
            found.append(self._builder.contact(atoms[rows], family[rows], _joint(covariance, rows)))
        return tuple(sorted(found, key=lambda contact: -contact.normal_force))

    def _prepared(self, atoms: Floats, family: Family, longer: float = 0.0) -> Workspace:
        """Workspace with room for atoms that reach farther by `longer` m than they say."""
        if not np.isfinite(atoms.sum()):
            check_finite("atoms", atoms, "of these nothing can be drawn")
        if _largest(family) > FLAT:
            raise InputError(f"family is {family}, expected {BALL} (ball) or {FLAT} (flat end)")
        widest = min(_largest(atoms[:, 3]), LARGEST * self._surface.thickness)
        self._space.make_room(self._mesh, widest + _largest(atoms[:, 4]) + longer)
        return self._space


def _largest(values: Floats | Family) -> float:
    """Largest of some values, 0 at least."""
    return float(values.max(initial=0))


def _joint(covariance: Floats, rows: NDArray[np.int64]) -> Floats:
    """Covariance (6 n, 6 n) of some atoms."""
    size = 6 * len(rows)
    if covariance.ndim == 3:
        out = np.zeros((size, size))
        for at, row in enumerate(rows):
            out[6 * at : 6 * at + 6, 6 * at : 6 * at + 6] = covariance[row]
        return out
    index = (6 * rows[:, None] + np.arange(6)).ravel()
    return np.asarray(covariance[np.ix_(index, index)])
