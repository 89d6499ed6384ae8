"""Choice between few contacts and a pressure field, reading by reading, by their evidence.

The evidence of a hypothesis is the marginal likelihood of the readings (MacKay 2003, Information
Theory, chapter 28), with all constants, so that hypotheses of different kinds compare. That of the
contacts is Laplace's of the fit. That of a field of unknown form is the mean over Gaussian priors
of several length scales and amplitudes, in closed form. Both are means over how many times more
than the noise the readings may be off, as no skin is quite like its model.
"""

import dataclasses
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, Ints, check_count, check_range, check_type
from skinfield.solve.atoms.fit_kernel import MOST, SHARED, WHITE
from skinfield.solve.atoms.fitter import AtomFit, ContactFitter
from skinfield.solve.contact_fit import ContactFit
from skinfield.solve.linear import GaussianField, smoothed, taxel_distance
from skinfield.solve.non_negative import NonNegative, NonNegativeOperator
from skinfield.solve.operator import InverseOperator

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


def is_believed(left: Floats, readings: Floats, white: Floats) -> bool:
    """Whether what is left over of readings (L,) is no more than what a skin's model may err by."""
    over = np.square(left * white).sum()
    most = max(WORTH**2 * np.square(readings * white).sum(), WORST**2 * len(left))
    return bool(over <= most)


@dataclass(frozen=True, kw_only=True)
class Auto:
    """Few contacts, or a field where one is more probable: the choice of every command.

    Parameters
    ----------
    contacts : ContactFit
        Its own `extended` is not asked.
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
        return AutoOperator(self, model)


class AutoField:
    """Non-negative field, or a linear one where no pressure explains the readings.

    Parameters
    ----------
    operator : NonNegativeOperator
    linear : InverseOperator
    model : ObservationModel

    Attributes
    ----------
    notes : tuple of str
        Of the last answer.
    """

    def __init__(
        self, operator: NonNegativeOperator, linear: InverseOperator, model: ObservationModel
    ) -> None:
        self.operator, self.linear, self.model = operator, linear, model
        self.notes: tuple[str, ...] = ()
        self.pressure_std, self.noise = operator.pressure_std, operator.noise
        self.posterior, self.model_error = operator.posterior, operator.model_error

    @property
    def gap(self) -> float:
        """Of the last answer, see `NonNegativeOperator.gap`; NaN of a linear one."""
        return float("nan") if self.notes else self.operator.gap

    @property
    def iterations(self) -> int:
        """Newton steps that the last reading took."""
        return self.operator.iterations

    def apply(self, readings: Floats, out: Floats, deadline_ns: int | None = None) -> None:
        """See `FieldOperator.apply`."""
        self.operator.apply(readings, out, deadline_ns)
        self.notes = ()
        left = readings - self.model.matrix @ out
        if self.operator.deadline_met and not is_believed(
            left, readings, 1.0 / self.model.noise_std
        ):
            self.linear.apply(readings, out)
            self.notes = (LINEAR_NOTE,)

    def reset(self) -> None:
        """Forget the reading before."""
        self.operator.reset()


class AutoOperator:
    """Prepared choice; for one thread at a time.

    Parameters
    ----------
    settings : Auto
    model : ObservationModel
        With its physics.

    Attributes
    ----------
    contest : Contest
    extended : AutoField
    """

    def __init__(self, settings: Auto, model: ObservationModel) -> None:
        contacts = replace(settings.contacts, extended=None)
        self.settings, self.model = settings, model
        self.fitter = ContactFitter(contacts, model)
        linear = settings.linear.prepare(model)
        self.extended = AutoField(settings.field.prepare(model), linear, model)
        self.priors = FieldPriors.of(model, contacts.common_mode)
        self.contest = Contest()
        self._common = contacts.common_mode * float(model.noise_std.mean())
        self._along = np.zeros((2, len(model.taxels)), np.float32)
        self._linear, self._pressure = np.zeros(len(model.taxels)), np.zeros(len(model.grid))
        self.fitter.run_in()
        nothing = self.fitter.fit(np.zeros(len(model.taxels)))
        self.fitter.memory.marks[MOST] = settings.most_steps
        self._nothing = replace(nothing, notes=(FIELD_NOTE,))
        self._compare(np.zeros(len(model.taxels)), nothing)
        self.reset()

    @property
    def field_answers(self) -> bool:
        """Whether a field answers in place of the contacts of the last reading."""
        return self.contest.winner == FIELD

    def reset(self) -> None:
        """Forget the reading before."""
        self.fitter.reset()
        self.extended.reset()
        self.contest = Contest()

    def fit(self, readings: Floats, deadline_ns: int | None = None) -> AtomFit:
        """See `ContactOperator.fit`; none are found where a field answers.

        They are not even sought in readings about as strong as those of which a field was more
        probable, while it remains as probable as it was.
        """
        contest, white = self.contest, self.priors.white
        energy = float(np.square(readings * white).sum())
        if self.field_answers and not contest.is_due(energy, contest.count):
            value = field_evidence(self.priors, readings, self._along)
            if value > contest.field - 0.5 * (contest.field - contest.contacts):
                return self._nothing
        fit = self.fitter.fit(readings, deadline_ns)
        count = len(fit.atoms)
        if contest.is_due(energy, count) or not fit.explained:
            self._compare(readings, fit)
            contest.energy, contest.count = energy, count
        return self._nothing if self.field_answers else fit

    def _compare(self, readings: Floats, fit: AtomFit) -> None:
        """Compare a field with the contacts, and with nothing but noise.

        Contacts that do not explain the readings are not excused by a misfit where a field does.
        """
        memory = self.fitter.memory
        white, shared = memory.taxels[WHITE], float(memory.sums[SHARED])
        density, heard = noise_density(white, shared, self._common), int(np.count_nonzero(white))
        left, level = (readings - fit.predicted) * white, float(white @ (readings * white))
        contacts = fit.evidence + density
        if fit.explained:
            free = 4 * len(fit.atoms) + int(np.count_nonzero(fit.atoms[:, 4:]))
            contacts += misfit_gain(float(left @ left), heard - free)
        idle = float(np.square(readings * white).sum()) - shared * level**2
        nothing = density - 0.5 * idle + misfit_gain(idle, heard)
        field = field_evidence(self.priors, readings, self._along)
        rival = max(contacts, nothing)
        winner = self.contest.decide(rival, field, len(fit.atoms), self.settings.reluctance)
        if winner == FIELD and not self._leaves_less(readings, readings - fit.predicted):
            self.contest.winner = CONTACTS

    def _leaves_less(self, readings: Floats, left: Floats) -> bool:
        """Whether the field that would answer leaves far less than contacts, (L,), leave."""
        physics, white = self.model.physics, self.priors.white
        assert physics is not None  # without it no contact would have been sought
        linear = physics.quantity.linearise(readings, self._linear)
        self.extended.apply(linear, self._pressure)
        over = np.square((linear - self.model.matrix @ self._pressure) * white).sum()
        return bool(over < LESS * np.square(left * white).sum())
