"""A round rod that lies on the skin."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters.rounded import Rounded


@dataclass(frozen=True, kw_only=True)
class Rod(Rounded):
    """A round rod that lies along the turned x; tilted about y, it touches with its end.

    Parameters
    ----------
    radius, length : float, m
        Of the rod, rounded ends included.
    edge_radius : float, m
        Of the edges of its ends; as large as `radius`, its ends are half-spheres.
    position, rotation, tilt, force, depth, shear
        See `Body`. Its reference point is its lowest point below its middle.
    """

    radius: float
    length: float
    kind: ClassVar[str] = "rod"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the rod, in metres")
        check_positive("length", self.length, "of the rod, in metres")
        self.check_edge(min(self.radius, self.length / 2))

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        end, core = self.length / 2 - self.edge_radius, self.radius - self.edge_radius
        sideways, above = points[:, 1], points[:, 2] - self.radius
        inward = np.minimum(1.0, core / np.maximum(np.hypot(sideways, above), 1e-300))
        along = np.clip(points[:, 0], -end, end)
        return np.stack([along, sideways * inward, self.radius + above * inward], axis=1)

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        end, core = self.length / 2 - self.edge_radius, self.radius - self.edge_radius
        around = core * up[1:] / np.hypot(up[1], up[2])
        return np.array([-np.sign(up[0]) * end, -around[0], self.radius - around[1]])
