"""What follows from a pressure on a rung, computed when it is asked for."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import ContactFinder
from skinfield.errors import Floats
from skinfield.fields import Contact, Estimate, ModelError, PressureError, PressureNoise
from skinfield.layout import Grid
from skinfield.pipeline.ladder_focus import Window
from skinfield.pipeline.ladder_missing import ValidTaxels
from skinfield.pipeline.ladder_rungs import Rung, Rungs

FOLLOWING = ("traction", "displacement", "pressure_std", "contacts", "residual")


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What is known of an answer's errors."""

    noise: PressureNoise
    posterior: PressureError | None
    pressure_std: Floats
    model_error: ModelError


def linear_beliefs(rung: Rung) -> Beliefs:
    """Of the linear answer."""
    return Beliefs(rung.noise, rung.posterior, rung.pressure_std, rung.model_error)


def searched_beliefs(rung: Rung) -> Beliefs:
    """Of the answer of a search."""
    operator = rung.operator
    assert operator is not None  # it was searched with
    return Beliefs(operator.noise, operator.posterior, operator.pressure_std, operator.model_error)


def beliefs_in(rung: Rung, window: Window | None) -> Beliefs:
    """Of whichever answer a rung gives, or of its linear answer in a window."""
    if window is None:
        return linear_beliefs(rung) if rung.operator is None else searched_beliefs(rung)
    nodes, whole = window.nodes, linear_beliefs(rung)
    posterior = None if rung.posterior is None else rung.posterior.on(nodes)
    noise = PressureNoise(rung.noise.factor[nodes])
    return Beliefs(noise, posterior, whole.pressure_std[nodes], whole.model_error)


@dataclass(frozen=True, eq=False)
class Rest:
    """What an estimate holds beside its pressure.

    Attributes
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    readings : (L,) array
        Linearised.
    valid : (L,) bool array
    predicted : function that returns (L,) array
        Linearised readings that the answer predicts.
    moved : function that returns (K, 3) array, m
        Displacement.
    beliefs : function that returns Beliefs
    finder : ContactFinder
    """

    grid: Grid
    pressure: Floats
    readings: Floats
    valid: NDArray[np.bool_]
    predicted: Callable[[], Floats]
    moved: Callable[[], Floats]
    beliefs: Callable[[], Beliefs]
    finder: ContactFinder

    def traction(self) -> Floats:
        """Of a pressure along the normals, (K, 3) Pa."""
        return np.asarray(-self.pressure[:, None] * self.grid.normals)

    def displacement(self) -> Floats:
        """Of the surface, (K, 3) m."""
        return self.moved()

    def pressure_std(self) -> Floats:
        """As the solver states it, (K,) Pa."""
        return self.beliefs().pressure_std

    def contacts(self) -> tuple[Contact, ...]:
        """By falling force."""
        known = self.beliefs()
        return self.finder(
            self.grid, self.pressure, known.noise, known.posterior, known.model_error
        )

    def residual(self) -> Floats:
        """Readings less what the pressure predicts, (L,); NaN for taxels that were left out."""
        return np.asarray(np.where(self.valid, self.readings - self.predicted(), np.nan))

    def estimate(self, **known: Any) -> Estimate:
        """The estimate, prompt."""
        return Estimate.later(
            {name: getattr(self, name) for name in FOLLOWING},
            grid=self.grid,
            pressure=self.pressure,
            valid=self.valid,
            **known,
        )


def rest_of_search(
    step: Rung, pressure: Floats, linear: Floats, valid: NDArray[np.bool_], finder: ContactFinder
) -> Rest:
    """Of a search on a rung, whose operator is the one that searched."""
    model = step.model
    assert model is not None  # it was searched with
    return Rest(
        grid=step.grid,
        pressure=pressure,
        readings=linear,
        valid=valid,
        predicted=lambda: np.asarray(model.matrix @ pressure),
        moved=lambda: step.deformation(pressure),
        beliefs=lambda: beliefs_in(step, None),
        finder=finder,
    )


@dataclass(frozen=True, eq=False)
class Linear:
    """The linear answer of a rung, whole or in a window.

    Attributes
    ----------
    rungs : Rungs
    step : Rung
        One of them.
    window : Window or None
    rows : (N, L) array or None
        Of the rung's matrix, in the window.
    known : ValidTaxels or None
        What is prepared without the taxels that are missing, if any are.
    """

    rungs: Rungs
    step: Rung
    window: Window | None
    rows: Floats | None
    known: ValidTaxels | None

    def rest(self, linear: Floats, valid: NDArray[np.bool_], finder: ContactFinder) -> Rest:
        """Pressure of linearised readings, 0 where not valid, and what follows from it."""
        step, window, known, rows = self.step, self.window, self.known, self.rows
        matrix, explained, filled = step.matrix, self.rungs.explained, linear
        if known is not None:
            filled, matrix, explained = known.readings(linear), known.matrix(step), known.explained
            rows = None if window is None else matrix[window.nodes]

        def moved() -> Floats:
            whole = step.deformation(matrix @ filled)
            return whole if window is None else whole[window.nodes]

        return Rest(
            grid=step.grid if window is None else window.grid,
            pressure=np.asarray((matrix if rows is None else rows) @ filled),
            readings=linear,
            valid=valid,
            predicted=lambda: np.asarray(explained @ filled),
            moved=moved,
            beliefs=lambda: beliefs_in(step if known is None else known.on(step), window),
            finder=finder,
        )
