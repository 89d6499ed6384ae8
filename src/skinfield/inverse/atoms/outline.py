"""Outlines of atoms in the plane, one by one or of several that overlap."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

POINTS = 32  # of an outline, before the first comes again
FINE = 96  # of each member of a body
TURN = np.linspace(-np.pi / 2, np.pi / 2, POINTS // 2)
CIRCLE = np.linspace(0.0, 2.0 * np.pi, POINTS + 1)
COSINE, SINE = np.cos(CIRCLE), np.sin(CIRCLE)
END_COSINE, END_SINE = np.cos(TURN), np.sin(TURN)


def outline(atom: Floats) -> Floats:
    """Closed polygon (33, 2) m around an atom (6,), anticlockwise."""
    x, y, _, radius, half, angle = atom
    if half <= 0.0:
        out = np.empty((POINTS + 1, 2))
        out[:, 0] = x + radius * COSINE
        out[:, 1] = y + radius * SINE
        return out
    return _drawn_out(x, y, radius, half, angle, END_COSINE, END_SINE)


def _drawn_out(
    x: float, y: float, radius: float, half: float, angle: float, cosine: Floats, sine: Floats
) -> Floats:
    """Polygon of two half circles, each given by cosine and sine of its points."""
    count = len(cosine)
    along, across = np.empty(2 * count + 1), np.empty(2 * count + 1)
    along[:count] = half + radius * cosine
    along[count:-1] = -along[:count]
    across[:count] = radius * sine
    across[count:-1] = -across[:count]
    along[-1], across[-1] = along[0], across[0]
    east, north = np.cos(angle), np.sin(angle)
    return np.column_stack([x + east * along - north * across, y + north * along + east * across])


def area(atom: Floats) -> float:
    """Of an atom, m²."""
    return float(np.pi * atom[3] ** 2 + 4.0 * atom[3] * atom[4])


def semi_axes(atom: Floats) -> tuple[float, float]:
    """Of the ellipse with the second moments of an atom's area, m, the longer first."""
    a, c = atom[3], atom[4]
    if c <= 0.0:
        return float(a), float(a)
    end = (np.pi / 4 - 16 / (9 * np.pi)) * a**4 + np.pi * a**2 * (c + 4 * a / (3 * np.pi)) ** 2
    along, across = 4 / 3 * a * c**3 + end, 4 / 3 * c * a**3 + np.pi / 4 * a**4
    size = area(atom)
    return float(2.0 * np.sqrt(along / size)), float(2.0 * np.sqrt(across / size))


def bodies(atoms: Floats) -> list[list[int]]:
    """Atoms (N, 6) that overlap, directly or through others: lists of rows, together all."""
    count = len(atoms)
    owner = list(range(count))
    for i in range(count):
        for j in range(i):
            if _apart(atoms[i], atoms[j]) < atoms[i, 3] + atoms[j, 3]:
                new, old = owner[j], owner[i]
                owner = [new if one == old else one for one in owner]
    return [[i for i in range(count) if owner[i] == name] for name in dict.fromkeys(owner)]


def _apart(first: Floats, second: Floats) -> float:
    """Distance in m of the segments of two atoms."""
    ends = [_ends(first), _ends(second)]
    if _cross(*ends):
        return 0.0
    pairs = [(ends[0], end) for end in ends[1]] + [(ends[1], end) for end in ends[0]]
    return min(float(distance(end[None], *segment)[0]) for segment, end in pairs)


def _ends(atom: Floats) -> tuple[Floats, Floats]:
    way = atom[4] * np.array([np.cos(atom[5]), np.sin(atom[5])])
    return atom[:2] - way, atom[:2] + way


def _cross(first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> bool:
    """Whether two segments cross."""

    def sides(line: tuple[Floats, Floats], points: tuple[Floats, Floats]) -> float:
        along = line[1] - line[0]
        one, two = (along[0] * (p - line[0])[1] - along[1] * (p - line[0])[0] for p in points)
        return float(one * two)

    return sides(first, second) < 0.0 and sides(second, first) < 0.0


def distance(points: Floats, start: Floats, end: Floats) -> Floats:
    """Of points (N, 2) from a segment, (N,) m."""
    way = end - start
    square = float(way @ way)
    share = np.clip((points - start) @ way / square, 0.0, 1.0) if square > 0.0 else 0.0
    return np.asarray(np.linalg.norm(points - start - np.multiply.outer(share, way), axis=-1))


@dataclass(frozen=True, eq=False)
class Body:
    """Several atoms as one.

    Attributes
    ----------
    outline : (N, 2) array, m
        Closed, anticlockwise; holes are not in it.
    area : float, m²
        Within the outline.
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


def body(atoms: Floats) -> Body:
    """Outline of the union of atoms (N, 6) that hang together."""
    arcs, exposed = [], np.zeros((len(atoms), 2))
    for n, atom in enumerate(atoms):
        polygon = _fine(atom)[:-1]
        free = np.ones(len(polygon), dtype=bool)
        for other in np.delete(atoms, n, axis=0):
            free &= distance(polygon, *_ends(other)) >= other[3] * (1.0 - 1e-9)
        share = float(free.mean())
        exposed[n] = share * (2.0 * np.pi * atom[3] + 4.0 * atom[4]), share * 4.0 * atom[3]
        arcs += _runs(polygon, free)
    loop = max(_loops(arcs), key=lambda polygon: _moments(polygon)[0])
    size, spread = _moments(loop)
    variance, direction = np.linalg.eigh(spread)
    angle = float(np.arctan2(direction[1, 1], direction[0, 1]))
    turned = (angle + np.pi / 2) % np.pi - np.pi / 2
    return Body(loop, size, 2.0 * np.sqrt(variance[::-1]), turned, exposed)


def _fine(atom: Floats) -> Floats:
    if atom[4] > 0.0:
        turn = np.linspace(-np.pi / 2, np.pi / 2, FINE // 2)
        x, y, _, radius, half, angle = atom
        return _drawn_out(x, y, radius, half, angle, np.cos(turn), np.sin(turn))
    turn = np.linspace(0.0, 2.0 * np.pi, FINE + 1)
    return np.asarray(atom[:2] + atom[3] * np.column_stack([np.cos(turn), np.sin(turn)]))


def _runs(polygon: Floats, free: NDArray[np.bool_]) -> list[Floats]:
    """Parts of a closed polygon (N, 2) that are free, in its sense."""
    if free.all():
        return [polygon]
    if not free.any():
        return []
    start = int(np.flatnonzero(~free)[0])
    polygon, free = np.roll(polygon, -start, axis=0), np.roll(free, -start)
    change = np.flatnonzero(np.diff(np.r_[False, free, False].astype(int)))
    return [polygon[low:high] for low, high in change.reshape(-1, 2)]


def _loops(arcs: list[Floats]) -> list[Floats]:
    """Closed polygons of arcs, each continued by the one that starts nearest to its end."""
    left, loops = list(arcs), []
    while left:
        way = [left.pop()]
        while left:
            end = way[-1][-1]
            gaps = [float(np.linalg.norm(arc[0] - end)) for arc in left]
            nearest = int(np.argmin(gaps))
            if gaps[nearest] > np.linalg.norm(way[0][0] - end):
                break
            way.append(left.pop(nearest))
        loops.append(np.vstack([*way, way[0][:1]]))
    return loops


def _moments(polygon: Floats) -> tuple[float, Floats]:
    """Area and second moments (2, 2) per area about the centre, of a closed polygon (N, 2)."""
    middle = polygon[:-1].mean(axis=0)
    here, there = polygon[:-1] - middle, polygon[1:] - middle
    cross = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
    size = float(cross.sum() / 2.0)
    centre = (cross[:, None] * (here + there)).sum(axis=0) / (6.0 * size)
    both = here + there
    outer = sum(np.einsum("n,ni,nj->ij", cross, part, part) for part in (here, there, both))
    return size, np.asarray(outer / (24.0 * size) - np.outer(centre, centre))
