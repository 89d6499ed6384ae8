"""From the arrays of a cycle to the estimate of one patch."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import ContactFinder
from skinfield.engine.clockwork import Clockwork
from skinfield.engine.group import Group
from skinfield.engine.state import Answer
from skinfield.errors import Floats
from skinfield.fields import Estimate, ModelError, PressureError, PressureNoise
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


def estimate_of(
    work: Clockwork,
    finder: ContactFinder,
    patch: int,
    grid_of: Callable[[int, int], Grid],
    stamp_ns: int,
    latency: float,
) -> Estimate:
    """Copy a patch's answer out of the arrays; contacts and deformation follow when asked for."""
    state, intake = work.state, work.intake
    group = work.groups[state.group[patch]]
    place, rung = patch - group.first, int(state.rung[patch])
    rows, answer = intake.rows_of(patch), Answer(state.answer[patch])
    valid = intake.valid[rows].copy()
    pressure = _pressure(group, answer, rung, place)
    readings = intake.linear[rows].copy()
    explained = None
    if work.linear:
        filled = work.white[group.index][place] * group.kind.noise_std
        explained = group.rungs.explained @ filled
    grid = grid_of(patch, rung)

    def rest() -> dict[str, Any]:
        predicted = explained
        if predicted is None:
            model = group.rungs.steps[rung].model
            assert model is not None  # searches have one
            predicted = model.matrix @ pressure
        beliefs = _beliefs(group, answer, rung)
        residual = np.where(valid, readings - predicted, np.nan)
        moved = group.rungs.steps[rung].deformation.on(grid)(pressure)
        found = finder(grid, pressure, beliefs.noise, beliefs.posterior, beliefs.model_error)
        return {
            "traction": -pressure[:, None] * grid.normals,
            "displacement": moved,
            "pressure_std": beliefs.pressure_std,
            "contacts": found,
            "residual": residual,
        }

    return Estimate(
        grid=grid,
        pressure=pressure,
        valid=valid,
        latency=latency,
        stamp_ns=stamp_ns,
        notes=_notes(work, patch, answer, valid),
        **rest(),
    )


def _pressure(group: Group, answer: Answer, rung: int, place: int) -> Floats:
    if answer == Answer.LINEAR:
        return np.asarray(group.fields[rung][place], dtype=np.float64)
    if answer == Answer.FEASIBLE:
        return np.array(group.feasible[rung][place])
    return np.zeros(len(group.rungs.steps[rung].grid))


def _beliefs(group: Group, answer: Answer, rung: int) -> Beliefs:
    step = group.rungs.steps[rung]
    operator = step.operator
    if answer == Answer.LINEAR or operator is None:
        return Beliefs(step.noise, step.posterior, step.pressure_std, step.model_error)
    return Beliefs(operator.noise, operator.posterior, operator.pressure_std, operator.model_error)


def _notes(
    work: Clockwork, patch: int, answer: Answer, valid: NDArray[np.bool_]
) -> tuple[str, ...]:
    notes = []
    if answer == Answer.LINEAR and not work.linear:
        notes.append("no time to search: the clipped linear answer, without a certificate")
    if not valid.all():
        missing = int(len(valid) - valid.sum())
        notes.append(f"{missing} taxels left out; pressure_std is that of all taxels")
    return tuple(notes)
