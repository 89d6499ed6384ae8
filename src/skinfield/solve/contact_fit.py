"""Contacts as few round or drawn-out loads: the most accurate answer on a thin skin."""

import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import MODE
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ModelError, PressureError, PressureNoise
from skinfield.estimate.live_contacts import CONTACT
from skinfield.estimate.row_contacts import contacts_of_rows, pressure_std_of_rows
from skinfield.solve.atoms.fit_data import FitData
from skinfield.solve.atoms.fitter import AtomFit, ContactFitter, FitSettings
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.idle_kernel import WIDE, WideLoads
from skinfield.solve.operator import EXACT, Data, DeadlineMargin, Solution
from skinfield.solve.packed import Packed


class ContactData(Data):
    """Scratch memory of a `ContactOperator`, and its reading before.

    Attributes
    ----------
    rows : (most,) array of CONTACT
        Contacts of the last reading, by falling force; `patch`, `track`, `age` and `speed` are
        left to others.
    count : int
        How many of the rows hold.
    choice : MechanicsChoice
        Of all fits of the readings, which grids of a patch share.
    """

    rows: NDArray[np.void]

    def __init__(self, operator: "ContactOperator") -> None:
        super().__init__(operator, len(operator.model.grid), DeadlineMargin(most=30_000))
        self.rows, self.count = np.zeros(operator.solver.most_contacts, CONTACT), 0
        self.follows = operator.solver.warm
        self.choice, self._operator = operator.fitter.data(), operator

    @property
    def fit(self) -> FitData:
        """By the mechanics that are more probable."""
        return self.choice.fit

    @property
    def settled(self) -> bool:
        """Whether all sets of contacts were compared, or these explain all."""
        return self.fit.settled

    @property
    def noise(self) -> Floats:
        """Deviation (L,) of what is solved next, in the quantity's unit; may be written to.

        Averages have less than the operator's. Taxels that are left out count as infinite.
        """
        return self.fit.noise

    def reset(self) -> None:
        """Forget the reading before."""
        self.choice.reset()

    def start_from(self, other: Data) -> None:
        """Go on with the memory of another grid's fit, from now on with the same one."""
        if isinstance(other, ContactData):
            self.choice = other.choice

    def keep(self) -> AtomFit:
        """What was found in the last reading, which nothing overwrites."""
        operator, rows = self._operator, self.rows[: self.count]
        return operator.fitter.answer_of(self.fit, operator.renderer, rows)


@dataclass(frozen=True, eq=False)
class ContactOperator:
    """Prepared search for the contacts that explain L readings.

    Attributes
    ----------
    solver : ContactFit
    model : ObservationModel
    fitter : ContactFitter
        Shared by all grids of a patch.
    renderer : AtomRenderer
        For the grid.
    valid : (L,) bool array, optional
        Taxels that are used. Default all.
    """

    solver: "ContactFit"
    model: ObservationModel
    fitter: ContactFitter
    renderer: AtomRenderer
    valid: NDArray[np.bool_] | None = None
    linear = None  # no matrix
    posterior: ClassVar[PressureError | None] = None  # its contacts state their own
    model_error: ClassVar[ModelError] = EXACT

    @property
    def noise(self) -> PressureError:
        """None: no contact is found in its pressure."""
        return PressureNoise(np.zeros(self.model.matrix.T.shape))

    def data(self) -> ContactData:
        """Make its scratch memory."""
        return ContactData(self)

    def on(self, model: ObservationModel) -> "ContactOperator":
        """The same fit for another grid of the patch; all else is shared."""
        physics = model.physics
        assert physics is not None  # as it is that of the grid before
        renderer = AtomRenderer(model.grid, physics.flat.layer, physics.flat.mechanics)
        return replace(self, model=model, renderer=renderer)

    @cached_property
    def wide(self) -> Packed:
        """No loads as wide as those of a field: see `idle_kernel`."""
        none = np.zeros((0, 1))
        loads = WideLoads(none.astype(np.float32), np.zeros(1, np.int64), none, none, 0.0)
        return Packed(loads, WIDE)

    def solve(
        self,
        readings: Floats,
        data: ContactData,
        deadline_ns: int | None = None,
        *,
        touched: bool = False,
    ) -> Solution:
        """See `Operator.solve`; the idle test is left out if something is known to touch."""
        readings, out = data.heard(readings, self.valid), (data.solution.pressure, data.rows)
        if not touched and self.rests(readings, data, self.wide):
            return data.solution
        choice, grid = data.choice, self.renderer
        data.count = self.fitter.fit(readings, choice, grid, out, self.valid, deadline_ns)
        return self._solution(readings, data, deadline_ns)

    def rests(self, readings: Floats, data: ContactData, wide: Packed) -> bool:
        """Whether readings (L,), 0 where not valid, are idle; they are answered then.

        `wide` are `WideLoads`, that are no contact.
        """
        if not self.fitter.rests(readings, data.fit, wide, self.valid):
            return False
        data.count = 0
        data.solution.pressure.fill(0.0)
        self._solution(readings, data, None)
        return True

    def _solution(self, readings: Floats, data: ContactData, deadline_ns: int | None) -> Solution:
        """Solution of what was fitted."""
        solution, fit = data.solution, data.fit
        solution.operator, solution.fit, solution.notes = self, data, self.fitter.notes(data.choice)
        solution.solver, solution.offset = type(self.solver).__name__, fit.offset
        solution.gap = solution.objective = float("nan")
        solution.evidence, solution.steps = float(fit.search.known[0]), 0
        np.copyto(solution.readings, readings)
        solution.in_time = deadline_ns is None or time.perf_counter_ns() <= deadline_ns
        return solution

    def prepare_mechanics(self) -> None:
        """Make the tables of other mechanics, for readings that have a deadline; takes seconds."""
        self.fitter.mechanics.models  # noqa: B018

    def without(self, valid: NDArray[np.bool_]) -> "ContactOperator":
        """See `Operator.without`; nothing is prepared anew."""
        return replace(self, valid=np.array(valid, np.bool_))

    def predicted(self, solution: Solution) -> Floats:
        """See `Operator.predicted`."""
        if solution.fit is not None:
            return solution.fit.keep().predicted
        return np.asarray(self.model.matrix @ solution.pressure)

    def contacts(self, solution: Solution) -> tuple[Contact, ...] | None:
        """See `Operator.contacts`."""
        if solution.fit is None:
            return ()
        fit = solution.fit.keep()
        return contacts_of_rows(fit.rows, fit.grid, solution.pressure)

    def pressure_std(self, solution: Solution) -> Floats:
        """See `Operator.pressure_std`."""
        if solution.fit is None:
            return self.noise.std
        fit = solution.fit.keep()
        return pressure_std_of_rows(fit.rows, fit.grid, solution.pressure)

    def displacement(self, solution: Solution) -> Floats | None:
        """See `Operator.displacement`."""
        return None if solution.fit is None else solution.fit.keep().displacement


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
        What the model is wrong by, part of what taxels read: middle of a prior within a factor of
        ten, from which it is inferred, reading by reading and press by press.
    starts : int
        Places from which each new contact is sought.
    warm : bool
        Start from the reading before, and follow where taxels rest. Its answer is kept only as long
        as it explains the readings.
    common_mode : float
        Standard deviation of an offset that all taxels share, such as a drift, in those of the
        noise; it is integrated out. 0 for none.
    check_mechanics : bool
        Compare the layer's stated mechanics, press by press, with another Poisson's ratio and with
        a cover, or without; the more probable one answers, and a note says so. False for a layer
        that is known. Takes `warm`. Tables of others, 2 s each once per machine, are made with the
        first clear press that has no deadline, or by `prepare_mechanics`.

    See Also
    --------
    Auto : a field where one is more probable, such as of a whole palm.
    """

    def prepare(self, model: ObservationModel) -> ContactOperator:
        """Tabulate what single contacts are read as, and templates of them all over the patch."""
        fitter, physics = ContactFitter(self, model), model.physics
        assert physics is not None  # the fitter checks it
        renderer = AtomRenderer(model.grid, physics.flat.layer, physics.flat.mechanics)
        operator = ContactOperator(self, model, fitter, renderer)
        if MODE.interpreted:
            return operator
        data = operator.data()
        for reading in fitter.touches():  # a first reading is as fast as the next
            soon = time.perf_counter_ns() + 10**9  # too soon to tabulate other mechanics
            operator.solve(reading, data, soon)
        data.fit.infer()
        return operator
