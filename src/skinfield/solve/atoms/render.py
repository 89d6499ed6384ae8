"""Rendering of atoms on a grid: pressure and displacement."""

from collections.abc import Hashable
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.elastic import Layer, Mechanics
from skinfield.errors import Floats, InputError, check_finite
from skinfield.skin import Grid
from skinfield.solve.atoms.render_kernels import (
    NODE,
    WEIGHT,
    GridMesh,
    blend,
    held,
    mesh_of,
    points_along,
    render,
)
from skinfield.solve.atoms.render_tables import (
    FOLD,
    INNER,
    OUTER,
    DisplacementTable,
    PressureTable,
    displacement_table,
    pressure_table,
)
from skinfield.solve.atoms.rows_kernel import GRID, RowGrid
from skinfield.solve.atoms.table import BALL, FLAT
from skinfield.solve.packed import Packed

NEAR = 2.0  # thicknesses around a drawn-out atom in which each of its points counts
COUNT = OUTER * 4 + INNER  # coefficients of a displacement
FAR_POINTS = 4  # along the segment, for nodes farther away


@inner
def _near(atom: Floats, radius: float, surface: PressureTable, mesh: GridMesh, box: Any) -> None:
    """First row and column and those behind the last, of the nodes near an atom."""
    wide = abs(atom[4] * np.cos(atom[5])) + radius + NEAR * surface.thickness
    high = abs(atom[4] * np.sin(atom[5])) + radius + NEAR * surface.thickness
    box[0] = int(np.ceil((atom[1] - high - mesh.y) / mesh.pitch))
    box[1] = int(np.ceil((atom[0] - wide - mesh.x) / mesh.pitch))
    box[2] = int(np.floor((atom[1] + high - mesh.y) / mesh.pitch)) + 1
    box[3] = int(np.floor((atom[0] + wide - mesh.x) / mesh.pitch)) + 1


@inner
def _radial_terms(
    radius: float,
    force: float,
    family: int,
    surface: PressureTable,
    moves: DisplacementTable,
    terms: Floats,
) -> None:
    """Coefficients (2, COUNT) of one radius and force."""
    first, b0, b1, b2, b3 = blend(radius, surface)
    scale = force / radius
    b0, b1, b2, b3 = scale * b0, scale * b1, scale * b2, scale * b3
    for part in range(2):
        t0 = moves.displacement[family, first, part]
        t1 = moves.displacement[family, first + 1, part]
        t2 = moves.displacement[family, first + 2, part]
        t3 = moves.displacement[family, first + 3, part]
        for j in range(COUNT):
            terms[part, j] = b0 * t0[j] + b1 * t1[j] + b2 * t2[j] + b3 * t3[j]


@njit(inline="always")
def _response(
    normal: Floats, radial: Floats, r2: float, square: float, fold: float
) -> tuple[float, float]:
    """Displacement outwards, and away from the axis over the distance, at a squared distance."""
    if r2 < square:
        t = np.sqrt(1.0 - r2 / square)
        up, away = normal[INNER - 1], radial[INNER - 1]
        for j in range(INNER - 2, -1, -1):
            up = up * t + normal[j]
            away = away * t + radial[j]
    else:
        s = np.sqrt(r2 - square)
        place = OUTER * s / (s + fold)
        i = min(int(place), OUTER - 1)
        t = place - i
        c = INNER + 4 * i
        up = ((normal[c] * t + normal[c + 1]) * t + normal[c + 2]) * t + normal[c + 3]
        away = ((radial[c] * t + radial[c + 1]) * t + radial[c + 2]) * t + radial[c + 3]
    return up, away


@inner
def _add_round(
    x: float,
    y: float,
    radius: float,
    share: float,
    terms: Floats,
    thickness: float,
    reach: float,
    mesh: GridMesh,
    box: Any,
    inside: bool,
    out: Floats,
) -> None:
    """Add a round atom's displacement along the axes of the plane and outwards, (K, 3).

    To the nodes inside the box, or to those outside.
    """
    far = min(radius + reach, 1e9)
    pitch = mesh.pitch
    first_row = max(int(np.ceil((y - far - mesh.y) / pitch)), 0)
    first_column = max(int(np.ceil((x - far - mesh.x) / pitch)), 0)
    end_row = min(int(np.floor((y + far - mesh.y) / pitch)) + 1, mesh.rows)
    end_column = min(int(np.floor((x + far - mesh.x) / pitch)) + 1, mesh.columns)
    if inside:
        first_row, first_column = max(first_row, box[0]), max(first_column, box[1])
        end_row, end_column = min(end_row, box[2]), min(end_column, box[3])
    square, limit, fold = radius * radius, far * far, FOLD * thickness
    normal, radial = terms[0], terms[1]
    for row in range(first_row, end_row):
        away_y = mesh.y + row * pitch - y
        skipped = end_column, end_column  # columns that are left out
        if not inside and box[0] <= row < box[2]:
            skipped = max(box[1], first_column), max(box[3], first_column)
        for start, end in ((first_column, min(skipped[0], end_column)), (skipped[1], end_column)):
            for column in range(start, end):
                away_x = mesh.x + column * pitch - x
                r2 = away_x * away_x + away_y * away_y
                if r2 <= limit:
                    up, away = _response(normal, radial, r2, square, fold)
                    k = row * mesh.columns + column
                    out[k, 0] += share * away * away_x
                    out[k, 1] += share * away * away_y
                    out[k, 2] += share * up


@njit
def displacement(
    atoms: Floats,
    family: Any,
    surface: PressureTable,
    moves: DisplacementTable,
    mesh: GridMesh,
    frames: Floats,
    out: Floats,
) -> None:
    """Write the displacement of the nodes in the patch's frame, (K, 3) m.

    `frames` (K, 3, 3), or (1, 3, 3) where all are the same.
    """
    out[:] = 0.0
    thickness, reach = surface.thickness, moves.reach
    box, terms = np.empty(4, np.int64), np.empty((2, COUNT))
    for n in range(len(atoms)):
        radius = held(atoms[n, 3], surface)
        _radial_terms(radius, atoms[n, 2], family[n], surface, moves, terms)
        _near(atoms[n], radius, surface, mesh, box)
        east, north = atoms[n, 4] * np.cos(atoms[n, 5]), atoms[n, 4] * np.sin(atoms[n, 5])
        near = points_along(radius, atoms[n, 4])
        for inside, count in ((True, near), (False, min(near, FAR_POINTS))):
            for q in range(count):
                x, y = atoms[n, 0] + NODE[count, q] * east, atoms[n, 1] + NODE[count, q] * north
                share = WEIGHT[count, q]
                _add_round(x, y, radius, share, terms, thickness, reach, mesh, box, inside, out)
    for k in range(len(out)):
        frame = frames[k if len(frames) > 1 else 0]
        u, v, w = out[k, 0], out[k, 1], out[k, 2]
        for i in range(3):
            out[k, i] = frame[i, 0] * u + frame[i, 1] * v + frame[i, 2] * w


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
        return Packed(RowGrid(self._mesh, *places, self._surface, self._layer.thickness), GRID)

    @cached_property
    def _moves(self) -> DisplacementTable:
        """What displacements are made of: tabulated when the first one is asked for."""
        return displacement_table(self._layer, cast(Hashable, self._mechanics))

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
        _check(atoms, family)
        render(atoms, family, self._surface, self._mesh, out)

    def displacement(self, atoms: Floats, family: Family, out: Floats) -> None:
        """Write the displacement of the nodes in the patch's frame into `out` (K, 3), m."""
        _check(atoms, family)
        displacement(atoms, family, self._surface, self._moves, self._mesh, self._frames, out)


def _check(atoms: Floats, family: Family) -> None:
    """Raise InputError for atoms that cannot be drawn."""
    if not np.isfinite(atoms.sum()):
        check_finite("atoms", atoms, "of these nothing can be drawn")
    if family.max(initial=BALL) > FLAT:
        raise InputError(f"family is {family}, expected {BALL} (ball) or {FLAT} (flat end)")
