"""A ball."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters.body import Body


@dataclass(frozen=True, kw_only=True)
class Sphere(Body):
    """A ball, or the half-sphere of the paper. It is the same however it is turned or tilted.

    Parameters
    ----------
    radius : float, m
    position : (x, y), m
        Of its centre in the plane.
    rotation, tilt, force, depth, shear
        See `Body`.
    """

    radius: float
    kind: ClassVar[str] = "ball"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the sphere, in metres")

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        square = (x - self.position[0]) ** 2 + (y - self.position[1]) ** 2
        below = np.sqrt(np.maximum(self.radius**2 - square, 0.0))
        return np.where(square < self.radius**2, self.radius - below, np.inf)
