"""Outline, area and second moments of several atoms as one."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse.atoms.outline import drawn_out

FEW = 4  # atoms that are drawn with the finer outline
FINE, COARSE = 96, 48  # points of an atom


@dataclass(frozen=True, eq=False)
class Body:
    """Several atoms as one.

    Attributes
    ----------
    outline : (N, 2) array, m
        Closed, anticlockwise; without holes, and around all parts where there are several.
    area : float, m²
        That is covered, holes left out.
    axes : (2,) array, m
        Semi-axes of the ellipse of equal second moments, the longer first.
    angle : float, rad
        Of the longer axis.
    moves : (atoms, 2) array, m
        How the area grows with each atom's radius and half-length.
    """

    outline: Floats
    area: float
    axes: Floats
    angle: float
    moves: Floats


def body_of(atoms: Floats) -> Body:
    """Union of atoms (N, 6)."""
    count = FINE if len(atoms) <= FEW else COARSE
    polygons = np.stack([_polygon(atom, count) for atom in atoms])
    free = _free(polygons, atoms)
    radius, half = atoms[:, 3], atoms[:, 4]
    around = np.column_stack([2.0 * np.pi * radius + 4.0 * half, 4.0 * radius])
    loops = _loops(_arcs(polygons, free))
    sizes, spread = _moments(loops)
    variance, direction = np.linalg.eigh(spread)
    angle = float(np.arctan2(direction[1, 1], direction[0, 1]))
    return Body(
        outline=_around([loop for loop, size in zip(loops, sizes, strict=True) if size > 0.0]),
        area=float(sizes.sum()),
        axes=2.0 * np.sqrt(variance[::-1]),
        angle=(angle + np.pi / 2) % np.pi - np.pi / 2,
        moves=free.mean(axis=1)[:, None] * around,
    )


def _polygon(atom: Floats, count: int) -> Floats:
    """Points (count, 2) m around an atom, anticlockwise."""
    x, y, _, radius, half, angle = atom
    if half > 0.0:
        turn = np.linspace(-np.pi / 2, np.pi / 2, count // 2)
        return drawn_out(x, y, radius, half, angle, np.cos(turn), np.sin(turn))[:-1]
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.asarray(atom[:2] + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1))


@njit(cache=True, nogil=True)
def _free(polygons: Floats, atoms: Floats) -> Any:
    """Which points (N, P, 2) of each atom lie in no other, (N, P)."""
    free = np.ones(polygons.shape[:2], dtype=np.bool_)
    for m in range(len(atoms)):
        east, north = np.cos(atoms[m, 5]), np.sin(atoms[m, 5])
        half, square = atoms[m, 4], (atoms[m, 3] * (1.0 - 1e-9)) ** 2
        for n in range(len(atoms)):
            if n == m:
                continue
            for i in range(polygons.shape[1]):
                x, y = polygons[n, i, 0] - atoms[m, 0], polygons[n, i, 1] - atoms[m, 1]
                along = min(max(x * east + y * north, -half), half)
                x, y = x - along * east, y - along * north
                if x * x + y * y < square:
                    free[n, i] = False
    return free


def _arcs(polygons: Floats, free: NDArray[np.bool_]) -> list[Floats]:
    """Parts of closed polygons (N, P, 2) that are free, in their sense."""
    count = free.shape[1]
    twice, on = np.hstack([polygons, polygons]), np.hstack([free, free])
    covered = np.where(on, 2 * count, np.arange(2 * count))
    ends = np.minimum.accumulate(covered[:, ::-1], axis=1)[:, ::-1]  # the next that is not free
    rows, starts = np.nonzero(free & ~np.roll(free, 1, axis=1))
    whole = [polygons[row] for row in np.flatnonzero(free.all(axis=1))]
    return whole + [
        twice[row, start : ends[row, start]] for row, start in zip(rows, starts, strict=True)
    ]


def _loops(arcs: list[Floats]) -> list[Floats]:
    """Closed polygons of arcs, each continued by the one that starts nearest to its end."""
    starts = np.array([arc[0] for arc in arcs])
    used = np.zeros(len(arcs), dtype=bool)
    loops = []
    for first in range(len(arcs)):
        if used[first]:
            continue
        way, at = [], first
        while not used[at]:
            way.append(arcs[at])
            used[at] = True
            apart = np.square(starts - arcs[at][-1]).sum(axis=1)
            apart[used] = np.inf
            apart[first] = np.square(starts[first] - arcs[at][-1]).sum()
            at = int(np.argmin(apart))
        loops.append(np.vstack([*way, way[0][:1]]))
    return loops


def _moments(loops: list[Floats]) -> tuple[Floats, Floats]:
    """Area of each loop, negative around a hole, and second moments (2, 2) of all per area."""
    middle = loops[0].mean(axis=0)
    sizes, first, second = np.zeros(len(loops)), np.zeros(2), np.zeros((2, 2))
    for index, loop in enumerate(loops):
        here, there = loop[:-1] - middle, loop[1:] - middle
        cross = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
        both = here + there
        sizes[index] = cross.sum() / 2.0
        first += cross @ both / 6.0
        second += sum((part.T * cross) @ part for part in (here, there, both)) / 24.0
    centre = first / sizes.sum()
    return sizes, np.asarray(second / sizes.sum() - np.outer(centre, centre))


def _around(loops: list[Floats]) -> Floats:
    """The one loop, or the convex hull of several."""
    if len(loops) == 1:
        return loops[0]
    from scipy.spatial import ConvexHull

    points = np.vstack(loops)
    corners = ConvexHull(points).vertices
    return np.asarray(points[np.append(corners, corners[0])])
