"""Solvers of a benchmark behind one call, and chains of readings that they answer in order."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from skinfield.elastic import BaseStress, BondedLayer, HalfSpace, Mechanics, ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ContactFinder, Estimate
from skinfield.lab.bench.scene import LEAD, BenchSettings
from skinfield.reconstruct import Reconstructor
from skinfield.skin import Grid
from skinfield.solve import (
    ContactFit,
    ContactOperator,
    GaussianField,
    Inverse,
    NonNegative,
    Solver,
)


@dataclass(frozen=True, eq=False)
class Answer:
    """What a contender found last.

    Attributes
    ----------
    pressure : (K,) float32 array, Pa
        A copy.
    contacts : function
        Of no argument: finds the contacts.
    gap : float
        Certified, relative; NaN where none is known.
    met : bool or None
        Whether the solver says that it kept the deadline; None if it does not say.
    iterations : int or None
    """

    pressure: Any
    contacts: Callable[[], Sequence[Contact]]
    gap: float = 0.0
    met: bool | None = None
    iterations: int | None = None


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


@dataclass(eq=False)
class Prepared:
    """A linear solver as one matrix in single precision: pressure and displacement."""

    name: str
    rec: Reconstructor

    def __post_init__(self) -> None:
        self._single = np.empty(len(self.rec.patch), np.float32)
        self._out = np.empty(4 * len(self.rec.grid), np.float32)

    def reset(self) -> None:
        """Nothing is kept."""

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """One product of a matrix and a vector, whatever the deadline."""
        self._single[:] = readings
        self.rec.apply(self._single, self._out)

    def last(self) -> Answer:
        """See `Contender.last`: a closed form has no gap."""
        rec, pressure = self.rec, self._out[: len(self.rec.grid)].copy()
        found = (rec.plan.noise, rec.plan.posterior, rec.plan.model_error)
        return Answer(pressure, lambda: rec.finder(rec.grid, pressure.astype(np.float64), *found))


@dataclass(eq=False)
class Iterative:
    """A field that is found step by step."""

    name: str
    operator: Any  # a FieldOperator with a gap and iterations
    grid: Grid
    finder: ContactFinder = field(default_factory=ContactFinder)

    def __post_init__(self) -> None:
        self._pressure = np.zeros(len(self.grid))

    def reset(self) -> None:
        """See `Contender.reset`."""
        self.operator.reset()

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """See `Contender.answer`."""
        self.operator.apply(readings, self._pressure, deadline_ns)

    def last(self) -> Answer:
        """See `Contender.last`."""
        made, pressure = self.operator, self._pressure.copy()
        found = (made.noise, made.posterior, made.model_error)
        return Answer(
            pressure.astype(np.float32),
            lambda: self.finder(self.grid, pressure, *found),
            float(made.gap),
            getattr(made, "deadline_met", None),
            int(made.iterations),
        )


@dataclass(eq=False)
class Fitted:
    """Contacts that are found without a field."""

    name: str
    operator: ContactOperator
    _fit: Any = None

    def reset(self) -> None:
        """See `Contender.reset`."""
        self.operator.reset()

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """See `Contender.answer`."""
        self._fit = self.operator.fit(readings, deadline_ns)

    def last(self) -> Answer:
        """See `Contender.last`: no bound of its error is known."""
        fit = self._fit
        late = any("deadline" in note for note in fit.notes)
        return Answer(fit.pressure.astype(np.float32), lambda: fit.contacts, np.nan, not late)


@dataclass(eq=False)
class Called:
    """A whole call `rec(readings, deadline=...)`."""

    name: str
    rec: Reconstructor
    latency: list[float] = field(default_factory=list)
    _estimate: Estimate | Any = None

    def reset(self) -> None:
        """See `Contender.reset`."""
        self.rec.reset()

    def answer(self, readings: Floats, deadline_ns: int | None) -> None:
        """See `Contender.answer`."""
        room = None
        if deadline_ns is not None:
            room = max((deadline_ns - time.perf_counter_ns()) * 1e-9, 1e-9)
        self._estimate = self.rec(readings, deadline=room)

    def last(self) -> Answer:
        """See `Contender.last`."""
        made = self._estimate
        self.latency.append(made.latency)
        met = bool(made.deadline_met)
        return Answer(made.pressure, lambda: made.contacts, float(made.gap), met)


def model_of(settings: BenchSettings, nodes: int) -> ObservationModel:
    """What taxels read of pressure on `nodes` x `nodes`, on the bonded layer."""
    grid = Grid.square(settings.patch, nodes=nodes)
    return ObservationModel.of(
        settings.patch, settings.layer, grid, BondedLayer(), settings.quantity, settings.noise
    )


def non_negative(name: str, model: ObservationModel, solver: NonNegative) -> Iterative:
    """A non-negative field."""
    return Iterative(name, solver.prepare(model), model.grid)


def contact_fit(model: ObservationModel) -> Fitted:
    """The contact fit alone: no field stands in for readings that it does not explain."""
    return Fitted("ContactFit", ContactFit(extended=None).prepare(model))


def gaussian(name: str, settings: BenchSettings, nodes: int) -> Prepared:
    """The linear field, prepared once."""
    return Prepared(name, reconstructor(settings, nodes, GaussianField(), precision=np.float32))


def paper_prepared(name: str, settings: BenchSettings, nodes: int) -> Prepared:
    """The paper's inverse, half-space and points, prepared once."""
    point, half_space = BaseStress(pad_averaged=False), HalfSpace(psi=0.25)
    made = reconstructor(settings, nodes, Inverse(), half_space, point, np.float32)
    return Prepared(name, made)


def reconstructor(
    settings: BenchSettings,
    nodes: int,
    solver: Solver,
    mechanics: Mechanics | None = None,
    quantity: BaseStress | None = None,
    precision: Any = np.float64,
) -> Reconstructor:
    """On `nodes` x `nodes`; by default of the bonded layer and the quantity of the settings."""
    return Reconstructor(
        settings.patch,
        settings.layer,
        Grid.square(settings.patch, nodes=nodes),
        mechanics=mechanics or BondedLayer(),
        quantity=quantity or settings.quantity,
        solver=solver,
        noise_std=settings.noise,
        precision=precision,
    )


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
