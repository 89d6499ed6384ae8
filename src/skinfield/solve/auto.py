"""Choice between few contacts and a pressure field, reading by reading, by their evidence.

The evidence of a hypothesis is the marginal likelihood of the readings (MacKay 2003, Information
Theory, chapter 28), with all constants, so that hypotheses of different kinds compare. That of the
contacts is Laplace's of the fit. That of a field of unknown form is the mean over Gaussian priors
of several length scales and amplitudes, in closed form. Both are means over how many times more
than the noise the readings may be off, as no skin is quite like its model.
"""

import dataclasses
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, check_count, check_range, check_shape, check_type
from skinfield.estimate import Contact, ModelError, PressureError
from skinfield.solve.atoms.fit_kernel import NOW
from skinfield.solve.contact_fit import ContactFit, ContactOperator
from skinfield.solve.dual.problem import DualProblem
from skinfield.solve.field_evidence import (
    SQUARES,
    FieldCovariance,
    FieldPriors,
    field_evidence,
    misfit_gain,
    noise_density,
)
from skinfield.solve.linear import GaussianField
from skinfield.solve.non_negative import NonNegative, NonNegativeOperator
from skinfield.solve.operator import Data, DeadlineMargin, LinearOperator, Solution

WORTH = 0.15  # of the readings, root mean square: what is left over if a model is to be believed,
WORST = 4.0  # or times the noise
RISE = 1.5  # of the readings' squares over the noise, after which the hypotheses are compared again
LESS = 0.5  # of the squares that contacts leave over, a field must leave to answer in their place
CONTACTS, FIELD = 0, 1
FIELD_NOTE = "more probable than few contacts: a field answers"
LINEAR_NOTE = "no pressure explains the readings: a linear field answers; check ν, cover and gains"


@dataclass
class Contest:
    """Which hypothesis answers, and what it was chosen by.

    Attributes
    ----------
    winner : int
        CONTACTS or FIELD.
    contacts, field : float
        Evidence of each when they were compared, contacts or nothing at all.
    energy : float
        Squares of the readings over the noise then; 0 before any comparison.
    count : int
        Atoms then.
    """

    winner: int = CONTACTS
    contacts: float = 0.0
    field: float = 0.0
    energy: float = 0.0
    count: int = -1

    def is_due(self, energy: float, count: int) -> bool:
        """Whether a reading is another one than that by which it was decided."""
        same = self.energy / RISE < energy < self.energy * RISE
        return not same or count != self.count or not count

    def decide(self, contacts: float, field: float, count: int, margin: float) -> int:
        """Take in the evidence of each; another one wins only if better by a margin.

        Parameters
        ----------
        contacts, field : float
        count : int
            Atoms; to none a field need not lose by a margin.
        margin : float
            Logarithm of the odds by which the winner so far is favoured.
        """
        self.contacts, self.field = contacts, field
        lead = field - contacts
        if self.winner == CONTACTS and lead > margin:
            self.winner = FIELD
        elif self.winner == FIELD and lead < -(margin if count else 0.0):
            self.winner = CONTACTS
        return self.winner


@dataclass(frozen=True, kw_only=True)
class Auto:
    """Few contacts, or a field where one is more probable: the choice of every command.

    Parameters
    ----------
    contacts : ContactFit
        Of a hand, a tool, an edge.
    field : NonNegative
        Answers a palm, a sole, or whatever few contacts are not.
    linear : GaussianField
        Answers in its place where no pressure explains the readings, as where the model is wrong.
    reluctance : float
        Logarithm of the odds by which one must be more probable than what answered before, which
        is contacts at first. Idle readings are taken for a field in at most exp(-reluctance) of
        cases (Markov's inequality).
    most_steps : int
        Of refinement in the search for contacts, in one reading: what rests under a field's load
        is not tried for seconds.
    """

    contacts: ContactFit = dataclasses.field(default_factory=ContactFit)
    field: NonNegative = dataclasses.field(default_factory=NonNegative)
    linear: GaussianField = dataclasses.field(default_factory=GaussianField)
    reluctance: float = 7.0
    most_steps: int = 3000

    def __post_init__(self) -> None:
        check_type("contacts", self.contacts, ContactFit, "which finds few contacts")
        check_type("field", self.field, NonNegative, "a field that only presses")
        check_type("linear", self.linear, GaussianField, "a field that no constraint binds")
        check_count("most_steps", self.most_steps, 1, 1_000_000_000, "steps of refinement")
        check_range("reluctance", self.reluctance, 0.0, 1e6, "a logarithm of odds")

    def prepare(self, model: ObservationModel) -> "AutoOperator":
        """Prepare the contacts, the field, and the evidence of both."""
        operator = AutoOperator(
            solver=self,
            model=model,
            contact_fit=self.contacts.prepare(model),
            whole_field=self.field.prepare(model),
            whole_linear=self.linear.prepare(model),
            covariance=FieldCovariance.of(model, self.contacts.common_mode),
        )
        operator.solve(np.zeros(len(model.noise_std)), operator.data())  # compiles what it takes
        return operator


class AutoData(Data):
    """Scratch memory of an `AutoOperator`, and its reading before.

    Attributes
    ----------
    contacts : ContactData
        Whose `rows` and `noise` are these.
    count : int
        How many of the rows hold; -1 where a field answered, in whose pressure a finder finds them.
    """

    def __init__(self, operator: "AutoOperator") -> None:
        margin = DeadlineMargin(20_000, most=2_000_000)
        super().__init__(operator, len(operator.model.grid), margin)
        self.contacts, self.field = operator.contact_fit.data(), operator.whole_field.data()
        self.linear, self.contest = operator.whole_linear.data(), Contest()
        self.contacts.choice.limit(operator.solver.most_steps)
        self.along, self.sums = operator.covariance.room
        self.rows, self.count = self.contacts.rows, 0

    @property
    def noise(self) -> Floats:
        """See `ContactData.noise`."""
        return self.contacts.noise

    def reset(self) -> None:
        """Forget the reading before."""
        self.contacts.reset()
        self.field.reset()
        self.contest = Contest()

    def start_from(self, other: Data) -> None:
        """Go on with the memory of another grid, from now on with the same one."""
        if isinstance(other, AutoData):
            self.contacts.start_from(other.contacts)
            self.field.start_from(other.field)
            self.contest = other.contest


@dataclass(frozen=True, eq=False)
class AutoOperator:
    """Prepared choice.

    Attributes
    ----------
    solver : Auto
    model : ObservationModel
        With its physics.
    contact_fit : ContactOperator
    whole_field : NonNegativeOperator
    whole_linear : LinearOperator
    covariance : FieldCovariance
        These of all taxels. What a set of valid ones takes is prepared when it is first needed: a
        set may last for one reading, of which few contacts are all there is.
    valid : (L,) bool array, optional
        Taxels that are used. Default all.
    """

    solver: Auto
    model: ObservationModel
    contact_fit: ContactOperator
    whole_field: NonNegativeOperator
    whole_linear: LinearOperator
    covariance: FieldCovariance
    valid: NDArray[np.bool_] | None = None
    linear = None  # no matrix

    @cached_property
    def field(self) -> NonNegativeOperator:
        """Of the valid taxels."""
        return self.whole_field if self.valid is None else self.whole_field.without(self.valid)

    @cached_property
    def linear_field(self) -> LinearOperator:
        """Of the valid taxels."""
        return self.whole_linear if self.valid is None else self.whole_linear.without(self.valid)

    @cached_property
    def priors(self) -> FieldPriors:
        """Of a field as the valid taxels read it."""
        return self.covariance.whole if self.valid is None else self.covariance.priors(self.valid)

    @cached_property
    def white(self) -> Floats:
        """One over the noise, (L,); 0 of taxels that are left out."""
        white = 1.0 / self.model.noise_std
        return white if self.valid is None else white * self.valid

    @property
    def problem(self) -> DualProblem:
        """Of the field: an engine's test of idle patches."""
        return self.field.problem

    @property
    def common(self) -> float:
        """Standard deviation of an offset that all taxels share, in the quantity's unit."""
        return self.contact_fit.solver.common_mode * float(self.model.noise_std.mean())

    @cached_property
    def _shared(self) -> float:
        """Variance of that offset after readings."""
        precision = float(self.white @ self.white)
        return float(self.common**2 / (1.0 + self.common**2 * precision))

    @cached_property
    def _densities(self) -> tuple[int, float, float]:
        """Number of valid taxels, and `noise_density` with the offset that they share, without."""
        drifting = noise_density(self.white, self._shared, self.common)
        heard = int(np.count_nonzero(self.white))
        return heard, drifting, noise_density(self.white, 0.0, 0.0)

    @property
    def noise(self) -> PressureError:
        """Of the field."""
        return self.field.noise

    @property
    def posterior(self) -> PressureError | None:
        """Of the field."""
        return self.field.posterior

    @property
    def model_error(self) -> ModelError:
        """Of the field."""
        return self.field.model_error

    def data(self) -> AutoData:
        """Make its scratch memory."""
        return AutoData(self)

    def solve(self, readings: Floats, data: AutoData, deadline_ns: int | None = None) -> Solution:
        """See `Operator.solve`; contacts are found by `contact_fit`, a field by the other two.

        Contacts are not even sought in readings about as strong as those of which a field was more
        probable, while it remains as probable as it was.
        """
        readings, solution, contest = data.heard(readings, self.valid), data.solution, data.contest
        energy = float(np.square(readings * self.white).sum())
        if contest.winner == FIELD and not contest.is_due(energy, contest.count):
            value = self._of_field(readings, data)
            if value > contest.field - 0.5 * (contest.field - contest.contacts):
                data.count = -1
                solution.take(self._by_field(readings, data, deadline_ns))
                return solution
        found = self.contact_fit.solve(readings, data.contacts, deadline_ns)
        count, data.count = data.contacts.count, data.contacts.count
        if found.in_time and (contest.is_due(energy, count) or not data.contacts.fit.explained):
            self._compare(readings, data, found, deadline_ns)
            contest.energy, contest.count = energy, count
        if contest.winner == FIELD:
            data.count = -1
            found = self._by_field(readings, data, deadline_ns)
        solution.take(found)
        return solution

    def _by_field(
        self, readings: Floats, data: AutoData, deadline_ns: int | None = None
    ) -> Solution:
        """Non-negative field, or a linear one where no pressure explains the readings."""
        found, notes = self.field.solve(readings, data.field, deadline_ns), [FIELD_NOTE]
        highest = WORTH**2 * float(np.square(found.readings * self.white).sum())
        most = max(highest, WORST**2 * len(readings))
        if found.in_time and not self._squares(found.residual) <= most:
            found = self.linear_field.solve(readings, data.linear, deadline_ns)
            notes.append(LINEAR_NOTE)
        found.notes = tuple(notes)
        return found

    def _squares(self, left: Floats) -> float:
        """Squares of readings (L,) over the noise, but for what an offset that all share takes."""
        over = left * self.white
        return float(over @ over - self._shared * (over @ self.white) ** 2)

    def _of_field(self, readings: Floats, data: AutoData) -> float:
        """Evidence of a field."""
        return field_evidence(self.priors, SQUARES, readings, data.along, data.sums)

    def _compare(
        self, readings: Floats, data: AutoData, found: Solution, deadline_ns: int | None
    ) -> None:
        """Compare a field with the contacts, and with nothing but noise."""
        contest, fit, idle = data.contest, data.contacts.fit, self._squares(readings)
        heard, drifting, still = self._densities
        nothing = drifting - 0.5 * idle + misfit_gain(idle, heard)
        contacts = fit.total + still
        field = self._of_field(readings, data)
        rival = max(contacts, nothing)
        winner = contest.decide(rival, field, data.contacts.count, self.solver.reluctance)
        if winner == FIELD:
            over = self._squares(self._by_field(readings, data, deadline_ns).residual)
            left = readings - fit.memory.predicted[NOW] - fit.offset
            if not over < LESS * self._squares(left):
                contest.winner = CONTACTS

    def on(self, model: ObservationModel) -> "AutoOperator":
        """The same for another grid of the patch; all but the fields is shared."""
        return replace(
            self,
            model=model,
            contact_fit=self.contact_fit.on(model),
            whole_field=self.solver.field.prepare(model),
            whole_linear=self.solver.linear.prepare(model),
        )

    def without(self, valid: NDArray[np.bool_]) -> "AutoOperator":
        """See `Operator.without`; nothing is prepared yet."""
        check_shape("valid", valid, self.model.noise_std.shape, "one per taxel")
        contacts = self.contact_fit.without(valid)
        return replace(self, contact_fit=contacts, valid=contacts.valid)

    def predicted(self, solution: Solution) -> Floats:
        """See `Operator.predicted`."""
        return solution.operator.predicted(solution)

    def contacts(self, solution: Solution) -> tuple[Contact, ...] | None:
        """See `Operator.contacts`: None where a field answered."""
        return None if solution.fit is None else self.contact_fit.contacts(solution)

    def pressure_std(self, solution: Solution) -> Floats:
        """See `Operator.pressure_std`."""
        return solution.operator.pressure_std(solution)

    def displacement(self, solution: Solution) -> Floats | None:
        """See `Operator.displacement`."""
        return solution.operator.displacement(solution)
