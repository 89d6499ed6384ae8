"""Contact fit of a patch: its operator, residual tests, and the answer of one reading."""

from dataclasses import dataclass

import numpy as np

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.estimate import Contact
from skinfield.solve.atoms.dictionary import MARGIN, BallTemplates, make_bank
from skinfield.solve.atoms.fit_kernel import PARAMETERS, Inputs, Priors
from skinfield.solve.atoms.posterior import belief_of, stated
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.ring_source import Drawable, drawable
from skinfield.solve.atoms.search import AtomSet, FitProblem, search
from skinfield.solve.atoms.settings import FitSettings
from skinfield.solve.atoms.table import RING, atom_tables
from skinfield.solve.operator import Fit

ODD = 1e-4  # readings that contacts explain, and that are taken not to be explained
QUIETEST = 1e-3  # of the stated noise, that is believed
QUIET = 0.25  # of the expected squares of residuals: below, there is less noise than was stated
CALM = 0.7  # the same, where more noise than was stated had been assumed
UNSEEN = 12  # taxels that see no contact, and tell the noise by themselves
LOUD = 1.8  # times the stated noise, from which it is more: less may be weak touches
LOUDEST = 4.0  # times: what is left over beyond is no noise, but more than the atoms could tell
NORMAL_MEDIAN = 0.6745  # of the absolute value of a standard normal number


def explains(problem: FitProblem, found: AtomSet) -> bool:
    """Whether noise and model error account for what is left over, but for one reading in 1e4."""
    from scipy.special import chdtri

    squares = np.square(problem.left(found.predicted) * problem.inputs.white).sum()
    return bool(squares <= chdtri(_freedom(found, problem.heard), ODD))


def _freedom(found: AtomSet, taxels: int) -> int:
    return max(taxels - int(found.free.sum()), 1)


def noise_scale(problem: FitProblem, found: AtomSet, scale: float, most: int) -> float:
    """By how much the noise differs from what is assumed, by what the atoms leave over; or 1.

    `scale` is what is assumed already, in terms of what was stated. It is less where the squares
    are far fewer than the taxels: of all taxels, and of those that see a contact, the larger of the
    two, so that taxels that always read zero do not speak for the others. It is more where the
    atoms do not explain the readings and taxels that see none of them are as restless: what they
    read is no touch. Where as many atoms as there may be (`most`) do not explain the readings, all
    taxels tell it.
    """
    white = problem.inputs.white
    left = problem.left(found.predicted) * white
    seen = (np.abs(found.predicted) * white > 1.0) | (white <= 0.0)
    if not explains(problem, found):
        if len(found) >= most:
            left, seen = problem.left(np.zeros(len(left))) * white, white <= 0.0
        typical = 1.0
        if np.count_nonzero(~seen) >= UNSEEN:  # by the median, which a few large ones do not move
            typical = float(np.median(np.abs(left[~seen]))) / NORMAL_MEDIAN
        return typical if LOUD < typical <= LOUDEST / scale else 1.0
    if not len(found):
        return 1.0
    squares, parameters = np.square(left), int(found.free.sum())
    share = float(squares.sum()) / _freedom(found, problem.heard)
    seen &= white > 0.0
    if seen.sum() > parameters + 2:
        share = max(share, float(squares[seen].sum()) / (int(seen.sum()) - parameters))
    enough = QUIET if scale <= 1.0 else CALM
    return 1.0 if share > enough else max(float(np.sqrt(share)), QUIETEST / scale)


def significant(false_alarm_rate: float, taxels: int) -> float:
    """Gain in cost that noise exceeds at this rate: three parameters at as many places as taxels.

    Half the quantile of chi-squared with three degrees of freedom (Wilks 1938).
    """
    from scipy.special import chdtri

    return 0.5 * float(chdtri(3, false_alarm_rate / taxels))


MOVED = 0.5  # standard deviations within which what was known of a contact still holds
CHANGED = 0.2  # of its force's logarithm, likewise


def notes_on(problem: FitProblem, count: int, scale: float, offset: float) -> tuple[str, ...]:
    """What is to be told of an answer with as many contacts, in sentences."""
    notes = []
    if problem.late:
        notes.append(f"ContactFit stopped at the deadline, with {count} found")
    if scale > LOUD:
        notes.append("ContactFit saw more noise than was stated, and went by what it saw")
    if abs(offset) > problem.common > 0.0:
        notes.append("ContactFit took what all taxels share for an offset: tare the skin")
    return tuple(notes)


@dataclass(frozen=True, eq=False)
class Known:
    """What was found out about an atom (6,).

    Attributes
    ----------
    atom : (6,) array
        The minimum of the cost.
    offset : (6,) array
        From there to the posterior's mean, which is stated: its error is smaller.
    covariance : (6, 6) array
    """

    atom: Floats
    offset: Floats
    covariance: Floats

    def holds(self, atom: Floats) -> bool:
        """Whether an atom is still about where it was when its covariance was found."""
        off = atom - self.atom
        deviation = np.sqrt(np.diag(self.covariance)[:2])
        return bool((np.abs(off[:2]) < MOVED * deviation).all() and abs(off[2]) < CHANGED)


CURVATURE_STD = 0.8  # of the logarithm of a ball's radius of curvature, before any reading
FLAT_RADIUS, FLAT_STD = 3e-3, 0.7  # m: middle of the prior of a flat end, and of its logarithm
RING_RADIUS, RING_STD = 4e-3, 0.5  # m, and of its logarithm
LENGTH_STD = 4e-3  # m: of each component of the half-length of a line
FIRST = (6.0, 8.0, 60.0)  # standard deviations: touches by which all is loaded, faint and clear
ROUNDS = 5  # of searches, until the noise is as what is left over
PLACES = 100  # that are tried to tell how sure a contact is, for each family
FEW = 14  # for a contact that the reading before had, too
STEP, WIDE_STEP = 0.9, 1.2  # standard deviations between places, for many and for few
RISE = 1.5  # of the readings' squares over the noise, after which shapes are compared again


def _model_error(place: float, force: float) -> Floats:
    return np.diag(np.square([place, place, force, force, 0.0, 0.0]))


# What presses is no perfect ball, flat end, line or ring: in thicknesses, and part of the force.
ROUND_ERROR, ODD_ERROR = _model_error(0.02, 0.03), _model_error(0.25, 0.1)
QUIETER = 2.0  # times the stated precision, from which the noise is less than was stated


class ContactFitter:
    """Finds contacts reading by reading; for one thread at a time.

    Parameters
    ----------
    settings : FitSettings
        Such as `ContactFit()`.
    model : ObservationModel
        With its physics.

    Attributes
    ----------
    noise : (L,) array, in the quantity's unit
        Of the readings; the model's, until `take_noise`.
    """

    def __init__(self, settings: FitSettings, model: ObservationModel) -> None:
        if model.physics is None:
            raise InputError(
                "the model does not say what it is made of, expected physics: make it with "
                "ObservationModel.of()"
            )
        physics = model.physics
        self.settings, self.model = settings, model
        self.noise = model.noise_std
        self._thickness = thickness = physics.layer.thickness
        self._tables = atom_tables(physics)
        self._taxels = np.ascontiguousarray(model.taxels / thickness)
        self._bank: BallTemplates = make_bank(self._taxels, 1.0 / model.noise_std, self._tables)
        self._priors = Priors(
            float(np.log(settings.typical_radius)),
            CURVATURE_STD,
            float(np.log(FLAT_RADIUS / thickness)),
            FLAT_STD,
            float(np.log(RING_RADIUS / thickness)),
            RING_STD,
            LENGTH_STD / thickness,
        )
        low, high = self._taxels.min(axis=0) - MARGIN, self._taxels.max(axis=0) + MARGIN
        self._places = np.array([low, high])
        self._threshold = significant(settings.false_alarm_rate, len(model.taxels))
        self._renderer = AtomRenderer(model.grid, physics.layer, physics.mechanics)
        self.extended = settings.extended.prepare(model) if settings.extended else None
        self._before: AtomSet | None = None
        self._kept: tuple[Known, ...] = ()
        self._compared, self._scale = 0.0, 1.0

    def run_in(self, fields: bool = True) -> None:
        """Load all that is compiled: a first reading is as fast as the next.

        Parameters
        ----------
        fields : bool
            As of `fit`: without them half as much is needed.
        """
        strongest = int(np.argmax(self._bank.norms))
        template = self._bank.templates[strongest].astype(np.float64)
        for strength in FIRST:
            self.fit(template * (strength * self.model.noise_std), fields=fields)
        self.reset()

    def take_noise(self, noise: Floats) -> None:
        """Go by another noise (L,) from now on: infinite of taxels that shall not be heard.

        Nothing is prepared anew. What they read must be a number all the same.
        """
        if not np.array_equal(noise, self.noise):
            self.noise, self._kept = np.array(noise, dtype=np.float64), ()

    def take_rate(self, false_alarm_rate: float) -> None:
        """See a contact in another share of idle readings than the settings have it."""
        self._threshold = significant(false_alarm_rate, len(self.model.taxels))

    def reset(self) -> None:
        """Forget the reading before."""
        self._before, self._kept, self._compared, self._scale = None, (), 0.0, 1.0

    def fit(self, readings: Floats, deadline_ns: int | None = None, *, fields: bool = True) -> Fit:
        """Answer readings (L,); without `fields` deviation and displacement stay 0."""
        problem, found, scale, drawn = self._answer(readings, deadline_ns)
        nodes, offset = len(self.model.grid), problem.offset(found.predicted)
        pressure, std, moved = np.zeros(nodes), np.zeros(nodes), np.zeros((nodes, 3))
        contacts: tuple[Contact, ...] = ()
        if drawn is not None:
            atoms, family = drawn.atoms, drawn.family
            self._renderer.pressure(atoms, family, pressure)
            contacts = self._renderer.contacts(atoms, family, drawn.covariance, drawn.groups)
            if fields:
                self._renderer.pressure_std(atoms, family, drawn.each, std)
                self._renderer.displacement(atoms, family, moved)
        return Fit(
            pressure=pressure,
            pressure_std=std,
            displacement=moved,
            contacts=contacts,
            predicted=found.predicted + offset,
            offset=offset,
            explained=explains(problem, found),
            notes=notes_on(problem, len(found), scale, offset),
        )

    def _answer(
        self, readings: Floats, deadline_ns: int | None
    ) -> tuple[FitProblem, AtomSet, float, Drawable | None]:
        """The atoms that explain a reading, the scale of its noise, and the atoms as drawn."""
        settings, before = self.settings, self._before if self.settings.warm else None
        problem = self.problem(readings, deadline_ns)
        shapes = self._shapes_due(problem)
        scale, start = self._scale if before is not None and len(before) else 1.0, before
        for _ in range(ROUNDS):
            if scale != 1.0:
                problem = self.problem(readings, deadline_ns, scale)
            found = search(problem, start, settings.most_contacts, settings.starts, shapes)
            step = noise_scale(problem, found, scale, settings.most_contacts)
            if step == 1.0 or problem.late:
                break
            start = found if step < 1.0 and scale <= 1.0 else None
            scale, shapes = scale * step, True
        self._scale = scale
        same = before is not None and np.array_equal(before.family, found.family)
        self._before = found
        if not len(found):
            self._kept = ()
            return problem, found, scale, None
        atoms, covariance = self._stated(problem, found, same)
        return problem, found, scale, drawable(atoms, found.family, covariance, self._thickness)

    def _shapes_due(self, problem: FitProblem) -> bool:
        """Whether the readings say much more, or less, than when shapes were last compared."""
        energy = float(np.square(problem.inputs.readings * problem.inputs.white).sum())
        due = not self._compared / RISE < energy < self._compared * RISE
        if due:
            self._compared = energy
        return due

    def problem(
        self, readings: Floats, deadline_ns: int | None = None, scale: float = 1.0
    ) -> FitProblem:
        """One reading beside all that is known, at a scale of the noise."""
        readings, noise = np.ascontiguousarray(readings, dtype=np.float64), self.noise
        floor = self.settings.model_error * float(np.abs(readings).max())
        white = 1.0 / np.hypot(scale * noise, floor)  # of noise and model together
        common = self.settings.common_mode * float(noise[np.isfinite(noise)].mean())
        shared = common**2 / (1.0 + common**2 * float(np.square(white).sum()))
        inputs = Inputs(
            readings, white, self._taxels, self._tables, self._priors, shared, self._places
        )
        return FitProblem(inputs, self._bank, noise, self._threshold, common, deadline_ns)

    def _stated(self, problem: FitProblem, found: AtomSet, same: bool) -> tuple[Floats, Floats]:
        """Atoms (N, 6) of x, y, force, radius, half-length, angle in SI; their covariances."""
        atoms = np.empty((len(found), PARAMETERS))
        covariance = np.zeros((len(found), PARAMETERS, PARAMETERS))
        kept = []
        for index, atom in enumerate(found.atoms):
            known = self._kept[index] if same and index < len(self._kept) else None
            if known is None or not known.holds(atom):
                effort = PLACES, self.settings.starts, STEP
                if known is not None:
                    effort = FEW, 0, WIDE_STEP
                belief = belief_of(problem, found, index, *effort)
                offset = belief.mean(int(found.family[index])) - atom
                if problem.inputs.white.max() * self.noise.min() > QUIETER:
                    offset[:] = 0.0  # what is left over is model error, of which no mean is known
                odd = found.long[index] or found.family[index] == RING
                error = belief.covariance + (ODD_ERROR if odd else ROUND_ERROR)
                known = Known(atom.copy(), offset, error)
            kept.append(known)
            atoms[index], covariance[index] = stated(
                atom + known.offset, known.covariance, self._thickness
            )
        self._kept = tuple(kept)
        return atoms, covariance
