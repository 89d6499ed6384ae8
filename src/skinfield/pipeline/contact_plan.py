"""A patch whose solver finds contacts by itself; and which plan a solver needs."""

import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.fields import Contact
from skinfield.inverse import ContactOperator, Fit, InverseOperator, Solver
from skinfield.pipeline.field_plan import FieldPlan
from skinfield.pipeline.plan import Plan, Results, Setting, linear_plan, until
from skinfield.pipeline.reserve import Reserve

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
    reserve: Reserve = field(default_factory=lambda: Reserve(300_000, most=2_000_000))

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`."""
        for row, reading in zip(rows, readings, strict=True):
            start, end = time.perf_counter_ns(), until(deadline)
            fit = self.operator.fit(reading, self.reserve.before(end))
            late = end is not None and time.perf_counter_ns() >= end
            left = None if end is None else (end - time.perf_counter_ns()) * 1e-9
            if fit.explained or late or not self._answered(reading, fit, row, out, left):
                self._write(reading, fit, row, out)
            out.in_time[row] = self.reserve.learn(start, end)
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

    def _answered(
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
