"""A body as the elements need it: in thicknesses, with its sharp edges, without infinities."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
