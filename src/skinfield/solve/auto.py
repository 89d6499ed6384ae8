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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, Ints, check_count, check_range, check_type
from skinfield.estimate import Contact, ModelError, PressureError
from skinfield.solve.atoms.fit_kernel import MOST, NOW
from skinfield.solve.contact_fit import ContactFit, ContactOperator
from skinfield.solve.dual.problem import DualProblem
from skinfield.solve.linear import GaussianField, smoothed, taxel_distance
from skinfield.solve.non_negative import NonNegative, NonNegativeOperator
from skinfield.solve.operator import Data, DeadlineMargin, LinearOperator, Solution

LENGTHS = (0.7, 2.0, 6.0)  # of a field's correlation, in distances of taxels
AMPLITUDES = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # root mean square of its readings, over noise
MISFITS = (1.0, 1.6, 2.5, 4.0, 9.0, 27.0)  # times the noise that readings may be off
WORTH = 0.15  # of the readings, root mean square: what is left over if a model is to be believed,
WORST = 4.0  # or times the noise
RISE = 1.5  # of the readings' squares over the noise, after which the hypotheses are compared again
LESS = 0.5  # of the squares that contacts leave over, a field must leave to answer in their place
CONTACTS, FIELD = 0, 1
FIELD_NOTE = "more probable than few contacts: a field answers"
LINEAR_NOTE = "no pressure explains the readings: a linear field answers; check ν, cover and gains"


class FieldPriors(NamedTuple):
    """Gaussian priors of a field as L taxels read it, G of them, along the vectors of H lengths.

    Attributes
    ----------
    vectors : (H, L, L) float32 array
        Rows: eigenvectors of the covariance of the whitened readings.
    lengths : (G,) int array
        Which of the H each prior has.
    precision : (G, L) array
        One over the variance of whitened readings along them, noise and misfit included.
    shared : (G, L) array
        That times an offset of one standard deviation that all taxels share.
    gain : (G,) array
        Share of the squared product with `shared` that the offset takes.
    constant : (G,) array
        Logarithm of the density at no readings.
    white : (L,) array
        One over the noise.
    """

    vectors: NDArray[np.float32]
    lengths: Ints
    precision: Floats
    shared: Floats
    gain: Floats
    constant: Floats
    white: Floats

    @classmethod
    def of(cls, model: ObservationModel, common: float) -> "FieldPriors":
        """Of a model, with the standard deviation `common` of an offset, in that of the noise."""
        distance = taxel_distance(model.taxels, model.grid.pitch)
        white = 1.0 / model.noise_std
        offset = common * float(model.noise_std.mean()) * white
        vectors, along = [], []
        variances: list[Floats] = []
        for length in LENGTHS:
            gram = smoothed(model.grid, model.matrix, length * distance) @ model.matrix.T
            spectrum, columns = np.linalg.eigh(gram * np.outer(white, white))
            spectrum = np.maximum(spectrum, 0.0) / np.trace(gram * np.diag(white**2)) * len(white)
            vectors.append(columns.T)
            for amplitude in AMPLITUDES:
                variances.extend(np.square(amplitude) * spectrum + misfit**2 for misfit in MISFITS)
            along.append(columns.T @ offset)
        each = len(AMPLITUDES) * len(MISFITS)
        lengths = np.repeat(np.arange(len(LENGTHS)), each)
        precision = 1.0 / np.array(variances)
        ones = np.array(along)[lengths]
        squares = (np.square(ones) * precision).sum(axis=1)
        known = np.log(white).sum() - 0.5 * len(white) * np.log(2 * np.pi)
        return cls(
            vectors=np.ascontiguousarray(vectors, dtype=np.float32),
            lengths=lengths,
            precision=precision,
            shared=ones * precision,
            gain=1.0 / (1.0 + squares),
            constant=known + 0.5 * (np.log(precision).sum(axis=1) - np.log1p(squares)),
            white=white,
        )

    def spread(self, valid: NDArray[np.bool_]) -> "FieldPriors":
        """The same for readings (L,) of which these of the `valid` taxels alone count."""
        count, taxels = int(valid.sum()), len(valid)

        def padded(values: Floats) -> Floats:
            return np.pad(values, [(0, 0), (0, taxels - count)])

        vectors = np.zeros((len(self.vectors), taxels, taxels), np.float32)
        vectors[:, :count, valid] = self.vectors
        white = np.zeros(taxels)
        white[valid] = self.white
        return self._replace(
            vectors=vectors,
            precision=padded(self.precision),
            shared=padded(self.shared),
            white=white,
        )


@njit
def field_evidence(priors: FieldPriors, readings: Floats, along: NDArray[np.float32]) -> float:
    """Logarithm of the density of readings (L,) of a field: mean over the priors.

    `along` (2, L) is room.
    """
    taxels, last, total, highest = len(readings), -1, 0.0, -np.inf
    white, turned = along[0], along[1]
    for i in range(taxels):
        white[i] = readings[i] * priors.white[i]
    for g in range(len(priors.gain)):
        if priors.lengths[g] != last:
            last = priors.lengths[g]
            np.dot(priors.vectors[last], white, turned)
        squares, product = 0.0, 0.0
        for i in range(taxels):
            value = float(turned[i])
            squares += value * value * priors.precision[g, i]
            product += value * priors.shared[g, i]
        density = priors.constant[g] - 0.5 * (squares - priors.gain[g] * product * product)
        if density > highest:
            total = total * np.exp(highest - density) + 1.0 if highest > -np.inf else 1.0
            highest = density
        else:
            total += np.exp(density - highest)
    return float(highest + np.log(total / len(priors.gain)))


def noise_density(white: Floats, shared: float, common: float) -> float:
    """Logarithm of the density at 0 of noise and an offset that all taxels share.

    Parameters
    ----------
    white : (L,) array
        One over the deviations; 0 of taxels that are not heard.
    shared, common : float
        Variance of the offset after readings, and its standard deviation before.
    """
    heard = white[white > 0.0]
    known = np.log(heard).sum() - 0.5 * len(heard) * np.log(2 * np.pi)
    return float(known + (0.5 * np.log(shared) - np.log(common) if shared > 0.0 else 0.0))


def misfit_gain(squares: float, freedom: int) -> float:
    """What a mean over the misfits adds to the logarithm of a density without any.

    Parameters
    ----------
    squares : float
        Of what is left over, over the noise.
    freedom : int
        Taxels less the numbers that were fitted to them.
    """
    misfit = np.array(MISFITS)
    gains = 0.5 * squares * (1.0 - misfit**-2.0) - max(freedom, 1) * np.log(misfit)
    return float(np.logaddexp.reduce(gains) - np.log(len(misfit)))


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
            field=self.field.prepare(model),
            linear_field=self.linear.prepare(model),
            priors=FieldPriors.of(model, self.contacts.common_mode),
            noise_std=model.noise_std,
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
        self.contacts, self.field = operator.contact_fit.data(), operator.field.data()
        self.linear, self.contest = operator.linear_field.data(), Contest()
        self.contacts.fit.memory.marks[MOST] = operator.solver.most_steps
        self.along = np.zeros((2, len(operator.model.noise_std)), np.float32)
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
    field : NonNegativeOperator
    linear_field : LinearOperator
    priors : FieldPriors
    noise_std : (L,) array, in the quantity's unit
        Infinite of taxels that are left out.
    valid : (L,) bool array, optional
        Taxels that are used. Default all.
    """

    solver: Auto
    model: ObservationModel
    contact_fit: ContactOperator
    field: NonNegativeOperator
    linear_field: LinearOperator
    priors: FieldPriors
    noise_std: Floats
    valid: NDArray[np.bool_] | None = None
    linear = None  # no matrix

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
        precision = float(np.square(1.0 / self.noise_std).sum())
        return float(self.common**2 / (1.0 + self.common**2 * precision))

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
        energy = float(np.square(readings / self.noise_std).sum())
        if contest.winner == FIELD and not contest.is_due(energy, contest.count):
            value = field_evidence(self.priors, readings, data.along)
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
        highest = WORTH**2 * float(np.square(found.readings / self.noise_std).sum())
        most = max(highest, WORST**2 * len(readings))
        if found.in_time and not self._squares(found.residual) <= most:
            found = self.linear_field.solve(readings, data.linear, deadline_ns)
            notes.append(LINEAR_NOTE)
        found.notes = tuple(notes)
        return found

    def _squares(self, left: Floats) -> float:
        """Squares of readings (L,) over the noise, but for what an offset that all share takes."""
        over = left / self.noise_std
        return float(over @ over - self._shared * (over @ (1.0 / self.noise_std)) ** 2)

    def _compare(
        self, readings: Floats, data: AutoData, found: Solution, deadline_ns: int | None
    ) -> None:
        """Compare a field with the contacts, and with nothing but noise."""
        contest, fit, white = data.contest, data.contacts.fit, 1.0 / self.noise_std
        shared, idle = self._shared, self._squares(readings)
        known, heard = noise_density(white, shared, self.common), int(np.count_nonzero(white))
        nothing = known - 0.5 * idle + misfit_gain(idle, heard)
        contacts = fit.total + noise_density(white, 0.0, 0.0)
        field = field_evidence(self.priors, readings, data.along)
        rival = max(contacts, nothing)
        winner = contest.decide(rival, field, data.contacts.count, self.solver.reluctance)
        if winner == FIELD:
            over = self._squares(self._by_field(readings, data, deadline_ns).residual)
            left = readings - fit.memory.predicted[NOW] - fit.offset
            if not over < LESS * self._squares(left):
                contest.winner = CONTACTS

    def on(self, model: ObservationModel) -> "AutoOperator":
        """The same for another grid of the patch; all but the fields is shared."""
        field, linear = self.solver.field.prepare(model), self.solver.linear.prepare(model)
        if self.valid is not None:
            field, linear = field.without(self.valid), linear.without(self.valid)
        contacts = self.contact_fit.on(model)
        return replace(self, model=model, contact_fit=contacts, field=field, linear_field=linear)

    def without(self, valid: NDArray[np.bool_]) -> "AutoOperator":
        """See `Operator.without`."""
        part = self.model.subset(valid)
        return replace(
            self,
            contact_fit=self.contact_fit.without(valid),
            field=self.field.without(valid),
            linear_field=self.linear_field.without(valid),
            priors=FieldPriors.of(part, self.solver.contacts.common_mode).spread(valid),
            noise_std=np.where(valid, self.model.noise_std, np.inf),
            valid=np.array(valid, np.bool_),
        )

    def predicted(self, solution: Solution) -> Floats:
        """See `Operator.predicted`."""
        return solution.operator.predicted(solution)

    def contacts(self, solution: Solution) -> tuple[Contact, ...] | None:
        """See `Operator.contacts`: None where a field answered."""
        return None if solution.fit is None else solution.fit.keep().contacts

    def pressure_std(self, solution: Solution) -> Floats:
        """See `Operator.pressure_std`."""
        return solution.operator.pressure_std(solution)

    def displacement(self, solution: Solution) -> Floats | None:
        """See `Operator.displacement`."""
        return solution.operator.displacement(solution)
