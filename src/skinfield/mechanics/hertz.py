"""Closed forms of frictionless contact with an elastic half-space.

The half-space enters by one number, the effective modulus E* = E/(1 - nu²) of an elastic body
under a rigid one (`effective_modulus`). Each class is a body at rest, made from its contact radius,
depth or force: `HertzSphere.from_force(radius=6e-3, modulus=..., force=1.0)`. Formulas:
K. L. Johnson, Contact Mechanics (1985), chapters 3 to 5; I. N. Sneddon, Int. J. Engng Sci. 3 (1965)
47; V. L. Popov, Contact Mechanics and Friction (2010), chapter 5. The bonded layer is in
`axisymmetric` and `thin_layer`, tangential load in `stick`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats, check_positive, check_range
from skinfield.mechanics.round_contact import RoundContact, check_contact
from skinfield.mechanics.sneddon import SneddonCone as SneddonCone
from skinfield.mechanics.sneddon import SneddonSphere as SneddonSphere


def effective_modulus(young_modulus: float, poisson_ratio: float) -> float:
    """E* = E/(1 - nu²) in Pa, of an elastic half-space under a rigid body."""
    check_positive("young_modulus", young_modulus, "in Pa")
    check_range("poisson_ratio", poisson_ratio, -1.0, 0.5, "0.5 is incompressible")
    return young_modulus / (1.0 - poisson_ratio**2)


@dataclass(frozen=True, kw_only=True)
class HertzSphere(RoundContact):
    """Hertz: a sphere taken as the paraboloid r²/(2R) (Johnson 3.4, 4.2).

    Parameters
    ----------
    radius : float, m
        Of the sphere, R.
    modulus : float, Pa
        E*, see `effective_modulus`.
    contact_radius : float, m
    """

    radius: float
    modulus: float
    contact_radius: float

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the sphere, in metres")
        check_contact(self.modulus, self.contact_radius)

    @classmethod
    def from_depth(cls, *, radius: float, modulus: float, depth: float) -> "HertzSphere":
        """Pressed to a depth in m: a² = R depth."""
        check_positive("depth", depth, "of the lowest point, in metres")
        return cls(radius=radius, modulus=modulus, contact_radius=float(np.sqrt(radius * depth)))

    @classmethod
    def from_force(cls, *, radius: float, modulus: float, force: float) -> "HertzSphere":
        """Pressed with a force in N: a³ = 3 F R/(4 E*)."""
        check_positive("force", force, "into the half-space, in newtons")
        a = float(np.cbrt(0.75 * force * radius / modulus))
        return cls(radius=radius, modulus=modulus, contact_radius=a)

    @property
    def depth(self) -> float:
        """a²/R, m."""
        return self.contact_radius**2 / self.radius

    @property
    def force(self) -> float:
        """(4/3) E* a³/R, N."""
        return 4.0 / 3.0 * self.modulus * self.contact_radius**3 / self.radius

    @property
    def peak_pressure(self) -> float:
        """2 E* a/(pi R), Pa, half more than the mean."""
        return 2.0 * self.modulus * self.contact_radius / (np.pi * self.radius)

    def _pressure(self, share: Floats) -> Floats:
        return np.asarray(self.peak_pressure * np.sqrt(1.0 - share**2))

    def _height(self, r: Floats) -> Floats:
        return np.asarray(r**2 / (2.0 * self.radius))

    def _outside(self, r: Floats) -> Floats:
        a = self.contact_radius
        sides = (2.0 * a**2 - r**2) * np.arcsin(a / r) + a * np.sqrt(r**2 - a**2)
        return np.asarray(sides / (np.pi * self.radius))


@dataclass(frozen=True, kw_only=True)
class FlatPunch(RoundContact):
    """A flat end with a sharp edge (Boussinesq; Johnson 3.4): pressure infinite at the edge.

    Parameters
    ----------
    contact_radius : float, m
    modulus : float, Pa
        E*, see `effective_modulus`.
    approach : float, m
        Its depth.
    """

    contact_radius: float
    modulus: float
    approach: float

    def __post_init__(self) -> None:
        check_contact(self.modulus, self.contact_radius)
        check_positive("approach", self.approach, "depth of the flat end, in metres")

    @classmethod
    def from_force(cls, *, contact_radius: float, modulus: float, force: float) -> "FlatPunch":
        """Pressed with a force in N: depth = F/(2 E* a)."""
        check_positive("force", force, "into the half-space, in newtons")
        check_contact(modulus, contact_radius)
        depth = force / (2.0 * modulus * contact_radius)
        return cls(contact_radius=contact_radius, modulus=modulus, approach=depth)

    @classmethod
    def from_depth(cls, *, contact_radius: float, modulus: float, depth: float) -> "FlatPunch":
        """Pressed to a depth in m."""
        return cls(contact_radius=contact_radius, modulus=modulus, approach=depth)

    @property
    def depth(self) -> float:
        """See `approach`, m."""
        return self.approach

    @property
    def force(self) -> float:
        """2 E* a depth, N."""
        return 2.0 * self.modulus * self.contact_radius * self.depth

    def _pressure(self, share: Floats) -> Floats:
        root = np.sqrt(1.0 - share**2)
        scale = self.modulus * self.depth / (np.pi * self.contact_radius)
        return np.where(root > 0.0, scale / np.where(root > 0.0, root, 1.0), np.inf)

    def _height(self, r: Floats) -> Floats:
        return np.zeros_like(r)

    def _outside(self, r: Floats) -> Floats:
        return np.asarray(2.0 * self.depth / np.pi * np.arcsin(self.contact_radius / r))


@dataclass(frozen=True, kw_only=True)
class HertzLine:
    """A long cylinder on its side (Johnson 4.2c). Its depth is not defined on a half-space.

    Parameters
    ----------
    radius : float, m
        Of the cylinder.
    modulus : float, Pa
        E*, see `effective_modulus`.
    force_per_length : float, N/m
    """

    radius: float
    modulus: float
    force_per_length: float

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the cylinder, in metres")
        check_positive("modulus", self.modulus, "effective, in Pa")
        check_positive("force_per_length", self.force_per_length, "in newtons per metre")

    @property
    def half_width(self) -> float:
        """Of the contact, sqrt(4 P R/(pi E*)), m."""
        return float(np.sqrt(4.0 * self.force_per_length * self.radius / (np.pi * self.modulus)))

    @property
    def peak_pressure(self) -> float:
        """2 P/(pi b), Pa."""
        return 2.0 * self.force_per_length / (np.pi * self.half_width)

    def pressure(self, x: ArrayLike) -> Floats:
        """Pressure, Pa, at distances x in m from the middle line; zero outside the contact."""
        share = np.minimum(np.abs(as_floats("x", x)) / self.half_width, 1.0)
        return np.asarray(self.peak_pressure * np.sqrt(1.0 - share**2))
