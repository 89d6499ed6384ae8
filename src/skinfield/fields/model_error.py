"""What a solver gets wrong without any noise, stated as deviations of a contact."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_range

ENOUGH = 1e3  # a deviation beyond is no statement


@dataclass(frozen=True, kw_only=True)
class ModelError:
    """Deviations of a contact's answer that are there without noise; independent of each other.

    Parameters
    ----------
    force : float
        One standard deviation, part of the contact's normal force.
    place : float, m
        One standard deviation along each tangent.
    area : float
        One standard deviation, part of the contact's area.
    """

    force: float = 0.0
    place: float = 0.0
    area: float = 0.0

    def __post_init__(self) -> None:
        for name in ("force", "place", "area"):
            check_range(name, getattr(self, name), 0.0, ENOUGH, "one standard deviation")

    def covariance(self, force: float) -> Floats:
        """Of x m, y m and the normal force N of a contact with this force: (3, 3)."""
        covariance = np.zeros((3, 3))
        covariance[0, 0] = covariance[1, 1] = self.place**2
        covariance[2, 2] = (self.force * force) ** 2
        return covariance
