"""From the arrays of a cycle to the estimate of one patch."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import ContactFinder
from skinfield.engine.clockwork import Clockwork
from skinfield.engine.group import Group
from skinfield.engine.report import CycleReport
from skinfield.engine.state import FEASIBLE, LINEAR
from skinfield.errors import Floats
from skinfield.fields import Contact, Estimate, ModelError, PressureError, PressureNoise
from skinfield.layout import Grid


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What is known of an answer's errors, and how readings follow from it."""

    noise: PressureNoise
    posterior: PressureError | None
    pressure_std: Floats
    model_error: ModelError


def grid_on(group: Group, place: int, rung: int) -> Grid:
    """Nodes of a rung on one of the patches, which lie where those of the first do."""
    first, patch = group.kind.patches[0], group.kind.patches[place]
    grid = group.rungs.steps[rung].grid
    return Grid(patch, grid.shape, grid.pitch, grid.origin + patch.plane[0] - first.plane[0])


@dataclass(frozen=True, eq=False)
class Rest:
    """What follows from a pressure, each computed when it is asked for.

    Attributes
    ----------
    group : Group
    answer : int
        Of `Answer`.
    rung : int
    grid : Grid
    pressure : (K,) array, Pa
    readings : (L,) array
        Linearised.
    valid : (L,) bool array
    predicted : (L,) array or None
        Of a linear answer; of others it follows from the pressure.
    finder : ContactFinder
    """

    group: Group
    answer: int
    rung: int
    grid: Grid
    pressure: Floats
    readings: Floats
    valid: NDArray[np.bool_]
    predicted: Floats | None
    finder: ContactFinder

    def traction(self) -> Floats:
        """Of a pressure along the normals, (K, 3) Pa."""
        return np.asarray(-self.pressure[:, None] * self.grid.normals)

    def displacement(self) -> Floats:
        """Of the surface, (K, 3) m."""
        return self.group.rungs.steps[self.rung].deformation.on(self.grid)(self.pressure)

    def pressure_std(self) -> Floats:
        """As the solver states it, (K,) Pa."""
        return _beliefs(self.group, self.answer, self.rung).pressure_std

    def contacts(self) -> tuple[Contact, ...]:
        """By falling force."""
        known = _beliefs(self.group, self.answer, self.rung)
        return self.finder(
            self.grid, self.pressure, known.noise, known.posterior, known.model_error
        )

    def residual(self) -> Floats:
        """Readings less what the pressure predicts, (L,); NaN for taxels that were left out."""
        predicted = self.predicted
        if predicted is None:
            model = self.group.rungs.steps[self.rung].model
            assert model is not None  # searches have one
            predicted = model.matrix @ self.pressure
        return np.asarray(np.where(self.valid, self.readings - predicted, np.nan))


def estimate_of(
    work: Clockwork,
    finder: ContactFinder,
    patch: int,
    grid_of: Callable[[int, int], Grid],
    stamp_ns: int,
    report: CycleReport,
) -> Estimate:
    """Copy a patch's answer out of the arrays; contacts and deformation follow when asked for."""
    state, intake = work.state, work.intake
    group = work.groups[state.group[patch]]
    place, rung, answer = patch - group.first, int(state.rung[patch]), int(state.answer[patch])
    rows = intake.rows_of(patch)
    predicted = None
    if work.linear:
        filled = work.white[group.index][place] * group.kind.noise_std
        predicted = np.asarray(group.rungs.explained @ filled)
    rest = Rest(
        group=group,
        answer=answer,
        rung=rung,
        grid=grid_of(patch, rung),
        pressure=_pressure(group, answer, rung, place),
        readings=intake.linear[rows].copy(),
        valid=intake.valid[rows].copy(),
        predicted=predicted,
        finder=finder,
    )
    following = ("traction", "displacement", "pressure_std", "contacts", "residual")
    return Estimate.later(
        {name: getattr(rest, name) for name in following},
        grid=rest.grid,
        pressure=rest.pressure,
        valid=rest.valid,
        latency=report.spent,
        stamp_ns=stamp_ns,
        gap=float(state.gap[patch]),
        iterations=int(state.iterations[patch]),
        deadline_met=not report.overrun,
        notes=_notes(work, answer, rest.valid),
    )


def _pressure(group: Group, answer: int, rung: int, place: int) -> Floats:
    if answer == LINEAR:
        return np.asarray(group.fields[rung][place], dtype=np.float64)
    if answer == FEASIBLE:
        return np.array(group.feasible[rung][place])
    return np.zeros(len(group.rungs.steps[rung].grid))


def _beliefs(group: Group, answer: int, rung: int) -> Beliefs:
    step = group.rungs.steps[rung]
    operator = step.operator
    if answer == LINEAR or operator is None:
        return Beliefs(step.noise, step.posterior, step.pressure_std, step.model_error)
    return Beliefs(operator.noise, operator.posterior, operator.pressure_std, operator.model_error)


def _notes(work: Clockwork, answer: int, valid: NDArray[np.bool_]) -> tuple[str, ...]:
    notes = []
    if answer == LINEAR and not work.linear:
        notes.append("no time to search: the clipped linear answer, without a certificate")
    if not valid.all():
        missing = int(len(valid) - valid.sum())
        notes.append(f"{missing} taxels left out; pressure_std is that of all taxels")
    return tuple(notes)
