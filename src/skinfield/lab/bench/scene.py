"""Scene of a benchmark, and its contenders: two fingers that move, solvers behind one call."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skinfield.elastic import BaseStress, BondedLayer, ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ContactFinder
from skinfield.lab.paper import FIELD, LAYER, PAPER, paper_patch
from skinfield.reconstruct import Reconstructor
from skinfield.simulate import Sphere, press
from skinfield.skin import Grid
from skinfield.solve import Solution, Solver

MICROSECONDS = (10, 20, 30, 50, 70, 100, 200, 500)
MILLISECONDS = (1, 2, 5, 10, 20, 50)
LADDER = tuple(us * 1e-6 for us in MICROSECONDS) + tuple(ms * 1e-3 for ms in MILLISECONDS)  # s
GAPS = (1e-2, 1e-4)  # certified: how far above the minimum an objective may be
FIT_DEADLINES = (0.5e-3, 2e-3)  # s: beside none


@dataclass(frozen=True, kw_only=True)
class BenchSize:
    """How much is measured.

    Parameters
    ----------
    name : str
    grids : tuple of int
        Nodes on a side, where Figure 9 has 10 to 40.
    nodes : int
        On a side, of the any-time curves.
    deadlines : tuple of float, s
        Of the any-time curves.
    readings : int
        Of the moving press, that count; before them come some that do not.
    rounds : int
        In which all contenders take turns.
    paper_laps : int
        Of the paper's algorithm per grid, in all rounds together.
    laps : int
        Of a prepared operator per grid and round.
    steps : int
        Readings of the solvers per grid and round.
    cell : float, m
        Of the grid of the true press.
    """

    name: str
    grids: tuple[int, ...] = (10, 20, 30, 40)
    nodes: int = 40
    deadlines: tuple[float, ...] = LADDER
    readings: int
    rounds: int
    paper_laps: int
    laps: int
    steps: int
    cell: float = 0.25e-3


SMOKE = BenchSize(
    name="smoke", grids=(10, 20), nodes=20, deadlines=(30e-6, 1e-3), readings=6, rounds=1,
    paper_laps=2, laps=200, steps=6, cell=1e-3,
)  # fmt: skip
SHORT = BenchSize(name="short", readings=100, rounds=5, paper_laps=10, laps=600, steps=40)
FULL = BenchSize(name="full", readings=300, rounds=15, paper_laps=60, laps=1000, steps=100)
SIZES = {size.name: size for size in (SMOKE, SHORT, FULL)}  # seconds, minutes, half an hour


NOISE = BaseStress().typical_noise  # Pa: taxels read what the paper inverts
LEAD = 8  # readings before those that count, so that a warm chain is warm
RATE = 50.0  # readings per second, as of the iCub's skin
RADIUS = 6e-3  # m, of the fingers' tips
EXTENT = 50e-3  # m: side of the square in which they touch
MIDDLES = np.array([[-10.5e-3, 0.0], [10.5e-3, 0.0]])  # m: the balls never meet
SWAY = np.array([4e-3, 9e-3])  # m, across and along
# 1/s, of x, y and force of each: no two alike, so that no pose comes twice
PACES = np.array([[0.41, 0.67, 0.9], [0.53, 0.59, 1.3]])
PHASES = np.array([[0.0, 0.4, 0.0], [1.3, 1.1, 2.0]])
FORCES = (0.3, 2.0)  # N, the least and the most of each


@dataclass(frozen=True, eq=False)
class BenchScene:
    """T readings of two fingers, after LEAD further ones.

    Attributes
    ----------
    readings : (LEAD + T, L) array, in the quantity's unit
        With noise.
    exact : (LEAD + T, L) array
        Without.
    places : (LEAD + T, 2, 2) array, m
        Of the fingers on the patch's plane.
    forces : (LEAD + T, 2) array, N
    """

    readings: Floats
    exact: Floats
    places: Floats
    forces: Floats

    def __len__(self) -> int:
        return len(self.readings) - LEAD

    def part(self, turn: int, steps: int) -> Floats:
        """Readings (LEAD + steps, L) for a round: one after another, and from the start again."""
        first = max(turn, 0) * steps % max(len(self) - steps + 1, 1)
        return self.readings[first : first + LEAD + steps]


def paths(count: int) -> tuple[Floats, Floats]:
    """Places (count, 2, 2) m and forces (count, 2) N of two fingers, reading by reading."""
    turn = 2 * np.pi * np.arange(count)[:, None, None] / RATE * PACES + PHASES
    swing = np.sin(turn)
    low, high = FORCES
    force = 0.5 * (low + high) + 0.5 * (high - low) * swing[:, :, 2]
    return MIDDLES + SWAY * swing[:, :, :2], force


def make_scene(
    size: BenchSize, seed: int = 0, show: Callable[[int, int], None] = lambda done, of: None
) -> BenchScene:
    """Press a ball for each finger and reading, on a grid of its own, and read the paper's patch.

    Parameters
    ----------
    size : BenchSize
    seed : int
        Of the noise.
    show : function of (done, of)
        Called before each press.
    """
    patch, total = paper_patch(), LEAD + size.readings
    places, forces = paths(total)
    exact = np.empty((total, len(patch)))
    for index in range(total):
        show(index, total)
        balls = [
            Sphere(radius=RADIUS, force=float(force), position=(float(x), float(y)))
            for force, (x, y) in zip(forces[index], places[index], strict=True)
        ]
        solved = press(LAYER, balls, EXTENT, size.cell)
        exact[index] = solved.readings(patch.plane, patch.pad_diameter, "stress")
    noisy = exact + np.random.default_rng(seed).normal(scale=NOISE, size=exact.shape)
    return BenchScene(noisy, exact, places, forces)


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


def iterative(name: str, model: ObservationModel, solver: Solver) -> Contender:
    """A solver that answers reading by reading, in memory of its own."""
    made, finder = solver.prepare(model), ContactFinder()
    data = made.data()

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
