"""A body as the elements need it: in thicknesses, with its sharp edges, without infinities."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.fem.profiles import Profile

REACH = 20.0  # thicknesses; bodies may be wider, contacts not
SAMPLES = 4001


@dataclass(frozen=True)
class Shape:
    """A body over the radius, both in thicknesses.

    Parameters
    ----------
    profile : callable
        Heights in m at radii in m.
    thickness : float, m
    """

    profile: Profile
    thickness: float

    def heights(self, radius: Floats) -> Floats:
        """Above the lowest point, infinite where the body is not."""
        found = np.asarray(self.profile(radius * self.thickness), dtype=float) / self.thickness
        if found.shape != radius.shape or np.isnan(found).any() or (found < 0).any():
            raise InputError(
                f"profile gives {found!r} for {radius.shape} radii, expected as many heights of "
                "0 or more: metres above the lowest point, infinite where the body is not"
            )
        return found

    def outermost(self) -> float:
        """Where the body may touch at most: it is there, and no higher than the layer."""
        radius = np.linspace(0.0, REACH, SAMPLES)
        below = np.flatnonzero(self.heights(radius) < 1.0)
        if not len(below):
            raise InputError(
                f"profile is nowhere below {self.thickness:g} m within a radius of "
                f"{REACH * self.thickness:g} m, expected heights above the body's lowest point, 0"
            )
        return float(radius[min(below[-1] + 1, SAMPLES - 1)])

    def edges(self) -> list[float]:
        """Radii within the body at which it ends."""
        radius = np.linspace(0.0, REACH, SAMPLES)
        there = np.isfinite(self.heights(radius))
        found = []
        for index in np.flatnonzero(there[1:] != there[:-1]):
            inside, outside = radius[index : index + 2][:: 1 if there[index] else -1]
            for _ in range(60):
                middle = (inside + outside) / 2
                if np.isfinite(self.heights(np.array([middle])))[0]:
                    inside = middle
                else:
                    outside = middle
            found.append(float(inside))
        return found
