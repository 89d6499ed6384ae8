"""Choice of a layer's mechanics by evidence: another Poisson's ratio, or a cover, than stated.

What another mechanics does to a reading, force and radius of a contact nearly make up for: what is
left over hardly shows it, and the force is off by 40 % all the same. The marginal likelihood of
contacts that are fitted anew by it does show it (MacKay 2003, chapter 28), by some nats a press. So
each press is fitted by every mechanics, until the sum over presses is sure; meanwhile what they
make of the contact differently is part of what is not known of it. Then nothing is fitted but by
the one that is more probable.
"""

import time
from dataclasses import replace
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
    COMPARED,
    DRAWN,
    PRESSES,
    RESTING,
    STAGE,
    UNSURE_FORCE,
    UNSURE_PLACE,
    Neighbours,
    ReadingRules,
)

RATIOS = 0.5, 0.475, 0.45, 0.4  # Poisson's: of elastomers, with more and more bubbles
CLOSE = 0.012  # to the stated one: no other one
UNLIKELY = -2.0  # ln odds of each other mechanics over the stated one, before any press
MOST_TOLD = 4.0  # ln odds by one press
BETTER = 3.0  # ln odds, 20 to 1, from which another one answers
TRIED = 500  # steps of refinement: the right one needs fewer, nine times in ten
SETTLED = 10.0  # ln odds against all others, which never get higher: then few presses are tried
FEWER = 4  # presses to the next of these
CLEAR = 400.0  # the readings' squares over the noise: a press that tells something
STRONGER = 4.0  # times the readings' squares: then a press tells more than it did
FEW = 3  # contacts: what more of them are may be a palm, which tells nothing
WHOLE = 100_000_000  # ns, in which all are tried in one go
PIECE = 4  # times what drawing an answer takes: less time is not worth beginning


def other_physics(physics: Physics) -> tuple[tuple[str, Physics], ...]:
    """What a skin may be made of instead, each with a clause that says so."""
    layer, mechanics = physics.layer, physics.mechanics
    if not isinstance(mechanics, BondedLayer):
        return ()
    ratios = [each for each in RATIOS if abs(each - layer.poisson_ratio) > CLOSE]
    softer = [replace(physics, layer=replace(layer, poisson_ratio=each)) for each in ratios]
    covered = not mechanics.inextensible_cover
    cover = replace(physics, mechanics=replace(mechanics, inextensible_cover=covered))
    return (
        *((f"its Poisson's ratio were {each.layer.poisson_ratio:g}", each) for each in softer),
        (f"it had {'an' if covered else 'no'} inextensible cover", cover),
    )


class MechanicsChoice:
    """Fits of a patch's readings: one that answers, and one by each mechanics, tried on presses.

    Parameters
    ----------
    models : N FitModel
        The first one by what is stated.
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
    noise : (L,) array
        Deviation of what is solved next; may be written to.
    odds : (N,) array
        Logarithms of the odds of each, but for a constant, by the presses before.
    here : (N,) array
        What the press adds to them.
    """

    def __init__(
        self,
        models: tuple[FitModel, ...],
        bank: Templates,
        near: Neighbours,
        rules: ReadingRules,
        noise: Floats,
        thickness: float,
    ) -> None:
        self.models, self.noise, self._most, self.acting = models, noise.copy(), 0, 0
        self._scale = np.array([1.0 / thickness, 1.0 / thickness, 1.0])
        tried = models if len(models) > 1 else ()
        self.fit = FitData(models[0], bank, near, rules, noise)
        self._trials = [FitData(model, bank, near, rules, noise) for model in tried]
        self.odds, self.here = np.zeros((2, len(models)))
        self._places = np.zeros((len(models), 3))
        self._reading, self._its_noise = np.zeros((2, len(noise)))
        self._heard = np.ones(len(noise), np.bool_)
        self.reset()

    def limit(self, steps: int) -> None:
        """Stop after so many steps of a reading."""
        self._most = self.fit.memory.marks[MOST] = steps

    def reset(self) -> None:
        """Forget the readings before."""
        self._answer_by(0)
        for fit in (self.fit, *self._trials):
            fit.reset()
        self.here[:], self.odds[:], self.odds[0] = 0.0, UNLIKELY, 0.0
        self._trial, self._steps = -1, 0
        self._press, self._next, self._energy = 0, 1, 0.0

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
        np.copyto(self.fit.noise, self.noise)
        count = answer_reading(self.fit.packed.address, *rest)
        if self._is_due(end):
            if self._trial < 0:
                self._begin(rows[0], readings, heard)
            if self._try(grid, pressure, len(rows), end):
                np.copyto(self.fit.noise, self.noise)
                count = answer_reading(self.fit.packed.address, *rest)
        return count

    def _is_due(self, end: int) -> bool:
        """Whether a press is to be tried by each, if there is time until `end`, ns."""
        own = self.fit.own
        if not self._trials:
            return False
        if self._trial < 0:
            if own.marks[STAGE] != RESTING or not 0 < self.fit.count <= FEW:
                return False
            energy = own.numbers[COMPARED]
            if own.marks[PRESSES] != self._press:
                due = energy > CLEAR and own.marks[PRESSES] >= self._next
            else:
                due = energy > STRONGER * self._energy
            if not due:
                return False
        return not end or end - time.perf_counter_ns() > PIECE * own.numbers[DRAWN]

    def _begin(self, row: Any, readings: Floats, heard: NDArray[np.bool_]) -> None:
        """Have a reading be fitted by each, over the time of the next ones if need be."""
        own = self.fit.own
        press, self._energy = int(own.marks[PRESSES]), max(float(own.numbers[COMPARED]), CLEAR)
        if press != self._press:
            odds = self.odds + self.here
            self.odds[:] = np.maximum(odds - odds[self.acting], -SETTLED)
        self._press, self._trial, self._steps = press, 0, 0
        self._places[:] = row["x"], row["y"], np.log(row["normal_force"])
        np.copyto(self._reading, readings)
        np.copyto(self._heard, heard)
        np.copyto(self._its_noise, self.noise)

    def _try(self, grid: int, pressure: Floats, most: int, end: int) -> bool:
        """Go on fitting that reading by each; True where all is done, and decided."""
        whole = not end or end - time.perf_counter_ns() > WHOLE
        before = 0 if whole else end - int(PIECE / 2 * self.fit.own.numbers[DRAWN])
        room, rows = np.empty_like(pressure), np.zeros(most, CONTACT)
        for trial in self._trials[self._trial :]:
            memory, address = trial.memory, trial.packed.address
            if not self._steps:
                memory.counts[:] = 0
                np.copyto(trial.noise, self._its_noise)
            memory.marks[MOST] = TRIED - self._steps
            count = answer_reading(address, grid, room, rows, self._reading, self._heard, before)
            interrupted, self._steps = self._steps > 0, self._steps + max(memory.marks[STEPS], 1)
            resting = trial.own.marks[STAGE] == RESTING
            if not resting and self._steps < TRIED:
                return False
            if not resting and interrupted:  # its last piece may have been too short to infer
                memory.marks[MOST] = 1
                count = answer_reading(address, grid, room, rows, self._reading, self._heard, 0)
            self._keep_place(rows[:count])
            self._trial, self._steps = self._trial + 1, 0
        self._decide()
        return True

    def _keep_place(self, rows: NDArray[np.void]) -> None:
        """Write place and force of the contact that a trial has nearest to where one was."""
        place = self._places[self._trial]
        if len(rows):
            apart = np.square(rows["x"] - place[0]) + np.square(rows["y"] - place[1])
            row = rows[np.argmin(apart)]
            place[:] = row["x"], row["y"], np.log(row["normal_force"])

    def _decide(self) -> None:
        """See which one answers, and how far the others differ from it."""
        totals = np.array([trial.total for trial in self._trials])
        self.here[:] = np.clip(totals - totals[self.acting], -MOST_TOLD, MOST_TOLD)
        self._trial, odds = -1, self.odds + self.here
        best = int(np.argmax(odds))
        if odds[best] - odds[self.acting] > BETTER:
            self._answer_by(best)
        own, odds = self.fit.own, odds - odds[self.acting]
        shares = np.exp(odds - odds.max())
        apart = (self._places - self._places[self.acting]) * self._scale
        squares = shares @ np.square(apart) / shares.sum()
        own.numbers[UNSURE_PLACE] = np.sqrt(0.5 * (squares[0] + squares[1]))
        own.numbers[UNSURE_FORCE] = np.sqrt(squares[2])
        rival = np.delete(odds, self.acting).max()
        self._next = self._press + (FEWER if rival < -SETTLED else 1)

    def _answer_by(self, number: int) -> None:
        """Have the trial by a mechanics answer from now on."""
        if number == self.acting:
            return
        spare = self.fit
        self.fit, self._trials[number], self.acting = self._trials[number], spare, number
        spare.use(self.models[number])
        spare.own.errors[:] = self.fit.own.errors
        own, self.fit.memory.marks[MOST] = self.fit.own, self._most
        self._press, self._energy = int(own.marks[PRESSES]), float(own.numbers[COMPARED])
