"""Bodies that are round about the axis of the press, as their height over the radius.

Any function from radii (N,) m to heights (N,) m above the body's lowest point will do; it is
infinite where the body is not. These are the usual ones.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive, check_range

Profile = Callable[[Floats], Floats]


@dataclass(frozen=True, kw_only=True)
class SphereProfile:
    """A ball of a radius in m."""

    radius: float

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the ball, in metres")

    def __call__(self, radius: Floats) -> Floats:
        """Height (N,) m at radii (N,) m."""
        below = np.sqrt(np.maximum(self.radius**2 - radius**2, 0.0))
        return np.where(radius < self.radius, self.radius - below, np.inf)


@dataclass(frozen=True, kw_only=True)
class FlatProfile:
    """A flat end of a radius in m, or a ring; its edges may be rounded and its sides may lean.

    Parameters
    ----------
    radius : float, m
    edge_radius : float, m
        Of the rounding, within `radius`.
    inner_radius : float, m
        Of the hole of a ring.
    flank : float
        Rise over run of the sides above the rounding: elastomer that wells up against a steep side
        needs one to lie against. By default the body ends at `radius`.
    """

    radius: float
    edge_radius: float = 0.0
    inner_radius: float = 0.0
    flank: float = np.inf

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the flat end, in metres")
        check_range("inner_radius", self.inner_radius, 0.0, self.radius, "of the ring's hole")
        sides = 2 if self.inner_radius else 1
        most = (self.radius - self.inner_radius) / sides
        check_range("edge_radius", self.edge_radius, 0.0, most, "the rounding lies within the end")
        check_range("flank", self.flank, 0.0, np.inf, "rise over run of the sides")

    def __call__(self, radius: Floats) -> Floats:
        """Height (N,) m at radii (N,) m."""
        beyond = radius - (self.radius - self.edge_radius)
        if self.inner_radius:
            beyond = np.maximum(beyond, self.inner_radius + self.edge_radius - radius)
        if np.isinf(self.flank):
            bend = np.clip(beyond, 0.0, self.edge_radius)
            side = np.where(beyond <= self.edge_radius * (1 + 1e-12), 0.0, np.inf)
        else:  # the rounding ends where it is as steep as the side
            bend = np.clip(beyond, 0.0, self.edge_radius * np.sin(np.arctan(self.flank)))
            side = self.flank * np.maximum(beyond - bend, 0.0)
        return self.edge_radius - np.sqrt(self.edge_radius**2 - bend**2) + side


@dataclass(frozen=True, kw_only=True)
class ConeProfile:
    """A cone whose flank rises by `slope` per radius, up to `radius` m."""

    slope: float
    radius: float

    def __post_init__(self) -> None:
        check_positive("slope", self.slope, "rise over run of the flank")
        check_positive("radius", self.radius, "of the cone's base, in metres")

    def __call__(self, radius: Floats) -> Floats:
        """Height (N,) m at radii (N,) m."""
        return np.where(radius <= self.radius, self.slope * radius, np.inf)
