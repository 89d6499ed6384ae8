"""Solvers of a benchmark behind one call, and chains of readings that they answer in order."""

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from skinfield.elastic import BaseStress, BondedLayer, ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ContactFinder
from skinfield.lab.bench.scene import LEAD, NOISE
from skinfield.lab.paper import FIELD, LAYER, PAPER, paper_patch
from skinfield.reconstruct import Reconstructor
from skinfield.skin import Grid
from skinfield.solve import ContactFit, NonNegative, Operator, Solution


class Outcome(NamedTuple):
    """What a contender found last."""

    pressure: Any  # (K,) float32 array, Pa: a copy
    contacts: Callable[[], Sequence[Contact]]  # finds them
    gap: float = 0.0  # certified, relative; NaN where none is known


class Contender(NamedTuple):
    """A prepared solver that answers reading by reading."""

    name: str  # as it stands in tables and figures
    answer: Callable[[Floats, int | None], object]  # of readings (L,), by a `perf_counter_ns`
    last: Callable[[], Outcome]
    reset: Callable[[], object] = lambda: None  # forgets the reading before


def linear(name: str, rec: Reconstructor) -> Contender:
    """A linear solver as one matrix in single precision: pressure and displacement."""
    single, out = np.empty(len(rec.patch), np.float32), np.empty(4 * len(rec.grid), np.float32)
    noise = (rec.plan.noise, rec.plan.posterior, rec.plan.model_error)

    def answer(readings: Floats, deadline_ns: int | None) -> None:
        single[:] = readings
        rec.apply(single, out)

    def last() -> Outcome:
        pressure = out[: len(rec.grid)].copy()
        return Outcome(pressure, lambda: rec.finder(rec.grid, pressure.astype(np.float64), *noise))

    return Contender(name, answer, last)


def non_negative(name: str, model: ObservationModel, solver: NonNegative) -> Contender:
    """A non-negative field, which is found step by step."""
    return _iterative(name, solver.prepare(model))


def contact_fit(model: ObservationModel) -> Contender:
    """The contact fit alone: no field stands in for readings that it does not explain."""
    return _iterative("ContactFit", ContactFit(extended=None).prepare(model))


def _iterative(name: str, made: Operator) -> Contender:
    data, finder = made.data(), ContactFinder()

    def contacts(solution: Solution) -> Sequence[Contact]:
        found = made.contacts(solution)
        if found is not None:
            return found
        noise = (made.noise, made.posterior, made.model_error)
        return finder(made.model.grid, solution.pressure, *noise)

    def last() -> Outcome:
        solution = data.solution.keep()
        pressure = solution.pressure.astype(np.float32)
        return Outcome(pressure, lambda: contacts(solution), solution.gap)

    return Contender(name, lambda y, by: made.solve(y, data, by), last, data.reset)


def model_of(nodes: int) -> ObservationModel:
    """What the paper's patch reads of pressure on `nodes` x `nodes`, on the bonded layer."""
    grid = Grid.square(paper_patch(), nodes=nodes)
    return ObservationModel.of(paper_patch(), LAYER, grid, BondedLayer(), BaseStress(), NOISE)


def gaussian(name: str, nodes: int) -> Contender:
    """The linear field, prepared once."""
    return linear(name, FIELD.prepared(nodes, NOISE, np.float32))


def paper_prepared(name: str, nodes: int) -> Contender:
    """The paper's inverse, half-space and points, prepared once."""
    return linear(name, PAPER.prepared(nodes, NOISE, np.float32))


class Laps(NamedTuple):
    """What T readings took, (T,) s, and brought, in order."""

    seconds: Floats
    answers: list[Outcome]


def run_chain(
    contender: Contender, readings: Floats, deadline: float | None, *, cold: bool, lead: int = LEAD
) -> Laps:
    """Answer all readings in order; the first `lead` do not count.

    Parameters
    ----------
    contender : Contender
    readings : (lead + T, L) array
    deadline : float, s, or None
        For each reading, from its own start.
    cold : bool
        Forget the reading before, each time; else start from it.
    lead : int
    """
    contender.reset()
    room = None if deadline is None else round(deadline * 1e9)
    spent, answers = np.empty(len(readings)), []
    for index, reading in enumerate(readings):
        if cold:
            contender.reset()
        start = time.perf_counter_ns()
        contender.answer(reading, None if room is None else start + room)
        spent[index] = time.perf_counter_ns() - start
        if index >= lead:
            answers.append(contender.last())
    return Laps(spent[lead:] * 1e-9, answers)
