"""The smallest set of atoms that explains a reading, found greedily."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse.atoms.bank import Bank
from skinfield.inverse.atoms.kernel import PARAMETERS, Tables
from skinfield.inverse.atoms.refine import Priors, refine, refine_each

ROUND = np.array([True, True, True, True, False, False])
LONG = np.ones(6, dtype=np.bool_)
BURST = 12  # steps of refinement between looks at the clock
SETTLED = 1e-3  # gain in cost of the last step
LENGTHS = (1.2, 3.0)  # half-lengths from which a drawn-out contact is sought, in thicknesses
ANGLES = 4
RARER = 1.0  # in ln odds: a flat end, and a drawn-out contact, before any reading
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
class Problem:
    """One reading and all that is known beside it.

    Attributes
    ----------
    readings : (L,) array
    white : (L,) array
        One over the standard deviation of noise and model together.
    taxels : (L, 2) array, thicknesses
    tables : Tables
    priors : Priors
    bank : Bank
    noise : (L,) array
        By which the bank was whitened.
    places : (2, 2) array, thicknesses
        Lowest and highest x and y that contacts may have.
    threshold : float
        Gain in cost that a new contact must bring.
    deadline_ns : int or None
    """

    readings: Floats
    white: Floats
    taxels: Floats
    tables: Tables
    priors: Priors
    bank: Bank
    noise: Floats
    places: Floats
    threshold: float
    deadline_ns: int | None = None

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return self.deadline_ns is not None and time.perf_counter_ns() >= self.deadline_ns

    def nothing(self) -> AtomSet:
        """No contact at all."""
        size = len(self.readings)
        cost = 0.5 * float(np.square(self.readings * self.white).sum())
        none = np.empty((0, PARAMETERS))
        return AtomSet(none, np.empty(0, np.int64), cost, np.zeros(size), np.empty((0, 0)))

    def refined(self, atoms: Floats, family: NDArray[np.int64], iterations: int = 60) -> AtomSet:
        """Atoms moved to the next minimum of the cost, or until the time is up."""
        atoms = np.array(atoms, order="C")
        free = np.where(np.any(atoms[:, 4:], axis=1)[:, None], LONG, ROUND)
        size = PARAMETERS * len(atoms)
        predicted, hessian = np.empty(len(self.readings)), np.empty((size, size))
        done = 0
        while True:
            cost, tried = refine(
                atoms,
                family,
                free,
                self.readings,
                self.white,
                self.taxels,
                self.tables,
                self.priors,
                BURST,
                SETTLED,
                predicted,
                hessian,
            )
            done += tried
            if tried < BURST or done >= iterations or self.late:
                return AtomSet(atoms, family, float(cost), predicted, hessian)

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
        known = -len(found) * float(np.log(np.prod(self.places[1] - self.places[0]) * LOG_FORCES))
        for family, long in zip(found.family, found.long, strict=True):
            std = self.priors.ball_std if family == 0 else self.priors.flat_std
            known -= float(np.log(std)) + 0.5 * np.log(2 * np.pi) + RARER * float(family + long)
            known -= (2 * np.log(self.priors.length_std) + np.log(2 * np.pi)) * float(long)
        laplace = 0.5 * float(free.sum()) * np.log(2 * np.pi) - 0.5 * size
        return float(-found.cost + known + laplace)

    def with_one_more(self, found: AtomSet, starts: int) -> AtomSet | None:
        """The best set with one more ball, or None where there is no place for it."""
        residual = (self.readings - found.predicted) * self.noise_white
        seeds = self.bank.starts(residual, starts)
        if not len(seeds):
            return None
        left = self.readings - found.predicted
        costs = refine_each(
            seeds,
            np.zeros(len(seeds), np.int64),
            ROUND,
            left,
            self.white,
            self.taxels,
            self.tables,
            self.priors,
            BURST,
            SETTLED,
            np.empty((len(seeds), PARAMETERS, PARAMETERS)),
        )
        best = None
        for index in np.argsort(costs)[:2]:
            atoms = np.concatenate([found.atoms, seeds[index : index + 1]])
            family = np.append(found.family, 0)
            new = self.refined(atoms, family)
            if best is None or new.cost < best.cost:
                best = new
            if self.late:
                break
        return best

    @property
    def noise_white(self) -> Floats:
        """One over the noise by which the bank is whitened."""
        return 1.0 / self.noise

    def without(self, found: AtomSet, index: int) -> AtomSet:
        """The set without one of its atoms, the others moved to where they then belong."""
        keep = np.arange(len(found)) != index
        if not keep.any():
            return self.nothing()
        return self.refined(found.atoms[keep], found.family[keep])

    def reshaped(self, found: AtomSet, index: int, family: int, long: bool) -> AtomSet:
        """The set with one atom of another shape."""
        kinds = found.family.copy()
        kinds[index] = family
        if not long:
            atoms = found.atoms.copy()
            atoms[index, 4:] = 0.0
            return self.refined(atoms, kinds)
        others = np.arange(len(found)) != index
        left = self.readings - self.alone(found, others)
        seeds = []
        for length in LENGTHS:
            for angle in np.arange(ANGLES) * np.pi / ANGLES:
                atom = found.atoms[index].copy()
                atom[4:] = length * np.cos(angle), length * np.sin(angle)
                atom[3] = min(atom[3], 0.0)
                seeds.append(atom)
        table = np.array(seeds)
        costs = refine_each(
            table,
            np.full(len(table), family),
            LONG,
            left,
            self.white,
            self.taxels,
            self.tables,
            self.priors,
            BURST,
            SETTLED,
            np.empty((len(table), PARAMETERS, PARAMETERS)),
        )
        atoms = found.atoms.copy()
        atoms[index] = table[np.argmin(costs)]
        return self.refined(atoms, kinds)

    def split(self, found: AtomSet, index: int) -> AtomSet:
        """The set with two balls in the place of a long atom."""
        pair = np.repeat(found.atoms[index : index + 1], 2, axis=0)
        pair[:, :2] += np.array([[0.7], [-0.7]]) * pair[:, 4:]
        pair[:, 2] -= np.log(2.0)
        pair[:, 4:] = 0.0
        others = np.arange(len(found)) != index
        atoms = np.concatenate([found.atoms[others], pair])
        return self.refined(atoms, np.append(found.family[others], [0, 0]))

    def alone(self, found: AtomSet, which: NDArray[np.bool_]) -> Floats:
        """What some of the atoms are read as, (L,)."""
        from skinfield.inverse.atoms.kernel import predict

        out = np.zeros(len(self.readings))
        if which.any():
            jacobian = np.empty((len(out), int(which.sum()), PARAMETERS))
            predict(
                found.atoms[which], found.family[which], self.taxels, self.tables, out, jacobian
            )
        return out


def search(problem: Problem, start: AtomSet | None, most: int, starts: int) -> AtomSet:
    """Grow, reshape and prune a set of atoms while that pays.

    Parameters
    ----------
    problem : Problem
    start : AtomSet, optional
        Of the reading before.
    most : int
        Atoms.
    starts : int
        Places from which each new atom is sought.
    """
    found = problem.nothing()
    if start is not None and len(start):
        found = pruned(problem, problem.refined(start.atoms, start.family, BURST))
    while not problem.late and len(found) < most:
        better = grown(problem, found, starts)
        if better is None:
            break
        found = better
    found = pruned(problem, found)
    return reshaped(problem, found)


def grown(problem: Problem, found: AtomSet, starts: int) -> AtomSet | None:
    """One more ball, or one atom drawn out, whichever is more probable; None if neither pays."""
    more = problem.with_one_more(found, starts)
    if more is None or found.cost - more.cost < problem.threshold:
        return None
    best, evidence = more, problem.evidence(more)
    for index in np.flatnonzero(~found.long):
        if problem.late:
            break
        for family in (0, 1):
            long = problem.reshaped(found, int(index), family, True)
            value = problem.evidence(long)
            if value > evidence:
                best, evidence = long, value
    return best


def pruned(problem: Problem, found: AtomSet) -> AtomSet:
    """Without the atoms that the reading does not need."""
    index = 0
    while index < len(found) and not problem.late:
        less = problem.without(found, index)
        if less.cost - found.cost < problem.threshold:
            found, index = less, 0
        else:
            index += 1
    return found


def reshaped(problem: Problem, found: AtomSet) -> AtomSet:
    """Each atom in the shape that is most probable."""
    if not len(found):
        return found
    evidence = problem.evidence(found)
    index = 0
    while index < len(found):
        for other in alternatives(problem, found, index):
            value = problem.evidence(other)
            if value > evidence:
                found, evidence = other, value
        index += 1
    return found


def alternatives(problem: Problem, found: AtomSet, index: int) -> Iterator[AtomSet]:
    """The set with one atom of the other family, round, or as two."""
    long = bool(found.long[index])
    if problem.late:
        return
    yield problem.reshaped(found, index, 1 - int(found.family[index]), long)
    if long and not problem.late:
        yield problem.reshaped(found, index, 0, False)
        yield problem.reshaped(found, index, 1, False)
        yield problem.split(found, index)


def copied(found: AtomSet) -> AtomSet:
    """A set whose atoms may be moved in place."""
    return replace(found, atoms=found.atoms.copy(), family=found.family.copy())
