"""Everything about a patch that needs no reading, by what kind of solver it has."""

import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import ContactFinder
from skinfield.contacts.finder import EXACT
from skinfield.errors import Floats, Ints
from skinfield.fields import Contact, ModelError, PressureNoise, PressurePosterior
from skinfield.inverse import (
    FieldOperator,
    InverseOperator,
)
from skinfield.layout import Grid
from skinfield.observation import Deformation, ObservationModel, Quantity
from skinfield.pipeline.missing import CHUNK, MissingTaxels


@dataclass(frozen=True, eq=False)
class Results:
    """Where T readings' answers are written.

    Attributes
    ----------
    fields : (T, 4 K) array
        Pressure (K) Pa, then displacement x, y, z (K each) m.
    pressure_std : (T, K) array, Pa
    residual : (T, L) array, in the quantity's unit
    contacts : list of T tuples of Contact
    notes : list of str
    """

    fields: Floats
    pressure_std: Floats
    residual: Floats
    contacts: list[tuple[Contact, ...]]
    notes: list[str]

    @classmethod
    def empty(cls, readings: int, taxels: int, nodes: int) -> "Results":
        """Room for some readings."""
        return cls(
            np.empty((readings, 4 * nodes)),
            np.empty((readings, nodes)),
            np.full((readings, taxels), np.nan),
            [()] * readings,
            [],
        )


class Plan(Protocol):
    """Prepared reconstruction from the taxels that are valid."""

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """Write the answers of `readings` (R, L'), in the quantity's unit, into `rows` of `out`.

        `deadline` is in seconds for each reading.
        """
        ...

    def reset(self) -> None:
        """Forget the readings before."""
        ...

    def within(self, setting: "Setting") -> "Plan":
        """The same in another setting of the same patch."""
        ...


@dataclass(frozen=True, eq=False)
class Setting:
    """What all plans of a patch share.

    Attributes
    ----------
    model : ObservationModel
        Of the support: wherever pressure may be.
    deformation : Deformation
        Of the support.
    nodes : (K,) int array
        Of the support, where the answer is wanted.
    grid : Grid
        These nodes.
    quantity : Quantity
    finder : ContactFinder
    precision : numpy.float64 or numpy.float32
    model_errors : bool
        Whether contacts state the solver's own model error; not where intervals are learnt.
    """

    model: ObservationModel
    deformation: Deformation
    nodes: Ints
    grid: Grid
    quantity: Quantity
    finder: ContactFinder
    precision: type[np.floating[Any]]
    model_errors: bool = True


@dataclass(frozen=True, eq=False)
class LinearPlan:
    """Resampling, inversion and displacement in one matrix.

    Attributes
    ----------
    operator : (4 K, L') array, Fortran order
        From linearised readings to pressure (K), then displacement x (K), y (K), z (K).
    explained : (L', L') array
        From linearised readings to what the pressure predicts of them.
    noise : PressureNoise
    pressure_std : (K,) array, Pa
        As the solver states it.
    posterior : PressurePosterior or None
        Of a Bayesian solver.
    model_error : ModelError
        That the solver states beside.
    valid : (L,) bool array
        Which taxels it uses.
    missing : MissingTaxels or None
        What answers readings that lack further taxels, if the solver is a Bayesian one.
    """

    setting: Setting
    operator: NDArray[Any]
    explained: Floats
    noise: PressureNoise
    pressure_std: Floats
    posterior: PressurePosterior | None
    model_error: ModelError
    valid: NDArray[np.bool_]
    missing: MissingTaxels | None = None

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`: one matrix product, whatever the deadline."""
        setting, nodes = self.setting, len(self.setting.grid)
        out.pressure_std[rows] = self.pressure_std
        for first in range(0, len(rows), CHUNK):
            part, chunk = rows[first : first + CHUNK], readings[first : first + CHUNK]
            linear = setting.quantity.linearise(chunk, np.empty_like(chunk))
            out.fields[part] = (self.operator @ linear.T.astype(setting.precision)).T
            out.residual[np.ix_(part, self.valid)] = linear - linear @ self.explained.T
        for row in rows:
            out.contacts[row] = setting.finder(
                setting.grid,
                out.fields[row, :nodes],
                self.noise,
                self.posterior,
                self.model_error if setting.model_errors else EXACT,
            )

    def reset(self) -> None:
        """Nothing is kept."""

    def within(self, setting: Setting) -> "LinearPlan":
        """See `Plan.within`."""
        return replace(self, setting=setting)


def linear_plan(
    setting: Setting,
    model: ObservationModel,
    inverse: InverseOperator,
    valid: NDArray[np.bool_],
) -> LinearPlan:
    """Fold resampling, inversion and displacement into one matrix."""
    nodes, gaussian = setting.nodes, inverse.gaussian if valid.all() else None
    displacement = setting.deformation(inverse.matrix.T)[:, nodes]  # (L', K, 3)
    pressure = inverse.matrix[nodes]
    blocks = [pressure, *np.moveaxis(displacement, (2, 1, 0), (0, 1, 2))]
    return LinearPlan(
        setting=setting,
        operator=np.asfortranarray(np.concatenate(blocks), dtype=setting.precision),
        explained=model.matrix @ inverse.matrix,
        noise=PressureNoise(pressure * model.noise_std),
        pressure_std=inverse.pressure_std[nodes],
        posterior=None if inverse.posterior is None else inverse.posterior.on(nodes),
        model_error=inverse.model_error,
        valid=valid,
        missing=None if gaussian is None else MissingTaxels(gaussian.on(nodes)),
    )


@dataclass(frozen=True, eq=False)
class FieldPlan:
    """A solver whose field is not linear in the readings, reading by reading."""

    setting: Setting
    model: ObservationModel
    operator: FieldOperator
    valid: NDArray[np.bool_]

    @cached_property
    def _noise(self) -> PressureNoise:
        return PressureNoise(self.operator.noise.factor[self.setting.nodes])

    @cached_property
    def _posterior(self) -> PressurePosterior | None:
        whole = self.operator.posterior
        return None if whole is None else whole.on(self.setting.nodes)

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`."""
        setting, nodes = self.setting, len(self.setting.grid)
        whole = np.empty(len(self.model.grid))
        for row, reading in zip(rows, readings, strict=True):
            linear = setting.quantity.linearise(reading, np.empty_like(reading))
            self.operator.apply(linear, whole, until(deadline))
            moved = setting.deformation(whole)[setting.nodes]
            out.fields[row, :nodes] = pressure = whole[setting.nodes]
            out.fields[row, nodes:] = moved.T.ravel()
            out.pressure_std[row] = self.operator.pressure_std[setting.nodes]
            out.residual[row, self.valid] = linear - self.model.matrix @ whole
            out.contacts[row] = setting.finder(
                setting.grid,
                pressure,
                self._noise,
                self._posterior,
                self.operator.model_error if setting.model_errors else EXACT,
            )

    def reset(self) -> None:
        """Forget the reading before, where the operator keeps it."""
        reset = getattr(self.operator, "reset", None)
        if reset is not None:
            reset()

    def within(self, setting: Setting) -> "FieldPlan":
        """See `Plan.within`."""
        return replace(self, setting=setting)


def until(deadline: float | None) -> int | None:
    """Time of `time.perf_counter_ns` at which a deadline in seconds from now ends."""
    return None if deadline is None else time.perf_counter_ns() + int(deadline * 1e9)
