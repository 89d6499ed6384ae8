"""Contact fit of a patch: its operator, residual tests, and the answer of one reading."""

import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError, Ints
from skinfield.estimate import Contact
from skinfield.solve.atoms.alternatives_kernel import SearchMemory, SearchRules
from skinfield.solve.atoms.atom_readings import PARAMETERS
from skinfield.solve.atoms.dictionary import MARGIN, Templates, make_templates
from skinfield.solve.atoms.fit_kernel import (
    LATE,
    MOST,
    NOW,
    READINGS,
    SHARED,
    STEPS,
    WHITE,
    FitMemory,
    FitModel,
    Priors,
)
from skinfield.solve.atoms.posterior_kernel import PosteriorMemory
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.ring_source import Drawable, drawable
from skinfield.solve.atoms.search_kernel import search_atoms
from skinfield.solve.atoms.settings import FitSettings
from skinfield.solve.atoms.table import RING, atom_tables

ODD = 1e-4  # readings that contacts explain, and that are taken not to be explained
QUIETEST = 1e-3  # of the stated noise, that is believed
QUIET = 0.25  # of the expected squares of residuals: below, there is less noise than was stated
CALM = 0.7  # the same, where more noise than was stated had been assumed
UNSEEN = 12  # taxels that see no contact, and tell the noise by themselves
LOUD = 1.8  # times the stated noise, from which it is more: less may be weak touches
LOUDEST = 4.0  # times: what is left over beyond is no noise, but more than the atoms could tell
NORMAL_MEDIAN = 0.6745  # of the absolute value of a standard normal number


def significant(false_alarm_rate: float, taxels: int) -> float:
    """Gain in cost that noise exceeds at this rate: three parameters at as many places as taxels.

    Half the quantile of chi-squared with three degrees of freedom (Wilks 1938).
    """
    from scipy.special import chdtri

    return 0.5 * float(chdtri(3, false_alarm_rate / taxels))


CURVATURE_STD = 0.8  # of the logarithm of a ball's radius of curvature, before any reading
FLAT_RADIUS, FLAT_STD = 3e-3, 0.7  # m: middle of the prior of a flat end, and of its logarithm
RING_RADIUS, RING_STD = 4e-3, 0.5  # m, and of its logarithm
LENGTH_STD = 4e-3  # m: of each component of the half-length of a line
FIRST = (6.0, 8.0, 60.0)  # standard deviations: touches by which all is loaded, faint and clear
ROUNDS = 5  # of searches, until the noise is as what is left over
RISE = 1.5  # of the readings' squares over the noise, after which shapes are compared again


def _model_error(place: float, force: float) -> Floats:
    return np.diag(np.square([place, place, force, force, 0.0, 0.0]))


# What presses is no perfect ball, flat end, line or ring: in thicknesses, and part of the force.
ROUND_ERROR, ODD_ERROR = _model_error(0.02, 0.03), _model_error(0.25, 0.1)
QUIETER = 2.0  # times the stated precision, from which the noise is less than was stated


@dataclass(frozen=True, eq=False)
class AtomFit:
    """What a contact fit makes of one reading; fields and contacts are drawn when they are used.

    Attributes
    ----------
    renderer : AtomRenderer
    thickness : float, m
    atoms, offsets : (N, 6) arrays
        At the minimum of the cost, and from there to the posterior's mean; see `fit_kernel`.
    covariance : (N, 6, 6) array
    family : (N,) int array
    at_mean : bool
        Whether the mean is the answer: its error is smaller.
    predicted : (L,) array, in the quantity's unit
        What the taxels would read of them.
    offset : float, in the quantity's unit
        That all taxels are taken to share; it is part of what is predicted.
    evidence : float
        Logarithm of the marginal likelihood, up to a constant that all readings share.
    explained : bool
        Whether noise accounts for what the contacts leave over.
    notes : tuple of str
    """

    renderer: AtomRenderer
    thickness: float
    atoms: Floats
    offsets: Floats
    covariance: Floats
    family: Ints
    at_mean: bool
    predicted: Floats
    offset: float
    evidence: float
    explained: bool
    notes: tuple[str, ...]

    @property
    def parameters(self) -> int:
        """Numbers that were fitted: four of each atom, six of a drawn-out one."""
        return int(4 * len(self.atoms) + 2 * np.any(self.atoms[:, 4:], axis=1).sum())

    @cached_property
    def drawn(self) -> Drawable | None:
        """Atoms as they are drawn; None without any."""
        if not len(self.atoms):
            return None
        atoms, covariance = np.empty_like(self.atoms), np.empty_like(self.covariance)
        for index, (atom, known) in enumerate(zip(self.atoms, self.covariance, strict=True)):
            odd = np.any(atom[4:]) or self.family[index] == RING
            error = known + (ODD_ERROR if odd else ROUND_ERROR)
            mean = atom + self.offsets[index] if self.at_mean else atom
            atoms[index], covariance[index] = stated(mean, error, self.thickness)
        return drawable(atoms, self.family, covariance, self.thickness)

    @cached_property
    def pressure(self) -> Floats:
        """Mean pressure on each cell, (K,) Pa."""
        out = np.zeros(len(self.renderer.grid))
        if len(self.atoms):
            self.renderer.pressure(*self._rendered, out)
        return out

    @cached_property
    def _rendered(self) -> tuple[Floats, Ints]:
        """Atoms in SI as they are drawn, without what a covariance takes, and their families."""
        if self.family.max() == RING:
            assert self.drawn is not None  # as there are atoms
            return self.drawn.atoms, self.drawn.family
        mean = self.atoms + self.offsets if self.at_mean else self.atoms
        out, half = np.empty_like(mean), mean[:, 4:]
        out[:, :2] = mean[:, :2] * self.thickness
        out[:, 2:4] = np.exp(mean[:, 2:4]) * (1.0, self.thickness)
        out[:, 4] = np.hypot(half[:, 0], half[:, 1]) * self.thickness
        out[:, 5] = np.arctan2(half[:, 1], half[:, 0])
        return out, self.family

    @cached_property
    def pressure_std(self) -> Floats:
        """One standard deviation of it, (K,) Pa."""
        out, drawn = np.zeros(len(self.renderer.grid)), self.drawn
        if drawn is not None:
            self.renderer.pressure_std(drawn.atoms, drawn.family, drawn.each, out)
        return out

    @cached_property
    def displacement(self) -> Floats:
        """Of the nodes in the patch's frame, (K, 3) m."""
        out = np.zeros((len(self.renderer.grid), 3))
        if self.drawn is not None:
            self.renderer.displacement(self.drawn.atoms, self.drawn.family, out)
        return out

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """By falling normal force."""
        drawn = self.drawn
        if drawn is None:
            return ()
        return self.renderer.contacts(drawn.atoms, drawn.family, drawn.covariance, drawn.groups)


class FitData:
    """Scratch memory of a contact fit, and what it remembers of the reading before.

    Parameters
    ----------
    operator : ContactFitter
    """

    def __init__(self, operator: "ContactFitter") -> None:
        settings, most = operator.settings, operator.settings.most_contacts
        self.memory = FitMemory.of(operator.fit_model, most)
        self.search = SearchMemory.of(operator.bank, most, settings.starts)
        self.posterior = PosteriorMemory.of(most)
        self.noise = operator.model.noise_std.copy()
        self.threshold = operator.threshold
        self.scale = 1.0
        self.compared = 0.0
        self.before = np.zeros(most + 1, np.int64)  # families of the reading before, their number

    def reset(self) -> None:
        """Forget the reading before."""
        self.memory.counts[:], self.posterior.known[:] = 0, 0
        self.scale, self.compared, self.before[-1] = 1.0, 0.0, 0
        self.search.state[:] = 0


class ContactFitter:
    """Finds contacts reading by reading; for one thread at a time.

    Parameters
    ----------
    settings : FitSettings
        Such as `ContactFit()`.
    model : ObservationModel
        With its physics.
    """

    def __init__(self, settings: FitSettings, model: ObservationModel) -> None:
        if model.physics is None:
            raise InputError(
                "the model does not say what it is made of, expected physics: make it with "
                "ObservationModel.of()"
            )
        physics = model.physics
        self.settings, self.model = settings, model
        self._thickness = thickness = physics.layer.thickness
        tables = atom_tables(physics)
        taxels = np.ascontiguousarray(model.taxels / thickness)
        priors = Priors(
            float(np.log(settings.typical_radius)),
            CURVATURE_STD,
            float(np.log(FLAT_RADIUS / thickness)),
            FLAT_STD,
            float(np.log(RING_RADIUS / thickness)),
            RING_STD,
            LENGTH_STD / thickness,
        )
        low, high = taxels.min(axis=0) - MARGIN, taxels.max(axis=0) + MARGIN
        self.fit_model = FitModel(taxels, tables, priors, np.array([low, high]))
        self.bank: Templates = make_templates(self.fit_model, 1.0 / model.noise_std)
        self.threshold = significant(settings.false_alarm_rate, len(model.taxels))
        self._renderer = AtomRenderer(model.grid, physics.layer, physics.mechanics)
        self.extended = settings.extended.prepare(model) if settings.extended else None
        self._data = FitData(self)

    @property
    def noise(self) -> Floats:
        """Of the readings (L,); the model's, until `take_noise`."""
        return self._data.noise

    @property
    def memory(self) -> FitMemory:
        """What is known of the last reading."""
        return self._data.memory

    def run_in(self) -> None:
        """Load all that is compiled: a first reading is as fast as the next."""
        bank = self.bank
        strongest = int(np.argmax(bank.norms))
        block = int(np.searchsorted(bank.firsts, strongest, side="right")) - 1
        template = np.zeros(len(self.model.taxels))
        np.add.at(template, bank.taxels[block], bank.templates[strongest])
        for strength in FIRST:
            fit = self.fit(template * (strength * self.model.noise_std))
        _ = fit.pressure, fit.contacts
        self.reset()

    def with_settings(self, settings: FitSettings) -> "ContactFitter":
        """Share all that is prepared, with a memory of its own: for patches of equal geometry.

        `settings` may differ in what is weighed, not in how many atoms or starts there are.
        """
        other = copy.copy(self)
        other.settings = settings
        other._data = FitData(other)
        return other

    def take_noise(self, noise: Floats) -> None:
        """Go by another noise (L,) from now on: infinite of taxels that shall not be heard."""
        if not np.array_equal(noise, self._data.noise):
            self._data.noise = np.array(noise, dtype=np.float64)
            self._data.posterior.known[:] = 0

    def take_rate(self, false_alarm_rate: float) -> None:
        """See a contact in another share of idle readings than the settings have it."""
        self._data.threshold = significant(false_alarm_rate, len(self.model.taxels))

    def reset(self) -> None:
        """Forget the reading before."""
        self._data.reset()

    def fit(self, readings: Floats, deadline_ns: int | None = None) -> "AtomFit":
        """See `ContactOperator.fit`."""
        data = self._data
        memory = data.memory
        self._search(readings, data, deadline_ns or 0)
        count = int(memory.counts[NOW])
        family = memory.family[NOW, :count].copy()
        data.before[:count], data.before[-1] = family, count
        predicted = memory.predicted[NOW].copy()
        offset = self._offset(memory, predicted)
        return AtomFit(
            renderer=self._renderer,
            thickness=self._thickness,
            atoms=memory.atoms[NOW, :count].copy(),
            offsets=data.posterior.offsets[:count].copy(),
            covariance=data.posterior.covariance[:count].copy(),
            family=family,
            # where what is left over is model error, no mean of it is known
            at_mean=not memory.taxels[WHITE].max() * data.noise.min() > QUIETER,
            predicted=predicted + offset,
            offset=offset,
            evidence=float(data.search.known[0]),
            explained=self._explains(memory),
            notes=self._notes(data, count, offset),
        )

    def _offset(self, memory: FitMemory, predicted: Floats) -> float:
        weight = np.square(memory.taxels[WHITE])
        return float(memory.sums[SHARED] * (weight @ (memory.taxels[READINGS] - predicted)))

    def _common(self, data: FitData) -> float:
        return self.settings.common_mode * float(data.noise[np.isfinite(data.noise)].mean())

    def _notes(self, data: FitData, count: int, offset: float) -> tuple[str, ...]:
        """What is to be told of an answer with as many contacts, in sentences."""
        notes = []
        if data.memory.marks[LATE]:
            steps, most = data.memory.marks[STEPS], data.memory.marks[MOST]
            end = f"after {steps} steps" if steps >= most > 0 else "at the deadline"
            notes.append(f"ContactFit stopped {end}, with {count} found")
        if data.scale > LOUD:
            notes.append("ContactFit saw more noise than was stated, and went by what it saw")
        if abs(offset) > self._common(data) > 0.0:
            notes.append("ContactFit took what all taxels share for an offset: tare the skin")
        return tuple(notes)

    def weigh(self, readings: Floats, data: FitData, scale: float) -> None:
        """Take in a reading (L,) with a scale of the noise."""
        memory, noise = data.memory, data.noise
        memory.taxels[READINGS] = readings
        floor = self.settings.model_error * float(np.abs(readings).max())
        memory.taxels[WHITE] = 1.0 / np.hypot(scale * noise, floor)
        common = self._common(data)
        squares = float(np.square(memory.taxels[WHITE]).sum())
        memory.sums[SHARED] = common**2 / (1.0 + common**2 * squares)

    def _search(self, readings: Floats, data: FitData, deadline: int) -> None:
        memory, settings = data.memory, self.settings
        warm = settings.warm and bool(data.before[-1])
        if not settings.warm or not data.before[-1]:
            memory.counts[NOW] = 0
        scale = data.scale if warm else 1.0
        self.weigh(readings, data, scale)
        energy = float(np.square(memory.taxels[READINGS] * memory.taxels[WHITE]).sum())
        shapes = not data.compared / RISE < energy < data.compared * RISE
        if shapes:
            data.compared = energy
        rules = SearchRules(data.threshold, settings.most_contacts, settings.starts)
        for turn in range(ROUNDS):
            if turn:
                self.weigh(readings, data, scale)
            search_atoms(
                self.fit_model,
                self.bank,
                memory,
                data.search,
                data.posterior,
                rules,
                data.noise,
                shapes,
                deadline,
            )
            step = self._noise_scale(data, scale)
            if step == 1.0 or memory.marks[LATE]:
                break
            if not (step < 1.0 and scale <= 1.0):
                memory.counts[NOW] = 0
            scale, shapes = scale * step, True
        data.scale = scale

    def _explains(self, memory: FitMemory) -> bool:
        """Whether noise and model error account for what is left over, but for one in 1e4."""
        left = self._left(memory) * memory.taxels[WHITE]
        return bool(left @ left <= self._limits[self._freedom(memory)])

    @cached_property
    def _limits(self) -> Floats:
        """Squares of as many normal numbers as the place that all but one in 1e4 stay below."""
        from scipy.special import chdtri

        return np.asarray(chdtri(np.arange(len(self.model.taxels) + 1), ODD))

    def _left(self, memory: FitMemory) -> Floats:
        predicted = memory.predicted[NOW]
        return np.asarray(memory.taxels[READINGS] - predicted - self._offset(memory, predicted))

    def _parameters(self, memory: FitMemory) -> int:
        count = memory.counts[NOW]
        long = np.any(memory.atoms[NOW, :count, 4:], axis=1)
        return int(4 * count + 2 * long.sum())

    def _freedom(self, memory: FitMemory) -> int:
        heard = int(np.count_nonzero(memory.taxels[WHITE]))
        return max(heard - self._parameters(memory), 1)

    def _noise_scale(self, data: FitData, scale: float) -> float:
        """By how much the noise differs from what is assumed, by what the atoms leave over; or 1.

        `scale` is what is assumed already, in terms of what was stated. It is less where the
        squares are far fewer than the taxels: of all taxels, and of those that see a contact, the
        larger of the two, so that taxels that always read zero do not speak for the others. It is
        more where the atoms do not explain the readings and taxels that see none of them are as
        restless: what they read is no touch. Where as many atoms as there may be do not explain the
        readings, all taxels tell it.
        """
        memory = data.memory
        white, predicted = memory.taxels[WHITE], memory.predicted[NOW]
        count = int(memory.counts[NOW])
        left = self._left(memory) * white
        seen = (np.abs(predicted) * white > 1.0) | (white <= 0.0)
        if not self._explains(memory):
            if count >= self.settings.most_contacts:
                nothing = np.zeros(len(left))
                left = (memory.taxels[READINGS] - self._offset(memory, nothing)) * white
                seen = white <= 0.0
            typical = 1.0
            if np.count_nonzero(~seen) >= UNSEEN:  # by the median, which a few large do not move
                typical = float(np.median(np.abs(left[~seen]))) / NORMAL_MEDIAN
            return typical if LOUD < typical <= LOUDEST / scale else 1.0
        if not count:
            return 1.0
        squares, parameters = np.square(left), self._parameters(memory)
        share = float(squares.sum()) / self._freedom(memory)
        seen &= white > 0.0
        if seen.sum() > parameters + 2:
            share = max(share, float(squares[seen].sum()) / (int(seen.sum()) - parameters))
        enough = QUIET if scale <= 1.0 else CALM
        return 1.0 if share > enough else max(float(np.sqrt(share)), QUIETEST / scale)


def stated(atom: Floats, covariance: Floats, thickness: float) -> tuple[Floats, Floats]:
    """An atom and its covariance as x m, y m, force N, radius m, half-length m and angle rad."""
    half, angle = float(np.hypot(atom[4], atom[5])), float(np.arctan2(atom[5], atom[4]))
    force, radius = float(np.exp(atom[2])), float(np.exp(atom[3])) * thickness
    by = np.zeros((PARAMETERS, PARAMETERS))
    by[0, 0] = by[1, 1] = thickness
    by[2, 2], by[3, 3] = force, radius
    if half > 0.0:
        along, across = np.cos(angle), np.sin(angle)
        by[4, 4], by[4, 5] = thickness * along, thickness * across
        by[5, 4], by[5, 5] = -across / half, along / half
    place = atom[:2] * thickness
    return np.array([*place, force, radius, half * thickness, angle]), by @ covariance @ by.T
