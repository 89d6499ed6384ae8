"""Posterior of atoms: covariance by exploring what fits about as well.

Between taxels the posterior of a contact is no ellipsoid but a curved valley, along which another
place is made up for by another force and radius. It is walked on a lattice of places: at each,
force and radius (and half-length) are refined and then integrated out by Laplace's approximation,
as in the nested approximations of Rue, Martino and Chopin (2009).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.solve.atoms.fit_kernel import PARAMETERS, Inputs, refined
from skinfield.solve.atoms.search import RARER, AtomSet, FitProblem
from skinfield.solve.atoms.table import BALL, FLAT, RING

REACH = 14  # steps of the lattice each way
STEPS = 4  # of refinement at each place
SETTLED = 1e-2  # gain in cost of the last of them
DEEP = 6.0  # in cost: places that are worse than the best by more do not count
ROUND_OFF = 1e-9, 1e-12  # of a Hessian's diagonal, and beside it: what is added so that it inverts


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


SHORTEST, LONGEST = 0.004, 0.35  # thicknesses between them
LEAST = 1e-6  # of all weights: a family with less has no radius of its own
CERTAIN = 0.05  # thicknesses: deviation of the place up to which the minimum's curvature tells all
SURE = 0.15  # thicknesses: deviation up to which other minima are not looked for
AROUND = 3.0  # thicknesses beyond what the atom reaches, within which taxels count


@dataclass(frozen=True, eq=False)
class Belief:
    """Weighted places of one contact, with what would press there.

    Attributes
    ----------
    atoms : (C, 6) array
        See `kernel`.
    family : (C,) int array
    inner : (C, 6, 6) array
        Covariance of the parameters beside the place, at each place.
    weights : (C,) array
        Of sum 1.
    """

    atoms: Floats
    family: NDArray[np.int64]
    inner: Floats
    weights: Floats

    def mean(self, family: int) -> Floats:
        """Of all parameters, (6,): of place and ln force whatever presses, else if it is a family.

        A ball and a flat end that are read alike have another radius.
        """
        mean = self.weights @ self.atoms
        same = self.family == family
        share = float(self.weights[same].sum())
        if share > LEAST:
            mean[3:] = self.weights[same] @ self.atoms[same, 3:] / share
        return np.asarray(mean)

    @property
    def covariance(self) -> Floats:
        """Of all parameters, (6, 6)."""
        off = self.atoms - self.weights @ self.atoms
        spread = (off * self.weights[:, None]).T @ off
        return np.asarray(spread + np.einsum("c,cij->ij", self.weights, self.inner))


def stated(atom: Floats, covariance: Floats, thickness: float) -> tuple[Floats, Floats]:
    """An atom and its covariance as x m, y m, force N, radius m, half-length m and angle rad."""
    half, angle = float(np.hypot(atom[4], atom[5])), float(np.arctan2(atom[5], atom[4]))
    force, radius = float(np.exp(atom[2])), float(np.exp(atom[3])) * thickness
    by = np.zeros((PARAMETERS, PARAMETERS))
    by[0, 0] = by[1, 1] = thickness
    by[2, 2], by[3, 3] = force, radius
    if half > 0.0:
        along, across = np.cos(angle), np.sin(angle)
        by[4, 4], by[4, 5] = thickness * along, thickness * across
        by[5, 4], by[5, 5] = -across / half, along / half
    place = atom[:2] * thickness
    return np.array([*place, force, radius, half * thickness, angle]), by @ covariance @ by.T


def laplace(problem: FitProblem, found: AtomSet, index: int) -> Belief:
    """One atom by the curvature of the cost at its minimum, all others moving along.

    Places that no reading tells are even over the patch: their variance is its width squared / 12.
    """
    free = found.free.ravel()
    hessian = found.hessian.copy()
    width = problem.inputs.places[1] - problem.inputs.places[0]
    for axis in (0, 1):
        rows = np.arange(len(found)) * PARAMETERS + axis
        hessian[rows, rows] += 12.0 / width[axis] ** 2
    whole = np.zeros((free.size, free.size))
    part = hessian[np.ix_(free, free)]
    try:
        whole[np.ix_(free, free)] = np.linalg.inv(part)
    except np.linalg.LinAlgError:  # something moves no reading and has no prior
        whole[np.ix_(free, free)] = np.linalg.pinv(part)
    own = slice(PARAMETERS * index, PARAMETERS * (index + 1))
    one = slice(index, index + 1)
    return Belief(found.atoms[one], found.family[one], whole[own, own][None], np.ones(1))


def belief_of(
    problem: FitProblem, found: AtomSet, index: int, places: int, starts: int, step: float
) -> Belief:
    """What the reading leaves open about one atom, the others being where they are.

    At most so many `places` are tried for each family, `step` standard deviations apart. Further
    minima are sought from so many `starts`; with 0 of them the other family is not tried, either.
    """
    own, free, family = found.atoms[index], found.free[index], int(found.family[index])
    first = laplace(problem, found, index)
    variance, direction = np.linalg.eigh(first.inner[0, :2, :2])
    widest = float(np.sqrt(max(variance[1], 0.0)))
    if widest < CERTAIN or problem.late:
        return first
    length = np.clip(step * np.sqrt(np.maximum(variance, 0.0)), SHORTEST, LONGEST)
    axes = np.ascontiguousarray((direction * length).T)
    others = np.arange(len(found)) != index
    offset = problem.offset(found.predicted)
    left = problem.inputs.readings - problem.alone(found, others) - offset
    seeds = own[None]
    if not free[4] and family != RING and starts and widest > SURE:
        seeds = np.concatenate([seeds, problem.bank.starts(left / problem.noise, starts)])
    kinds = (BALL, FLAT) if starts and family != RING else (family,)
    walks = [explore(problem, seeds, kind, free, axes, left, places) for kind in kinds]
    atoms, inner, log_weight = (np.concatenate(each) for each in zip(*walks, strict=True))
    families = np.repeat(kinds, [len(walk[2]) for walk in walks])
    if not len(atoms):
        return first
    weight = np.exp(log_weight - log_weight.max())
    return Belief(atoms, families, inner, weight / weight.sum())


def _near(given: Inputs, own: Floats) -> NDArray[np.int64]:
    """Taxels that an atom may be read by, wherever the walk takes it."""
    tables = given.tables
    reach = np.exp(own[3]) + np.hypot(own[4], own[5]) + tables.pad_radius + tables.sight + AROUND
    square = np.square(given.taxels - own[:2]).sum(axis=1)
    return np.flatnonzero(square <= reach**2)


def explore(
    problem: FitProblem,
    seeds: Floats,
    family: int,
    free: NDArray[np.bool_],
    axes: Floats,
    left: Floats,
    most: int,
) -> tuple[Floats, Floats, Floats]:
    """Walk over places from the seeds (M, 6) while the cost stays near the least.

    Parameters
    ----------
    seeds : (M, 6) array
        The first is where the lattice of places has its origin.
    family : int
        Of the atom.
    free : (6,) bool array
        What is refined at each place beside it.
    axes : (2, 2) array
        Steps of the lattice.
    left : (L,) array
        Readings that other atoms leave to explain.
    most : int
        Places that are looked at.

    Returns
    -------
    atoms : (C, 6) array
        At each place.
    inner : (C, 6, 6) array
        Covariance of what is refined there.
    weight : (C,) array
        Logarithm.
    """
    near, given = _near(problem.inputs, seeds[0]), problem.inputs
    white, taxels = given.white[near], given.taxels[near]
    given = given._replace(readings=left[near], white=white, taxels=taxels, shared=0.0)
    origin, (low, high) = seeds[0, :2], given.places
    moves = np.zeros((1, 1, 6), dtype=np.bool_)
    moves[..., 2:] = free[2:]
    waiting: list[tuple[int, int, Floats]] = []
    best, put = np.inf, set[tuple[int, int]]()

    def visit(i: int, j: int, atom: Floats) -> None:
        """Put a place at the end, with the atom to start from, if it is new and near."""
        if abs(i) <= REACH and abs(j) <= REACH and (i, j) not in put:
            put.add((i, j))
            waiting.append((i, j, atom))

    steps = np.linalg.solve(axes.T, (seeds[:, :2] - origin).T).T
    for seed, (i, j) in zip(seeds, np.round(steps).astype(int).tolist(), strict=True):
        visit(i, j, seed)
    atoms: list[Floats] = []
    hessians: list[Floats] = []
    costs: list[float] = []
    while waiting and len(costs) < most:
        wave, waiting[:] = waiting[: most - len(costs)], waiting[most - len(costs) :]
        start, steps = np.array([atom for _, _, atom in wave]), np.array([at[:2] for at in wave])
        start[:, :2] = origin + steps[:, :1] * axes[0] + steps[:, 1:] * axes[1]
        on = np.flatnonzero(((start[:, :2] >= low) & (start[:, :2] <= high)).all(axis=1))
        start, kinds = start[on], np.full((len(on), 1), family)
        every = np.repeat(moves, len(on), axis=0)
        made = refined(start[:, None], kinds, every, given, STEPS, SETTLED)
        for n, (i, j) in enumerate(steps[on].tolist()):
            cost = float(made.cost[n])
            if cost > best + DEEP:
                continue
            best = min(best, cost)
            atoms.append(start[n])
            costs.append(cost)
            hessians.append(made.hessian[n])
            for way in range(9):
                visit(i + way // 3 - 1, j + way % 3 - 1, start[n])
    inner, half = inverses(np.array(hessians).reshape(-1, 6, 6), free)
    return np.array(atoms).reshape(-1, 6), inner, -np.array(costs) - half - RARER[family]
