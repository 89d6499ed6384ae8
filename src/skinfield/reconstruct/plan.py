"""Plan of a patch: one operator per set of valid taxels, and one matrix for what is linear."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Deformation
from skinfield.errors import Floats, InputError, Ints
from skinfield.estimate import (
    Contact,
    ContactFinder,
    Estimate,
    PressureError,
    PressureNoise,
)
from skinfield.estimate.finder import GridLevel, contacts_on, level_of
from skinfield.estimate.live_contacts import LiveContacts
from skinfield.signal.drift import Drift
from skinfield.skin import Grid
from skinfield.solve import LinearOperator, Operator, Solution
from skinfield.solve.atoms.fit_kernel import NOW
from skinfield.solve.repair import readings_of

NO_SHIFT: Floats = np.zeros(2)
MOST_SETS = 16  # of valid taxels whose operators stay prepared, beside that of all
MOST = 1e6  # s: a deadline that is as good as none


def until(deadline: float | None, start: int) -> int | None:
    """Time, ns, at which a deadline ends, in seconds from the start."""
    return None if deadline is None else start + int(min(deadline, MOST) * 1e9)


@dataclass(frozen=True, eq=False)
class FieldContacts:
    """How contacts are found in the fields of one grid, the same for every door.

    Attributes
    ----------
    finder : ContactFinder
    grid : Grid
    nodes : (K,) int array, optional
        The grid's, among those of the operators. Default all.
    """

    finder: ContactFinder
    grid: Grid
    nodes: Ints | None = None

    @cached_property
    def level(self) -> Any:
        """`GridLevel` of an operator's answers, of those that came last."""
        return lru_cache(MOST_SETS + 1)(self._level_of)

    def _level_of(self, operator: Operator) -> GridLevel:
        errors = *self._errors(operator), operator.model_error, self.finder
        if self.nodes is None and operator.noise.felt:  # else nothing is found in its pressure
            problem = getattr(operator, "problem", None)
        else:
            problem = None
        if problem is None:
            return level_of(self.grid, *errors)
        signatures = (operator.model.matrix / operator.model.noise_std[:, None]).T
        threshold = problem.threshold
        return level_of(self.grid, *errors, signatures=signatures, threshold=threshold)

    def _errors(self, operator: Operator) -> tuple[PressureError, PressureError | None]:
        """Noise and posterior on the grid's nodes."""
        noise: Any = operator.noise
        posterior: Any = operator.posterior
        if self.nodes is None:
            return noise, posterior
        return noise.on(self.nodes), None if posterior is None else posterior.on(self.nodes)

    def __call__(
        self, operator: Operator, pressure: Floats, readings: Floats | None = None
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa; `readings` (L,) are linearised, 0 where left out."""
        level, (noise, posterior) = self.level(operator), self._errors(operator)
        white = None
        if readings is not None and len(level.signatures) == len(pressure):
            white = readings / operator.model.noise_std
        error = noise if posterior is None else posterior
        return contacts_on(level, self.grid, pressure, error, operator.model_error, white)


@lru_cache(maxsize=64)
def field_contacts(finder: ContactFinder, grid: Grid) -> FieldContacts:
    """How contacts are found on a grid that is an operator's own."""
    return FieldContacts(finder, grid)


def details(
    solution: Solution,
    pressure: Floats,
    valid: NDArray[np.bool_],
    grid: Grid,
    deformation: Deformation,
    find: FieldContacts | None = None,
    nodes: Ints | None = None,
    predict: Callable[[], Floats] | None = None,
    given: tuple[Floats, Floats | float] | None = None,
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
    find : FieldContacts, optional
        Where the operator finds none by itself. Default: there are none.
    nodes : int array, optional
        Those of the solution's nodes that are the grid's. Default all.
    predict : function, optional
        What the taxels would read of it, (L,) as its readings. Default as its operator says.
    given : tuple of (L,) arrays, in the quantity's unit, optional
        Readings, and the rest that was taken from them. Default the solution's, and 0.
    """
    operator = solution.operator
    predicted = cache(predict or (lambda: operator.predicted(solution)))
    read = cache(lambda: readings_of(solution, valid, predicted, given))
    here: Any = slice(None) if nodes is None else nodes

    def contacts() -> tuple[Contact, ...]:
        found = operator.contacts(solution)
        if found is None:
            return () if find is None else find(operator, pressure, solution.readings)
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
        "residual": lambda: np.where(valid, solution.readings - predicted(), np.nan),
        "readings": lambda: read()[0],
        "readings_std": lambda: read()[1],
    }


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
    """

    fields: NDArray[Any] = field(default_factory=lambda: np.zeros((0, 0)))

    @classmethod
    def of(
        cls, operator: LinearOperator, deformation: Deformation, nodes: Ints, precision: Any
    ) -> "LinearFields":
        """Fold resampling, inversion and displacement into one matrix."""
        gaussian = operator.gaussian
        posterior: Any = operator.posterior
        displacement = deformation(operator.matrix.T)[:, nodes]  # (L, K, 3)
        pressure = operator.matrix[nodes]
        blocks = [pressure, *np.moveaxis(displacement, (2, 1, 0), (0, 1, 2))]
        fields = np.asfortranarray(np.concatenate(blocks), dtype=precision)
        std, matrix = operator.pressure_std()[nodes], np.asfortranarray(fields[: len(nodes)])
        error = None if posterior is None else posterior.on(nodes)
        prior = None if gaussian is None else gaussian.on(nodes)
        parts = operator.solver, operator.model, matrix, std, error, operator.model_error, prior
        made = cls(*parts, operator.valid, operator, fields=fields)
        vars(made)["noise"] = PressureNoise(pressure * operator.model.noise_std)
        return made

    def displacement(self, solution: Solution) -> Floats:
        """See `Operator.displacement`."""
        readings = self.filled(solution.readings).astype(self.fields.dtype, copy=False)
        moved = np.dot(self.fields, readings)[len(self.matrix) :]
        return np.asarray(moved.reshape(3, -1).T, dtype=np.float64)


class Followed:
    """Memory of an operator from reading to reading: its own, and where taxels rest.

    Where they rest is followed beside contacts; see `Drift`. An operator that finds no contacts by
    itself answers readings as they are, and so does one that starts each reading anew.

    Parameters
    ----------
    operator : Operator
        Of all taxels.
    """

    def __init__(self, operator: Operator) -> None:
        self.data: Any = operator.data()
        noise = operator.model.noise_std
        self.drift = Drift(noise) if self.data.follows else None
        self._every = np.ones(len(noise), np.bool_)

    def solve(
        self,
        operator: Operator,
        reading: Floats,
        valid: NDArray[np.bool_] | None,
        stamp_ns: int,
        end: int | None,
    ) -> Solution:
        """Answer a reading (L,) by a time, ns, less the rest of its taxels; then follow the rest.

        The operator is that of the `valid` (L,) ones; None for all.
        """
        data, drift = self.data, self.drift
        by = end if data.margin is None else data.margin.before(end)
        if drift is None:
            return operator.solve(reading, data, by)
        solution: Solution = operator.solve(drift.take(reading, stamp_ns), data, by)
        if data.count >= 0:  # else a field answers
            fit, every = data.fit, self._every if valid is None else valid
            predicted = fit.memory.predicted[NOW] if data.count else None
            drift.learn(every, stamp_ns, predicted, fit.misfit, data.count)
        return solution

    def reset(self) -> None:
        """Forget the readings before."""
        self.data.reset()
        if self.drift is not None:
            self.drift.reset()


class Plan:
    """What is prepared of a patch: an operator of all taxels, and of sets of them as they come.

    Parameters
    ----------
    operator : Operator
        Of all taxels, on a support: wherever pressure may be.
    deformation : Deformation
        Of the support.
    nodes : (K,) int array
        Of the support, where the answer is wanted.
    grid : Grid
        These nodes.
    finder : ContactFinder
    precision : numpy.float64 or numpy.float32
        Of products.
    alive : (L,) bool array, optional
        Taxels that `write` goes by. Default all.
    """

    def __init__(
        self,
        operator: Operator,
        deformation: Deformation,
        nodes: Ints,
        grid: Grid,
        finder: ContactFinder,
        precision: type[np.floating[Any]] = np.float64,
        alive: NDArray[np.bool_] | None = None,
    ) -> None:
        self.deformation, self.grid, self._alive = deformation, grid, alive
        self._parts = deformation, nodes, precision
        whole = len(nodes) == len(operator.model.grid)
        self._nodes = None if whole or operator.linear is not None else nodes
        self.linear: LinearFields | None = None
        if operator.linear is not None:
            operator = self.linear = LinearFields.of(operator.linear, *self._parts)
        self.whole: Operator = operator
        self._without = lru_cache(MOST_SETS)(self._prepared_without)
        self.find, self.relative = FieldContacts(finder, grid, self._nodes), False
        self._spare: list[Followed] = []  # of threads that are not at work

    def of(self, valid: NDArray[np.bool_]) -> Operator:
        """Operator of the valid taxels, (L,); it takes all readings."""
        return self.whole if valid.all() else self._without(valid.tobytes())

    def _prepared_without(self, key: bytes) -> Operator:
        valid, linear = np.frombuffer(key, np.bool_), self.linear
        if linear is None or linear.gaussian is not None:
            return self.whole.without(valid)
        assert linear.source is not None
        return LinearFields.of(linear.source.without(valid), *self._parts)

    def answer(
        self,
        reading: Floats,
        valid: NDArray[np.bool_],
        stamp_ns: np.int64,
        start: int,
        deadline: float | None,
    ) -> Estimate:
        """Answer one reading (L,), where `valid`, the rest to be computed when asked for.

        The deadline is s after `start`, ns.
        """
        end, operator = until(deadline, start), self.of(valid)
        try:
            memory = self._spare.pop()
        except IndexError:
            memory = self.memory()
        solution, data = memory.solve(operator, reading, valid, int(stamp_ns), end), memory.data
        solved, solution = time.perf_counter_ns(), solution.keep()
        margin = data.margin if data.searched else None  # else it could not have been any earlier
        rest = 0.0 if memory.drift is None else memory.drift.rest.copy()  # of lost ones it stays
        self._spare.append(memory)
        pressure = solution.pressure if self._nodes is None else solution.pressure[self._nodes]
        parts = valid, self.grid, self.deformation, self.find, self._nodes, None
        estimate = Estimate.later(
            details(solution, pressure, *parts, (reading.copy(), rest)),
            grid=self.grid,
            pressure=pressure.copy(),  # what is computed later is of what was found
            valid=valid,
            stamp_ns=stamp_ns,
            gap=solution.gap,
            iterations=solution.steps,
            notes=solution.notes,
            solver=solution.solver,
            is_field=solution.fit is None,
            relative=self.relative,
        )
        known, now = vars(estimate), time.perf_counter_ns()
        known["latency"], known["deadline_met"] = (now - start) * 1e-9, end is None or now <= end
        if end is not None and margin is not None:
            margin.learn(end, solved)
        return estimate

    def write(
        self, reading: Floats, out: NDArray[np.void], stamp_ns: int, deadline: float | None
    ) -> int:
        """Write the contacts of one reading (L,) into rows of `CONTACT`; how many there are."""
        memory, live, whitened, read = self._live
        data, valid = memory.data, self._alive
        operator = self.whole if valid is None else self.of(valid)
        end = None if deadline is None else until(deadline, time.perf_counter_ns())
        solution = memory.solve(operator, reading, valid, stamp_ns, end)
        if data.rows is not None and data.count >= 0:
            return int(live.take(data.rows, data.count, NO_SHIFT, stamp_ns, out))
        np.multiply(solution.readings, whitened, out=read)
        return int(live(0, solution.pressure, stamp_ns, out, read))

    @cached_property
    def _live(self) -> tuple["Followed", LiveContacts, Floats, Floats]:
        """Memory of `write`, how contacts become rows, one over the noise, and room."""
        if self._nodes is not None:
            raise InputError(
                f"the grid has {len(self.grid)} nodes, a window of the patch, expected one over "
                "all of it, such as Grid.square(patch): contacts are found where taxels are"
            )
        known, noise = self.whole, self.whole.model.noise_std
        live = LiveContacts([self.find.level(known)])
        return Followed(known), live, 1.0 / noise, np.zeros_like(noise)

    def memory(self) -> Followed:
        """That has seen no reading, of one that goes through a recording."""
        return Followed(self.whole)

    def reset(self, rest: Floats | None = None) -> None:
        """Forget the readings before, but for where taxels rest: `Drift.known`, if it is given."""
        if rest is not None and not self._spare:
            self._spare.append(self.memory())
        for memory in self._spare:
            memory.reset()
            if rest is not None and memory.drift is not None:
                memory.drift.go_on_from(rest)
        if "_live" in vars(self):
            memory, live, *_ = self._live
            memory.reset()
            live.reset()

    def run_in(self) -> None:
        """Load what is compiled for contacts and displacement."""
        operator, grid = self.whole, self.whole.model.grid if self.linear is None else self.grid
        if operator.contacts(operator.data().solution) is not None:
            return
        peak = np.zeros(len(grid))
        peak[len(peak) // 2] = 1e3 * max(float(operator.noise.std.max()), 1.0)
        FieldContacts(self.find.finder, grid)(operator, peak)
        self.deformation(np.zeros(len(operator.model.grid)))
