"""Rigid bodies that press on the skin."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skinfield.errors import Floats, check_positive


class Indenter(Protocol):
    """A rigid body above the skin, pushed down by a force."""

    @property
    def position(self) -> tuple[float, float]:
        """Its axis in the plane, m."""
        ...

    @property
    def force(self) -> float:
        """Into the skin, N."""
        ...

    def height(self, x: Floats, y: Floats) -> Floats:
        """Height of its lower surface above its lowest point, m; infinite where it is not."""
        ...


@dataclass(frozen=True, kw_only=True)
class Sphere:
    """A ball, or the half-sphere of the paper.

    Parameters
    ----------
    radius : float, m
    position : (x, y), m
        Of its centre in the plane.
    force : float, N
    """

    radius: float
    position: tuple[float, float] = (0.0, 0.0)
    force: float = 1.0

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the sphere, in metres")
        check_positive("force", self.force, "into the skin, in newtons")

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        square = (x - self.position[0]) ** 2 + (y - self.position[1]) ** 2
        below = np.sqrt(np.maximum(self.radius**2 - square, 0.0))
        return np.where(square < self.radius**2, self.radius - below, np.inf)


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """A flat-ended cylinder that stands upright.

    Parameters
    ----------
    radius : float, m
    position : (x, y), m
        Of its axis in the plane.
    force : float, N
    """

    radius: float
    position: tuple[float, float] = (0.0, 0.0)
    force: float = 1.0

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the cylinder, in metres")
        check_positive("force", self.force, "into the skin, in newtons")

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        distance = np.hypot(x - self.position[0], y - self.position[1])
        return np.where(distance <= self.radius, 0.0, np.inf)
