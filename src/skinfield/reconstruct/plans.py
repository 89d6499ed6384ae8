"""Plans of a patch: those of solvers that search, and one for whichever taxels answer."""

import time
from collections import OrderedDict
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, PressureNoise, PressurePosterior
from skinfield.estimate.finder import EXACT
from skinfield.reconstruct.plan import (
    DeadlineMargin,
    LinearPlan,
    PatchAnswer,
    ResultArrays,
    Setting,
    distinct,
    linear_plan,
    spread_out,
    until,
)
from skinfield.solve import ContactOperator, FieldOperator, Fit, InverseOperator, Solver


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
    margin : DeadlineMargin
    whole : bool
        Whether the operator takes all L readings, of which it leaves out some itself.
    """

    setting: Setting
    model: ObservationModel
    operator: FieldOperator
    valid: NDArray[np.bool_]
    margin: DeadlineMargin = field(default_factory=DeadlineMargin)
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

    def prompt(self, reading: Floats, end: int | None) -> PatchAnswer:
        """Answer one reading (L',) at once, until a time of `time.perf_counter_ns`."""
        setting, operator = self.setting, self.operator
        linear = setting.linearised(reading)
        found = np.empty(len(self.model.grid))
        taken = spread_out(linear, self.valid) if self.whole else linear
        operator.apply(taken, found, self.margin.before(end))
        pressure = found if len(found) == len(setting.nodes) else found[setting.nodes]
        iterations = getattr(operator, "iterations", 0)

        def residual() -> Floats:
            matrix = self.model.matrix[self.valid] if self.whole else self.model.matrix
            return spread_out(linear - matrix @ found, self.valid)

        return PatchAnswer(
            pressure,
            {
                "displacement": lambda: setting.deformation(found)[setting.nodes],
                "pressure_std": lambda: operator.pressure_std[setting.nodes],
                "contacts": lambda: self.contacts(pressure),
                "residual": residual,
            },
            getattr(operator, "gap", float("nan")),
            iterations,
            getattr(operator, "notes", ()),
            margin=self.margin if iterations > 0 else None,
        )

    def contacts(self, pressure: Floats) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa."""
        known = self.noise, self.posterior, self.operator.model_error
        return self.setting.contacts(pressure, *known)

    def reset(self) -> None:
        """Forget the reading before, where the operator keeps it."""
        reset = getattr(self.operator, "reset", None)
        if reset is not None:
            reset()

    def without(self, valid: NDArray[np.bool_]) -> "FieldPlan | None":
        """Plan that leaves out taxels, if the operator can do so without preparing again."""
        leave_out = getattr(self.operator, "without", None)
        if leave_out is None or not self.valid.all():
            return None
        return replace(self, operator=leave_out(valid), valid=valid, whole=True)


LESS = 0.5  # of the squares that contacts leave over, a field must leave to answer in their place


@dataclass(frozen=True, eq=False)
class ContactPlan:
    """A solver that finds the contacts by itself, reading by reading."""

    setting: Setting
    operator: ContactOperator
    valid: NDArray[np.bool_]
    extended: FieldPlan | None
    margin: DeadlineMargin = field(default_factory=lambda: DeadlineMargin(300_000, most=2_000_000))

    def prompt(self, reading: Floats, end: int | None) -> PatchAnswer:
        """Answer one reading (L',), all of it, until a time of `time.perf_counter_ns`."""
        fit = self.operator.fit(reading, self.margin.before(end))
        late = end is not None and time.perf_counter_ns() >= end
        chosen: bool | None = getattr(self.operator, "field_answers", None)
        asked = not fit.explained if chosen is None else chosen
        if asked and not late and self.extended is not None:
            field = self.extended.prompt(reading - fit.offset, end)
            if chosen:
                return replace(field, notes=(*fit.notes, *field.notes), margin=self.margin)
            if self._explains_more(field, reading - fit.predicted):
                note = "more than few contacts: a non-negative field answers"
                return replace(field, notes=(note, *fit.notes), margin=self.margin)
        here = self.setting.nodes
        whole = len(here) == len(self.setting.model.grid)
        return PatchAnswer(
            fit.pressure if whole else fit.pressure[here],
            {
                "displacement": lambda: fit.displacement if whole else fit.displacement[here],
                "pressure_std": lambda: fit.pressure_std if whole else fit.pressure_std[here],
                "contacts": lambda: fit.contacts if whole else self._inside(fit),
                "residual": lambda: spread_out(reading - fit.predicted, self.valid),
            },
            float("nan"),
            notes=fit.notes,
            margin=self.margin,
        )

    def _explains_more(self, field: PatchAnswer, left: Floats) -> bool:
        """Whether a field leaves far less of a reading than contacts, which leave `left` (L',)."""
        assert self.extended is not None
        noise = self.extended.model.noise_std
        over = np.square(field.rest["residual"]()[self.valid] / noise).sum()
        return bool(over < LESS * np.square(left / noise).sum())

    def _inside(self, fit: Fit) -> tuple[Contact, ...]:
        """Contacts that press the window, with the window's own nodes."""
        order = np.argsort(self.setting.nodes)
        nodes = self.setting.nodes[order]
        kept = []
        for contact in fit.contacts:
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


Plan = LinearPlan | FieldPlan | ContactPlan


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
            shorter = self.whole.without(valid) if isinstance(self.whole, FieldPlan) else None
            self._kept[key] = shorter or make_plan(self.setting, self._solver, valid)
        self._kept.move_to_end(key)
        return self._kept[key]

    def solve(
        self, table: Floats, valid: NDArray[np.bool_], out: ResultArrays, deadline: float | None
    ) -> None:
        """Write the answers of readings (T, L), where `valid` (T, L), into `out`.

        `deadline` is in seconds for each reading.
        """
        rows, plan = np.arange(len(table)), self.whole
        if isinstance(plan, LinearPlan) and plan.gaussian is not None:
            full = valid.all(axis=1)
            rows, short = np.flatnonzero(full), np.flatnonzero(~full)
            if len(short):
                plan.solve_among(table[short], valid[short], short, out)
        patterns, which = distinct(valid[rows])
        for index, pattern in enumerate(patterns):
            these = rows[which == index]
            part = table[these] if pattern.all() else table[np.ix_(these, pattern)]
            plan = self.of(pattern)
            if isinstance(plan, LinearPlan):
                plan.solve(part, these, out)
                continue
            for row, reading in zip(these, part, strict=True):
                end = until(deadline, start := time.perf_counter_ns())
                answer = plan.prompt(reading, end)
                out.in_time[row] = answer.met(start, end)
                out.take(row, answer)

    def prompt(self, reading: Floats, valid: NDArray[np.bool_], end: int | None) -> PatchAnswer:
        """Answer one reading (L,) at once."""
        own = reading.copy()  # what is computed later is of this one; the caller may write over his
        if valid.all():
            return self.whole.prompt(own, end)
        if isinstance(self.whole, LinearPlan) and self.whole.gaussian is not None:
            return self.whole.prompt(own, end, valid)
        return self.of(valid).prompt(own[valid], end)

    def within(self, setting: Setting) -> "Plans":
        """The same in another setting of the same patch."""

        def moved(plan: Plan) -> Plan:
            if isinstance(plan, ContactPlan) and plan.extended is not None:
                plan = replace(plan, extended=replace(plan.extended, setting=setting))
            return replace(plan, setting=setting)

        other = Plans(setting, self._solver, moved(self.whole))
        other._kept.update((key, moved(plan)) for key, plan in self._kept.items())
        return other

    def reset(self) -> None:
        """Forget the readings before."""
        for plan in (self.whole, *self._kept.values()):
            plan.reset()

    def run_in(self) -> None:
        """Load what is compiled for contacts and displacement."""
        plan = self.whole
        if isinstance(plan, ContactPlan):
            return
        peak = np.zeros(len(self.setting.grid))
        peak[len(peak) // 2] = 1e3 * max(float(plan.noise.std.max()), 1.0)
        self.setting.contacts(peak, plan.noise, plan.posterior, EXACT)
        self.setting.deformation(np.zeros(len(self.setting.model.grid)))
