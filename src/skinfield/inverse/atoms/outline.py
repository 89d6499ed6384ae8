"""Outlines of atoms in the plane, and which of them overlap."""

import math

import numpy as np

from skinfield.errors import Floats

POINTS = 32  # of an outline, before the first comes again
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
    return drawn_out(x, y, radius, half, angle, END_COSINE, END_SINE)


def drawn_out(
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
