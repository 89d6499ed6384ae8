"""A straight edge."""

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
class Wedge(Rounded):
    """A wedge that stands on its straight edge, which lies along the turned x.

    Parameters
    ----------
    half_angle : float, rad
        Between its middle plane and its flanks.
    length, width : float, m
        Of the edge along x, and of the whole wedge across it.
    edge_radius : float, m
        Of the edge and of its ends.
    position, rotation, tilt, force, depth, shear
        See `Body`. Its reference point is the middle of its edge.
    """

    half_angle: float
    length: float
    width: float
    kind: ClassVar[str] = "wedge"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("length", self.length, "of the wedge's edge, in metres")
        check_positive("width", self.width, "of the wedge, in metres")
        check_half_angle(self.half_angle, "wedge")
        self.check_edge(min(self.length, self.width) / 2)

    @property
    def _profile(self) -> tuple[float, float, float]:
        half_width = self.width / 2 - self.edge_radius
        return half_width, self.edge_radius, 1 / np.tan(self.half_angle)

    @property
    def _end(self) -> float:
        return self.length / 2 - self.edge_radius

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        across, up = nearest_in_profile(np.abs(points[:, 1]), points[:, 2], *self._profile)
        along = np.clip(points[:, 0], -self._end, self._end)
        return np.stack([along, np.copysign(across, points[:, 1]), up], axis=1)

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        across, above = lowest_of_profile(float(up[1]), float(up[2]), *self._profile)
        return np.array([-np.sign(up[0]) * self._end, across, above])
