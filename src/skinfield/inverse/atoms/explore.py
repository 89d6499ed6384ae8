"""What a reading leaves open about the place of one contact, compiled.

Between taxels the posterior of a contact is no ellipsoid but a curved valley, along which another
place is made up for by another force and radius. It is walked on a lattice of places: at each,
force and radius (and half-length) are refined and then integrated out by Laplace's approximation,
as in the nested approximations of Rue, Martino and Chopin (2009).
"""

from typing import Any

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.kernel import Tables
from skinfield.inverse.atoms.refine import Priors, cholesky_solve, refine

REACH = 14  # steps of the lattice each way
STEPS = 4  # of refinement at each place
DEEP = 6.0  # in cost: places that are worse than the best by more do not count


@njit(cache=True, nogil=True)
def invert(hessian: Floats, free: Any, out: Floats) -> float:
    """Write the inverse over free parameters, else 0, (6, 6).

    Returns half the logarithm of the Hessian's determinant, infinite where that is not positive.
    """
    index = np.flatnonzero(free)
    size = len(index)
    part, right = np.empty((size, size)), np.empty(size)
    out[:] = 0.0
    half = 0.0
    for column in range(size):
        for a in range(size):
            right[a] = 1.0 if a == column else 0.0
            for b in range(size):
                part[a, b] = hessian[index[a], index[b]]
            part[a, a] = part[a, a] * (1.0 + 1e-9) + 1e-12
        if not cholesky_solve(part, right):
            return np.inf
        for a in range(size):
            out[index[a], index[column]] = right[a]
        half += np.log(part[column, column])
    return half


@njit(cache=True, nogil=True)
def explore(
    seeds: Floats,
    family: int,
    free: Any,
    axes: Floats,
    origin: Floats,
    places: Floats,
    readings: Floats,
    white: Floats,
    taxels: Floats,
    tables: Tables,
    priors: Priors,
    out_atoms: Floats,
    out_inner: Floats,
    out_weight: Floats,
) -> int:
    """Walk over places at `origin` + integers times the rows of `axes` (2, 2).

    Parameters
    ----------
    seeds : (M, 6) array
        Atoms from which the walk starts.
    family : int
    free : (6,) bool array
        What is refined at each place beside it.
    out_atoms, out_inner, out_weight : (C, 6), (C, 6, 6), (C,) arrays
        Atom at each place; covariance of what is refined there; logarithm of the weight.

    Returns
    -------
    int
        How many places were written.
    """
    most = out_weight.shape[0]
    side = 2 * REACH + 1
    visited = np.zeros((side, side), dtype=np.bool_)
    queue = np.empty((most * 8 + seeds.shape[0], 2), dtype=np.int64)
    start = np.empty((most * 8 + seeds.shape[0], 6))
    head, tail, count = 0, 0, 0
    determinant = axes[0, 0] * axes[1, 1] - axes[0, 1] * axes[1, 0]
    for m in range(seeds.shape[0]):
        dx, dy = seeds[m, 0] - origin[0], seeds[m, 1] - origin[1]
        i = int(np.round((dx * axes[1, 1] - dy * axes[1, 0]) / determinant))
        j = int(np.round((dy * axes[0, 0] - dx * axes[0, 1]) / determinant))
        if abs(i) > REACH or abs(j) > REACH or visited[i + REACH, j + REACH]:
            continue
        visited[i + REACH, j + REACH] = True
        queue[tail, 0], queue[tail, 1] = i, j
        start[tail] = seeds[m]
        tail += 1
    moves = np.zeros((1, 6), dtype=np.bool_)
    moves[0, 2:] = free[2:]
    kinds = np.array([family])
    atom = np.empty((1, 6))
    predicted, hessian = np.empty(len(readings)), np.empty((6, 6))
    best = np.inf
    while head < tail and count < most:
        i, j = queue[head]
        atom[0] = start[head]
        atom[0, 0] = origin[0] + i * axes[0, 0] + j * axes[1, 0]
        atom[0, 1] = origin[1] + i * axes[0, 1] + j * axes[1, 1]
        head += 1
        if (atom[0, :2] < places[0]).any() or (atom[0, :2] > places[1]).any():
            continue
        cost = refine(
            atom,
            kinds,
            moves,
            readings,
            white,
            taxels,
            tables,
            priors,
            STEPS,
            1e-2,
            predicted,
            hessian,
        )[0]
        if cost > best + DEEP:
            continue
        best = min(best, cost)
        half_log = invert(hessian, moves[0], out_inner[count])
        out_atoms[count] = atom[0]
        out_weight[count] = -cost - half_log
        count += 1
        for di in range(-1, 2):
            for dj in range(-1, 2):
                p, q = i + di, j + dj
                if abs(p) > REACH or abs(q) > REACH or visited[p + REACH, q + REACH]:
                    continue
                visited[p + REACH, q + REACH] = True
                queue[tail, 0], queue[tail, 1] = p, q
                start[tail] = atom[0]
                tail += 1
    return count
