"""Bodies of revolution for the exact layer: a cone, power laws, a flat end with a rounded rim."""

from dataclasses import dataclass
from math import gamma

import numpy as np

from skinfield.errors import Floats


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """f = scale (r / scale)^exponent, Galin's and Sneddon's family."""

    exponent: float
    scale: float
    reach = float("inf")
    kink = 0.0

    def height(self, r: Floats) -> Floats:
        return np.asarray(self.scale * (r / self.scale) ** self.exponent)

    @property
    def stretch(self) -> float:
        """Ratio of `springs` to `height`: 2 for a paraboloid, pi / 2 for a cone."""
        n = self.exponent
        return float(np.sqrt(np.pi) / 2 * n * gamma(n / 2) / gamma((n + 1) / 2))

    def springs(self, x: Floats) -> Floats:
        return self.stretch * self.height(x)

    def springs_slope(self, x: Floats) -> Floats:
        return np.asarray(self.stretch * self.exponent * (x / self.scale) ** (self.exponent - 1.0))


@dataclass(frozen=True, kw_only=True)
class Taper(PowerLaw):
    """A cone, f = slope r."""

    slope: float
    exponent: float = 1.0
    scale: float = 1.0

    def height(self, r: Floats) -> Floats:
        return self.slope * r

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
