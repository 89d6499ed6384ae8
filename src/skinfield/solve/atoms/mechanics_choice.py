"""Choice of a layer's mechanics by evidence: another Poisson's ratio, or a cover, than stated.

What another mechanics does to a reading, force and radius of a contact nearly make up for: what is
left over hardly shows it, and the force is off by 40 % all the same. The marginal likelihood of
contacts that are fitted anew by it does show it (MacKay 2003, chapter 28), by some nats a press. So
each press is fitted by every mechanics, until the sum over presses is sure; meanwhile what they
make of the contact differently is part of what is not known of it. Then nothing is fitted but by
the one that is more probable. A contact that goes on, at rest or sliding, is one press: what its
form is unlike those of the model would else tell the same of the mechanics over and over.
"""

import time
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import BondedLayer, Physics
from skinfield.errors import Floats
from skinfield.estimate.live_contacts import CONTACT
from skinfield.solve.atoms.dictionary import Templates
from skinfield.solve.atoms.fit_data import FitData
from skinfield.solve.atoms.fit_kernel import MOST, STEPS, FitModel
from skinfield.solve.atoms.reading_kernel import answer_reading
from skinfield.solve.atoms.reading_memory import (
    BEFORE,
    COMPARED,
    DRAWN,
    GOES_ON,
    OPEN_FORCE,
    OPEN_HALFWAY,
    OPEN_PLACE,
    RESTING,
    STAGE,
    STEPS_AT_ONCE,
    UNSURE_FORCE,
    UNSURE_PLACE,
    Neighbours,
    ReadingRules,
)
from skinfield.solve.atoms.table import atom_tables

SOFTER = 0.45  # Poisson's ratio of an elastomer with bubbles, or of a foam
UNLIKELY = -2.0  # ln odds of each other mechanics over the stated one, before any press
MOST_TOLD = 4.0  # ln odds by one press
BETTER = 3.0  # ln odds, 20 to 1, from which another one answers
TRIED = 500  # steps of refinement: the right one needs fewer, nine times in ten
SETTLED = 10.0  # ln odds against all others, which never get higher: then few presses are tried
FEWER = 4  # presses to the next of these
CLEAR = 400.0  # the readings' squares over the noise: a press that tells something
STRONGER = 4.0  # times the readings' squares: then a press tells more than it did
FEW = 3  # contacts: what more of them are may be a palm, which tells nothing
PIECE = 4  # times what drawing an answer takes: less time is not worth beginning
MAKING = 30_000_000_000  # ns, in which all tables are surely made
WHOLE = 100_000_000  # ns, in which all are tried in one go
BESIDE = 8  # steps beside a reading, where a contact goes on from the one before
# How far contacts are apart by another ratio, or cover: thicknesses, and logarithm of the force.
APART = np.array([[0.5, 0.35], [0.3, 0.75]])
SPARE = 0.1  # of the time that is left when a reading is answered, for what may wait


def other_physics(physics: Physics) -> tuple[tuple[str, Physics], ...]:
    """What a skin may be made of instead, each with a clause that says so."""
    layer, mechanics = physics.layer, physics.mechanics
    if not isinstance(mechanics, BondedLayer):
        return ()
    ratio = SOFTER if layer.poisson_ratio > 0.5 * (SOFTER + 0.5) else 0.5
    other = replace(layer, poisson_ratio=ratio)
    covered = not mechanics.inextensible_cover
    foam = " or less, as of a foam" if ratio < 0.5 else ""
    article, cover = "an" if covered else "no", replace(mechanics, inextensible_cover=covered)
    return (
        (f"its Poisson's ratio were {ratio:g}{foam}", replace(physics, layer=other)),
        (
            f"it had {article} inextensible cover",
            replace(physics, mechanics=cover),
        ),
    )


class OtherMechanics:
    """What a skin may be made of instead, with tables that are made when first needed.

    Parameters
    ----------
    stated : FitModel
    physics : Physics, optional
        What is stated. Default: no other is compared with it.

    Attributes
    ----------
    stated : FitModel
    clauses : tuple of str
        What to say of each; nothing of the first, that is stated.
    """

    def __init__(self, stated: FitModel, physics: Physics | None = None) -> None:
        others = () if physics is None else other_physics(physics)
        self.clauses = ("", *(clause for clause, _ in others))
        self.stated, self._physics = stated, tuple(other for _, other in others)

    @cached_property
    def models(self) -> tuple[FitModel, ...]:
        """Of each; takes seconds where no table of it is on disk."""
        more = (self.stated._replace(tables=atom_tables(each)) for each in self._physics)
        return (self.stated, *more)

    @property
    def is_ready(self) -> bool:
        """Whether all tables are made."""
        return "models" in vars(self)


class MechanicsChoice:
    """Fit of a patch's readings, and one by each other mechanics, tried on presses.

    Parameters
    ----------
    others : OtherMechanics
    bank : Templates
    near : Neighbours
    rules : ReadingRules
    noise : (L,) array
    thickness : float, m
        Of the layer.

    Attributes
    ----------
    fit : FitData
        The one that answers, by the mechanics number `acting`.
    odds : (N,) array
        Logarithms of the odds of each, but for a constant, by the presses before.
    here : (N,) array
        What the press adds to them.
    compared : int
        Presses by which they were compared.
    """

    def __init__(
        self,
        others: OtherMechanics,
        bank: Templates,
        near: Neighbours,
        rules: ReadingRules,
        noise: Floats,
        thickness: float,
    ) -> None:
        self._others, self._known, self._count = others, (bank, near, rules), len(others.clauses)
        self._scale = np.array([1.0 / thickness, 1.0 / thickness, 1.0])
        self.fit = FitData(others.stated, bank, near, rules, noise)
        self._trials, self._tried = list[FitData](), list(range(1, self._count))
        self.odds, self.here, self._totals = np.zeros((3, self._count))
        self._places = np.zeros((self._count, 3))
        self._reading, self._its_noise = np.zeros((2, len(noise)))
        self._heard, self.acting = np.ones(len(noise), np.bool_), 0
        if others.is_ready:
            self._make_trials()
        self.reset()

    @property
    def likely(self) -> int:
        """Number of the most probable mechanics, of which one that does not answer is not sure."""
        return int(np.argmax(self.odds + self.here))

    @property
    def probability(self) -> float:
        """Of the mechanics that answers, if the skin has one of these."""
        odds = self.odds + self.here
        return float(1.0 / np.exp(odds - odds[self.acting]).sum())

    def reset(self) -> None:
        """Forget the readings before."""
        if self.acting:
            self._answer_by(0)
        for fit in (self.fit, *self._trials):
            fit.reset()
        self.here[:], self.odds[:], self.odds[0] = 0.0, UNLIKELY, 0.0
        self._trial, self._steps = -1, 0
        self._presses, self._press, self._next, self._energy = 0, 0, 1, 0.0
        self.compared = 0
        self._leave_open()

    def answer(
        self,
        grid: int,
        pressure: Floats,
        rows: NDArray[np.void],
        readings: Floats,
        heard: NDArray[np.bool_],
        end: int,
    ) -> int:
        """Find the contacts of readings, and go on with the choice as far as the time allows.

        See `answer_reading`; `grid` is the address of the `RowGrid`.
        """
        rest = grid, pressure, rows, readings, heard, end
        count = answer_reading(self.fit.packed.address, *rest)
        goes_on = bool(self.fit.own.marks[GOES_ON])
        self._presses += count > 0 and not goes_on
        if not self._is_due(end):
            return count
        if self._trial < 0:
            self._begin(rows[0], readings, heard)
        far = not end or end - time.perf_counter_ns() > WHOLE
        steps = BESIDE if far and goes_on else 0
        if self._try(grid, pressure, len(rows), 0 if far else end, steps) and far:
            count = answer_reading(self.fit.packed.address, *rest)
        return count

    def _is_due(self, end: int) -> bool:
        """Whether a press is to be tried by each, if there is time until `end`, ns."""
        if self._count < 2:
            return False
        own = self.fit.own
        if self._trial < 0:
            if own.marks[STAGE] != RESTING or not 0 < self.fit.count <= FEW:
                return False
            energy = own.numbers[BEFORE]
            if self._presses != self._press:
                due = energy > CLEAR and self._presses >= self._next
            else:
                due = energy > STRONGER * self._energy
            if not due:
                return False
        least = PIECE * own.numbers[DRAWN] if self._others.is_ready else MAKING
        return not end or end - time.perf_counter_ns() > least

    def _make_trials(self) -> None:
        if not self._trials:
            models, noise = self._others.models, self.fit.noise
            self._trials = [FitData(model, *self._known, noise) for model in models[1:]]

    def _begin(self, row: Any, readings: Floats, heard: NDArray[np.bool_]) -> None:
        """Have a reading be fitted by each, over the time of the next ones if need be."""
        self._make_trials()
        self._energy = max(float(self.fit.own.numbers[BEFORE]), CLEAR)
        if self._presses != self._press:
            self.compared += 1
            odds = self.odds + self.here
            self.odds[:] = np.maximum(odds - odds[self.acting], -SETTLED)
        self._press, self._trial, self._steps = self._presses, 0, 0
        self._totals[self.acting] = self.fit.infer()
        self._places[:] = row["x"], row["y"], np.log(row["normal_force"])
        np.copyto(self._reading, readings)
        np.copyto(self._heard, heard)
        np.copyto(self._its_noise, self.fit.noise)

    def _try(self, grid: int, pressure: Floats, most: int, end: int, steps: int) -> bool:
        """Go on fitting that reading by each; True where all is done, and decided.

        By so many `steps`, 0 for any, and till a part of the time to `end`, 0 for any, is up.
        """
        now, before = time.perf_counter_ns(), 0
        if end:
            least = int(PIECE * self.fit.own.numbers[DRAWN])
            before = now + max(int(SPARE * (end - now)), least // 2)
        room, rows = np.empty_like(pressure), np.zeros(most, CONTACT)
        for trial in self._trials[self._trial :]:
            memory, address = trial.memory, trial.packed.address
            if not self._steps:
                memory.counts[:] = 0
                np.copyto(trial.noise, self._its_noise)
            memory.marks[MOST], trial.own.marks[STEPS_AT_ONCE] = TRIED - self._steps, steps
            count = answer_reading(address, grid, room, rows, self._reading, self._heard, before)
            self._steps += max(memory.marks[STEPS], 1)
            halfway = trial.own.marks[STAGE] != RESTING or (steps and trial.own.marks[OPEN_HALFWAY])
            if halfway and self._steps < TRIED:
                return False
            self._totals[self._tried[self._trial]] = trial.infer()
            self._keep_place(rows[:count])
            self._trial, self._steps = self._trial + 1, 0
            if steps and self._trial < len(self._trials):
                return False
        self._decide()
        return True

    def _keep_place(self, rows: NDArray[np.void]) -> None:
        """Write place and force of the contact that a trial has nearest to where one was."""
        place = self._places[self._tried[self._trial]]
        if len(rows):
            apart = np.square(rows["x"] - place[0]) + np.square(rows["y"] - place[1])
            row = rows[np.argmin(apart)]
            place[:] = row["x"], row["y"], np.log(row["normal_force"])

    def _decide(self) -> None:
        """See which one answers, and how far the others differ from it."""
        totals = self._totals
        self.here[:] = np.clip(totals - totals[self.acting], -MOST_TOLD, MOST_TOLD)
        self._trial, odds = -1, self.odds + self.here
        best = self.likely
        if odds[best] - odds[self.acting] > BETTER:
            self._answer_by(best)
        own, odds = self.fit.own, odds - odds[self.acting]
        shares = np.exp(odds - odds.max())
        apart = (self._places - self._places[self.acting]) * self._scale
        squares = shares @ np.square(apart) / shares.sum()
        own.numbers[UNSURE_PLACE] = np.sqrt(0.5 * (squares[0] + squares[1]))
        own.numbers[UNSURE_FORCE] = np.sqrt(squares[2])
        self._leave_open()
        rival = np.delete(odds, self.acting).max()
        self._next = self._press + (FEWER if rival < -SETTLED else 1)

    def _leave_open(self) -> None:
        """State how far a press that begins may be off, before it was tried."""
        own, odds = self.fit.own, self.odds + self.here
        shares = np.exp(odds - odds.max())
        shares = np.delete(shares / shares.sum(), self.acting)
        squares = shares @ np.square(APART[: len(shares)])
        own.numbers[OPEN_PLACE], own.numbers[OPEN_FORCE] = np.sqrt(squares)

    def _answer_by(self, number: int) -> None:
        """Have another mechanics answer from now on; what it was tried by goes by this one."""
        place, models = self._tried.index(number), self._others.models
        trial, own = self._trials[place], self.fit.own
        trial.use(models[self.acting])
        self.fit.use(models[number])
        own.errors[:], trial.own.errors[:] = trial.own.errors.copy(), own.errors.copy()
        own.numbers[COMPARED] = 0.0  # all sets of atoms are to be compared anew
        self._tried[place], self.acting = self.acting, number
