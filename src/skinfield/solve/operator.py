"""Operators: solve slowly once (`prepare`), then reading by reading in memory of the caller's."""

import time
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, check_shape
from skinfield.estimate import Contact, ModelError, PressureError, PressureNoise
from skinfield.skin import Grid
from skinfield.solve.gaussian_model import GaussianModel, SetError, TaxelSet

EXACT = ModelError()
EARLIER, LATER = 0.999, 1.1  # changes of a margin: at rest it is too short in one call of a hundred
PAUSED, SLIGHTLY = 2.0, 1.02  # times the margin: what took so long was mostly the machine's doing


@dataclass
class DeadlineMargin:
    """Learns from how late answers were.

    Attributes
    ----------
    margin_ns : int, ns
    least, most : int, ns
        Between which it stays.
    """

    margin_ns: int = 10_000
    least: int = 2_000
    most: int = 50_000

    def before(self, end: int | None) -> int | None:
        """When a solver should end so that all is done at `end` of `time.perf_counter_ns`."""
        return None if end is None else end - self.margin_ns

    def learn(self, end: int, solved: int, now: int | None = None) -> bool:
        """Take note that all is done now, and the solver was when it was `solved`; if in time.

        Learnt is what was left to do after that, and by how much the solver was later than it
        should have been, up to thrice as much: more is for want of time, and no margin helps.
        """
        now = time.perf_counter_ns() if now is None else now
        rest, over = now - solved, solved - (end - self.margin_ns)
        took = rest + min(max(over, 0), 3 * rest)
        change = EARLIER
        if took > self.margin_ns:
            change = LATER if took < PAUSED * self.margin_ns else SLIGHTLY
        self.margin_ns = int(min(max(change * self.margin_ns, self.least), self.most))
        return now <= end


class Fit(Protocol):
    """What a solver that finds contacts by itself makes of one reading."""

    @property
    def grid(self) -> Grid:
        """On which they stand."""
        ...

    @property
    def rows(self) -> NDArray[np.void]:
        """Contacts, (N,) of CONTACT, by falling normal force."""
        ...

    @property
    def displacement(self) -> Floats:
        """(K, 3), m, in the patch's frame."""
        ...

    @property
    def predicted(self) -> Floats:
        """What the taxels would read of them, (L,), in the quantity's unit."""
        ...

    @property
    def parameters(self) -> int:
        """Numbers that were fitted."""
        ...

    def keep(self) -> "Fit":
        """Itself."""
        ...

    def on(self, grid: Grid, shift: Floats, /) -> "Fit":
        """The same on a patch of equal geometry, whose plane is shifted by (2,) m."""
        ...


class FitSource(Protocol):
    """A fit, or the memory that holds one until the next reading."""

    def keep(self) -> Fit:
        """The fit, which nothing overwrites."""
        ...


@dataclass(eq=False)
class Solution:
    """Answer to one reading; an operator writes each into the same, `keep` copies one.

    Attributes
    ----------
    pressure : (K,) array, Pa
    readings : (L,) array, in the quantity's unit
        As the solver took them, mostly linearised; 0 for taxels that are left out.
    solver : str
        Name of the solver that answered.
    operator : Operator
        That answered, and knows the rest.
    gap : float
        Share of the objective, 0 to 1, by which it is above the minimum at most, proved; else NaN.
    objective : float
        That the solver minimised; NaN where it has none.
    evidence : float
        Logarithm of the readings' probability with this answer's model; NaN if unknown.
    steps : int
        Of an iterative solver.
    in_time : bool
        Whether it was there at the deadline.
    notes : tuple of str
    offset : float, in the quantity's unit
        That all taxels are taken to share.
    fit : FitSource, optional
        Of a solver that finds contacts by itself.
    """

    pressure: Floats
    readings: Floats
    solver: str
    operator: "Operator"
    gap: float = float("nan")
    objective: float = float("nan")
    evidence: float = float("nan")
    steps: int = 0
    in_time: bool = True
    notes: tuple[str, ...] = ()
    offset: float = 0.0
    fit: FitSource | None = None

    @property
    def residual(self) -> Floats:
        """Readings less what the answer predicts, (L,); worked out each time."""
        return self.readings - self.operator.predicted(self)

    def keep(self) -> "Solution":
        """A copy that nothing overwrites."""
        other = object.__new__(Solution)  # several times as quick as `copy.copy`
        vars(other).update(vars(self))
        other.pressure, other.readings = self.pressure.copy(), self.readings.copy()
        other.fit = None if self.fit is None else self.fit.keep()
        return other

    def take(self, other: "Solution") -> None:
        """Become a copy of another, in the same arrays."""
        arrays = self.pressure, self.readings
        vars(self).update(vars(other))
        self.pressure, self.readings = arrays
        np.copyto(self.pressure, other.pressure)
        np.copyto(self.readings, other.readings)


class Data:
    """Scratch memory of an operator, for one thread at a time; base of each operator's own.

    What is made for an operator also serves those that leave out some of its taxels.

    Parameters
    ----------
    operator : Operator
    nodes : int
    margin : DeadlineMargin, optional
        What remains to be done after a deadline, in this memory's calls.

    Attributes
    ----------
    solution : Solution
        Of the last reading.
    rows : structured array of `CONTACT`, or None
        Of a solver that finds contacts by itself: those of the last reading, by falling force.
    count : int
        How many of the rows hold; -1 where a `ContactFinder` finds contacts in the pressure.
    follows : bool
        Whether readings follow each other, so that the rest of taxels is to be followed, too.
    """

    rows: NDArray[np.void] | None = None
    count = -1
    follows = False

    def __init__(
        self, operator: "Operator", nodes: int, margin: DeadlineMargin | None = None
    ) -> None:
        taxels, self.margin = len(operator.model.noise_std), margin
        name = type(operator.solver).__name__
        self.solution = Solution(np.zeros(nodes), np.zeros(taxels), name, operator)
        self._heard = np.zeros(taxels)

    @property
    def searched(self) -> bool:
        """Whether the last answer could have been there earlier."""
        return True

    @property
    def settled(self) -> bool:
        """Whether the search for the last answer came to its end."""
        return True

    def reset(self) -> None:
        """Forget the reading before."""

    def start_from(self, other: "Data") -> None:
        """Begin the next reading where another operator, as of a coarser grid, ended its last."""

    def heard(self, readings: Floats, valid: NDArray[np.bool_] | None) -> Floats:
        """Readings (L,), 0 where not `valid` (L,): themselves where all are."""
        if valid is None:
            return readings
        self._heard.fill(0.0)
        np.copyto(self._heard, readings, where=valid)
        return self._heard

    def linearise(
        self, operator: "Operator", readings: Floats, valid: NDArray[np.bool_] | None
    ) -> Solution:
        """Linearise readings (L,) into the solution, which is an operator's from now on."""
        solution, physics = self.solution, operator.model.physics
        solution.operator, out = operator, solution.readings
        made = self.heard(readings, valid)
        if physics is not None:
            made = physics.quantity.linearise(made, out)
        if made is not out:
            np.copyto(out, made)
        return solution


class Operator(Protocol):
    """Solver that is prepared for a model: immutable, shared by threads and processes."""

    @property
    def solver(self) -> "Solver":
        """That prepared it."""
        ...

    @property
    def model(self) -> ObservationModel:
        """For which it is prepared."""
        ...

    @property
    def linear(self) -> "LinearOperator | None":
        """Itself, where it is a matrix; bulk products go by it."""
        ...

    @property
    def noise(self) -> PressureError:
        """How the readings' noise moves the pressure, about: contacts must stand out of it."""
        ...

    @property
    def posterior(self) -> PressureError | None:
        """By which contacts are said to be sure, if by more than the readings' noise."""
        ...

    @property
    def model_error(self) -> ModelError:
        """What is wrong with contacts otherwise: added to their covariance."""
        ...

    def data(self) -> Any:
        """Make the only scratch memory there is: a `Data` of its own kind."""
        ...

    def solve(self, readings: Floats, data: Any, deadline_ns: int | None = None) -> Solution:
        """Answer `readings` (L,), in the quantity's unit: `data.solution`, written over each time.

        All of them are numbers, but for taxels that are left out. `deadline_ns` is a time of
        `time.perf_counter_ns`, at which the best answer so far is taken. Allocates no array.
        """
        ...

    def without(self, valid: NDArray[np.bool_], /) -> "Operator":
        """Leave out taxels, by a mask (L,) of those to use.

        It still takes all L readings; those left out may be anything.
        """
        ...

    def predicted(self, solution: Solution, /) -> Floats:
        """What the taxels would read of an answer, (L,) as `Solution.readings`."""
        ...

    def contacts(self, solution: Solution, /) -> tuple[Contact, ...] | None:
        """Contacts of an answer; None where a `ContactFinder` finds them in its pressure."""
        ...

    def pressure_std(self, solution: Solution, /) -> Floats:
        """One standard deviation of an answer's pressure as the solver states it, (K,) Pa."""
        ...

    def displacement(self, solution: Solution, /) -> Floats | None:
        """Of an answer, (K, 3) m; None where a `Deformation` computes it of its pressure."""
        ...


class Solver(Protocol):
    """Anything with `prepare` is a solver: nothing to inherit, nowhere to register."""

    def prepare(self, model: ObservationModel, /) -> Operator:
        """Do every computation that needs no reading."""
        ...


class FieldOperator:
    """Base of operators whose answer is a field alone."""

    def contacts(self, solution: Solution) -> None:
        """A finder finds them."""

    def displacement(self, solution: Solution) -> Floats | None:
        """Of the pressure."""
        return None


class LinearData(Data):
    """Scratch memory of a `LinearOperator`."""

    def __init__(self, operator: "LinearOperator") -> None:
        matrix = operator.matrix
        super().__init__(operator, len(matrix))
        self.solution.gap = 0.0
        single = matrix.dtype != np.float64
        self.factors = np.zeros(matrix.shape[1], matrix.dtype) if single else None
        self.product: Any = np.zeros(len(matrix), matrix.dtype) if single else None


@dataclass(frozen=True, eq=False)
class LinearOperator(FieldOperator):
    """Prepared linear map from L readings to the pressure on K nodes.

    Attributes
    ----------
    solver : Solver
    model : ObservationModel
    matrix : (K, L) array, Pa per unit of the linearised reading
    std : (K,) array, Pa, optional
        One standard deviation of the pressure as the solver states it: by default a Bayesian one's
        posterior, else how far the noise of one reading moves the answer.
    posterior : PressureError, optional
        Of a Bayesian solver: its contacts' covariance. Else that is of the readings' noise alone.
    model_error : ModelError
        What is wrong with its contacts otherwise: added to their covariance.
    gaussian : GaussianModel, optional
        Of a Bayesian solver: by which it answers without some of its taxels at little cost.
    valid : (L,) bool array, optional
        Taxels that are used. Default all.
    source : LinearOperator, optional
        Whose pressure this one's is a part or an average of: what the readings are explained by.
    taxels : TaxelSet, optional
        By which valid readings stand for the others; else columns are 0.
    """

    solver: Solver
    model: ObservationModel
    matrix: NDArray[Any]
    std: Floats | None = None
    posterior: PressureError | None = None
    model_error: ModelError = EXACT
    gaussian: GaussianModel | None = None
    valid: NDArray[np.bool_] | None = None
    source: "LinearOperator | None" = None
    taxels: TaxelSet | None = None

    @property
    def linear(self) -> "LinearOperator":
        """Itself."""
        return self

    @cached_property
    def noise(self) -> PressureError:
        """How the readings' noise moves the pressure."""
        noise = self.model.noise_std
        if self.taxels is None:
            return PressureNoise(self.matrix * noise)
        return PressureNoise(self.matrix @ self.filled(np.diag(noise)).T)

    @cached_property
    def explained(self) -> Floats:
        """From linearised readings to what the pressure predicts of them, (L, L)."""
        if self.source is not None:
            return self.source.explained
        return np.asarray(self.model.matrix @ self.matrix)

    def data(self) -> LinearData:
        """Make its scratch memory."""
        return LinearData(self)

    def solve(self, readings: Floats, data: LinearData, deadline_ns: int | None = None) -> Solution:
        """See `Operator.solve`; one product, whatever the deadline."""
        solution, factors = data.linearise(self, readings, self.valid), data.factors
        filled = self.filled(solution.readings)
        if factors is None:
            np.dot(self.matrix, filled, out=solution.pressure)
        else:
            np.copyto(factors, filled, casting="same_kind")
            np.copyto(solution.pressure, np.dot(self.matrix, factors, out=data.product))
        solution.in_time = deadline_ns is None or time.perf_counter_ns() <= deadline_ns
        return solution

    def linearised(self, readings: Floats) -> Floats:
        """Readings (..., L) as a linear sensor's."""
        physics = self.model.physics
        return (
            physics.quantity.linearise(readings, np.empty_like(readings)) if physics else readings
        )

    def filled(self, readings: Floats) -> Floats:
        """What the matrix is multiplied with, of linearised readings (..., L), all finite."""
        if self.taxels is None:
            return readings
        rows = readings.reshape(-1, readings.shape[-1])
        return self.taxels.filled(rows).reshape(readings.shape)

    def predicted(self, solution: Solution) -> Floats:
        """See `Operator.predicted`."""
        return np.asarray(self.explained @ self.filled(solution.readings))

    def pressure_std(self, solution: Solution | None = None) -> Floats:
        """The same of all answers, (K,) Pa."""
        if self.std is not None:
            return self.std
        return self.noise.std if self.posterior is None else self.posterior.std

    def without(self, valid: NDArray[np.bool_]) -> Self:
        """Leave out taxels: with the same prior, or else by the solver, which prepares anew."""
        check_shape("valid", valid, self.model.noise_std.shape, "one per taxel")
        if self.gaussian is not None:  # the same matrix, before which the readings are filled up
            part, taxels = copy(self), TaxelSet.of(self.gaussian, np.array(valid, np.bool_))
            errors = {"posterior": SetError(taxels, False), "noise": SetError(taxels, True)}
            vars(part).update(errors, std=None, source=self, taxels=taxels, valid=taxels.valid)
            return part
        made = self.solver.prepare(self.model.subset(valid)).linear
        assert made is not None  # as it is of all taxels
        matrix = np.zeros((len(made.matrix), len(valid)))
        matrix[:, valid] = made.matrix
        return replace(self, matrix=matrix, std=made.std, posterior=made.posterior, valid=valid)


def propagated_std(matrix: Floats, noise_std: Floats) -> Floats:
    """How far independent noise (L,) moves the output of a matrix (K, L): (K,)."""
    return np.asarray(np.sqrt(np.square(matrix) @ np.square(noise_std)))
