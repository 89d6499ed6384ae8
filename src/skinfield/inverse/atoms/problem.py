"""One reading, a set of atoms, and how well they explain it."""

import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse.atoms.bank import Bank
from skinfield.inverse.atoms.cost import Given, Priors
from skinfield.inverse.atoms.kernel import PARAMETERS, Tables, predict
from skinfield.inverse.atoms.refine import refined

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
    common : float
        Standard deviation of an offset that all taxels share, before any reading.
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
    common: float = 0.0
    deadline_ns: int | None = None

    @cached_property
    def given(self) -> Given:
        """As compiled functions take it."""
        return Given(
            self.readings,
            self.white,
            self.taxels,
            self.tables,
            self.priors,
            self._shared,
            self.places,
        )

    @cached_property
    def _shared(self) -> float:
        """Variance of the shared offset, given the readings."""
        return self.common**2 / (1.0 + self.common**2 * float(np.square(self.white).sum()))

    def offset(self, predicted: Floats) -> float:
        """The shared offset that is most probable, if atoms are read as `predicted` (L,)."""
        return self._shared * float(np.square(self.white) @ (self.readings - predicted))

    def left(self, predicted: Floats) -> Floats:
        """Readings without what atoms are read as, and without the shared offset."""
        return self.readings - predicted - self.offset(predicted)

    @property
    def heard(self) -> int:
        """Taxels that count."""
        return int(np.count_nonzero(self.white))

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return self.deadline_ns is not None and time.perf_counter_ns() >= self.deadline_ns

    def nothing(self) -> AtomSet:
        """No contact at all."""
        zero = np.zeros(len(self.readings))
        total = float(np.square(self.white) @ self.readings)
        squares = float(np.square(self.readings * self.white).sum())
        cost = 0.5 * (squares - self._shared * total**2)
        none = np.empty((0, PARAMETERS))
        return AtomSet(none, np.empty(0, np.int64), cost, zero, np.empty((0, 0)))

    def refined(self, atoms: Floats, family: NDArray[np.int64], iterations: int = 60) -> AtomSet:
        """Atoms moved to the next minimum of the cost, or until the time is up."""
        atoms = np.array(atoms, order="C")
        free = np.where(np.any(atoms[:, 4:], axis=1)[:, None], LONG, ROUND)
        done = 0
        while True:
            made = refined(atoms[None], family[None], free[None], self.given, BURST, SETTLED)
            done += int(made.tried[0])
            if made.tried[0] < BURST or done >= iterations or self.late:
                cost, predicted, hessian = float(made.cost[0]), made.predicted[0], made.hessian[0]
                return AtomSet(atoms, family, cost, predicted, hessian)

    def misfit(self, found: AtomSet) -> float:
        """By how many standard deviations the squares of the residuals exceed their number."""
        squares = float(np.square(self.left(found.predicted) * self.white).sum())
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
        known = -len(found) * float(np.log(np.prod(self.places[1] - self.places[0]) * LOG_FORCES))
        for family, long in zip(found.family, found.long, strict=True):
            std = (self.priors.ball_std, self.priors.flat_std, self.priors.ring_std)[family]
            known -= float(np.log(std)) + 0.5 * np.log(2 * np.pi) + RARER[family]
            length = 2 * np.log(self.priors.length_std) + np.log(2 * np.pi)
            known -= (float(length) + LONGER) * float(long)
        laplace = 0.5 * float(free.sum()) * np.log(2 * np.pi) - 0.5 * size
        return float(-found.cost + known + laplace)

    def alone(self, found: AtomSet, which: NDArray[np.bool_]) -> Floats:
        """What some of the atoms are read as, (L,)."""
        out = np.zeros(len(self.readings))
        if which.any():
            jacobian = np.empty((len(out), int(which.sum()), PARAMETERS))
            predict(
                found.atoms[which], found.family[which], self.taxels, self.tables, out, jacobian
            )
        return out
