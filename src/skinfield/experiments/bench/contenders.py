"""What is timed: prepared solvers behind one call, `answer(readings, deadline_ns)`."""

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from skinfield.contacts import ContactFinder
from skinfield.errors import Floats
from skinfield.experiments.bench.settings import BenchSettings
from skinfield.fields import Contact
from skinfield.inverse import (
    ContactFit,
    ContactOperator,
    FieldOperator,
    Fit,
    GaussianField,
    Inverse,
    NonNegative,
    Solver,
)
from skinfield.layout import Grid
from skinfield.mechanics import BondedLayer, HalfSpace, Mechanics
from skinfield.observation import BaseStress, ObservationModel
from skinfield.pipeline import Reconstructor

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
