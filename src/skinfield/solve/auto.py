"""Choice between few contacts and a pressure field, reading by reading, by their evidence.

The evidence of a hypothesis is the marginal likelihood of the readings (MacKay 2003, Information
Theory, chapter 28), with all constants, so that hypotheses of different kinds compare. That of the
contacts is Laplace's of the fit. That of a field of unknown form is the mean over Gaussian priors
of several length scales and amplitudes, in closed form. Both are means over how many times more
than the noise the readings may be off, as no skin is quite like its model.
"""

import dataclasses
import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import parallel_compilation
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, check_count, check_range, check_shape, check_type
from skinfield.estimate import Contact, ModelError, PressureError
from skinfield.solve.atoms.fit_data import FitData
from skinfield.solve.atoms.fit_kernel import MOST, NOW
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
from skinfield.solve.idle_kernel import WIDE
from skinfield.solve.linear import GaussianField
from skinfield.solve.non_negative import NonNegative, NonNegativeOperator
from skinfield.solve.operator import Data, DeadlineMargin, LinearOperator, Solution
from skinfield.solve.packed import Packed

WORTH = 0.15  # of the readings, root mean square: what is left over if a model is to be believed,
WORST = 4.0  # or times the noise
RISE = 1.5  # of the readings' squares over the noise, after which the hypotheses are compared again
LESS = 0.5  # of the squares that contacts leave over, a field must leave to answer in their place
HAND = 0.25  # of the taxels: fewer are touched by a hand, where contacts are told by strips
CONTACTS, FIELD = 0, 1
COMPARING = 25_000  # ns: the evidence of a field takes about so long
PATIENCE = 50  # readings in which contacts are sought bit by bit, before a field answers instead
TURNS = 4  # readings of which one goes on with that, while a field answers
FIELD_NOTE = "more probable than few contacts: a field answers"
LINEAR_NOTE = "no pressure explains the readings: a linear field answers; check ν, cover and gains"

COMPILED_APART = """
import numpy as np
from skinfield import Grid, Layer, NonNegative, Reconstructor, layouts
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.field_evidence import SQUARES, FieldCovariance, field_evidence
patch, layer = layouts.icub_triangle(), Layer()
rec = Reconstructor(patch, layer, Grid.square(patch, nodes=8), solver=NonNegative())
AtomRenderer(rec.grid, layer, rec.mechanics).displacement(np.ones((1, 6)), np.zeros(1, np.int64))
covariance = FieldCovariance.of(rec.model, 1.0)
field_evidence(covariance.whole, SQUARES, np.zeros(len(patch)), *covariance.room)
"""  # all that answers of a field take


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
    is_open : bool
        Whether the search for contacts is going on.
    readings : int
        For which it has been going on.
    """

    winner: int = CONTACTS
    contacts: float = 0.0
    field: float = 0.0
    energy: float = 0.0
    count: int = -1
    is_open: bool = False
    readings: int = 0

    @property
    def is_ripe(self) -> bool:
        """Whether what is known of the contacts may lose to a field."""
        return self.winner == FIELD or not self.is_open or self.readings >= PATIENCE

    def go_on(self, is_open: bool) -> None:
        """Take note whether the search for contacts goes on after one more reading."""
        self.is_open, self.readings = is_open, self.readings + 1 if is_open else 0

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
        with parallel_compilation(COMPILED_APART, field_evidence):
            contact_fit = self.contacts.prepare(model)
        covariance = FieldCovariance.of(model, self.contacts.common_mode)
        operator = AutoOperator(
            solver=self,
            model=model,
            contact_fit=contact_fit,
            whole_field=self.field.prepare(model),
            whole_linear=self.linear.prepare(model),
            covariance=covariance,
            wide=Packed(covariance.wide(self.reluctance), WIDE),
        )
        nothing, data = np.zeros(len(model.noise_std)), operator.data()
        for touched in (False, True):
            operator.solve(nothing, data, touched=touched)  # compiles what it takes
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
        self.contacts.fit.memory.marks[MOST] = operator.solver.most_steps
        self.along, self.sums = operator.covariance.room
        self.rows, self.count = self.contacts.rows, 0
        self.follows = self.contacts.follows
        self.solution = self.contacts.solution

    @property
    def fit(self) -> FitData:
        """Of the contacts."""
        return self.contacts.fit

    @property
    def settled(self) -> bool:
        """See `ContactData.settled`."""
        return self.contacts.settled

    @property
    def noise(self) -> Floats:
        """See `ContactData.noise`."""
        return self.contacts.noise

    def reset(self) -> None:
        """Forget the reading before."""
        self.contacts.reset()
        self.field.reset()
        self.contest = Contest()

    def take(self, field: Solution) -> Solution:
        """Take a field for the solution."""
        self.count = -1
        self.solution.take(field)
        return self.solution

    def rest(self) -> None:
        """Take note that nothing touches: what does next is compared anew with a field."""
        self.count = self.contacts.count = 0
        if self.contest.winner == FIELD:
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
    wide : Packed
        `WideLoads` of the idle test.
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
    wide: Packed
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

    def prepare_mechanics(self) -> None:
        """See `ContactOperator.prepare_mechanics`."""
        self.contact_fit.prepare_mechanics()

    def data(self) -> AutoData:
        """Make its scratch memory."""
        return AutoData(self)

    def solve(
        self,
        readings: Floats,
        data: AutoData,
        deadline_ns: int | None = None,
        *,
        touched: bool = False,
    ) -> Solution:
        """See `Operator.solve`; contacts are found by `contact_fit`, a field by the other two.

        Neither is sought in readings that the idle test passes, which is left out if something
        is known to touch. Contacts are not even sought in readings about as strong as those of
        which a field was more probable, while it remains as probable as it was; or only now and
        then, where the search for them was interrupted. Comparisons for which there is no time are
        made with the next readings.
        """
        readings, contest = data.heard(readings, self.valid), data.contest
        if not touched and self.contact_fit.rests(readings, data.contacts, self.wide):
            data.rest()
            return data.solution
        over, by = readings * self.white, deadline_ns
        energy, fit = float(over @ over), data.contacts.fit
        due = contest.is_due(energy, contest.count)
        if contest.winner == FIELD and not due:
            contest.readings += 1
            if not contest.is_open or contest.readings % TURNS:
                value = self._of_field(readings, data)
                if value > contest.field - 0.5 * (contest.field - contest.contacts):
                    return data.take(self._by_field(readings, data, deadline_ns))
            due = True
        if by is not None and due and contest.is_ripe:  # what is left, the comparison needs
            by -= (by - time.perf_counter_ns()) // 2 if contest.is_open else COMPARING
        found = self.contact_fit.solve(readings, data.contacts, by, touched=True)
        count = data.count = data.contacts.count
        due |= contest.is_due(energy, count) or not fit.explained
        contest.go_on(not fit.compared)
        in_time = deadline_ns is None or time.perf_counter_ns() < deadline_ns
        field = None
        if due and contest.is_ripe and in_time:
            field = self._compare(readings, data, deadline_ns)
            if field is None or contest.winner == FIELD or field.gap <= self.problem.tolerance:
                contest.energy, contest.count, contest.readings = energy, count, 0
        if contest.winner == FIELD:
            field = field or self._by_field(readings, data, deadline_ns)
            few = fit.touched < HAND * np.count_nonzero(self.white)
            if not (fit.in_strips and (few or field.operator is self.linear_field)):
                return data.take(field)
            contest.winner = CONTACTS  # a field says nothing of a hand on a skin unlike its model
        return found

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
        self, readings: Floats, data: AutoData, deadline_ns: int | None
    ) -> Solution | None:
        """Compare a field with the contacts, and with nothing but noise.

        The field, if it is more probable. It wins only if it leaves less over.
        """
        contest, fit, idle = data.contest, data.contacts.fit, self._squares(readings)
        heard, drifting, still = self._densities
        nothing = drifting - 0.5 * idle + misfit_gain(idle, heard)
        rival, field = max(fit.total + still, nothing), self._of_field(readings, data)
        if contest.decide(rival, field, data.contacts.count, self.solver.reluctance) == CONTACTS:
            return None
        found = self._by_field(readings, data, deadline_ns)
        left = readings - fit.memory.predicted[NOW] - fit.offset
        if not self._squares(found.residual) < LESS * self._squares(left):
            contest.winner = CONTACTS
        return found

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
