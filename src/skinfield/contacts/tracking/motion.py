"""How contacts move, as far as it is known beforehand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats, check_positive

HOLD = 0.1  # s: for which an acceleration, or a change of the force's rate, lasts


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How contacts move and how fast forces change.

    Velocity and rate of the force are random walks (continuous white noise acceleration;
    Bar-Shalom, Li and Kirubarajan 2001, section 6.2.2), whose intensity does not depend on how
    often the skin is read. A reading that this cannot explain is taken for the onset of a touch or
    of a motion: the rates are then as unknown as those of a new contact.

    Parameters
    ----------
    acceleration : float, m/s²
        Typical, along the skin, each lasting 0.1 s.
    force_rate : float, N/s
        By which the rate of the force changes within 0.1 s.
    first_speed : float, m/s
        One standard deviation of the velocity of a new contact, along each tangent.
    first_force_rate : float, N/s
        One standard deviation of its force's rate.
    top_speed : float, m/s
        No contact moves faster along the skin: a jump of a solver's answer is no velocity.
    surprise : float
        Squared Mahalanobis distance of place and force from what is foretold, beyond which an
        onset is assumed: 16.3 has a chance of 1e-3.
    """

    acceleration: float = 0.2
    force_rate: float = 4.0
    first_speed: float = 0.06
    first_force_rate: float = 15.0
    top_speed: float = 0.25
    surprise: float = 16.3

    def __post_init__(self) -> None:
        check_positive("acceleration", self.acceleration, "along the skin, in m/s²")
        check_positive("force_rate", self.force_rate, "change of it within 0.1 s, in N/s")
        check_positive("first_speed", self.first_speed, "of a new contact, in m/s")
        check_positive("first_force_rate", self.first_force_rate, "of a new contact, in N/s")
        check_positive("top_speed", self.top_speed, "of a contact along the skin, in m/s")
        check_positive("surprise", self.surprise, "squared Mahalanobis distance of an onset")

    @cached_property
    def pushes(self) -> Floats:
        """Intensity (3,) of the white noise that drives the rates: m²/s³ twice, and N²/s³."""
        place = self.acceleration**2 * HOLD
        return np.array([place, place, self.force_rate**2 / HOLD])

    @cached_property
    def first_rates(self) -> Floats:
        """Variance (3,) of the rates of a new contact."""
        return np.array([self.first_speed, self.first_speed, self.first_force_rate]) ** 2
