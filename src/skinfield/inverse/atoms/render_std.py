"""How far the pressure of atoms may be off, from how far their parameters may be; compiled."""

from typing import Any

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.compiled import inner
from skinfield.inverse.atoms.render_kernels import Mesh, Surface, add_pressure

SIZE = 6  # parameters of an atom
NEGLIGIBLE = 1e-12  # of a variance: what of it is left over by those before


@inner
def _root(covariance: Floats, factor: Floats) -> int:
    """Lower triangle whose square is the covariance, in columns without zeros; their number."""
    count = 0
    for j in range(SIZE):
        pivot = covariance[j, j]
        for k in range(count):
            pivot -= factor[j, k] * factor[j, k]
        if not pivot > NEGLIGIBLE * covariance[j, j]:
            continue
        root = np.sqrt(pivot)
        for i in range(SIZE):
            value = covariance[i, j]
            for k in range(count):
                value -= factor[i, k] * factor[j, k]
            factor[i, count] = value / root if i >= j else 0.0
        count += 1
    return count


@inner
def _move(atom: Floats, step: Floats, factor: float, moved: Floats) -> None:
    """Atom at the end of a step; the radius grows by its logarithm, so that it stays positive."""
    for i in range(SIZE):
        moved[i] = atom[i] + factor * step[i]
    moved[3] = atom[3] * np.exp(min(max(factor * step[3] / atom[3], -3.0), 3.0))
    moved[4] = abs(moved[4])


@inner
def _gather(
    mesh: Mesh, first: Any, second: Any, plain: Floats, moved: Floats, share: float, out: Floats
) -> None:
    """Add the squared difference in both boxes, and clear the second picture there."""
    low_row, low_column = max(min(first[0], second[0]), 0), max(min(first[1], second[1]), 0)
    high_row = min(max(first[0] + first[2], second[0] + second[2]), mesh.rows)
    high_column = min(max(first[1] + first[3], second[1] + second[3]), mesh.columns)
    for row in range(low_row, high_row):
        for k in range(row * mesh.columns + low_column, row * mesh.columns + high_column):
            out[k] += share * (moved[k] - plain[k]) ** 2
            moved[k] = 0.0


@inner
def _clear(mesh: Mesh, box: Any, out: Floats) -> None:
    for row in range(max(box[0], 0), min(box[0] + box[2], mesh.rows)):
        low, high = max(box[1], 0), min(box[1] + box[3], mesh.columns)
        for k in range(row * mesh.columns + low, row * mesh.columns + high):
            out[k] = 0.0


@njit(cache=True, nogil=True)
def pressure_std(
    atoms: Floats,
    family: Any,
    covariance: Floats,
    surface: Surface,
    mesh: Mesh,
    out: Floats,
    boxes: Any,
    cells: Floats,
    room: Floats,
    pictures: Floats,
    small: Floats,
) -> None:
    """Write one standard deviation of each cell's pressure, (K,) Pa; atoms are independent.

    The mean square of what changes at the ends of the axes of each covariance, drawn out by the
    root of their number: to first order in the covariance the variance, and still in range where
    the atom may be off by more than its size (spherical cubature; Arasaratnam and Haykin 2009).
    """
    out[:] = 0.0
    plain, changed = pictures[0], pictures[1]
    factor, step, moved = small[:SIZE], small[SIZE], small[SIZE + 1]
    for n in range(len(atoms)):
        count = _root(covariance[n], factor)
        if not add_pressure(atoms[n], family[n], surface, mesh, plain, boxes[0], cells, room):
            boxes[0, 2:] = 0
        for j in range(count):
            step[:] = factor[:, j]
            for side in (-1.0, 1.0):
                _move(atoms[n], step, side * np.sqrt(count), moved)
                on = add_pressure(moved, family[n], surface, mesh, changed, boxes[1], cells, room)
                if not on:
                    boxes[1] = boxes[0]
                _gather(mesh, boxes[0], boxes[1], plain, changed, 0.5 / count, out)
        _clear(mesh, boxes[0], plain)
    for k in range(len(out)):
        out[k] = np.sqrt(out[k])
