"""A cone, point down."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters.profile import (
    check_half_angle,
    lowest_of_profile,
    nearest_in_profile,
)
from skinfield.simulate.indenters.rounded import Rounded


@dataclass(frozen=True, kw_only=True)
class Cone(Rounded):
    """A cone that stands on its point, with a cylinder of the same radius above it.

    Parameters
    ----------
    half_angle : float, rad
        Between its axis and its flank; 80 degrees is blunt, 20 degrees is a spike.
    radius : float, m
        Of its base.
    edge_radius : float, m
        Of its tip, which becomes a ball, and of its rim.
    position, rotation, tilt, force, depth, shear
        See `Body`. Its reference point is its tip.
    """

    half_angle: float
    radius: float
    kind: ClassVar[str] = "cone"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the cone's base, in metres")
        check_half_angle(self.half_angle, "cone")
        self.check_edge(self.radius)

    @property
    def _profile(self) -> tuple[float, float, float]:
        return self.radius - self.edge_radius, self.edge_radius, 1 / np.tan(self.half_angle)

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        from_axis = np.hypot(points[:, 0], points[:, 1])
        across, along = nearest_in_profile(from_axis, points[:, 2], *self._profile)
        inward = across / np.maximum(from_axis, 1e-300)
        return np.stack([points[:, 0] * inward, points[:, 1] * inward, along], axis=1)

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        lean = float(np.hypot(up[0], up[1]))
        across, along = lowest_of_profile(lean, float(up[2]), *self._profile)
        outward = up[:2] / lean if lean > 0.0 else np.zeros(2)
        return np.array([*(across * outward), along])
