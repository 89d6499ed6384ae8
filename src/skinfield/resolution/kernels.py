"""Readings of one round contact at many places, compiled."""

import numpy as np
from numba import njit

from skinfield.errors import Floats, Ints
from skinfield.inverse.atoms.kernel import Tables, predict


@njit(cache=True, nogil=True)
def picked(points: Floats, rows: Ints) -> Floats:
    """Rows of points (N, 2): indexing by an array, but quick to compile."""
    out = np.empty((len(rows), 2))
    for n in range(len(rows)):
        out[n, 0], out[n, 1] = points[rows[n], 0], points[rows[n], 1]
    return out


@njit(cache=True, nogil=True)
def grams(
    places: Floats,
    log_force: Floats,
    log_radius: float,
    taxels: Floats,
    white: Floats,
    start: Ints,
    rows: Ints,
    tables: Tables,
    out: Floats,
) -> None:
    """Write into `out` (P, 5, 5) the inner products of readings and their derivatives.

    Lengths in thicknesses. `rows[start[p]:start[p + 1]]` are the taxels near place p; `white` is 1
    over their noise. Of the five, the first is the reading, then its derivatives by x, y, ln force
    and ln radius.
    """
    atoms, family = np.zeros((1, 6)), np.zeros(1, np.int64)
    atoms[0, 3] = log_radius
    five = np.empty(5)
    out[:] = 0.0
    for p in range(len(places)):
        near = rows[start[p] : start[p + 1]]
        count = len(near)
        readings, slopes = np.empty(count), np.empty((count, 1, 6))
        atoms[0, 0], atoms[0, 1], atoms[0, 2] = places[p, 0], places[p, 1], log_force[p]
        predict(atoms, family, picked(taxels, near), tables, readings, slopes)
        for n in range(count):
            five[0] = readings[n]
            for i in range(4):
                five[i + 1] = slopes[n, 0, i]
            weight = white[near[n]] ** 2
            for i in range(5):
                for j in range(i + 1):
                    out[p, i, j] += five[i] * five[j] * weight
        for i in range(5):
            for j in range(i):
                out[p, j, i] = out[p, i, j]
