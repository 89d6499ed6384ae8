"""Profiles of round bodies that press: heights over the radius, and smooth shapes of them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_positive, check_range

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


STEEPEST = 6.0  # rise over run; beyond it a flank goes on straight
STEP = 1e-5  # thicknesses, of differences


@dataclass(frozen=True)
class SmoothShape:
    """A body that goes on for ever, so that a node may pass its edge on the way to its place.

    Where the body is not, or is steeper than `STEEPEST`, it goes on from the nearest radius where
    it is at that slope.

    Parameters
    ----------
    shape : Shape
    starts, stops : (n,) arrays
        Radii between which the body is taken as it is.
    """

    shape: Shape
    starts: Floats
    stops: Floats

    @classmethod
    def of(cls, shape: Shape) -> "SmoothShape":
        """Find the flat enough parts of a body."""
        radius = np.linspace(0.0, REACH, 8 * SAMPLES)
        heights = shape.heights(radius)
        there = np.isfinite(heights[1:]) & np.isfinite(heights[:-1])
        rise = np.abs(np.diff(np.where(np.isfinite(heights), heights, 0.0)))
        rise = there & (rise <= STEEPEST * np.diff(radius))
        inside = np.concatenate([[False], rise, [False]])
        starts, stops = inside[1:] & ~inside[:-1], inside[:-1] & ~inside[1:]
        return cls(shape, radius[starts], radius[stops])

    def held(self, radius: Floats) -> NDArray[np.bool_]:
        """Whether the body is taken as it is at radii (N,)."""
        return np.asarray(np.abs(radius - self._nearest(radius)) < 1e-12)

    def heights(self, radius: Floats) -> Floats:
        """Above the lowest point, at radii (N,)."""
        nearest = self._nearest(radius)
        return self.shape.heights(nearest) + STEEPEST * np.abs(radius - nearest)

    def derivatives(self, radius: Floats) -> tuple[Floats, Floats, Floats]:
        """Height, slope and curvature at radii (N,)."""
        radius = np.abs(radius)
        below, here, above = (self.heights(np.abs(radius + d)) for d in (-STEP, 0.0, STEP))
        return here, (above - below) / (2 * STEP), (above - 2 * here + below) / STEP**2

    def _nearest(self, radius: Floats) -> Floats:
        inside = np.clip(radius[:, None], self.starts, self.stops)
        best = np.abs(inside - radius[:, None]).argmin(axis=1)
        return np.asarray(inside[np.arange(len(radius)), best])
