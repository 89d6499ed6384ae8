"""Closed lines around what touches: marching squares on the touched fraction."""

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

Edge = tuple[int, int, int]  # row and column of its first node, and 0 along x or 1 along y


def outlines(share: Floats, y: Floats, x: Floats) -> list[Floats]:
    """Polygons along which a picture passes through one half.

    Parameters
    ----------
    share : (rows, columns) array
        Between nodes it is taken as linear, and 0 around the picture.
    y, x : (rows,) and (columns,) arrays, m
        Places of the nodes, evenly spaced.

    Returns
    -------
    list of (N, 2) arrays, m
        Closed, the first point repeated as the last; what is above one half lies to the left, so
        holes run the other way round. The largest first.
    """
    high = np.pad(share, 1) - 0.5
    step = float(x[1] - x[0]) if len(x) > 1 else float(y[1] - y[0]) if len(y) > 1 else 1.0
    origin = np.array([x[0] - step, y[0] - step])
    follow = _segments(high)
    polygons = []
    while follow:
        start = next(iter(follow))
        way = [start]
        while True:
            ahead = follow[way[-1]].pop()
            if not follow[way[-1]]:
                del follow[way[-1]]
            way.append(ahead)
            if ahead == start:
                break
        polygons.append(origin + step * _crossings(high, way))
    return sorted(polygons, key=lambda polygon: -abs(enclosed(polygon)))


def enclosed(polygon: Floats) -> float:
    """Area within a closed polygon (N, 2), positive where it runs counter-clockwise."""
    x, y = polygon.T
    return float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) / 2)


def _crossings(high: Floats, way: list[Edge]) -> Floats:
    """Where the line crosses edges of the lattice, (N, 2) as column and row."""
    row, column, upright = np.array(way).T
    here = high[row, column]
    there = high[row + upright, column + 1 - upright]
    part = here / (here - there)
    return np.column_stack([column + part * (1 - upright), row + part * upright])


def _segments(high: Floats) -> dict[Edge, list[Edge]]:
    """From the edge where the line enters a square of four nodes to that where it leaves."""
    inside = high > 0
    corners = _numbered(inside)
    follow: dict[Edge, list[Edge]] = defaultdict(list)
    for row, column in zip(*np.nonzero((corners > 0) & (corners < 15)), strict=True):
        r, c = int(row), int(column)
        bottom, top, left, right = (r, c, 0), (r + 1, c, 0), (r, c, 1), (r, c + 1, 1)
        cases: dict[int, list[tuple[Edge, Edge]]] = {
            1: [(bottom, left)], 2: [(right, bottom)], 3: [(right, left)],
            4: [(top, right)], 5: [(bottom, left), (top, right)], 6: [(top, bottom)],
            7: [(top, left)], 8: [(left, top)], 9: [(bottom, top)],
            10: [(right, bottom), (left, top)], 11: [(right, top)], 12: [(left, right)],
            13: [(bottom, right)], 14: [(left, bottom)],
        }  # fmt: skip
        for enters, leaves in cases[int(corners[row, column])]:
            follow[enters].append(leaves)
    return dict(follow)


def _numbered(inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Which corners of each square are inside: 1 lower left, 2 lower right, 4 upper right, 8."""
    weights = (inside[:-1, :-1], inside[:-1, 1:], inside[1:, 1:], inside[1:, :-1])
    return np.asarray(sum(part.astype(np.int64) << bit for bit, part in enumerate(weights)))
