"""Taxels that are broken, and in which way."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_positive, check_range


class Defect(IntEnum):
    """What a taxel does instead of feeling."""

    NONE = 0
    ABSENT = 1
    """Never answers: NaN."""
    DEAD = 2
    """Sends its count at rest, for ever."""
    STUCK = 3
    """Keeps one count from some moment on."""
    FLICKERING = 4
    """A loose joint: loses its capacitance for moments."""
    SATURATED = 5
    """A short: at the clamp of full load, for ever."""


Kinds = NDArray[np.int8]


@dataclass(frozen=True, kw_only=True)
class Defects:
    """How likely each defect is, per taxel. 0: none.

    Parameters
    ----------
    absent, dead, stuck, flickering, saturated : float
        Probability that a taxel is so; in sum at most 1.
    stuck_within : float, s
        A stuck taxel stops at a moment between the start of a recording and this.
    open_time, closed_time : float, s
        Mean time that a loose joint is open, and closed. Assumed.
    """

    absent: float = 0.0
    dead: float = 0.0
    stuck: float = 0.0
    flickering: float = 0.0
    saturated: float = 0.0
    stuck_within: float = 10.0
    open_time: float = 0.2
    closed_time: float = 0.5

    def __post_init__(self) -> None:
        for name in ("absent", "dead", "stuck", "flickering", "saturated"):
            check_range(name, getattr(self, name), 0.0, 1.0, "a probability; 0 is off")
        for name in ("stuck_within", "open_time", "closed_time"):
            check_positive(name, getattr(self, name), "in seconds")
        if sum(self._likely) > 1.0 + 1e-12:
            raise InputError(
                f"probabilities sum to {sum(self._likely):g}, expected at most 1: a taxel has "
                "one defect or none"
            )

    @property
    def _likely(self) -> tuple[float, ...]:
        return (self.absent, self.dead, self.stuck, self.flickering, self.saturated)

    def draw(self, taxels: int, rng: np.random.Generator) -> Kinds:
        """Defect of each taxel, (L,) of `Defect`."""
        kind = np.searchsorted(np.cumsum(self._likely), rng.random(taxels), side="right") + 1
        return np.where(kind > len(self._likely), Defect.NONE, kind).astype(np.int8)

    def open(self, readings: int, taxels: int, rate: float, rng: np.random.Generator) -> Floats:
        """Where loose joints are open, (T, L) of 0 and 1: a two-state Markov chain in time.

        With rates a of opening and b of closing, the state after a period is open with the
        stationary probability a/(a + b), plus what is left of the present one, exp(-(a + b)/r).
        """
        opening, closing = 1.0 / self.closed_time, 1.0 / self.open_time
        share = opening / (opening + closing)
        keep = np.exp(-(opening + closing) / rate)
        draws = rng.random((readings, taxels))
        state = np.empty((readings, taxels))
        state[0] = draws[0] < share
        for reading in range(1, readings):
            state[reading] = draws[reading] < share + (state[reading - 1] - share) * keep
        return state
