"""A patch whose solver has a field that is not linear in the readings."""

import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts.finder import EXACT
from skinfield.errors import Floats, Ints
from skinfield.fields import Contact, PressureError, PressureNoise, PressurePosterior
from skinfield.inverse import FieldOperator
from skinfield.observation import ObservationModel
from skinfield.pipeline.plan import Answer, Results, Setting, spread_out, until


@dataclass(frozen=True, eq=False)
class FieldPlan:
    """A solver whose field is not linear in the readings, reading by reading.

    Attributes
    ----------
    setting : Setting
    model : ObservationModel
        Of the valid taxels, L' of L; of all where `whole`.
    operator : FieldOperator
    valid : (L,) bool array
    whole : bool
        Whether the operator takes all L readings, of which it leaves out some itself.
    """

    setting: Setting
    model: ObservationModel
    operator: FieldOperator
    valid: NDArray[np.bool_]
    whole: bool = False

    @cached_property
    def noise(self) -> PressureNoise:
        """By which contacts are told."""
        return PressureNoise(self.operator.noise.factor[self.setting.nodes])

    @cached_property
    def posterior(self) -> PressurePosterior | None:
        """By which they are said to be sure."""
        whole = self.operator.posterior
        return None if whole is None else whole.on(self.setting.nodes)

    @cached_property
    def _matrix(self) -> Floats:
        return self.model.matrix[self.valid] if self.whole else self.model.matrix

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`."""
        nodes = len(self.setting.grid)
        for row, reading in zip(rows, readings, strict=True):
            end = until(deadline)
            answer = self.prompt(reading, end)
            out.in_time[row] = end is None or time.perf_counter_ns() <= end
            out.gap[row], out.iterations[row] = answer.gap, answer.iterations
            out.fields[row, :nodes] = answer.pressure
            out.fields[row, nodes:] = answer.rest["displacement"]().T.ravel()
            out.pressure_std[row] = answer.rest["pressure_std"]()
            out.residual[row] = answer.rest["residual"]()
            out.contacts[row] = answer.rest["contacts"]()

    def prompt(self, reading: Floats, end: int | None) -> Answer:
        """Answer one reading (L',) at once, until a time of `time.perf_counter_ns`."""
        setting, operator = self.setting, self.operator
        linear = setting.quantity.linearise(reading, np.empty_like(reading))
        found = np.empty(len(self.model.grid))
        operator.apply(spread_out(linear, self.valid) if self.whole else linear, found, end)
        pressure = found if len(found) == len(setting.nodes) else found[setting.nodes]
        return Answer(
            pressure,
            {
                "displacement": lambda: setting.deformation(found)[setting.nodes],
                "pressure_std": lambda: operator.pressure_std[setting.nodes],
                "contacts": lambda: self.contacts(pressure, self.noise, self.posterior),
                "residual": lambda: spread_out(linear - self._matrix @ found, self.valid),
            },
            getattr(operator, "gap", float("nan")),
            getattr(operator, "iterations", 0),
        )

    def contacts(
        self, pressure: Floats, noise: PressureError, posterior: PressureError | None
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa, whose errors are known."""
        error = self.operator.model_error if self.setting.model_errors else EXACT
        return self.setting.finder(self.setting.grid, pressure, noise, posterior, error)

    def reset(self) -> None:
        """Forget the reading before, where the operator keeps it."""
        reset = getattr(self.operator, "reset", None)
        if reset is not None:
            reset()

    def within(self, setting: Setting) -> "FieldPlan":
        """See `Plan.within`."""
        return replace(self, setting=setting)

    def without(self, valid: NDArray[np.bool_]) -> "FieldPlan | None":
        """Plan that leaves out taxels, if the operator can do so without preparing again."""
        leave_out = getattr(self.operator, "without", None)
        if leave_out is None or not self.valid.all():
            return None
        return FieldPlan(self.setting, self.setting.model, leave_out(valid), valid, whole=True)
