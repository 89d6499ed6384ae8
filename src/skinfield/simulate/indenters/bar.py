"""A bar with a flat face."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters.rounded import Rounded


@dataclass(frozen=True, kw_only=True)
class Bar(Rounded):
    """A bar with a flat rectangular face; tilted, it touches with an edge or a corner.

    Parameters
    ----------
    length, width : float, m
        Of its face along the turned x and y, rounded edges included.
    edge_radius, position, rotation, tilt, force, depth, shear
        See `Rounded` and `Body`. Its reference point is the middle of its face.
    """

    length: float
    width: float
    kind: ClassVar[str] = "bar"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("length", self.length, "of the bar, in metres")
        check_positive("width", self.width, "of the bar, in metres")
        self.check_edge(min(self.length, self.width) / 2)

    @property
    def _corner(self) -> Floats:
        return np.array([self.length, self.width]) / 2 - self.edge_radius

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        found = np.maximum(points, self.edge_radius)
        found[:, :2] = np.clip(points[:, :2], -self._corner, self._corner)
        return found

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        return np.array([*(-np.sign(up[:2]) * self._corner), self.edge_radius])
