"""One track: a filter, whose contact it is, and what it has absorbed."""

import math
from dataclasses import dataclass

import numpy as np

from skinfield.contacts.tracking.kernels import predict, update
from skinfield.contacts.tracking.motion import Motion
from skinfield.errors import Floats
from skinfield.fields import Contact


@dataclass(frozen=True, eq=False)
class Seen:
    """A contact of one reading in the developed plane.

    Attributes
    ----------
    contact : Contact
    value : (3,) array
        x and y m, normal force N.
    noise : (3, 3) array
        Covariance of `value`.
    """

    contact: Contact
    value: Floats
    noise: Floats


@dataclass
class Identity:
    """What goes with a contact when tracks are exchanged: number, and times in s."""

    number: int
    made: float
    slipped: float
    slips: bool = False


@dataclass(frozen=True, eq=False)
class Absorbed:
    """A contact that merged into another: both as they were at that time.

    Attributes
    ----------
    identity : Identity
    time : float, s
    apart : (6,) array
        State of the absorbed one less that of the one that stayed.
    forces : (2,) array, N
        Of the absorbed one, and of the one that stayed.
    variance : float, m² and m²/s²
        Of the distance, and of its rate, on each axis.
    """

    identity: Identity
    time: float
    apart: Floats
    forces: Floats
    variance: tuple[float, float]


class Track:
    """One contact through time.

    Attributes
    ----------
    mean, covariance : (6,) and (6, 6) arrays
        x and y m in the developed plane, normal force N, and their rates per s.
    identity : Identity or None
        None until it is confirmed.
    seen : Seen
        What was seen of it last.
    time : float, s
        When that was.
    readings : int
        In which it was seen.
    first : float, s
        When it was seen first.
    absorbed : list of Absorbed
    parent : Track or None
        From which it split, until it is confirmed.
    """

    def __init__(self, motion: Motion, seen: Seen, now: float) -> None:
        self._motion = motion
        self.mean, self.covariance = np.zeros(6), np.zeros((6, 6))
        self.identity: Identity | None = None
        self.absorbed: list[Absorbed] = []
        self.parent: Track | None = None
        self.readings, self.first = 0, now
        self.restart(seen, now, np.zeros(3))

    @property
    def is_confirmed(self) -> bool:
        """Whether it is told."""
        return self.identity is not None

    @property
    def known(self) -> Identity:
        """Identity of a track that is confirmed."""
        if self.identity is None:
            raise AssertionError("only confirmed tracks are told, merge and split")
        return self.identity

    def restart(self, seen: Seen, now: float, rates: Floats) -> None:
        """Begin anew at what is seen, with rates (3,) of which little is known."""
        self.mean[:3], self.mean[3:] = seen.value, rates
        self.covariance[:] = 0.0
        self.covariance[:3, :3] = seen.noise
        self.covariance[range(3, 6), range(3, 6)] = self._motion.first_rates
        self._saw(seen, now)

    def predict(self, step: float) -> None:
        """Carry on by `step` s; a force does not become a pull."""
        predict(self.mean, self.covariance, step, self._motion.pushes)
        if self.mean[2] < 0.0:
            self.mean[2] = self.mean[5] = 0.0

    def update(self, seen: Seen, now: float) -> None:
        """Take up what is seen."""
        motion = self._motion
        update(
            self.mean,
            self.covariance,
            seen.value,
            seen.noise,
            now - self.time,
            motion.first_rates,
            motion.surprise,
        )
        speed = math.hypot(self.mean[3], self.mean[4])
        if speed > motion.top_speed:
            self.mean[3:5] *= motion.top_speed / speed
        self._saw(seen, now)

    def _saw(self, seen: Seen, now: float) -> None:
        self.seen, self.time = seen, now
        self.readings += 1
