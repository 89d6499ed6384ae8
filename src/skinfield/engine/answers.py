"""From the arrays of a cycle to the estimate of one patch."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import ContactFinder
from skinfield.engine.clockwork import Clockwork
from skinfield.engine.group import Group
from skinfield.engine.report import CycleReport
from skinfield.engine.state import FEASIBLE, LINEAR
from skinfield.errors import Floats
from skinfield.fields import Estimate
from skinfield.layout import Grid
from skinfield.pipeline.ladder_estimate import Rest, linear_beliefs, searched_beliefs


def grid_on(group: Group, place: int, rung: int) -> Grid:
    """Nodes of a rung on one of the patches, which lie where those of the first do."""
    first, patch = group.kind.patches[0], group.kind.patches[place]
    grid = group.rungs.steps[rung].grid
    return Grid(patch, grid.shape, grid.pitch, grid.origin + patch.plane[0] - first.plane[0])


def grid_of(work: Clockwork, patch: int, rung: int) -> Grid:
    """Nodes of a rung on a patch, by its row."""
    group, place = work.places[patch]
    return grid_on(group, place, rung)


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
    step, grid, rows = group.rungs.steps[rung], grid_of(patch, rung), intake.rows_of(patch)
    pressure, valid = _pressure(group, answer, rung, place), intake.valid[rows].copy()
    filled = work.white[group.index][place] * group.kind.noise_std

    def predicted() -> Floats:
        if step.model is None:
            return np.asarray(group.rungs.explained @ filled)
        return np.asarray(step.model.matrix @ pressure)

    linear = answer == LINEAR or step.operator is None
    return Rest(
        grid=grid,
        pressure=pressure,
        readings=intake.linear[rows].copy(),
        valid=valid,
        predicted=predicted,
        moved=lambda: step.deformation.on(grid)(pressure),
        beliefs=lambda: linear_beliefs(step) if linear else searched_beliefs(step),
        finder=finder,
    ).estimate(
        latency=report.spent,
        stamp_ns=stamp_ns,
        gap=float(state.gap[patch]),
        iterations=int(state.iterations[patch]),
        deadline_met=not report.overrun,
        notes=_notes(work, answer, valid),
    )


def _pressure(group: Group, answer: int, rung: int, place: int) -> Floats:
    if answer == LINEAR:
        return np.asarray(group.fields[rung][place], dtype=np.float64)
    if answer == FEASIBLE:
        return np.array(group.feasible[rung][place])
    return np.zeros(len(group.rungs.steps[rung].grid))


def _notes(work: Clockwork, answer: int, valid: NDArray[np.bool_]) -> tuple[str, ...]:
    notes = []
    if answer == LINEAR and not work.linear:
        notes.append("no time to search: the clipped linear answer, without a certificate")
    if not valid.all():
        missing = int(len(valid) - valid.sum())
        notes.append(f"{missing} taxels left out; pressure_std is that of all taxels")
    return tuple(notes)
