"""Contact fit of a patch: its operator, residual tests, and the answer of one reading."""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.solve.atoms.alternatives_kernel import (
    BETTER,
    EXPLORE,
    SEEK,
    SETTLE,
    SearchMemory,
    SearchRules,
)
from skinfield.solve.atoms.atom_fit import AtomFit
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
from skinfield.solve.atoms.misfit_kernel import evidence_of_errors
from skinfield.solve.atoms.posterior_kernel import PosteriorMemory
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.rows_kernel import Drawing, write_rows
from skinfield.solve.atoms.search_kernel import search_atoms
from skinfield.solve.atoms.settings import FitSettings
from skinfield.solve.atoms.table import atom_tables

ODD = 1e-4  # readings that contacts explain, and that are taken not to be explained
QUIETEST = 1e-3  # of the stated noise, that is believed
QUIET = 0.25  # of the expected squares of residuals: below, there is less noise than was stated
CALM = 0.7  # the same, where more noise than was stated had been assumed
UNSEEN = 12  # taxels that see no contact, and tell the noise by themselves
CLIPPED = 9.0  # squares of residuals count no more: they may be touches
LOUD = 1.2  # times the stated noise, from which it is more: less may be weak touches
LOUDEST = 4.0  # times: what is left over beyond is no noise, but more than the atoms could tell
ERRORS: Floats = 1e-3 * np.exp2(np.arange(9.0))  # of the model: parts of what is read
ERROR_STD = 1.4  # of the logarithm of the model error, before any reading
COARSE = 0.1  # model error at which contacts are sought first, and at most
FINER = 0.25  # part of the inferred one, at which more of them are sought
STRONG = 20.0  # deviations of a reading, from which the model may be what is wrong
AROUND = 4.5  # thicknesses over which a model error reaches
BESIDE, WIDER = 0.2, 4.0  # how much of it does, and times the error
ELSEWHERE = 1.0  # thicknesses from one press to another one
FORGET = 0.98  # of what presses before say of the model error, at each other one
TABULATED = 0.002  # of the highest reading, to which what atoms are read as is known
MOST_SAID = 20.0  # by one press, in logarithms
LARGEST = 0.2  # model error, from which on contacts explain nothing
PRESSES, UNLIKE = 10, 0.02  # of which a model error as large is worth a note


def wideness(error: Any) -> Any:
    """How much what neighbours read counts, for a model error: a large one is not local."""
    return np.minimum(np.hypot(BESIDE, WIDER * error), 1.0)


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


QUIETER = 2.0  # times the stated precision, from which the noise is less than was stated


class FitData:
    """Scratch memory of a contact fit, and what it remembers of the reading before.

    Parameters
    ----------
    fitter : ContactFitter

    Attributes
    ----------
    noise : (L,) array, in the quantity's unit
        Deviation of what is solved next; infinite of taxels that shall not be heard.
    total : float
        Logarithm of the marginal likelihood of the atoms, whatever the model error, over the
        density of the stated noise at 0.
    offset : float, in the quantity's unit
        That all taxels are taken to share.
    explained : bool
        Whether noise and model error account for what is left over.
    """

    def __init__(self, fitter: "ContactFitter") -> None:
        settings, most = fitter.settings, fitter.settings.most_contacts
        self.memory = FitMemory.of(fitter.fit_model, most)
        self.search = SearchMemory.of(fitter.bank, most, settings.starts)
        self.posterior = PosteriorMemory.of(most)
        self.drawing = Drawing.of(most)
        self.noise = fitter.model.noise_std.copy()
        self.heard = self.noise.copy()  # infinite of taxels that are left out
        self.threshold = fitter.threshold
        self.scale = 1.0
        self.compared = 0.0
        self.before = np.zeros(most + 1, np.int64)  # families of the reading before, their number
        self.misfit = self.spread = fitter.settings.model_error
        self.evidence = np.zeros(len(ERRORS))  # of model errors, by this reading
        self.last, self.learnt = self.evidence, self.evidence  # by the one and all presses before
        self.presses, self.place = 0, np.full(2, np.inf)
        self.total = self.offset = 0.0
        self.explained = True

    @property
    def count(self) -> int:
        """Atoms of the answer."""
        return int(self.memory.counts[NOW])

    @property
    def at_mean(self) -> bool:
        """Whether the posterior's mean is the answer: its error is smaller.

        Where what is left over is model error, no mean of it is known.
        """
        return not self.memory.taxels[WHITE].max() * self.heard.min() > QUIETER

    def take_noise(self, valid: NDArray[np.bool_] | None) -> None:
        """Go by the present noise, with all taxels or with those of a mask (L,)."""
        noise = self.noise if valid is None else np.where(valid, self.noise, np.inf)
        if not np.array_equal(noise, self.heard):
            np.copyto(self.heard, noise)
            self.posterior.known[:] = 0

    def squares(self, left: Floats) -> float:
        """Of what is left over of readings (L,), over their noise."""
        return float(np.square(left / self.heard).sum())

    def reset(self) -> None:
        """Forget the reading before."""
        self.memory.counts[:], self.posterior.known[:] = 0, 0
        self.scale, self.compared, self.before[-1] = 1.0, 0.0, 0
        self.search.state[:] = 0
        self.last = self.learnt = np.zeros(len(ERRORS))
        self.presses, self.place = 0, np.full(2, np.inf)

    def state(self) -> tuple[Any, ...]:
        """The answer so far; `take_state` goes back to it."""
        memory, count = self.memory, int(self.memory.counts[NOW])
        atoms, family = memory.atoms[NOW, :count].copy(), memory.family[NOW, :count].copy()
        return atoms, family, self.scale, self.misfit, self.spread, self.evidence

    def take_state(self, state: tuple[Any, ...]) -> None:
        """Take an answer of before; the set's costs are those of another one then."""
        atoms, family, self.scale, self.misfit, self.spread, self.evidence = state
        memory, count = self.memory, len(atoms)
        memory.counts[NOW] = count
        memory.atoms[NOW, :count], memory.family[NOW, :count] = atoms, family


class ContactFitter:
    """Finds contacts reading by reading: prepared once, for all grids of a patch.

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
        from scipy.spatial import cKDTree

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
        tree = cKDTree(taxels)
        near = tree.sparse_distance_matrix(tree, 2.0 * AROUND, output_type="coo_matrix").tocsr()
        near.data = np.where(near.data > 0.0, np.exp(-np.square(near.data / AROUND)), 0.0)
        self._around = near
        self.fit_model = FitModel(taxels, tables, priors, np.array([low, high]))
        self.bank: Templates = make_templates(self.fit_model, 1.0 / model.noise_std)
        self.threshold = significant(settings.false_alarm_rate, len(model.taxels))

    def data(self) -> FitData:
        """Make scratch memory."""
        return FitData(self)

    def touches(self) -> list[Floats]:
        """Readings (L,) of touches by which all that is compiled is run."""
        bank = self.bank
        strongest = int(np.argmax(bank.norms))
        block = int(np.searchsorted(bank.firsts, strongest, side="right")) - 1
        template = np.zeros(len(self.model.taxels))
        np.add.at(template, bank.taxels[block], bank.templates[strongest])
        return [template * (strength * self.model.noise_std) for strength in FIRST]

    def fit(
        self,
        readings: Floats,
        data: FitData,
        valid: NDArray[np.bool_] | None = None,
        deadline_ns: int | None = None,
    ) -> None:
        """Find the contacts of readings (L,), 0 where not `valid`; see `ContactOperator.solve`."""
        memory = data.memory
        data.take_noise(valid)
        self._search(readings, data, deadline_ns or 0)
        count = data.count
        data.before[:count], data.before[-1] = memory.family[NOW, :count], count
        data.offset = self._offset(memory, memory.predicted[NOW])
        data.explained = self._explains(memory) and data.misfit < LARGEST

    def write(
        self, data: FitData, renderer: AtomRenderer, pressure: Floats, rows: NDArray[np.void]
    ) -> int:
        """Write pressure (K,) and rows of `CONTACT` of the last answer; how many there are."""
        known = data.memory, data.posterior, data.at_mean, data.spread, data.drawing
        return int(write_rows(renderer.rows, *known, pressure, rows))

    def answer_of(self, data: FitData, renderer: AtomRenderer) -> AtomFit:
        """The last answer, drawn by a renderer when it is used."""
        memory, count = data.memory, data.count
        return AtomFit(
            renderer=renderer,
            thickness=self._thickness,
            atoms=memory.atoms[NOW, :count].copy(),
            offsets=data.posterior.offsets[:count].copy(),
            covariance=data.posterior.covariance[:count].copy(),
            family=memory.family[NOW, :count].copy(),
            model_error=data.spread,
            at_mean=data.at_mean,
            predicted=memory.predicted[NOW] + data.offset,
            offset=data.offset,
            evidence=float(data.search.known[0]),
            explained=data.explained,
            notes=self.notes(data),
        )

    def _offset(self, memory: FitMemory, predicted: Floats) -> float:
        weight = np.square(memory.taxels[WHITE])
        return float(memory.sums[SHARED] * (weight @ (memory.taxels[READINGS] - predicted)))

    def _common(self, data: FitData) -> float:
        return self.settings.common_mode * float(data.heard[np.isfinite(data.heard)].mean())

    def notes(self, data: FitData) -> tuple[str, ...]:
        """What is to be told of the last answer, in sentences."""
        notes, count, offset = [], data.count, data.offset
        if data.memory.marks[LATE]:
            steps, most = data.memory.marks[STEPS], data.memory.marks[MOST]
            end = f"after {steps} steps" if steps >= most > 0 else "at the deadline"
            notes.append(f"ContactFit stopped {end}, with {count} found")
        if data.scale > LOUD:
            notes.append("ContactFit saw more noise than was stated, and went by what it saw")
        if abs(offset) > self._common(data) > 0.0:
            notes.append("ContactFit took what all taxels share for an offset: tare the skin")
        if data.presses >= PRESSES and data.misfit > UNLIKE:
            notes.append(
                f"ContactFit: this skin reads unlike its model, by {100 * data.misfit:.0f} % press "
                "after press: Poisson's ratio, cover or gains differ; calibrate"
            )
        return tuple(notes)

    def _squares(self, memory: FitMemory) -> Floats:
        """Squares of what taxels around the atoms read, and of what is read beside them, (2, L).

        Of all taxels, where nothing is found.
        """
        values = np.square(memory.taxels[READINGS])
        count = int(memory.counts[NOW])
        if count:
            atoms = memory.atoms[NOW, :count]
            reach = AROUND + np.exp(atoms[:, 3]) + np.hypot(atoms[:, 4], atoms[:, 5])
            away = self.fit_model.taxels[:, None] - atoms[:, :2]
            values[~(np.hypot(away[..., 0], away[..., 1]) < reach).any(axis=1)] = 0.0
        return np.stack([values, self._around @ values])

    def _noise(self, data: FitData) -> Floats:
        """What a taxel may be off by where the model holds, (L,): noise, and the tables' error."""
        highest = float(np.abs(data.memory.taxels[READINGS]).max())
        return np.hypot(data.scale * data.heard, TABULATED * highest)

    def _weigh(self, readings: Floats, data: FitData, error: float) -> None:
        """Take in a reading (L,) with a model error, in parts of what the taxels around it read."""
        memory = data.memory
        memory.taxels[READINGS] = readings
        own, beside = self._squares(memory)
        square = error**2 * (own + wideness(error) ** 2 * beside)
        memory.taxels[WHITE] = 1.0 / np.sqrt(np.square(self._noise(data)) + square)
        common = self._common(data)
        squares = float(np.square(memory.taxels[WHITE]).sum())
        memory.sums[SHARED] = common**2 / (1.0 + common**2 * squares)

    def _search(self, readings: Floats, data: FitData, deadline: int) -> None:
        """Find the atoms, first with a coarse model; more where they outweigh a better model.

        How wrong the model is, is inferred with each number of them, by the marginal likelihood.
        """
        memory = data.memory
        if not self.settings.warm:
            data.reset()
        warm = bool(data.before[-1])
        heard = readings / data.heard
        energy, strong = float(np.square(heard).sum()), float(np.abs(heard).max()) > STRONG
        thorough = not warm or not data.compared / RISE < energy < data.compared * RISE
        if thorough:
            data.compared = energy
        error = data.misfit
        if not warm:
            memory.counts[NOW], data.scale = 0, 1.0
            error = COARSE if strong else FINER * COARSE
        best = self._round(readings, data, error, thorough, deadline)
        while thorough and strong and not memory.marks[LATE]:
            before = data.state()
            value = self._round(readings, data, FINER * min(data.misfit, COARSE), True, deadline)
            if not value > best + BETTER:
                data.take_state(before)
                break
            best = value
        index = 0
        while thorough and index < memory.counts[NOW] > 1 and not memory.marks[LATE]:
            before = data.state()
            memory.counts[NOW] -= 1
            for row in (memory.atoms[NOW], memory.family[NOW]):
                row[index:-1] = row[index + 1 :].copy()
            self._weigh(readings, data, data.misfit)
            self._run(data, SETTLE, False, deadline)
            value = self._infer(data)
            if value > best + BETTER:
                best = value
                continue
            data.take_state(before)
            index += 1
        data.total = best
        self._learn(data)
        self._weigh(readings, data, data.spread)
        self._run(data, EXPLORE, False, deadline)

    def _run(self, data: FitData, purpose: int, shapes: bool, deadline: int) -> None:
        settings = self.settings
        search_atoms(
            self.fit_model,
            self.bank,
            data.memory,
            data.search,
            data.posterior,
            SearchRules(data.threshold, settings.most_contacts, settings.starts, purpose),
            data.heard,
            shapes,
            deadline,
        )

    def _round(
        self, readings: Floats, data: FitData, error: float, shapes: bool, deadline: int
    ) -> float:
        """Search with a model error, and infer noise and error by what is found: the evidence."""
        memory = data.memory
        for turn in range(ROUNDS):
            self._weigh(readings, data, min(error, COARSE))
            self._run(data, SEEK, shapes or turn > 0, deadline)
            step = self._noise_scale(data)
            if step == 1.0 or memory.marks[LATE] or turn == ROUNDS - 1:
                break  # what is taken away is sought anew
            if not (step < 1.0 and data.scale <= 1.0):
                memory.counts[NOW] = 0
            data.scale *= step
        return self._infer(data)

    def _infer(self, data: FitData) -> float:
        """Infer the model error from what the atoms leave and presses before; their evidence."""
        memory, out = data.memory, np.empty(len(ERRORS))
        squares = self._squares(memory) if memory.counts[NOW] else np.zeros((2, len(data.heard)))
        noise = self._noise(data)
        evidence_of_errors(
            self.fit_model,
            memory,
            noise,
            squares,
            self._common(data),
            ERRORS,
            wideness(ERRORS),
            out,
        )
        prior = data.learnt - 0.5 * np.square(
            np.log(ERRORS / self.settings.model_error) / ERROR_STD
        )
        share = np.exp(prior + out - (prior + out).max())
        evidence = float(np.log(share.sum() / np.exp(prior - prior.max()).sum()))
        evidence += float((prior + out).max() - prior.max())
        share /= share.sum()
        data.evidence = np.maximum(out - out.max(), -MOST_SAID)
        data.misfit = float(np.exp(share @ np.log(ERRORS)))
        data.spread = float(np.sqrt(share @ np.square(ERRORS)))
        heard = np.isfinite(noise)
        return evidence - float(np.log(noise[heard] / data.heard[heard]).sum())

    def _learn(self, data: FitData) -> None:
        """Count what the press before says of the model error, where this is another one."""
        if data.memory.counts[NOW]:
            place = data.memory.atoms[NOW, 0, :2]
            if not np.hypot(*(place - data.place)) <= ELSEWHERE:
                data.learnt = FORGET * (data.learnt + data.last)
                data.presses, data.place = data.presses + 1, place.copy()
            data.last = data.evidence

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

    def _noise_scale(self, data: FitData) -> float:
        """By how much the noise differs from what is assumed, by what the atoms leave over; or 1.

        It is less where the squares are far fewer than the taxels: of all taxels, and of those that
        see a contact, the larger of the two, so that taxels that always read zero do not speak for
        the others. It is more where the atoms do not explain the readings and taxels that see none
        of them are as restless: what they read is no touch. Where as many atoms as there may be do
        not explain the readings, all taxels tell it.
        """
        memory, scale = data.memory, data.scale
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
            if np.count_nonzero(~seen) >= UNSEEN:
                typical = float(np.sqrt(np.minimum(np.square(left[~seen]), CLIPPED).mean()))
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
