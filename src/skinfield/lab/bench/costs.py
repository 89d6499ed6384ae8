"""Cost of a reading: solvers behind one call, Figure 9 on this machine, and whole calls."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import cycle
from typing import Any, Protocol

import numpy as np

from skinfield.elastic import BaseStress, BondedLayer, HalfSpace, Mechanics, ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ContactFinder
from skinfield.lab.bench.machine import Spread, laps, spread, undisturbed
from skinfield.lab.bench.scene import FIT_DEADLINES, GAPS, LEAD, BenchSettings, Scene
from skinfield.lab.paper import reconstruct_as_paper, stress_matrix
from skinfield.reconstruct import Reconstructor
from skinfield.skin import Grid
from skinfield.solve import (
    ContactFit,
    ContactOperator,
    FieldOperator,
    Fit,
    GaussianField,
    Inverse,
    NonNegative,
    Solver,
)

NAN = float("nan")
CONVERGED = NonNegative(tolerance=1e-9, precision=np.float64)  # what others are compared with
LONG = NonNegative(tolerance=1e-5)  # goes on while there is time


@dataclass(frozen=True, eq=False)
class Answer:
    """What a contender found last.

    Attributes
    ----------
    pressure : (K,) float32 array, Pa
        A copy.
    gap : float
        Certified, relative; NaN where none is known.
    met : bool or None
        Whether the solver says that it kept the deadline; None if it does not say.
    iterations : int or None
    contacts : tuple of Contact, or None where they must be found in the field
    """

    pressure: Any
    gap: float = 0.0
    met: bool | None = None
    iterations: int | None = None
    contacts: tuple[Contact, ...] | None = None


class Contender(Protocol):
    """A prepared solver that answers reading by reading."""

    @property
    def name(self) -> str:
        """As it stands in tables and figures."""
        ...

    def reset(self) -> None:
        """Forget the reading before."""
        ...

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """Find pressure or contacts of `readings` (L,) by a time of `time.perf_counter_ns`."""
        ...

    def last(self) -> Answer:
        """What was found last."""
        ...

    def contacts(self, pressure: Any) -> tuple[Contact, ...]:
        """Contacts in a field that it found."""
        ...


@dataclass(eq=False)
class Prepared:
    """A linear solver as one matrix in single precision: pressure and displacement."""

    name: str
    rec: Reconstructor

    def __post_init__(self) -> None:
        nodes = len(self.rec.grid)
        self._single = np.empty(len(self.rec.patch), np.float32)
        self._out = np.empty(4 * nodes, np.float32)
        self._pressure = self._out[:nodes]

    def reset(self) -> None:
        """Nothing is kept."""

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """One product of a matrix and a vector, whatever the deadline."""
        self._single[:] = readings
        self.rec.apply(self._single, self._out)

    def last(self) -> Answer:
        """See `Contender.last`: a closed form has no gap."""
        return Answer(self._pressure.copy())

    def contacts(self, pressure: Any) -> tuple[Contact, ...]:
        """See `Contender.contacts`."""
        plan = self.rec.plan
        field = pressure.astype(np.float64)
        return self.rec.finder(self.rec.grid, field, plan.noise, plan.posterior, plan.model_error)


@dataclass(eq=False)
class Iterative:
    """A field that is found step by step."""

    name: str
    operator: FieldOperator
    grid: Grid
    finder: ContactFinder = field(default_factory=ContactFinder)

    def __post_init__(self) -> None:
        self._pressure = np.zeros(len(self.grid))

    def reset(self) -> None:
        """See `Contender.reset`."""
        operator: Any = self.operator
        operator.reset()

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """See `Contender.answer`."""
        self.operator.apply(readings, self._pressure, deadline_ns)

    def last(self) -> Answer:
        """See `Contender.last`."""
        operator: Any = self.operator
        return Answer(
            self._pressure.astype(np.float32),
            float(operator.gap),
            getattr(operator, "deadline_met", None),
            int(operator.iterations),
        )

    def contacts(self, pressure: Any) -> tuple[Contact, ...]:
        """See `Contender.contacts`."""
        operator = self.operator
        return self.finder(
            self.grid,
            pressure.astype(np.float64),
            operator.noise,
            operator.posterior,
            operator.model_error,
        )


@dataclass(eq=False)
class Fitted:
    """Contacts that are found without a field."""

    name: str
    operator: ContactOperator

    def __post_init__(self) -> None:
        self._fit: Fit | None = None

    def reset(self) -> None:
        """See `Contender.reset`."""
        self.operator.reset()

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """See `Contender.answer`."""
        self._fit = self.operator.fit(readings, deadline_ns)

    def last(self) -> Answer:
        """See `Contender.last`: no bound of its error is known."""
        assert self._fit is not None, "nothing was answered yet"
        fit = self._fit
        late = any("deadline" in note for note in fit.notes)
        return Answer(fit.pressure.astype(np.float32), NAN, not late, None, fit.contacts)

    def contacts(self, pressure: Any) -> tuple[Contact, ...]:
        """The fit's own."""
        assert self._fit is not None, "nothing was answered yet"
        return self._fit.contacts


def model_of(settings: BenchSettings, nodes: int) -> ObservationModel:
    """What taxels read of pressure on `nodes` x `nodes`, on the bonded layer."""
    grid = Grid.square(settings.patch, nodes=nodes)
    return ObservationModel.of(
        settings.patch, settings.layer, grid, BondedLayer(), settings.quantity, settings.noise
    )


def non_negative(name: str, model: ObservationModel, solver: NonNegative) -> Iterative:
    """A non-negative field."""
    return Iterative(name, solver.prepare(model), model.grid)


def contact_fit(name: str, model: ObservationModel) -> Fitted:
    """The contact fit alone: no field stands in for readings that it does not explain."""
    return Fitted(name, ContactFit(extended=None).prepare(model))


def gaussian(name: str, settings: BenchSettings, nodes: int) -> Prepared:
    """The linear field, prepared once."""
    return _prepared(name, settings, nodes, GaussianField(), BondedLayer(), settings.quantity)


def paper_prepared(name: str, settings: BenchSettings, nodes: int) -> Prepared:
    """The paper's inverse, half-space and points, prepared once."""
    point = BaseStress(pad_averaged=False)
    return _prepared(name, settings, nodes, Inverse(), HalfSpace(psi=0.25), point)


def _prepared(
    name: str,
    settings: BenchSettings,
    nodes: int,
    solver: Solver,
    mechanics: Mechanics,
    quantity: BaseStress,
) -> Prepared:
    rec = Reconstructor(
        settings.patch,
        settings.layer,
        Grid.square(settings.patch, nodes=nodes),
        mechanics=mechanics,
        quantity=quantity,
        solver=solver,
        noise_std=settings.noise,
        precision=np.float32,
    )
    return Prepared(name, rec)


@dataclass(frozen=True, eq=False)
class Chain:
    """What T readings took and brought, in order.

    Attributes
    ----------
    seconds : (T,) array
        Of each call.
    answers : list of T Answer
    """

    seconds: Floats
    answers: list[Answer]


def run_chain(
    contender: Contender, readings: Floats, deadline: float | None, *, cold: bool, lead: int = LEAD
) -> Chain:
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
    return Chain(spent[lead:] * 1e-9, answers)


PAPER, INVERSION = "paper", "paper, inversion alone"
PREPARED, FIELD = "paper's inverse, prepared", "GaussianField, prepared"
WARM_UP = -1  # the round that does not count
PAPER_REST_MS = {20: 0.4, 40: 1.4}  # as the paper states: all of it but the inversion
Show = Callable[[str, int, int], None]


@dataclass(frozen=True)
class GridTime:
    """Time per reading of one method on one grid.

    Attributes
    ----------
    nodes : int
        On a side.
    name : str
    seconds : Spread
    certified : float or None
        Share of the readings whose gap was certified as asked; None where none was.
    """

    nodes: int
    name: str
    seconds: Spread
    certified: float | None = None


@dataclass(eq=False)
class _Row:
    """A method on a grid, with the laps so far."""

    nodes: int
    name: str
    lap: Callable[[int], tuple[Floats, list[float]]]  # of a round: seconds, gaps
    target: float | None = None
    seconds: list[Floats] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)

    def take(self, turn: int) -> None:
        seconds, gaps = self.lap(turn)
        self.seconds.append(seconds)
        self.gaps.extend(gaps)

    def result(self) -> GridTime:
        found = spread(np.concatenate(self.seconds))
        assert found is not None, "a round has laps"
        share = None
        if self.target is not None:
            share = float(np.mean(np.array(self.gaps) <= self.target))
        return GridTime(self.nodes, self.name, found, share)


def grid_times(settings: BenchSettings, scene: Scene, show: Show) -> list[GridTime]:
    """Time every method on every grid, in turns."""
    size = settings.size
    rows: list[_Row] = []
    for done, nodes in enumerate(size.grids):
        show(f"preparing {nodes} x {nodes}", done, len(size.grids))
        rows.extend(_rows(settings, scene, nodes))
    for row in rows:
        show("warming up", 0, 1)
        row.lap(WARM_UP)
    for turn in range(size.rounds):
        for row in rows:
            show(f"{row.name}, {row.nodes} x {row.nodes}", turn, size.rounds)
            with undisturbed():
                row.take(turn)
    return [row.result() for row in rows]


def _rows(settings: BenchSettings, scene: Scene, nodes: int) -> Iterator[_Row]:
    yield from _paper_rows(settings, scene, nodes)
    for made in (
        paper_prepared(PREPARED, settings, nodes),
        gaussian(FIELD, settings, nodes),
    ):
        yield _Row(nodes, made.name, _repeated(made, scene, settings.size.laps))
    model, steps = model_of(settings, nodes), settings.size.steps
    for gap in GAPS:
        name = f"NonNegative to {gap:.0e}".replace("e-0", "e-")
        found = non_negative(name, model, NonNegative(tolerance=gap))
        for start in ("warm", "cold"):
            lap = _chained(found, scene, steps, None, cold=start == "cold")
            yield _Row(nodes, f"{found.name}, {start}", lap, target=gap)
    fit = contact_fit("ContactFit", model)
    for deadline in (*FIT_DEADLINES, None):
        within = "" if deadline is None else f" within {1e3 * deadline:g} ms"
        yield _Row(nodes, fit.name + within, _chained(fit, scene, steps, deadline, cold=False))


def _paper_rows(settings: BenchSettings, scene: Scene, nodes: int) -> Iterator[_Row]:
    """The algorithm as printed, all of it for every reading, and its inversion alone."""
    patch, layer = settings.patch, settings.layer
    grid = Grid.square(patch, nodes=nodes)
    plane, area = grid.plane, grid.cell_area
    matrix = stress_matrix(plane[:, None] - plane[None], layer.thickness)
    count = -(-settings.size.paper_laps // settings.size.rounds)
    readings = cycle(scene.readings)

    def whole() -> object:
        return reconstruct_as_paper(next(readings), patch.plane, plane, layer, area)

    def invert() -> object:
        return np.linalg.inv(matrix)

    for name, work in ((PAPER, whole), (INVERSION, invert)):
        yield _Row(nodes, name, _counted(work, count))


def _counted(work: Callable[[], object], count: int) -> Callable[[int], tuple[Floats, list[float]]]:
    """Laps of what has no gap; one alone to warm up."""
    return lambda turn: (laps(work, 1 if turn == WARM_UP else count), [])


def _repeated(
    made: Contender, scene: Scene, count: int
) -> Callable[[int], tuple[Floats, list[float]]]:
    """Laps of a method that takes equally long for every reading."""
    reading = scene.readings[LEAD]
    return _counted(lambda: made.answer(reading, None), count)


def _chained(
    made: Contender, scene: Scene, steps: int, deadline: float | None, *, cold: bool
) -> Callable[[int], tuple[Floats, list[float]]]:
    """Readings in order, others in each round."""

    def lap(turn: int) -> tuple[Floats, list[float]]:
        chain = run_chain(made, scene.part(turn, steps), deadline, cold=cold)
        return chain.seconds, [answer.gap for answer in chain.answers]

    return lap


SOLVERS: dict[str, Solver] = {
    "GaussianField": GaussianField(),
    "NonNegative": NonNegative(),
    "ContactFit": ContactFit(),
}


@dataclass(frozen=True, kw_only=True)
class Call:
    """`rec(readings, deadline=...)` of one solver at one deadline, warm.

    Attributes
    ----------
    solver : str
    deadline : float or None, s
    seconds : Spread
        By the clock outside of the call.
    latency : Spread or None
        As `Estimate.latency` says.
    gap : Spread or None
        As `Estimate.gap` says.
    reported : float
        Share of the estimates whose `deadline_met` is true.
    late : Spread or None, s
        By how much calls ended after the deadline, by the clock outside; 0 where before.
    """

    solver: str
    deadline: float | None
    seconds: Spread | None
    latency: Spread | None
    gap: Spread | None
    reported: float
    late: Spread | None


@dataclass(eq=False)
class _Calls:
    solver: str
    rec: Reconstructor
    deadline: float | None
    rows: list[tuple[float, float, float, bool]]  # seconds, latency, gap, met

    def take(self, readings: Floats) -> None:
        """Call for all readings in order; the first do not count."""
        self.rec.reset()
        for index, reading in enumerate(readings):
            start = time.perf_counter_ns()
            estimate = self.rec(reading, deadline=self.deadline)
            spent = (time.perf_counter_ns() - start) * 1e-9
            if index >= LEAD:
                said = (estimate.latency, float(estimate.gap), bool(estimate.deadline_met))
                self.rows.append((spent, *said))

    def result(self) -> Call:
        seconds, latency, gap, reported = np.array(self.rows, dtype=np.float64).T
        late = None if self.deadline is None else spread(np.maximum(seconds - self.deadline, 0))
        return Call(
            solver=self.solver,
            deadline=self.deadline,
            seconds=spread(seconds),
            latency=spread(latency),
            gap=spread(gap),
            reported=float(reported.mean()),
            late=late,
        )


def whole_calls(settings: BenchSettings, scene: Scene, show: Show) -> list[Call]:
    """Call every solver at every deadline, in turns, in another order each round."""
    todo = []
    for done, (name, solver) in enumerate(SOLVERS.items()):
        show("preparing reconstructors", done, len(SOLVERS))
        rec = Reconstructor(
            settings.patch,
            settings.layer,
            Grid.square(settings.patch, nodes=settings.size.nodes),
            quantity=settings.quantity,
            solver=solver,
            noise_std=settings.noise,
        )
        ladder = () if isinstance(solver, GaussianField) else settings.size.deadlines
        todo += [_Calls(name, rec, deadline, []) for deadline in (*ladder, None)]
    rng, rounds = np.random.default_rng(settings.seed), settings.size.rounds
    for turn in range(rounds):
        for done, which in enumerate(rng.permutation(len(todo))):
            show(f"calls, round {turn + 1} of {rounds}", done, len(todo))
            with undisturbed():
                todo[which].take(scene.part(turn, settings.size.steps))
    return [each.result() for each in todo]
