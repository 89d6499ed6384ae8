"""From one set of atoms to another that may explain a reading better."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse.atoms.problem import BURST, LONG, ROUND, SETTLED, AtomSet, Problem
from skinfield.inverse.atoms.profiles import BALL, RING
from skinfield.inverse.atoms.refine import refined

OFF_LATTICE = 2.0  # how much more than the best template an atom between the templates may gain
LENGTHS = (1.2, 3.0)  # half-lengths from which a drawn-out contact is sought, in thicknesses
ANGLES = 4
RINGS = (1.0, 1.8, 2.8)  # radii from which a ring is sought, in thicknesses
TRIED = 2  # of the places for a new atom: these are refined together with the others


def one_more(problem: Problem, found: AtomSet, starts: int) -> AtomSet | None:
    """The best set with one more ball, or None where none could bring enough."""
    left = problem.readings - found.predicted
    least = float(np.sqrt(2.0 * problem.threshold / OFF_LATTICE))
    seeds = problem.bank.starts(problem.left(found.predicted) / problem.noise, starts, least)
    if not len(seeds):
        return None
    costs = settle(problem, left, seeds, BALL, ROUND)
    best = None
    for index in np.argsort(costs)[:TRIED]:
        atoms = np.concatenate([found.atoms, seeds[index : index + 1]])
        new = problem.refined(atoms, np.append(found.family, BALL))
        if best is None or new.cost < best.cost:
            best = new
        if problem.late:
            break
    return best


def settle(
    problem: Problem, left: Floats, seeds: Floats, family: int, free: NDArray[np.bool_]
) -> Floats:
    """Refine each of the seeds (S, 6) alone, in place, on what is left to explain; costs (S,)."""
    given = problem.given._replace(readings=left)
    kinds = np.full((len(seeds), 1), family)
    moves = np.tile(free, (len(seeds), 1, 1))
    return refined(seeds[:, None], kinds, moves, given, BURST, SETTLED).cost


def without(problem: Problem, found: AtomSet, index: int) -> AtomSet:
    """The set without one of its atoms, the others moved to where they then belong."""
    keep = np.arange(len(found)) != index
    if not keep.any():
        return problem.nothing()
    return problem.refined(found.atoms[keep], found.family[keep])


def as_round(problem: Problem, found: AtomSet, index: int, family: int) -> AtomSet:
    """The set with one atom round, and of a family."""
    atoms, kinds = found.atoms.copy(), found.family.copy()
    atoms[index, 4:], kinds[index] = 0.0, family
    return problem.refined(atoms, kinds)


def as_family(problem: Problem, found: AtomSet, index: int, family: int) -> AtomSet:
    """The set with one atom of another family, as long as it was."""
    kinds = found.family.copy()
    kinds[index] = family
    return problem.refined(found.atoms, kinds)


def as_line(problem: Problem, found: AtomSet, members: list[int], family: int) -> AtomSet:
    """The set with one drawn-out atom in the place of some."""
    middle = _middle(found, members)
    seeds = []
    for length in LENGTHS:
        for angle in np.arange(ANGLES) * np.pi / ANGLES:
            seed = middle.copy()
            seed[3] = min(seed[3], 0.0)
            seed[4:] = length * np.cos(angle), length * np.sin(angle)
            seeds.append(seed)
    return _instead(problem, found, members, np.array(seeds), family, LONG)


def as_ring(problem: Problem, found: AtomSet, members: list[int]) -> AtomSet:
    """The set with one ring in the place of some atoms."""
    seeds = np.repeat(_middle(found, members)[None], len(RINGS), axis=0)
    seeds[:, 3], seeds[:, 4:] = np.log(RINGS), 0.0
    return _instead(problem, found, members, seeds, RING, ROUND)


def split(problem: Problem, found: AtomSet, index: int) -> AtomSet:
    """The set with two balls in the place of a long atom."""
    pair = np.repeat(found.atoms[index : index + 1], 2, axis=0)
    pair[:, :2] += np.array([[0.7], [-0.7]]) * pair[:, 4:]
    pair[:, 2] -= np.log(2.0)
    pair[:, 4:] = 0.0
    others = np.arange(len(found)) != index
    atoms = np.concatenate([found.atoms[others], pair])
    return problem.refined(atoms, np.append(found.family[others], [BALL, BALL]))


def clusters(found: AtomSet, gap: float) -> list[list[int]]:
    """Rows of atoms whose rims are no farther apart than `gap`, directly or through others."""
    half = np.hypot(found.atoms[:, 4], found.atoms[:, 5])
    reach = np.exp(found.atoms[:, 3]) + half
    owner = np.arange(len(found))
    for i in range(len(found)):
        for j in range(i):
            apart = float(np.hypot(*(found.atoms[i, :2] - found.atoms[j, :2])))
            if apart < reach[i] + reach[j] + gap:
                owner[owner == owner[i]] = owner[j]
    return [np.flatnonzero(owner == name).tolist() for name in np.unique(owner)]


def _middle(found: AtomSet, members: list[int]) -> Floats:
    """One atom with the force of some, amid them."""
    part = found.atoms[members]
    force = np.exp(part[:, 2])
    middle = np.asarray(force @ part / force.sum())
    middle[2] = np.log(force.sum())
    return middle


def _instead(
    problem: Problem,
    found: AtomSet,
    members: list[int],
    seeds: Floats,
    family: int,
    free: NDArray[np.bool_],
) -> AtomSet:
    """The set with the best of some seeds in the place of some atoms."""
    others = ~np.isin(np.arange(len(found)), members)
    left = problem.readings - problem.alone(found, others)
    best = seeds[np.argmin(settle(problem, left, seeds, family, free))]
    atoms = np.concatenate([found.atoms[others], best[None]])
    return problem.refined(atoms, np.append(found.family[others], family))
