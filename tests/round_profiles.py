"""Bodies of revolution for the exact layer: a cone, a flat end with a rounded rim."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats


@dataclass(frozen=True, kw_only=True)
class Taper:
    """A cone, f = slope r."""

    slope: float
    reach = float("inf")
    kink = 0.0

    def height(self, r: Floats) -> Floats:
        return self.slope * r

    def springs(self, x: Floats) -> Floats:
        return np.pi / 2.0 * self.slope * x

    def springs_slope(self, x: Floats) -> Floats:
        return np.full_like(x, np.pi / 2.0 * self.slope)


@dataclass(frozen=True, kw_only=True)
class RoundedFlat:
    """A flat end with a parabolic rim: f = 0 up to b, then (r - b)²/(2 edge_radius)."""

    flat_radius: float
    edge_radius: float
    reach = float("inf")

    @property
    def kink(self) -> float:
        return self.flat_radius

    def height(self, r: Floats) -> Floats:
        return np.maximum(r - self.flat_radius, 0.0) ** 2 / (2.0 * self.edge_radius)

    def springs(self, x: Floats) -> Floats:
        root, angle, beyond = self._rim(x)
        return beyond * (root - self.flat_radius * angle) / self.edge_radius

    def springs_slope(self, x: Floats) -> Floats:
        root, angle, _ = self._rim(x)
        return (2.0 * root - self.flat_radius * angle) / self.edge_radius

    def _rim(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        beyond = np.maximum(x, self.flat_radius)
        root = np.sqrt(beyond**2 - self.flat_radius**2)
        return root, np.arctan2(root, self.flat_radius), beyond
