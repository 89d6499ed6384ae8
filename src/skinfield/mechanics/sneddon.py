"""Sneddon's closed forms on a half-space: the true sphere and the cone.

I. N. Sneddon, The relation between load and penetration in the axisymmetric Boussinesq problem for
a punch of arbitrary profile, Int. J. Engng Sci. 3 (1965) 47-57.
"""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive, check_range
from skinfield.mechanics.profiles import Ball
from skinfield.mechanics.round_contact import RoundContact, check_contact

_NODES = 64


@dataclass(frozen=True, kw_only=True)
class SneddonSphere(RoundContact):
    """A true sphere, not a paraboloid (Sneddon 1965): wider and harder than Hertz's when deep.

    Parameters
    ----------
    radius : float, m
    modulus : float, Pa
        E*, see `effective_modulus`.
    contact_radius : float, m
        Below `radius`, which no force reaches.
    """

    radius: float
    modulus: float
    contact_radius: float

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the sphere, in metres")
        check_contact(self.modulus, self.contact_radius)
        below = float(np.nextafter(self.radius, 0.0))
        check_range("contact_radius", self.contact_radius, 0.0, below, "below the equator, in m")

    @classmethod
    def from_depth(cls, *, radius: float, modulus: float, depth: float) -> "SneddonSphere":
        """Pressed to a depth in m: depth = (a/2) ln((R + a)/(R - a)), solved for a."""
        check_positive("depth", depth, "of the lowest point, in metres")
        return cls._solved(radius, modulus, "depth", depth)

    @classmethod
    def from_force(cls, *, radius: float, modulus: float, force: float) -> "SneddonSphere":
        """Pressed with a force in N."""
        check_positive("force", force, "into the half-space, in newtons")
        return cls._solved(radius, modulus, "force", force)

    @classmethod
    def _solved(cls, radius: float, modulus: float, name: str, value: float) -> "SneddonSphere":
        from scipy.optimize import brentq

        def at(level: float) -> "SneddonSphere":
            a = radius * float(np.tanh(np.exp(level)))  # to the equator and to nothing, gently
            return cls(radius=radius, modulus=modulus, contact_radius=a)

        def excess(level: float) -> float:
            return float(np.log(getattr(at(level), name) / value))

        return at(brentq(excess, -40.0, 2.8, xtol=1e-14, rtol=1e-14))

    @property
    def depth(self) -> float:
        """(a/2) ln((R + a)/(R - a)), m."""
        return float(self.contact_radius * np.arctanh(self.contact_radius / self.radius))

    @property
    def force(self) -> float:
        """E* [(a² + R²)/2 ln((R + a)/(R - a)) - a R], N."""
        a, radius = self.contact_radius, self.radius
        share = a / radius
        if share < 0.1:  # the terms cancel; their series in a/R
            odd = [4.0 * n / (4.0 * n**2 - 1.0) * share ** (2 * n + 1) for n in range(1, 10)]
            return self.modulus * radius**2 * sum(odd)
        return float(self.modulus * ((a**2 + radius**2) * np.arctanh(share) - a * radius))

    def _pressure(self, share: Floats) -> Floats:
        """Abel's integral of the body's `springs_slope`, with x² = r² + v²."""
        a = self.contact_radius
        node, weight = _unit_rule()
        end = a * np.sqrt(1.0 - share**2)[..., None]
        x = np.sqrt((a * share[..., None]) ** 2 + (end * node) ** 2)
        rising = Ball(radius=self.radius).springs_slope(np.minimum(x, a)) / np.maximum(x, 1e-300)
        return np.asarray(self.modulus / np.pi * rising @ weight * end[..., 0])

    def _height(self, r: Floats) -> Floats:
        return Ball(radius=self.radius).height(r)

    def _outside(self, r: Floats) -> Floats:
        """Integral of (depth - springs)/sqrt(r² - x²), with x = r sin(angle)."""
        a = self.contact_radius
        node, weight = _unit_rule()
        end = np.arcsin(a / r)[..., None]
        x = np.minimum(r[..., None] * np.sin(end * node), a)
        left = self.depth - Ball(radius=self.radius).springs(x)
        return np.asarray(2.0 / np.pi * left @ weight * end[..., 0])


@dataclass(frozen=True, kw_only=True)
class SneddonCone(RoundContact):
    """A cone (Love; Sneddon 1965; Johnson 5.2): pressure infinite at the tip, as a logarithm.

    Parameters
    ----------
    slope : float
        Tangent of the angle between its side and the surface, the cotangent of the half angle.
    modulus : float, Pa
        E*, see `effective_modulus`.
    contact_radius : float, m
    """

    slope: float
    modulus: float
    contact_radius: float

    def __post_init__(self) -> None:
        check_positive("slope", self.slope, "tangent of the angle between side and surface")
        check_contact(self.modulus, self.contact_radius)

    @classmethod
    def from_depth(cls, *, slope: float, modulus: float, depth: float) -> "SneddonCone":
        """Pressed to a depth in m: a = 2 depth/(pi slope)."""
        check_positive("depth", depth, "of the tip, in metres")
        check_positive("slope", slope, "tangent of the angle between side and surface")
        return cls(slope=slope, modulus=modulus, contact_radius=2.0 * depth / (np.pi * slope))

    @classmethod
    def from_force(cls, *, slope: float, modulus: float, force: float) -> "SneddonCone":
        """Pressed with a force in N: a² = 2 F/(pi E* slope)."""
        check_positive("force", force, "into the half-space, in newtons")
        check_positive("slope", slope, "tangent of the angle between side and surface")
        a = float(np.sqrt(2.0 * force / (np.pi * modulus * slope)))
        return cls(slope=slope, modulus=modulus, contact_radius=a)

    @property
    def depth(self) -> float:
        """(pi/2) slope a, m."""
        return np.pi / 2.0 * self.slope * self.contact_radius

    @property
    def force(self) -> float:
        """(pi/2) E* slope a², N."""
        return np.pi / 2.0 * self.modulus * self.slope * self.contact_radius**2

    def _pressure(self, share: Floats) -> Floats:
        safe = np.where(share > 0.0, share, 1.0)
        inside = self.modulus * self.slope / 2.0 * np.arccosh(1.0 / safe)
        return np.where(share > 0.0, inside, np.inf)

    def _height(self, r: Floats) -> Floats:
        return self.slope * r

    def _outside(self, r: Floats) -> Floats:
        a = self.contact_radius
        return np.asarray(self.slope * (a * np.arcsin(a / r) - r + np.sqrt(r**2 - a**2)))


def _unit_rule() -> tuple[Floats, Floats]:
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    return (node + 1.0) / 2.0, weight / 2.0
