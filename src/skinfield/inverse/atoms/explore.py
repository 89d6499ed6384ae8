"""What a reading leaves open about the place of one contact.

Between taxels the posterior of a contact is no ellipsoid but a curved valley, along which another
place is made up for by another force and radius. It is walked on a lattice of places: at each,
force and radius (and half-length) are refined and then integrated out by Laplace's approximation,
as in the nested approximations of Rue, Martino and Chopin (2009).
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse.atoms.cost import Given
from skinfield.inverse.atoms.refine import refined

REACH = 14  # steps of the lattice each way
STEPS = 4  # of refinement at each place
SETTLED = 1e-2  # gain in cost of the last of them
DEEP = 6.0  # in cost: places that are worse than the best by more do not count
ROUND_OFF = 1e-9, 1e-12  # of a Hessian's diagonal, and beside it: what is added so that it inverts


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


class Queue:
    """Steps along the axes still to visit, each with the atom to start from; none twice."""

    def __init__(self) -> None:
        self.waiting: list[tuple[int, int, Floats]] = []
        self._seen: set[tuple[int, int]] = set()

    def put(self, i: int, j: int, atom: Floats) -> None:
        """Put a place at the end, if it is new and near."""
        if abs(i) <= REACH and abs(j) <= REACH and (i, j) not in self._seen:
            self._seen.add((i, j))
            self.waiting.append((i, j, atom))

    def take(self, most: int) -> list[tuple[int, int, Floats]]:
        """The first of them."""
        first, self.waiting = self.waiting[:most], self.waiting[most:]
        return first


def explore(
    seeds: Floats, family: int, free: NDArray[np.bool_], lattice: Lattice, given: Given, most: int
) -> Found:
    """Walk over places from the seeds (M, 6) while the cost stays near the least.

    `free` (6,) says what is refined at each place beside it; `most` places are found at most.
    """
    queue, best = Queue(), np.inf
    for seed, (i, j) in zip(seeds, _steps(seeds, lattice), strict=True):
        queue.put(int(i), int(j), seed)
    atoms: list[Floats] = []
    hessians: list[Floats] = []
    costs: list[float] = []
    while queue.waiting and len(costs) < most:
        for i, j, atom, cost, hessian in _wave(
            queue.take(most - len(costs)), family, free, lattice, given
        ):
            if cost > best + DEEP:
                continue
            best = min(best, cost)
            atoms.append(atom)
            costs.append(cost)
            hessians.append(hessian)
            for way in range(9):
                queue.put(i + way // 3 - 1, j + way % 3 - 1, atom)
    inner, half = inverses(np.array(hessians).reshape(-1, 6, 6), free)
    return Found(np.array(atoms).reshape(-1, 6), inner, -np.array(costs) - half)


def _steps(seeds: Floats, lattice: Lattice) -> Floats:
    """Of the places nearest to seeds (M, 6), (M, 2)."""
    return np.round(np.linalg.solve(lattice.axes.T, (seeds[:, :2] - lattice.origin).T).T)


def _wave(
    places: list[tuple[int, int, Floats]],
    family: int,
    free: NDArray[np.bool_],
    lattice: Lattice,
    given: Given,
) -> Iterator[tuple[int, int, Floats, float, Floats]]:
    """Steps, refined atom, cost and its Hessian of each place that lies on the patch."""
    atoms = np.array([atom for _, _, atom in places])
    steps = np.array([(i, j) for i, j, _ in places])
    atoms[:, :2] = lattice.origin + steps[:, :1] * lattice.axes[0] + steps[:, 1:] * lattice.axes[1]
    low, high = lattice.places
    on = np.flatnonzero(((atoms[:, :2] >= low) & (atoms[:, :2] <= high)).all(axis=1))
    atoms = atoms[on]
    moves = np.zeros((len(on), 1, 6), dtype=np.bool_)
    moves[:, 0, 2:] = free[2:]
    kinds = np.full((len(on), 1), family)
    made = refined(atoms[:, None], kinds, moves, given, STEPS, SETTLED)
    for n, (i, j) in enumerate(steps[on].tolist()):
        yield i, j, atoms[n], float(made.cost[n]), made.hessian[n]


def inverses(hessians: Floats, free: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Inverses (C, 6, 6) over what is free beside the place, else 0.

    And half the logarithm of the determinants (C,), infinite where one is not positive.
    """
    index = np.flatnonzero(free[2:]) + 2
    rows = np.ix_(np.arange(len(hessians)), index, index)
    part = hessians[rows]
    diagonal = np.arange(len(index))
    part[:, diagonal, diagonal] *= 1.0 + ROUND_OFF[0]
    part[:, diagonal, diagonal] += ROUND_OFF[1]
    sign, size = np.linalg.slogdet(part)
    part[sign <= 0.0] = np.eye(len(index))
    out = np.zeros_like(hessians)
    out[rows] = np.linalg.inv(part)
    return out, np.where(sign > 0.0, 0.5 * size, np.inf)
