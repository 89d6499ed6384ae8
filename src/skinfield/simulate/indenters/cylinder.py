"""A flat-ended cylinder."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters.rounded import Rounded


@dataclass(frozen=True, kw_only=True)
class Cylinder(Rounded):
    """A flat-ended cylinder; tilted, it touches with its rim.

    Parameters
    ----------
    radius : float, m
        Of the whole cylinder, rounded edge included.
    edge_radius, position, rotation, tilt, force, depth, shear
        See `Rounded` and `Body`. Its reference point is the middle of its face.
    """

    radius: float
    kind: ClassVar[str] = "flat cylinder"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the cylinder, in metres")
        self.check_edge(self.radius)

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        core = self.radius - self.edge_radius
        from_axis = np.hypot(points[:, 0], points[:, 1])
        inward = np.minimum(1.0, core / np.maximum(from_axis, 1e-300))
        return np.stack(
            [
                points[:, 0] * inward,
                points[:, 1] * inward,
                np.maximum(points[:, 2], self.edge_radius),
            ],
            axis=1,
        )

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        core = self.radius - self.edge_radius
        lean = float(np.hypot(up[0], up[1]))
        outward = core / lean if lean > 0.0 else 0.0
        return np.array([-up[0] * outward, -up[1] * outward, self.edge_radius])
