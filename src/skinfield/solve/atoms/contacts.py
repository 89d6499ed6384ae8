"""Contacts of atoms: outlines, areas, moments and their covariance."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats
from skinfield.estimate import Contact
from skinfield.skin import Grid
from skinfield.solve.atoms.render_kernels import SIZE, GridMesh, mesh_of, render
from skinfield.solve.atoms.render_tables import PressureTable
from skinfield.solve.atoms.table import FLAT

POINTS = 32  # of an outline, before the first comes again
FEW = 4  # atoms that are drawn with the finer outline
FINE, COARSE = 96, 48  # points of an atom among others


def polygon_of(atom: Floats, count: int) -> Floats:
    """Points (count, 2) m around an atom (6,), anticlockwise."""
    x, y, _, radius, half, angle = atom
    if half <= 0.0:
        turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
        return np.asarray(atom[:2] + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1))
    turn = np.linspace(-np.pi / 2, np.pi / 2, count // 2)
    along, across = half + radius * np.cos(turn), radius * np.sin(turn)
    along, across = np.append(along, -along), np.append(across, -across)
    east, north = np.cos(angle), np.sin(angle)
    return np.column_stack([x + east * along - north * across, y + north * along + east * across])


def _closed(points: Floats) -> Floats:
    return np.vstack([points, points[:1]])


def area_of(atom: Floats) -> float:
    """Of an atom, m²."""
    return float(np.pi * atom[3] ** 2 + 4.0 * atom[3] * atom[4])


def semi_axes(atom: Floats) -> tuple[float, float]:
    """Of the ellipse with the second moments of an atom's area, m, the longer first."""
    a, c = atom[3], atom[4]
    if c <= 0.0:
        return float(a), float(a)
    end = (np.pi / 4 - 16 / (9 * np.pi)) * a**4 + np.pi * a**2 * (c + 4 * a / (3 * np.pi)) ** 2
    along, across = 4 / 3 * a * c**3 + end, 4 / 3 * c * a**3 + np.pi / 4 * a**4
    size = area_of(atom)
    return float(2.0 * np.sqrt(along / size)), float(2.0 * np.sqrt(across / size))


def bodies(atoms: Floats) -> list[list[int]]:
    """Atoms (N, 6) that overlap, directly or through others: lists of rows, together all."""
    rows: list[list[float]] = atoms.tolist()
    owner = list(range(len(rows)))  # number of the body that each belongs to
    for i, one in enumerate(rows):
        for j, other in enumerate(rows[:i]):
            if owner[i] != owner[j] and _square_apart(one, other) < (one[3] + other[3]) ** 2:
                old, new = max(owner[i], owner[j]), min(owner[i], owner[j])
                owner = [new if name == old else name for name in owner]
    return [[n for n, its in enumerate(owner) if its == name] for name in dict.fromkeys(owner)]


def _square_apart(first: list[float], second: list[float]) -> float:
    """Squared distance in m² of the segments of two atoms."""
    east, north = first[4] * math.cos(first[5]), first[4] * math.sin(first[5])
    other_east, other_north = second[4] * math.cos(second[5]), second[4] * math.sin(second[5])
    x, y = second[0] - first[0], second[1] - first[1]
    cross = east * other_north - north * other_east
    if cross != 0.0:
        along = (x * other_north - y * other_east) / cross
        other_along = (x * north - y * east) / cross
        if abs(along) <= 1.0 and abs(other_along) <= 1.0:
            return 0.0
    nearest = math.inf
    for side in (-1.0, 1.0):  # else an end is nearest
        away = _square_from(x + side * other_east, y + side * other_north, east, north)
        other = _square_from(side * east - x, side * north - y, other_east, other_north)
        nearest = min(nearest, away, other)
    return nearest


def _square_from(x: float, y: float, east: float, north: float) -> float:
    """Squared distance of a point from a segment to both sides of the origin."""
    square = east * east + north * north
    share = min(max((x * east + y * north) / square, -1.0), 1.0) if square > 0.0 else 0.0
    return (x - share * east) ** 2 + (y - share * north) ** 2


@dataclass(frozen=True, eq=False)
class Shape:
    """How one or several atoms look in the plane, as one body.

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
    name : "sphere", "flat", "line" or "other"
    """

    outline: Floats
    area: float
    axes: Floats
    angle: float
    moves: Floats
    name: str = "other"

    @property
    def radius(self) -> float:
        """Of the circle of equal area, m."""
        return float(np.sqrt(self.area / np.pi))


def body_of(atoms: Floats) -> Shape:
    """Union of atoms (N, 6)."""
    count = FINE if len(atoms) <= FEW else COARSE
    polygons = np.stack([polygon_of(atom, count) for atom in atoms])
    free = _free(polygons, atoms)
    loops = _loops(_arcs(polygons, free))
    sizes, spread = _moments(loops)
    variance, direction = np.linalg.eigh(spread)
    angle = float(np.arctan2(direction[1, 1], direction[0, 1]))
    return Shape(
        outline=_around([loop for loop, size in zip(loops, sizes, strict=True) if size > 0.0]),
        area=float(sizes.sum()),
        axes=2.0 * np.sqrt(variance[::-1]),
        angle=(angle + np.pi / 2) % np.pi - np.pi / 2,
        moves=free.mean(axis=1)[:, None] * _area_moves(atoms),
    )


def _area_moves(atoms: Floats) -> Floats:
    """How the area of each of some atoms (N, 6) grows with its radius and half-length, (N, 2) m."""
    radius, half = atoms[:, 3], atoms[:, 4]
    return np.column_stack([2.0 * np.pi * radius + 4.0 * half, 4.0 * radius])


@njit
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
        loops.append(_closed(np.vstack(way)))
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
    return _closed(points[ConvexHull(points).vertices])


LINE = 0.5  # half-length over radius from which an atom is drawn out, not round


def _inside(atoms: Floats, mesh: GridMesh) -> NDArray[np.int64]:
    """Nodes in any of the atoms, sorted; else the nearest one."""
    reach = np.abs(atoms[:, 4] * np.sin(atoms[:, 5])) + atoms[:, 3]
    low, high = (atoms[:, 1] - reach).min(), (atoms[:, 1] + reach).max()
    first = max(math.ceil((low - mesh.y) / mesh.pitch), 0)
    last = min(math.floor((high - mesh.y) / mesh.pitch), mesh.rows - 1)
    y = mesh.y + np.arange(first, last + 1)[:, None] * mesh.pitch
    x = mesh.x + np.arange(mesh.columns) * mesh.pitch
    covered = np.zeros((len(y), mesh.columns), dtype=np.bool_)
    for at_x, at_y, _, radius, half, angle in atoms.tolist():
        east, north = math.cos(angle), math.sin(angle)
        away_x, away_y = x - at_x, y - at_y
        along = np.clip(away_x * east + away_y * north, -half, half)
        covered |= (away_x - along * east) ** 2 + (away_y - along * north) ** 2 <= radius * radius
    if covered.any():
        return np.asarray(np.flatnonzero(covered) + first * mesh.columns)
    row, column = np.rint((atoms[0, 1::-1] - (mesh.y, mesh.x)) / mesh.pitch).astype(int)
    row, column = np.clip([row, column], 0, [mesh.rows - 1, mesh.columns - 1])
    return np.array([row * mesh.columns + column])


def contact_of(
    grid: Grid, surface: PressureTable, atoms: Floats, family: NDArray[np.int64], covariance: Floats
) -> Contact:
    """Contact on a grid of atoms (N, 6) that are one body.

    `surface` is what round contacts look like; the covariance (6 N, 6 N) is that of all atoms.
    """
    force = atoms[:, 2]
    total = float(force.sum())
    share = force / total if total > 0.0 else np.full(len(atoms), 1.0 / len(atoms))
    centre = share @ atoms[:, :2]
    moves = _moves(atoms, share, centre, total)
    pressure, mesh = np.empty(len(grid)), mesh_of(grid)
    peak = render(atoms, family, surface, mesh, pressure)
    shape, skin = _shape_of(atoms, int(family[0])), grid.patch.surface
    grows = np.zeros((len(atoms), SIZE))
    grows[:, 3:5] = shape.moves
    variance = float(grows.ravel() @ covariance @ grows.ravel())  # of the area
    # All places at once: it is slow on a curved skin.
    places = skin.position_from_plane(np.vstack([centre, shape.outline]))
    normal = np.array(skin.frame_from_plane(centre[None])[0, :, 2])
    push, moment = 0.0 - total * normal, np.zeros(3)
    if not skin.is_flat:  # the sum over the cells, less what lies off the grid
        cells = np.flatnonzero(pressure)
        forces = -(pressure[cells] * grid.cell_area)[:, None] * grid.normals[cells]
        push = forces.sum(axis=0)
        moment = np.cross(grid.positions[cells] - places[0], forces).sum(axis=0)
    return Contact(
        position=places[0],
        force=push,
        moment=moment,
        normal=normal,
        area=shape.area,
        peak_pressure=peak,
        covariance=moves @ covariance @ moves.T,
        area_std=max(variance, 0.0) ** 0.5,
        radius=shape.radius,
        shape=shape.name,
        outline=places[1:],
        axes=shape.axes,
        angle=shape.angle,
        cells=_inside(atoms, mesh),
    )


def _moves(atoms: Floats, share: Floats, centre: Floats, total: float) -> Floats:
    """How the place and force of a body move with all parameters of its atoms, (3, 6 N)."""
    out = np.zeros((3, len(atoms), SIZE))
    out[0, :, 0] = out[1, :, 1] = share
    out[2, :, 2] = 1.0
    if len(atoms) > 1 and total > 0.0:
        out[:2, :, 2] = (atoms[:, :2] - centre).T / total
    return out.reshape(3, -1)


def _shape_of(atoms: Floats, family: int) -> Shape:
    """How a body of atoms looks in the plane."""
    if len(atoms) > 1:
        return body_of(atoms)
    atom = atoms[0]
    radius, half = float(atom[3]), float(atom[4])
    return Shape(
        outline=_closed(polygon_of(atom, POINTS)),
        area=area_of(atom),
        axes=np.array(semi_axes(atom)),
        angle=float((atom[5] + np.pi / 2) % np.pi - np.pi / 2) if half > 0.0 else 0.0,
        moves=_area_moves(atoms),
        name="line" if half > LINE * radius else "flat" if family == FLAT else "sphere",
    )
