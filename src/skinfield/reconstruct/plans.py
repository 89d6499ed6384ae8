"""Plans of a patch for whichever taxels answer, and the margin that they leave to a deadline."""

import time
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, Ints
from skinfield.estimate import Contact, PressureError, PressureNoise, PressurePosterior
from skinfield.estimate.finder import EXACT
from skinfield.reconstruct.plan import (
    Answer,
    LinearPlan,
    Plan,
    Results,
    Setting,
    distinct,
    linear_plan,
    spread_out,
    until,
)
from skinfield.solve import ContactOperator, FieldOperator, Fit, InverseOperator, Solver

EARLIER, LATER = 0.998, 1.1  # changes of it: at rest one call of fifty is late
NEAR = 3  # times the margin: an answer that is earlier by more tells nothing of lateness
PAUSE = 20_000  # ns late: the machine did something else, which no margin prevents


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

    def learn(self, start: int, end: int | None) -> bool:
        """Take note that all is done now; whether that is in time.

        Of an end so near to the start that nothing was left for the solver nothing is learnt.
        """
        if end is None:
            return True
        now = time.perf_counter_ns()
        tells = -NEAR * self.margin_ns < now - end < max(PAUSE, 2 * self.margin_ns)
        if tells and end - self.margin_ns > start:
            change = EARLIER if now <= end else LATER
            self.margin_ns = int(min(max(change * self.margin_ns, self.least), self.most))
        return now <= end


@dataclass(frozen=True, eq=False)
class FieldPlan:
    """A solver whose field is not linear in the readings, reading by reading.

    Attributes
    ----------
    setting : Setting
    model : ObservationModel
        Of the valid taxels, L' of L; of all where `whole`.
    operator : FieldOperator
    valid : (L,) bool array
    whole : bool
        Whether the operator takes all L readings, of which it leaves out some itself.
    """

    setting: Setting
    model: ObservationModel
    operator: FieldOperator
    valid: NDArray[np.bool_]
    whole: bool = False

    @cached_property
    def noise(self) -> PressureNoise:
        """By which contacts are told."""
        return PressureNoise(self.operator.noise.factor[self.setting.nodes])

    @cached_property
    def posterior(self) -> PressurePosterior | None:
        """By which they are said to be sure."""
        whole = self.operator.posterior
        return None if whole is None else whole.on(self.setting.nodes)

    @cached_property
    def _matrix(self) -> Floats:
        return self.model.matrix[self.valid] if self.whole else self.model.matrix

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`."""
        nodes = len(self.setting.grid)
        for row, reading in zip(rows, readings, strict=True):
            end = until(deadline)
            answer = self.prompt(reading, end)
            out.in_time[row] = end is None or time.perf_counter_ns() <= end
            out.gap[row], out.iterations[row] = answer.gap, answer.iterations
            out.fields[row, :nodes] = answer.pressure
            out.fields[row, nodes:] = answer.rest["displacement"]().T.ravel()
            out.pressure_std[row] = answer.rest["pressure_std"]()
            out.residual[row] = answer.rest["residual"]()
            out.contacts[row] = answer.rest["contacts"]()

    def prompt(self, reading: Floats, end: int | None) -> Answer:
        """Answer one reading (L',) at once, until a time of `time.perf_counter_ns`."""
        setting, operator = self.setting, self.operator
        linear = setting.quantity.linearise(reading, np.empty_like(reading))
        found = np.empty(len(self.model.grid))
        operator.apply(spread_out(linear, self.valid) if self.whole else linear, found, end)
        pressure = found if len(found) == len(setting.nodes) else found[setting.nodes]
        return Answer(
            pressure,
            {
                "displacement": lambda: setting.deformation(found)[setting.nodes],
                "pressure_std": lambda: operator.pressure_std[setting.nodes],
                "contacts": lambda: self.contacts(pressure, self.noise, self.posterior),
                "residual": lambda: spread_out(linear - self._matrix @ found, self.valid),
            },
            getattr(operator, "gap", float("nan")),
            getattr(operator, "iterations", 0),
        )

    def contacts(
        self, pressure: Floats, noise: PressureError, posterior: PressureError | None
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa, whose errors are known."""
        error = self.operator.model_error if self.setting.model_errors else EXACT
        return self.setting.finder(self.setting.grid, pressure, noise, posterior, error)

    def reset(self) -> None:
        """Forget the reading before, where the operator keeps it."""
        reset = getattr(self.operator, "reset", None)
        if reset is not None:
            reset()

    def within(self, setting: Setting) -> "FieldPlan":
        """See `Plan.within`."""
        return replace(self, setting=setting)

    def without(self, valid: NDArray[np.bool_]) -> "FieldPlan | None":
        """Plan that leaves out taxels, if the operator can do so without preparing again."""
        leave_out = getattr(self.operator, "without", None)
        if leave_out is None or not self.valid.all():
            return None
        return FieldPlan(self.setting, self.setting.model, leave_out(valid), valid, whole=True)


LESS = 0.5  # of the squares that contacts leave over, a field must leave to answer in their place


def make_plan(setting: Setting, solver: Solver, valid: NDArray[np.bool_]) -> Plan:
    """Prepare a solver for some taxels."""
    part = setting.model if valid.all() else setting.model.subset(valid)
    inverse = solver.prepare(part)
    if isinstance(inverse, InverseOperator):
        return linear_plan(setting, part, inverse, valid)
    if isinstance(inverse, ContactOperator):
        field = inverse.extended
        extended = None if field is None else FieldPlan(setting, part, field, valid)
        return ContactPlan(setting, inverse, valid, extended)
    return FieldPlan(setting, part, inverse, valid)


@dataclass(frozen=True, eq=False)
class ContactPlan:
    """A solver that finds the contacts by itself, reading by reading."""

    setting: Setting
    operator: ContactOperator
    valid: NDArray[np.bool_]
    extended: FieldPlan | None
    margin: DeadlineMargin = field(default_factory=lambda: DeadlineMargin(300_000, most=2_000_000))

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`."""
        for row, reading in zip(rows, readings, strict=True):
            start, end = time.perf_counter_ns(), until(deadline)
            fit = self.operator.fit(reading, self.margin.before(end))
            late = end is not None and time.perf_counter_ns() >= end
            left = None if end is None else (end - time.perf_counter_ns()) * 1e-9
            if fit.explained or late or not self._take_extended(reading, fit, row, out, left):
                self._write(reading, fit, row, out)
            out.in_time[row] = self.margin.learn(start, end)
            out.notes.extend(note for note in fit.notes if note not in out.notes)

    def _write(self, reading: Floats, fit: Fit, row: int, out: Results) -> None:
        setting, nodes = self.setting, len(self.setting.grid)
        whole, here = len(setting.nodes) == len(setting.model.grid), setting.nodes
        out.contacts[row] = fit.contacts if whole else self._inside(fit.contacts)
        out.fields[row, :nodes] = fit.pressure if whole else fit.pressure[here]
        moved = fit.displacement if whole else fit.displacement[here]
        out.fields[row, nodes:].reshape(3, nodes)[:] = moved.T
        out.pressure_std[row] = fit.pressure_std if whole else fit.pressure_std[here]
        out.residual[row, self.valid] = reading - fit.predicted
        out.gap[row], out.iterations[row] = np.nan, 0

    def _take_extended(
        self, reading: Floats, fit: Fit, row: int, out: Results, deadline: float | None
    ) -> bool:
        """Let a field answer a reading that contacts do not explain, if it explains more."""
        if self.extended is None:
            return False
        self.extended.solve(reading[None] - fit.offset, np.array([row]), out, deadline)
        noise = self.extended.model.noise_std
        left = np.square(out.residual[row, self.valid] / noise).sum()
        if left >= LESS * np.square((reading - fit.predicted) / noise).sum():
            return False
        note = "more than few contacts: a non-negative field answers"
        out.notes.extend([] if note in out.notes else [note])
        return True

    def _inside(self, contacts: tuple[Contact, ...]) -> tuple[Contact, ...]:
        """Contacts that press the window, with the window's own nodes."""
        order = np.argsort(self.setting.nodes)
        nodes = self.setting.nodes[order]
        kept = []
        for contact in contacts:
            place = np.minimum(np.searchsorted(nodes, contact.cells), len(nodes) - 1)
            here = nodes[place] == contact.cells
            if here.any():
                kept.append(replace(contact, cells=np.sort(order[place[here]])))
        return tuple(kept)

    def reset(self) -> None:
        """Forget the reading before."""
        self.operator.reset()
        if self.extended is not None:
            self.extended.reset()

    def within(self, setting: Setting) -> "ContactPlan":
        """See `Plan.within`."""
        extended = None if self.extended is None else self.extended.within(setting)
        return replace(self, setting=setting, extended=extended)


KEPT = 16  # sets of valid taxels whose plans stay prepared, beside that of all


class Plans:
    """What is prepared for all taxels, and for sets of them as they come.

    Parameters
    ----------
    setting : Setting
    solver : Solver
    whole : Plan, optional
        Of all taxels, if it is there already.
    """

    def __init__(self, setting: Setting, solver: Solver, whole: Plan | None = None) -> None:
        self.setting, self._solver = setting, solver
        every = np.ones(len(setting.model.noise_std), np.bool_)
        self.whole = make_plan(setting, solver, every) if whole is None else whole
        self._kept: OrderedDict[bytes, Plan] = OrderedDict()

    def of(self, valid: NDArray[np.bool_]) -> Plan:
        """Plan of the valid taxels, (L,)."""
        if valid.all():
            return self.whole
        key = np.packbits(valid).tobytes()
        if key not in self._kept:
            if len(self._kept) >= KEPT:
                self._kept.popitem(last=False)
            self._kept[key] = self._without(valid)
        self._kept.move_to_end(key)
        return self._kept[key]

    def _without(self, valid: NDArray[np.bool_]) -> Plan:
        shorter = self.whole.without(valid) if isinstance(self.whole, FieldPlan) else None
        return make_plan(self.setting, self._solver, valid) if shorter is None else shorter

    def solve(
        self, table: Floats, valid: NDArray[np.bool_], out: Results, deadline: float | None
    ) -> None:
        """Write the answers of readings (T, L), where `valid` (T, L), into `out`."""
        for pattern, rows in _patterns(valid, self._without_missing(table, valid, out)):
            part = table[rows] if pattern.all() else table[np.ix_(rows, pattern)]
            self.of(pattern).solve(part, rows, out, deadline)

    def prompt(self, reading: Floats, valid: NDArray[np.bool_], end: int | None) -> Answer | None:
        """Answer one reading (L,) at once; None where the plan computes all that there is."""
        whole = bool(valid.all())
        own = reading.copy()  # what is computed later is of this one; the caller may write over his
        if isinstance(self.whole, LinearPlan):
            return self.whole.prompt(own, end) if whole else self.whole.prompt_among(own, valid)
        plan = self.of(valid)
        if not isinstance(plan, FieldPlan):
            return None
        return plan.prompt(own if whole else own[valid], end)

    def within(self, setting: Setting) -> "Plans":
        """The same in another setting of the same patch."""
        other = Plans(setting, self._solver, self.whole.within(setting))
        other._kept.update((key, plan.within(setting)) for key, plan in self._kept.items())
        return other

    def reset(self) -> None:
        """Forget the readings before."""
        for plan in (self.whole, *self._kept.values()):
            plan.reset()

    def run_in(self) -> None:
        """Load what is compiled for contacts and displacement."""
        if isinstance(self.whole, (LinearPlan, FieldPlan)):
            peak = np.zeros(len(self.setting.grid))
            peak[len(peak) // 2] = 1e3 * max(float(self.whole.noise.std.max()), 1.0)
            self.whole.contacts(peak, self.whole.noise, self.whole.posterior)
            self.setting.deformation(np.zeros(len(self.setting.model.grid)))

    def _without_missing(self, table: Floats, valid: NDArray[np.bool_], out: Results) -> Ints:
        """Answer the readings that lack taxels, if the plan of all taxels can; rows that remain."""
        full, plan = valid.all(axis=1), self.whole
        if full.all() or not isinstance(plan, LinearPlan) or plan.missing is None:
            return np.arange(len(valid))
        rows = np.flatnonzero(~full)
        plan.missing.solve(plan, table[rows], valid[rows], rows, out)
        return np.flatnonzero(full)


def _patterns(valid: NDArray[np.bool_], rows: Ints) -> Iterator[tuple[NDArray[np.bool_], Ints]]:
    """Sets of taxels that are valid together in some rows, and the rows that have them."""
    if len(rows) == 1 or valid[rows].all():
        yield from [(valid[rows[0]], rows)] if len(rows) else []
        return
    patterns, which = distinct(valid[rows])
    for index, pattern in enumerate(patterns):
        yield pattern, rows[which == index]
