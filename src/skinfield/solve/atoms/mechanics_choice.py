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
from skinfield.solve.atoms.fit_data import FitData
from skinfield.solve.atoms.fit_kernel import MOST, STEPS
from skinfield.solve.atoms.reading_kernel import answer_reading
from skinfield.solve.atoms.reading_memory import (
    COMPARED,
    DRAWN,
    PRESSES,
    RESTING,
    STAGE,
    UNSURE_FORCE,
    UNSURE_PLACE,
)

SOFTER = 0.45  # Poisson's ratio of an elastomer with bubbles, or of a foam
UNLIKELY = -2.0  # ln odds of each other mechanics over the stated one, before any press
MOST_TOLD = 4.0  # ln odds by one press
BETTER = 2.0  # ln odds, from which another one answers
TRIED = 500  # steps of refinement: the right one needs fewer, nine times in ten
SETTLED = 10.0  # ln odds against all others, from which on few presses are fitted by them
STRONGER = 4.0  # times the readings' squares: then a press tells more than it did
FEW = 3  # contacts: what more of them are may be a palm, which tells nothing
PIECE = 4  # times what drawing an answer takes: less time is not worth beginning


def other_physics(physics: Physics) -> tuple[tuple[str, Physics], ...]:
    """What a skin may be made of instead, each with a clause that says so."""
    layer, mechanics = physics.layer, physics.mechanics
    if not isinstance(mechanics, BondedLayer):
        return ()
    ratio = SOFTER if layer.poisson_ratio > 0.5 * (SOFTER + 0.5) else 0.5
    other = replace(layer, poisson_ratio=ratio)
    covered = not mechanics.inextensible_cover
    article, cover = "an" if covered else "no", replace(mechanics, inextensible_cover=covered)
    return (
        (f"its Poisson's ratio were {ratio:g}", replace(physics, layer=other)),
        (
            f"it had {article} inextensible cover",
            replace(physics, mechanics=cover),
        ),
    )


class MechanicsChoice:
    """Fits of a patch's readings by each mechanics, of which one answers.

    Parameters
    ----------
    fits : list of N FitData
        The first one by what is stated.
    thickness : float, m
        Of the layer.

    Attributes
    ----------
    acting : int
        Number of the one that answers.
    learnt, here : (N,) arrays
        Logarithms of the odds of each, but for a constant, by presses before, and what this adds.
    """

    def __init__(self, fits: list[FitData], thickness: float) -> None:
        self.fits, self.thickness, self._open = fits, thickness, np.zeros(len(fits), np.bool_)
        (self.learnt, self.here), self._shifts = np.zeros((2, len(fits))), np.zeros((len(fits), 3))
        self._most = 0
        self.reset()

    @property
    def fit(self) -> FitData:
        """The one that answers."""
        return self.fits[self.acting]

    @property
    def noise(self) -> Floats:
        """Deviation (L,) of what is solved next, of all of them."""
        return self.fits[0].noise

    def limit(self, steps: int) -> None:
        """Stop after so many steps of a reading."""
        self._most = self.fit.memory.marks[MOST] = steps

    def reset(self) -> None:
        """Forget the readings before."""
        for fit in self.fits:
            fit.reset()
        self.acting, self.here[:], self.learnt[:] = 0, 0.0, UNLIKELY
        self.learnt[0] = 0.0
        self._open[:], self._shifts[:] = False, 0.0
        self._press, self._next, self._energy, self._steps = 0, 1, 0.0, 0

    def is_due(self, end: int) -> bool:
        """Whether others are to be tried on the press, if there is time until `end`, ns."""
        own, fits = self.fit.own, len(self.fits)
        if fits == 1 or own.marks[STAGE] != RESTING or not 0 < self.fit.count <= FEW:
            return False
        if own.marks[PRESSES] != self._press:
            due = own.marks[PRESSES] >= self._next
        else:
            due = self._open.any() or own.numbers[COMPARED] > STRONGER * self._energy
        left = end - time.perf_counter_ns() if end else np.inf
        return bool(due and left > PIECE * own.numbers[DRAWN])

    def compare(
        self, grid: int, rows: NDArray[np.void], nodes: int, readings: Floats, heard: Any, end: int
    ) -> bool:
        """Fit readings (L,) by the other mechanics, and see which is more probable.

        Parameters
        ----------
        grid : int
            Address of a `RowGrid` of so many `nodes`.
        rows : array of CONTACT
            That the acting fit has written.
        readings, heard : (L,) arrays
        end : int, ns
            Of the clock, or 0: what is not done until then goes on at the next reading.

        Returns
        -------
        bool
            Whether what is known of the contacts is now another.
        """
        fit = self.fit
        press, energy = int(fit.own.marks[PRESSES]), float(fit.own.numbers[COMPARED])
        if press != self._press or energy > STRONGER * self._energy:
            if press != self._press:
                self.learnt += self.here
            self.here[:], self._open[:], self._open[self.acting] = 0.0, True, False
            self._press, self._energy, self._steps, self._shifts[:] = press, energy, 0, 0.0
            for number in np.flatnonzero(self._open):
                self.fits[number].memory.counts[:] = 0
        before = end - int(PIECE / 2 * fit.own.numbers[DRAWN]) if end else 0
        pressure, others = np.empty(nodes), np.zeros(len(rows), rows.dtype)
        for number in np.flatnonzero(self._open):
            other = self.fits[number]
            address = other.packed.address
            other.memory.marks[MOST] = TRIED - self._steps
            count = answer_reading(address, grid, pressure, others, readings, heard, before)
            self._steps += int(other.memory.marks[STEPS])
            other.memory.marks[MOST] = self._most
            if other.own.marks[STAGE] != RESTING and self._steps < TRIED:
                return False
            self._open[number], self._steps = False, 0
            self.here[number] = min(max(other.total - fit.total, -MOST_TOLD), MOST_TOLD)
            self._shifts[number] = shift_of(rows[0], others[:count])
        self._decide()
        return True

    def _decide(self) -> None:
        """See which one answers, and how far the others differ from it."""
        odds = self.learnt + self.here
        best = int(np.argmax(odds))
        if odds[best] - odds[self.acting] > BETTER:
            self.acting = best
        own, odds = self.fit.own, odds - odds[self.acting]
        self._press, self._energy = int(own.marks[PRESSES]), float(own.numbers[COMPARED])
        shares = np.exp(odds - odds.max())
        squares = shares @ np.square(self._shifts - self._shifts[self.acting]) / shares.sum()
        thickness = self.thickness
        own.numbers[UNSURE_PLACE] = np.sqrt(0.5 * (squares[0] + squares[1])) / thickness
        own.numbers[UNSURE_FORCE] = np.sqrt(squares[2])
        rival = np.delete(odds, self.acting).max()
        self._next = 2 * self._press if rival < -SETTLED else self._press + 1


def shift_of(row: Any, others: NDArray[np.void]) -> Floats:
    """From a contact to the nearest of others: x and y, m, and of the force's logarithm; or 0."""
    if not len(others):
        return np.zeros(3)
    x, y = others["x"] - row["x"], others["y"] - row["y"]
    near = int(np.argmin(x * x + y * y))
    return np.array([x[near], y[near], np.log(others["normal_force"][near] / row["normal_force"])])
