"""Contacts as few round or drawn-out loads: the most accurate answer on a thin skin."""

import time
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ModelError, PressureError, PressureNoise
from skinfield.solve.atoms.settings import FitSettings
from skinfield.solve.dual.problem import DualProblem
from skinfield.solve.non_negative import NonNegativeOperator
from skinfield.solve.operator import EXACT, Data, DeadlineMargin, Solution

if TYPE_CHECKING:
    from skinfield.solve.atoms.fitter import ContactFitter

LESS = 0.5  # of the squares that contacts leave over, a field must leave to answer in their place


class ContactData(Data):
    """Scratch memory of a `ContactOperator`, and its reading before."""

    def __init__(self, operator: "ContactOperator") -> None:
        margin = DeadlineMargin(300_000, most=2_000_000)
        super().__init__(operator, len(operator.model.grid), margin)
        self.fitter = copy(operator.fitter)
        self.field: Any = None if operator.field is None else operator.field.data()
        self.reset()

    def reset(self) -> None:
        """Forget the reading before."""
        self.fitter.reset()
        if self.field is not None:
            self.field.reset()


@dataclass(frozen=True, eq=False)
class ContactOperator:
    """Prepared search for the contacts that explain L readings.

    Attributes
    ----------
    solver : ContactFit
    model : ObservationModel
    fitter : ContactFitter
        Of which each memory has a copy.
    noise_std : (L,) array, in the quantity's unit
        Infinite of taxels that are left out.
    field : NonNegativeOperator, optional
        What answers the readings that no few contacts explain.
    valid : (L,) bool array, optional
        Taxels that are used. Default all.
    """

    solver: "ContactFit"
    model: ObservationModel
    fitter: "ContactFitter"
    noise_std: Floats
    field: NonNegativeOperator | None
    valid: NDArray[np.bool_] | None = None
    linear = None  # no matrix

    @property
    def problem(self) -> DualProblem | None:
        """Of the field that stands in: an engine's test of idle patches."""
        return None if self.field is None else self.field.problem

    @property
    def noise(self) -> PressureError:
        """Of the field that stands in."""
        if self.field is None:
            return PressureNoise(np.zeros(self.model.matrix.T.shape))
        return self.field.noise

    @property
    def posterior(self) -> PressureError | None:
        """Of the field that stands in."""
        return None if self.field is None else self.field.posterior

    @property
    def model_error(self) -> ModelError:
        """Of the field that stands in."""
        return EXACT if self.field is None else self.field.model_error

    def data(self) -> ContactData:
        """Make its scratch memory."""
        return ContactData(self)

    def solve(
        self, readings: Floats, data: ContactData, deadline_ns: int | None = None
    ) -> Solution:
        """See `Operator.solve`; for the moment arrays are allocated."""
        readings, solution = data.heard(readings, self.valid), data.solution
        data.fitter.take_noise(self.noise_std)
        fit = data.fitter.fit(readings, deadline_ns)
        late = deadline_ns is not None and time.perf_counter_ns() >= deadline_ns
        if not (fit.explained or late or self.field is None):
            field = self.field.solve(readings - fit.offset, data.field, deadline_ns)
            left = self._squares(readings - fit.predicted)
            if self._squares(field.residual) < LESS * left:
                note = "more than few contacts: a non-negative field answers"
                solution.take(field)
                solution.notes, solution.offset = (note, *fit.notes), fit.offset
                return solution
        name, nothing = type(self.solver).__name__, float("nan")
        parts = fit.pressure, readings, name, self, nothing, nothing, nothing, 0
        in_time = deadline_ns is None or time.perf_counter_ns() <= deadline_ns
        solution.take(Solution(*parts, in_time, fit.notes, fit.offset, fit))
        return solution

    def _squares(self, left: Floats) -> float:
        """Of what is left over of readings (L,), over their noise."""
        return float(np.square(left / self.noise_std).sum())

    def without(self, valid: NDArray[np.bool_]) -> "ContactOperator":
        """See `Operator.without`; nothing is prepared anew."""
        noise = np.where(valid, self.model.noise_std, np.inf)
        field = None if self.field is None else self.field.without(valid)
        return replace(self, noise_std=noise, field=field, valid=np.array(valid, np.bool_))

    def predicted(self, solution: Solution) -> Floats:
        """See `Operator.predicted`."""
        if solution.fit is not None:
            return solution.fit.predicted
        return np.asarray(self.model.matrix @ solution.pressure)

    def contacts(self, solution: Solution) -> tuple[Contact, ...] | None:
        """See `Operator.contacts`: None where the field answered."""
        return None if solution.fit is None else solution.fit.contacts

    def pressure_std(self, solution: Solution) -> Floats:
        """See `Operator.pressure_std`."""
        if solution.fit is not None:
            return solution.fit.pressure_std
        return self.noise.std if self.field is None else self.field.pressure_std()

    def displacement(self, solution: Solution) -> Floats | None:
        """See `Operator.displacement`."""
        return None if solution.fit is None else solution.fit.displacement


@dataclass(frozen=True, kw_only=True)
class ContactFit(FitSettings):
    r"""Fit of the fewest contacts that explain the readings.

    Between taxels a thin skin is nearly blind, so a field must guess there. A contact has few
    unknowns: place, force and radius, and for a line its length and direction. Each is an atom:
    the pressure of a ball or of a flat end on the layer, exact, whose readings are tabulated with
    the nonlinear field in the gap for capacitance. Atoms are added where the residual is most
    significant, all are refined together (Levenberg 1944), and shapes are chosen by their marginal
    likelihood (Laplace's approximation; MacKay 2003, Information Theory, chapter 28).

    Parameters
    ----------
    most_contacts : int
        Atoms that are sought at most.
    false_alarm_rate : float
        Readings of an idle patch in which a contact may be seen, at most.
    typical_radius : float, m
        Of curvature of what touches: the middle of a broad prior, within a factor of two.
    model_error : float
        Of the readings, part of the highest: what no atom can explain.
    starts : int
        Places from which each new contact is sought.
    warm : bool
        Start from the reading before. Its answer is kept only as long as it explains the readings.
    common_mode : float
        Standard deviation of an offset that all taxels share, such as a drift, in those of the
        noise; it is integrated out. 0 for none.
    extended : NonNegative or None
        Answers the readings that no few contacts explain, such as a whole palm's; the estimate's
        `notes` say so. None leaves them to the best set of contacts.
    """

    def prepare(self, model: ObservationModel) -> ContactOperator:
        """Tabulate what single contacts are read as, and templates of them all over the patch."""
        from skinfield.solve.atoms.fitter import ContactFitter

        fitter = ContactFitter(self, model)
        fitter.run_in()
        return ContactOperator(self, model, fitter, model.noise_std, fitter.extended)
