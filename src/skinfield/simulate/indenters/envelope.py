"""How high the lowest of many triangles is over places of the plane."""

from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.errors import Floats, Ints

RIM = 1e-9
"""Share of a triangle by which it reaches past its edges: rounding must not part neighbours."""


def lowest_over(vertices: Floats, faces: Ints, x: Floats, y: Floats) -> Floats:
    """Height of the lowest triangle over each place, exactly.

    Parameters
    ----------
    vertices, faces : (N, 3) array, m, and (M, 3) int array
    x, y : (K,) arrays, m

    Returns
    -------
    (K,) array, m
        Infinite where no triangle is. Triangles that stand upright cover nothing.
    """
    if not len(x):
        return np.empty(0)
    side = int(np.ceil(np.sqrt(len(x))))
    low = np.array([x.min(), y.min()])
    span = np.maximum(np.array([x.max(), y.max()]) - low, 1e-12)
    bin_of = np.minimum((np.stack([x, y], axis=1) - low) / span * side, side - 1).astype(np.int64)
    flat = bin_of[:, 1] * side + bin_of[:, 0]
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(side * side + 1))
    found = np.full(len(x), np.inf)
    per_metre = side / span
    _compiled()(vertices, faces, x, y, order, starts, side, low, per_metre, RIM, found)
    return found


def _sweep(
    vertices: Floats,
    faces: Ints,
    x: Floats,
    y: Floats,
    order: Ints,
    starts: Ints,
    side: int,
    low: Floats,
    per_metre: Floats,
    rim: float,
    found: Floats,
) -> None:
    """Lower `found` to each triangle over the places in the bins that its box touches."""
    for face in range(len(faces)):
        a, b, c = vertices[faces[face, 0]], vertices[faces[face, 1]], vertices[faces[face, 2]]
        twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        longest = max(
            (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2,
            (c[0] - a[0]) ** 2 + (c[1] - a[1]) ** 2,
            (c[0] - b[0]) ** 2 + (c[1] - b[1]) ** 2,
        )
        if abs(twice) <= 1e-12 * longest:
            continue
        left = (min(a[0], b[0], c[0]) - low[0]) * per_metre[0] - 1e-6
        right = (max(a[0], b[0], c[0]) - low[0]) * per_metre[0] + 1e-6
        near = (min(a[1], b[1], c[1]) - low[1]) * per_metre[1] - 1e-6
        far = (max(a[1], b[1], c[1]) - low[1]) * per_metre[1] + 1e-6
        if right < 0 or far < 0 or left > side or near > side:
            continue
        for row in range(max(int(near), 0), min(int(far), side - 1) + 1):
            for column in range(max(int(left), 0), min(int(right), side - 1) + 1):
                index = row * side + column
                for slot in range(starts[index], starts[index + 1]):
                    place = order[slot]
                    dx, dy = x[place] - a[0], y[place] - a[1]
                    to_b = (dx * (c[1] - a[1]) - (c[0] - a[0]) * dy) / twice
                    to_c = ((b[0] - a[0]) * dy - dx * (b[1] - a[1])) / twice
                    if to_b >= -rim and to_c >= -rim and to_b + to_c <= 1.0 + rim:
                        height = a[2] + to_b * (b[2] - a[2]) + to_c * (c[2] - a[2])
                        found[place] = min(found[place], max(height, 0.0))


@lru_cache(maxsize=1)
def _compiled() -> Any:
    """`_sweep` as machine code: it runs over every triangle."""
    from numba import njit

    return njit(cache=True, nogil=True)(_sweep)
