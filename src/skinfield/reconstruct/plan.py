"""Plan of a patch: one operator per set of valid taxels, and products for what is linear."""

import time
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Deformation, ObservationModel, Quantity
from skinfield.errors import Floats, Ints
from skinfield.estimate import (
    Contact,
    ContactFinder,
    Estimate,
    PressureError,
    PressureNoise,
)
from skinfield.skin import Grid
from skinfield.solve import LinearOperator, Operator, Solution, TaxelSets
from skinfield.solve.operator import EXACT, Data, DeadlineMargin

CHUNK = 512  # readings per matrix product: the outputs stay in cache
SETS = 16  # at once: their deviations stay in cache
CALLS_KEPT = 16  # whose sets of taxels stay prepared
SETS_KEPT = 16  # of valid taxels whose operators stay prepared, beside that of all
MOST = 1e6  # s: a deadline that is as good as none


def until(deadline: float | None, start: int) -> int | None:
    """Time, ns, at which a deadline ends, in seconds from the start."""
    return None if deadline is None else start + int(min(deadline, MOST) * 1e9)


@dataclass(frozen=True, eq=False)
class PatchAnswer:
    """One reading's pressure, and how to compute the rest when it is asked for.

    Attributes
    ----------
    solution : Solution
    pressure : (K,) array, Pa
        Of the nodes where the answer is wanted.
    rest : mapping of names to functions
        See `details`.
    margin : DeadlineMargin, optional
        Which learns how late this was; none where it could not have been any earlier.
    """

    solution: Solution
    pressure: Floats
    rest: dict[str, Callable[[], Any]]
    margin: DeadlineMargin | None = None

    def met(self, start: int, deadline: float | None) -> bool:
        """Whether all that is done now, begun at `start`, ns, is there after `deadline`, s."""
        if (end := until(deadline, start)) is None:
            return True
        if self.margin is None:
            return time.perf_counter_ns() <= end
        return self.margin.learn(start, end)


@dataclass(frozen=True, eq=False)
class ResultArrays:
    """Where T readings' answers are written.

    Attributes
    ----------
    fields : (T, 4 K) array
        Pressure (K) Pa, then displacement x, y, z (K each) m.
    pressure_std : (T, K) array, Pa
    residual : (T, L) array, in the quantity's unit
    contacts : list of T tuples of Contact
    notes : list of str
    gap : (T,) array
        NaN where nothing is proved.
    iterations : (T,) int array
    in_time : (T,) bool array
    """

    fields: Floats
    pressure_std: Floats
    residual: Floats
    contacts: list[tuple[Contact, ...]]
    notes: list[str]
    gap: Floats
    iterations: Ints
    in_time: NDArray[np.bool_]

    @classmethod
    def empty(cls, readings: int, taxels: int, nodes: int) -> "ResultArrays":
        """Room for some readings."""
        return cls(
            np.empty((readings, 4 * nodes)),
            np.empty((readings, nodes)),
            np.full((readings, taxels), np.nan),
            [()] * readings,
            [],
            np.zeros(readings),
            np.zeros(readings, dtype=np.int64),
            np.ones(readings, dtype=np.bool_),
        )

    def take(self, row: int, answer: PatchAnswer) -> None:
        """Write one reading's answer."""
        nodes, rest = len(answer.pressure), answer.rest
        self.fields[row, :nodes] = answer.pressure
        self.fields[row, nodes:] = rest["displacement"]().T.ravel()
        self.pressure_std[row] = rest["pressure_std"]()
        self.residual[row] = rest["residual"]()
        self.contacts[row] = rest["contacts"]()
        solution = answer.solution
        self.gap[row], self.iterations[row] = solution.gap, solution.steps
        self.notes.extend(note for note in solution.notes if note not in self.notes)


@dataclass(frozen=True, eq=False)
class Setting:
    """What all plans of a patch share.

    Attributes
    ----------
    model : ObservationModel
        Of the support: wherever pressure may be.
    deformation : Deformation
        Of the support.
    nodes : (K,) int array
        Of the support, where the answer is wanted.
    grid : Grid
        These nodes.
    quantity : Quantity
    finder : ContactFinder
    precision : numpy.float64 or numpy.float32
    model_errors : bool
        Whether contacts state the solver's own model error; not where intervals are learnt.
    """

    model: ObservationModel
    deformation: Deformation
    nodes: Ints
    grid: Grid
    quantity: Quantity
    finder: ContactFinder
    precision: type[np.floating[Any]]
    model_errors: bool = True

    def linearised(self, readings: Floats) -> Floats:
        """Readings (..., L'), linearised into an array of its own."""
        return self.quantity.linearise(readings, np.empty_like(readings))


Finder = Callable[[Operator, Floats], tuple[Contact, ...]]


def details(
    solution: Solution,
    pressure: Floats,
    valid: NDArray[np.bool_],
    grid: Grid,
    deformation: Deformation,
    find: Finder,
    nodes: Ints | None = None,
) -> dict[str, Callable[[], Any]]:
    """What an estimate of a solution holds beside its pressure, to be worked out when asked for.

    Parameters
    ----------
    solution : Solution
        That nothing overwrites.
    pressure : (K,) array, Pa
        Of the grid's nodes.
    valid : (L,) bool array
    grid : Grid
    deformation : Deformation
        Of the solution's nodes.
    find : function of an operator and a pressure (K,)
        Finds the contacts, where the operator does not.
    nodes : int array, optional
        Those of the solution's nodes that are the grid's. Default all.
    """
    operator = solution.operator
    here: Any = slice(None) if nodes is None else nodes

    def contacts() -> tuple[Contact, ...]:
        found = operator.contacts(solution)
        if found is None:
            return find(operator, pressure)
        return found if nodes is None else _inside(found, nodes)

    def moved() -> Floats:
        displacement = operator.displacement(solution)
        if displacement is None:
            displacement = deformation(solution.pressure)
        return np.asarray(displacement[here])

    return {
        "traction": lambda: -pressure[:, None] * grid.normals,
        "displacement": moved,
        "pressure_std": lambda: np.array(operator.pressure_std(solution)[here]),
        "contacts": contacts,
        "residual": lambda: np.where(valid, solution.residual, np.nan),
    }


def finder_of(finder: ContactFinder, grid: Grid) -> Finder:
    """Finder of contacts on a grid that is an operator's own."""
    return lambda by, pressure: finder(grid, pressure, by.noise, by.posterior, by.model_error)


def estimate_of_solution(
    solution: Solution,
    valid: NDArray[np.bool_],
    grid: Grid,
    deformation: Deformation,
    finder: ContactFinder,
    *,
    predicted: Callable[[], Floats] | None = None,
    **known: Any,
) -> Estimate:
    """Estimate of a solution that nothing overwrites, of all its nodes; see `details`.

    Parameters
    ----------
    predicted : function that returns (L,) array, optional
        Linearised readings that the answer predicts, where the operator does not say so.
    **known
        Further attributes of the estimate.
    """
    find = finder_of(finder, grid)
    rest = details(solution, solution.pressure, valid, grid, deformation, find)
    if predicted is not None:
        left = predicted
        rest["residual"] = lambda: np.where(valid, solution.readings - left(), np.nan)
    its = {"grid": grid, "pressure": solution.pressure, "valid": valid, "gap": solution.gap}
    return Estimate.later(rest, iterations=solution.steps, **its, **known)


def _inside(contacts: tuple[Contact, ...], here: Ints) -> tuple[Contact, ...]:
    """Contacts that press a window, by its own nodes, which are `here` of theirs."""
    order = np.argsort(here)
    nodes = here[order]
    inside = []
    for contact in contacts:
        place = np.minimum(np.searchsorted(nodes, contact.cells), len(nodes) - 1)
        pressed = nodes[place] == contact.cells
        if pressed.any():
            inside.append(replace(contact, cells=np.sort(order[place[pressed]])))
    return tuple(inside)


@dataclass(frozen=True, eq=False)
class LinearFields(LinearOperator):
    """Linear operator of a window's nodes, with what follows of its answers in one matrix.

    Attributes
    ----------
    fields : (4 K, L) array, Fortran order
        From linearised readings to pressure (K), then displacement x (K), y (K), z (K).
    sets : TaxelSets, optional
        By which the readings are filled up: those of set `place` of them.
    """

    fields: NDArray[Any] = field(default_factory=lambda: np.zeros((0, 0)))
    sets: TaxelSets | None = None
    place: int = 0

    @classmethod
    def of(cls, setting: Setting, operator: LinearOperator) -> "LinearFields":
        """Fold resampling, inversion and displacement into one matrix."""
        nodes, gaussian = setting.nodes, operator.gaussian
        posterior: Any = operator.posterior
        displacement = setting.deformation(operator.matrix.T)[:, nodes]  # (L, K, 3)
        pressure = operator.matrix[nodes]
        blocks = [pressure, *np.moveaxis(displacement, (2, 1, 0), (0, 1, 2))]
        fields = np.asfortranarray(np.concatenate(blocks), dtype=setting.precision)
        made = cls(
            solver=operator.solver,
            model=operator.model,
            matrix=np.asfortranarray(fields[: len(nodes)]),
            std=operator.pressure_std()[nodes],
            posterior=None if posterior is None else posterior.on(nodes),
            model_error=operator.model_error,
            gaussian=None if gaussian is None else gaussian.on(nodes),
            valid=operator.valid,
            source=operator,
            fields=fields,
        )
        vars(made)["noise"] = PressureNoise(pressure * operator.model.noise_std)
        return made

    def filled(self, readings: Floats, which: Ints | None = None) -> Floats:
        """Readings (..., L) in which valid taxels stand for the others, of sets `which` (...)."""
        if self.sets is None:
            return readings
        rows = readings.reshape(-1, readings.shape[-1])
        each = np.full(len(rows), self.place) if which is None else which
        return self.sets.filled(rows, each).reshape(readings.shape)

    def displacement(self, solution: Solution) -> Floats:
        """See `Operator.displacement`."""
        readings = self.filled(solution.readings).astype(self.fields.dtype, copy=False)
        moved = np.dot(self.fields, readings)[len(self.matrix) :]
        return np.asarray(moved.reshape(3, -1).T, dtype=np.float64)

    def without(self, valid: NDArray[np.bool_]) -> "LinearFields":
        """The same matrices, before which the readings are filled up; of a Bayesian solver."""
        return self.of_sets(valid[None])[0]

    def of_sets(self, patterns: NDArray[np.bool_]) -> "list[LinearFields]":
        """As `without`, of sets of valid taxels (P, L)."""
        sets, found = self._sets(patterns.tobytes()), []
        for place, (posterior, noise) in enumerate(sets.errors):
            found.append(made := copy(self))
            parts = {"std": None, "posterior": posterior, "noise": noise, "sets": sets}
            vars(made).update(parts, valid=patterns[place], place=place)
        return found

    @cached_property
    def _sets(self) -> Callable[[bytes], TaxelSets]:
        gaussian, taxels = self.gaussian, self.fields.shape[1]
        assert gaussian is not None  # what it takes to leave taxels out
        return lru_cache(CALLS_KEPT)(
            lambda key: gaussian.sets(np.frombuffer(key, np.bool_).reshape(-1, taxels))
        )


def distinct(valid: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Ints]:
    """Different rows of a mask (R, L), and which of them each row is (R,)."""
    packed = np.packbits(valid, axis=1)
    keys = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()  # rows are compared as bytes
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return valid[first], which


class Plan:
    """What is prepared of a patch: an operator of all taxels, and of sets of them as they come.

    Parameters
    ----------
    setting : Setting
    operator : Operator
        Of all taxels.
    """

    def __init__(self, setting: Setting, operator: Operator) -> None:
        self.setting = setting
        self.linear: LinearFields | None = None
        if operator.linear is not None:
            operator = self.linear = LinearFields.of(setting, operator.linear)
        self.whole: Operator = operator
        own = self.linear is not None or len(setting.nodes) == len(setting.model.grid)
        self._nodes = None if own else setting.nodes
        self._without = lru_cache(SETS_KEPT)(self._prepared_without)
        self._errors = lru_cache(SETS_KEPT + 1)(self._errors_on)
        self._spare: list[Data] = []  # of threads that are not at work

    def of(self, valid: NDArray[np.bool_]) -> Operator:
        """Operator of the valid taxels, (L,); it takes all readings."""
        return self.whole if valid.all() else self._without(valid.tobytes())

    def _prepared_without(self, key: bytes) -> Operator:
        valid, linear = np.frombuffer(key, np.bool_), self.linear
        if linear is None or linear.gaussian is not None:
            return self.whole.without(valid)
        assert linear.source is not None
        return LinearFields.of(self.setting, linear.source.without(valid))

    def linear_of(self, valid: NDArray[np.bool_]) -> LinearFields:
        """The same, of a linear solver."""
        made = self.of(valid)
        assert isinstance(made, LinearFields)
        return made

    def answer(
        self, reading: Floats, valid: NDArray[np.bool_], start: int, deadline: float | None
    ) -> PatchAnswer:
        """Answer one reading (L,), where `valid`; the deadline is s after `start`, ns."""
        setting, end, operator = self.setting, until(deadline, start), self.of(valid)
        try:
            data = self._spare.pop()
        except IndexError:
            data = self.whole.data()
        by = end if data.margin is None else data.margin.before(end)
        solution = operator.solve(reading, data, by).keep()
        margin = data.margin if data.searched else None
        self._spare.append(data)
        pressure = solution.pressure if self._nodes is None else solution.pressure[self._nodes]
        parts = valid, setting.grid, setting.deformation, self.find, self._nodes
        return PatchAnswer(solution, pressure, details(solution, pressure, *parts), margin)

    def answer_all(
        self, table: Floats, valid: NDArray[np.bool_], out: ResultArrays, deadline: float | None
    ) -> None:
        """Write the answers of readings (T, L), where `valid` (T, L), into `out`.

        `deadline` is in seconds for each reading; what is linear is one product per chunk.
        """
        rows, linear = np.arange(len(table)), self.linear
        if linear is not None and linear.gaussian is not None:
            full = valid.all(axis=1)
            rows, short = np.flatnonzero(full), np.flatnonzero(~full)
            patterns, which = distinct(valid[short])
            order = np.argsort(which, kind="stable")  # one product serves many sets of taxels
            for first in range(0, len(patterns), SETS):
                start, end = np.searchsorted(which[order], [first, first + SETS])
                some = order[start:end]
                sets, these = linear.of_sets(patterns[first : first + SETS]), short[some]
                self._multiply(sets, which[some] - first, table[these], valid[these], these, out)
        patterns, which = distinct(valid[rows])
        for index, pattern in enumerate(patterns):
            these = rows[which == index]
            if linear is not None:
                mask = np.broadcast_to(pattern, (len(these), len(pattern)))
                one = [self.linear_of(pattern)], np.zeros(len(these), dtype=np.int64)
                self._multiply(*one, table[these], mask, these, out)
                continue
            for row in these:
                answer = self.answer(table[row], pattern, start := time.perf_counter_ns(), deadline)
                out.in_time[row] = answer.met(start, deadline)
                out.take(row, answer)

    def _multiply(
        self,
        operators: Sequence[LinearFields],
        which: Ints,
        table: Floats,
        valid: NDArray[np.bool_],
        rows: Ints,
        out: ResultArrays,
    ) -> None:
        """Write the answers of a table (R, L), where `valid` (R, L), into `rows` of `out`.

        `which` (R,) of the operators is each row's; they share their matrix.
        """
        setting, nodes, shared = self.setting, len(self.setting.grid), operators[0]
        for first in range(0, len(rows), CHUNK):
            part = slice(first, first + CHUNK)
            linear = setting.linearised(np.where(valid[part], table[part], 0.0))
            filled = shared.filled(linear, which[part])
            out.fields[rows[part]] = (shared.fields @ filled.T.astype(setting.precision)).T
            left = linear - filled @ shared.explained.T
            out.residual[rows[part]] = np.where(valid[part], left, np.nan)
        for place, row in zip(which, rows, strict=True):
            out.pressure_std[row] = operators[place].pressure_std()
            out.contacts[row] = self.find(operators[place], out.fields[row, :nodes])

    def find(self, operator: Operator, pressure: Floats) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa, of an operator's nodes that are the grid's."""
        setting, errors = self.setting, (operator.noise, operator.posterior)
        if self._nodes is not None:
            errors = self._errors(operator)  # type: ignore[arg-type]
        stated = operator.model_error if setting.model_errors else EXACT
        return setting.finder(setting.grid, pressure, *errors, stated)

    def _errors_on(self, operator: Operator) -> tuple[PressureError, PressureError | None]:
        """Noise and posterior of an operator, on the grid's nodes."""
        noise: Any = operator.noise
        posterior: Any = operator.posterior
        posterior = None if posterior is None else posterior.on(self._nodes)
        return PressureNoise(noise.factor[self._nodes]), posterior

    def within(self, setting: Setting) -> "Plan":
        """The same in another setting of the same patch and grid."""
        other = copy(self)
        other.setting, other._spare = setting, []
        return other

    def reset(self) -> None:
        """Forget the readings before."""
        for data in self._spare:
            data.reset()

    def run_in(self) -> None:
        """Load what is compiled for contacts and displacement."""
        operator, setting = self.whole, self.setting
        if operator.contacts(operator.data().solution) is not None:
            return
        noise = operator.noise
        peak = np.zeros(len(noise.std))
        peak[len(peak) // 2] = 1e3 * max(float(noise.std.max()), 1.0)
        grid = setting.model.grid if self.linear is None else setting.grid
        setting.finder(grid, peak, noise, operator.posterior, EXACT)
        setting.deformation(np.zeros(len(setting.model.grid)))
