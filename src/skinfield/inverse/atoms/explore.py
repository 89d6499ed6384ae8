"""What a reading leaves open about the place of one contact, compiled.

Between taxels the posterior of a contact is no ellipsoid but a curved valley, along which another
place is made up for by another force and radius. It is walked on a lattice of places: at each,
force and radius (and half-length) are refined and then integrated out by Laplace's approximation,
as in the nested approximations of Rue, Martino and Chopin (2009).
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.refine import Given, cholesky_solve, refine, room

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


class Lattice(NamedTuple):
    """Places at `origin` (2,) plus integers times the rows of `axes` (2, 2), within `places`."""

    axes: Floats
    origin: Floats
    places: Floats


class Found(NamedTuple):
    """Atom at each place (C, 6), covariance of what is refined there (C, 6, 6), ln weight (C,)."""

    atoms: Floats
    inner: Floats
    weight: Floats


class Queue(NamedTuple):
    """Steps (Q, 2) along the axes still to visit, atoms (Q, 6) to start from, and what was seen."""

    steps: Any
    start: Floats
    seen: Any


@njit(cache=True, nogil=True)
def _enqueue(i: int, j: int, atom: Floats, queue: Queue, tail: int) -> int:
    """Put a place at the end, if it is new and near; returns the new end."""
    if abs(i) > REACH or abs(j) > REACH or queue.seen[i + REACH, j + REACH]:
        return tail
    queue.seen[i + REACH, j + REACH] = True
    queue.steps[tail, 0], queue.steps[tail, 1] = i, j
    queue.start[tail] = atom
    return tail + 1


@njit(cache=True, nogil=True)
def _begin(seeds: Floats, lattice: Lattice, queue: Queue) -> int:
    """Put the places nearest to the seeds into the queue; returns its end."""
    axes = lattice.axes
    determinant = axes[0, 0] * axes[1, 1] - axes[0, 1] * axes[1, 0]
    tail = 0
    for m in range(seeds.shape[0]):
        dx, dy = seeds[m, 0] - lattice.origin[0], seeds[m, 1] - lattice.origin[1]
        i = int(np.round((dx * axes[1, 1] - dy * axes[1, 0]) / determinant))
        j = int(np.round((dy * axes[0, 0] - dx * axes[0, 1]) / determinant))
        tail = _enqueue(i, j, seeds[m], queue, tail)
    return tail


@njit(cache=True, nogil=True)
def explore(
    seeds: Floats, family: int, free: Any, lattice: Lattice, given: Given, found: Found
) -> int:
    """Walk over places from the seeds (M, 6) while the cost stays near the least.

    `free` (6,) says what is refined at each place beside it. Writes into `found`, as many places
    as there is room for; returns how many.
    """
    most, side = found.weight.shape[0], 2 * REACH + 1
    size = most * 8 + seeds.shape[0]
    queue = Queue(
        np.empty((size, 2), dtype=np.int64),
        np.empty((size, 6)),
        np.zeros((side, side), dtype=np.bool_),
    )
    head, tail, count = 0, _begin(seeds, lattice, queue), 0
    moves = np.zeros((1, 6), dtype=np.bool_)
    moves[0, 2:] = free[2:]
    kinds, atom = np.array([family]), np.empty((1, 6))
    normal = room(given.taxels.shape[0], 1)
    best = np.inf
    while head < tail and count < most:
        i, j = queue.steps[head]
        atom[0] = queue.start[head]
        atom[0, :2] = lattice.origin + i * lattice.axes[0] + j * lattice.axes[1]
        head += 1
        if (atom[0, :2] < lattice.places[0]).any() or (atom[0, :2] > lattice.places[1]).any():
            continue
        cost = refine(atom, kinds, moves, given, STEPS, 1e-2, normal)[0]
        if cost > best + DEEP:
            continue
        best = min(best, cost)
        found.weight[count] = -cost - invert(normal.hessian, moves[0], found.inner[count])
        found.atoms[count] = atom[0]
        count += 1
        for way in range(9):
            tail = _enqueue(i + way // 3 - 1, j + way % 3 - 1, atom[0], queue, tail)
    return count
