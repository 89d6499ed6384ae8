"""Greedy search for the atoms of a reading: the problem, proposals, and which to take."""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate.ranking import falling_order, first_largest
from skinfield.solve.atoms.dictionary import BallTemplates
from skinfield.solve.atoms.fit_kernel import PARAMETERS, Inputs, predict, refined
from skinfield.solve.atoms.table import BALL, FLAT, RING

ROUND = np.array([True, True, True, True, False, False])
LONG = np.ones(6, dtype=np.bool_)
BURST = 12  # steps of refinement between looks at the clock
SETTLED = 1e-3  # gain in cost of the last step
RARER = (0.0, 1.0, 2.0)  # ln odds of a ball over each family, before any reading
LONGER = 5.0  # ln odds of a round contact over a drawn-out one
LOG_FORCES = np.log(1e4)  # width of what forces may be, on a logarithmic scale


@dataclass(frozen=True, eq=False)
class AtomSet:
    """Atoms and how well they explain a reading.

    Attributes
    ----------
    atoms : (N, 6) array
        See `kernel`.
    family : (N,) int array
    cost : float
        Half the whitened squares of residuals and priors.
    predicted : (L,) array
    hessian : (6 N, 6 N) array
        Of the cost.
    """

    atoms: Floats
    family: NDArray[np.int64]
    cost: float
    predicted: Floats
    hessian: Floats

    def __len__(self) -> int:
        return len(self.atoms)

    @property
    def long(self) -> NDArray[np.bool_]:
        """Which atoms are drawn out."""
        return np.asarray(np.any(self.atoms[:, 4:], axis=1), dtype=np.bool_)

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which parameters move, (N, 6)."""
        return np.where(self.long[:, None], LONG, ROUND)


@dataclass(frozen=True, eq=False)
class FitProblem:
    """One reading and all that is known beside it.

    Attributes
    ----------
    inputs : Inputs
    bank : BallTemplates
    noise : (L,) array
        By which the bank was whitened.
    threshold : float
        Gain in cost that a new contact must bring.
    common : float
        Standard deviation of an offset that all taxels share, before any reading.
    deadline_ns : int or None
    """

    inputs: Inputs
    bank: BallTemplates
    noise: Floats
    threshold: float
    common: float = 0.0
    deadline_ns: int | None = None

    def offset(self, predicted: Floats) -> float:
        """The shared offset that is most probable, if atoms are read as `predicted` (L,)."""
        given = self.inputs
        return given.shared * float(np.square(given.white) @ (given.readings - predicted))

    def left(self, predicted: Floats) -> Floats:
        """Readings without what atoms are read as, and without the shared offset."""
        return self.inputs.readings - predicted - self.offset(predicted)

    @property
    def heard(self) -> int:
        """Taxels that count."""
        return int(np.count_nonzero(self.inputs.white))

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return self.deadline_ns is not None and time.perf_counter_ns() >= self.deadline_ns

    def nothing(self) -> AtomSet:
        """No contact at all."""
        zero = np.zeros(len(self.inputs.readings))
        readings, white, shared = self.inputs.readings, self.inputs.white, self.inputs.shared
        total = float(np.square(white) @ readings)
        cost = 0.5 * (float(np.square(readings * white).sum()) - shared * total**2)
        none = np.empty((0, PARAMETERS))
        return AtomSet(none, np.empty(0, np.int64), cost, zero, np.empty((0, 0)))

    def refined(self, atoms: Floats, family: NDArray[np.int64], iterations: int = 60) -> AtomSet:
        """Atoms moved to the next minimum of the cost, or until the time is up."""
        atoms = np.array(atoms, order="C")
        free = np.where(np.any(atoms[:, 4:], axis=1)[:, None], LONG, ROUND)
        done = 0
        while True:
            made = refined(atoms[None], family[None], free[None], self.inputs, BURST, SETTLED)
            done += int(made.tried[0])
            if made.tried[0] < BURST or done >= iterations or self.late:
                cost, predicted, hessian = float(made.cost[0]), made.predicted[0], made.hessian[0]
                return AtomSet(atoms, family, cost, predicted, hessian)

    def misfit(self, found: AtomSet) -> float:
        """By how many standard deviations the squares of the residuals exceed their number."""
        squares = float(np.square(self.left(found.predicted) * self.inputs.white).sum())
        return (squares - self.heard) / float(np.sqrt(2.0 * self.heard))

    def evidence(self, found: AtomSet) -> float:
        """Logarithm of the marginal likelihood, up to a constant, by Laplace's approximation.

        Places are uniform over the patch, the force's logarithm over `LOG_FORCES`; the other
        priors are those of the cost.
        """
        if not len(found):
            return -found.cost
        free = found.free.ravel()
        sign, size = np.linalg.slogdet(found.hessian[np.ix_(free, free)])
        if sign <= 0:
            return -np.inf
        (low, high), priors = self.inputs.places, self.inputs.priors
        known = -len(found) * float(np.log(np.prod(high - low) * LOG_FORCES))
        for family, long in zip(found.family, found.long, strict=True):
            std = (priors.ball_std, priors.flat_std, priors.ring_std)[family]
            known -= float(np.log(std)) + 0.5 * np.log(2 * np.pi) + RARER[family]
            length = 2 * np.log(priors.length_std) + np.log(2 * np.pi)
            known -= (float(length) + LONGER) * float(long)
        laplace = 0.5 * float(free.sum()) * np.log(2 * np.pi) - 0.5 * size
        return float(-found.cost + known + laplace)

    def alone(self, found: AtomSet, which: NDArray[np.bool_]) -> Floats:
        """What some of the atoms are read as, (L,)."""
        out = np.zeros(len(self.inputs.readings))
        if which.any():
            atoms, given = found.atoms[which], self.inputs
            jacobian = np.empty((len(out), len(atoms), PARAMETERS))
            predict(atoms, found.family[which], given.taxels, given.tables, out, jacobian)
        return out


OFF_LATTICE = 2.0  # how much more than the best template an atom between the templates may gain
LENGTHS = (1.2, 3.0)  # half-lengths from which a drawn-out contact is sought, in thicknesses
ANGLES = 4
RINGS = (1.0, 1.8, 2.8)  # radii from which a ring is sought, in thicknesses
TRIED = 2  # of the places for a new atom: these are refined together with the others


def one_more(problem: FitProblem, found: AtomSet, starts: int) -> AtomSet | None:
    """The best set with one more ball, or None where none could bring enough."""
    left = problem.inputs.readings - found.predicted
    least = float(np.sqrt(2.0 * problem.threshold / OFF_LATTICE))
    seeds = problem.bank.starts(problem.left(found.predicted) / problem.noise, starts, least)
    if not len(seeds):
        return None
    costs = settle(problem, left, seeds, BALL, ROUND)
    best = None
    for index in falling_order((-costs).tolist(), range(len(costs)))[:TRIED]:
        atoms = np.concatenate([found.atoms, seeds[index : index + 1]])
        new = problem.refined(atoms, np.append(found.family, BALL))
        if best is None or new.cost < best.cost:
            best = new
        if problem.late:
            break
    return best


def settle(
    problem: FitProblem, left: Floats, seeds: Floats, family: int, free: NDArray[np.bool_]
) -> Floats:
    """Refine each of the seeds (S, 6) alone, in place, on what is left to explain; costs (S,)."""
    given = problem.inputs._replace(readings=left)
    kinds = np.full((len(seeds), 1), family)
    moves = np.tile(free, (len(seeds), 1, 1))
    return refined(seeds[:, None], kinds, moves, given, BURST, SETTLED).cost


def without(problem: FitProblem, found: AtomSet, index: int) -> AtomSet:
    """The set without one of its atoms, the others moved to where they then belong."""
    keep = np.arange(len(found)) != index
    if not keep.any():
        return problem.nothing()
    return problem.refined(found.atoms[keep], found.family[keep])


def as_family(
    problem: FitProblem, found: AtomSet, index: int, family: int, *, is_round: bool = False
) -> AtomSet:
    """The set with one atom of another family, as long as it was or round."""
    atoms, kinds = found.atoms.copy(), found.family.copy()
    kinds[index] = family
    if is_round:
        atoms[index, 4:] = 0.0
    return problem.refined(atoms, kinds)


def as_line(problem: FitProblem, found: AtomSet, members: list[int], family: int) -> AtomSet:
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


def as_ring(problem: FitProblem, found: AtomSet, members: list[int]) -> AtomSet:
    """The set with one ring in the place of some atoms."""
    seeds = np.repeat(_middle(found, members)[None], len(RINGS), axis=0)
    seeds[:, 3], seeds[:, 4:] = np.log(RINGS), 0.0
    return _instead(problem, found, members, seeds, RING, ROUND)


def split(problem: FitProblem, found: AtomSet, index: int) -> AtomSet:
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
    problem: FitProblem,
    found: AtomSet,
    members: list[int],
    seeds: Floats,
    family: int,
    free: NDArray[np.bool_],
) -> AtomSet:
    """The set with the best of some seeds in the place of some atoms."""
    others = ~np.isin(np.arange(len(found)), members)
    left = problem.inputs.readings - problem.alone(found, others)
    best = seeds[first_largest(-settle(problem, left, seeds, family, free))]
    atoms = np.concatenate([found.atoms[others], best[None]])
    return problem.refined(atoms, np.append(found.family[others], family))


ODD = 1.0  # standard deviations of chi-squared, above which other shapes are tried
GAP = 3.5  # thicknesses between the rims of atoms that may be one body


def search(
    problem: FitProblem, start: AtomSet | None, most: int, starts: int, shapes: bool = True
) -> AtomSet:
    """Grow, prune and reshape a set of atoms while that pays.

    Parameters
    ----------
    problem : FitProblem
    start : AtomSet, optional
        Of the reading before.
    most : int
        Atoms.
    starts : int
        Places from which each new atom is sought.
    shapes : bool
        Whether to look at the shapes again where `start` explains the reading as it is.
    """
    found, grew = problem.nothing(), False
    if start is not None and len(start):
        found = pruned(problem, problem.refined(start.atoms, start.family, BURST))
    while not problem.late and len(found) < most:
        better = grown(problem, found, starts)
        if better is None:
            break
        found, grew = better, True
    if grew:
        found = pruned(problem, found)
    changed = start is None or grew or len(found) != len(start)
    return reshaped(problem, found) if shapes or changed else found


def grown(problem: FitProblem, found: AtomSet, starts: int) -> AtomSet | None:
    """One more ball, or one atom of another shape, whichever is more probable; None if not."""
    more = one_more(problem, found, starts)
    if more is None or found.cost - more.cost < problem.threshold:
        return None
    best, evidence = more, problem.evidence(more)
    for index in np.flatnonzero(~found.long & (found.family != RING)).tolist():
        for other in _bodies(problem, found, [index]):
            value = problem.evidence(other)
            if value > evidence:
                best, evidence = other, value
    return best


def _bodies(problem: FitProblem, found: AtomSet, members: list[int]) -> Iterator[AtomSet]:
    """The set with one body that is not round in the place of some atoms."""
    if not problem.late:
        yield as_line(problem, found, members, BALL)
    if not problem.late:
        yield as_line(problem, found, members, FLAT)
    if not problem.late:
        yield as_ring(problem, found, members)


def pruned(problem: FitProblem, found: AtomSet) -> AtomSet:
    """Without the atoms that the reading does not need."""
    index = 0
    while index < len(found) and not problem.late:
        less = without(problem, found, index)
        if less.cost - found.cost < problem.threshold:
            found, index = less, 0
        else:
            index += 1
    return found


def reshaped(problem: FitProblem, found: AtomSet) -> AtomSet:
    """Each atom in the most probable shape, and neighbours as one body where that is more so."""
    if not len(found):
        return found
    evidence = problem.evidence(found)
    for index in range(len(found)):
        for other in _alternatives(problem, found, index):
            value = problem.evidence(other)
            if value > evidence:
                found, evidence = other, value
    for members in clusters(found, GAP):
        if len(members) < 2:
            continue
        for other in _bodies(problem, found, members):
            value = problem.evidence(other)
            if value > evidence:
                return reshaped(problem, other)
    return found


def _alternatives(problem: FitProblem, found: AtomSet, index: int) -> Iterator[AtomSet]:
    """The set with one atom of the other family, round, or as two."""
    if problem.late or index >= len(found):
        return
    if found.family[index] != RING:
        yield as_family(problem, found, index, BALL + FLAT - int(found.family[index]))
        if not found.long[index] and problem.misfit(found) > ODD:
            yield from _bodies(problem, found, [index])
        if not found.long[index] or problem.late:
            return
    yield as_family(problem, found, index, BALL, is_round=True)
    yield as_family(problem, found, index, FLAT, is_round=True)
    if found.long[index]:
        yield split(problem, found, index)
