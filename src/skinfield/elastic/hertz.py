"""Closed forms of contact with an elastic half-space: Hertz, Sneddon, Cattaneo and Mindlin.

The half-space enters by one number, the effective modulus E* = E/(1 - nu²) of an elastic body
under a rigid one (`effective_modulus`). Each class is a body at rest, made from its contact radius,
depth or force: `HertzSphere.from_force(radius=6e-3, modulus=..., force=1.0)`. Formulas:
K. L. Johnson, Contact Mechanics (1985), chapters 3 to 5; I. N. Sneddon, The relation between load
and penetration in the axisymmetric Boussinesq problem for a punch of arbitrary profile, Int. J.
Engng Sci. 3 (1965) 47-57; V. L. Popov, Contact Mechanics and Friction (2010), chapter 5. The bonded
layer is in `axisymmetric` and `thin_layer`.

Tangential load, in full stick and partial slip: Cattaneo (1938) and Mindlin (1949), as in Johnson,
7.2. The normal contact is taken as it is: exact on an incompressible half-space, where pressure
and tangential displacement do not act on each other. Transverse displacements outside the direction
of the load are neglected in partial slip, as there.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic.axisymmetric import Ball
from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range


class RoundContact(ABC):
    """What every round contact on a half-space has."""

    contact_radius: float

    @property
    @abstractmethod
    def depth(self) -> float:
        """Of the body's lowest point below the undeformed surface, m."""

    @property
    @abstractmethod
    def force(self) -> float:
        """Into the surface, N."""

    @property
    def mean_pressure(self) -> float:
        """Over the contact, Pa."""
        return self.force / (np.pi * self.contact_radius**2)

    def pressure(self, r: ArrayLike) -> Floats:
        """Pressure, Pa, at distances r in m from the axis, any shape; zero outside the contact."""
        share = np.abs(as_floats("r", r)) / self.contact_radius
        return np.where(share <= 1.0, self._pressure(np.minimum(share, 1.0)), 0.0)

    def indentation(self, r: ArrayLike) -> Floats:
        """Displacement of the surface into the half-space, m, at r in m, inside and outside."""
        r = np.abs(as_floats("r", r))
        far = np.maximum(r, self.contact_radius)
        below = self.depth - self._height(np.minimum(r, self.contact_radius))
        return np.where(r <= self.contact_radius, below, self._outside(far))

    @abstractmethod
    def _pressure(self, share: Floats) -> Floats: ...

    @abstractmethod
    def _height(self, r: Floats) -> Floats: ...

    @abstractmethod
    def _outside(self, r: Floats) -> Floats: ...


def check_contact(modulus: float, contact_radius: float) -> None:
    """Raise InputError unless both are above zero."""
    check_positive("modulus", modulus, "effective, in Pa")
    check_positive("contact_radius", contact_radius, "in metres")


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
        node, weight = _sneddon_rule()
        end = a * np.sqrt(1.0 - share**2)[..., None]
        x = np.sqrt((a * share[..., None]) ** 2 + (end * node) ** 2)
        rising = Ball(radius=self.radius).springs_slope(np.minimum(x, a)) / np.maximum(x, 1e-300)
        return np.asarray(self.modulus / np.pi * rising @ weight * end[..., 0])

    def _height(self, r: Floats) -> Floats:
        return Ball(radius=self.radius).height(r)

    def _outside(self, r: Floats) -> Floats:
        """Integral of (depth - springs)/sqrt(r² - x²), with x = r sin(angle)."""
        a = self.contact_radius
        node, weight = _sneddon_rule()
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


def _sneddon_rule() -> tuple[Floats, Floats]:
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    return (node + 1.0) / 2.0, weight / 2.0


def tangential_stiffness(
    young_modulus: float, poisson_ratio: float, contact_radius: float
) -> float:
    """Force per displacement of a stuck round contact, 4 E a/((1 + nu)(2 - nu)), N/m.

    Whatever the pressure (Johnson 7.2, with G = E/(2 (1 + nu)) and one elastic body).
    """
    check_positive("young_modulus", young_modulus, "in Pa")
    check_positive("contact_radius", contact_radius, "in metres")
    check_range("poisson_ratio", poisson_ratio, 0.0, 0.5, "0.5 is incompressible")
    return 4.0 * young_modulus * contact_radius / ((1.0 + poisson_ratio) * (2.0 - poisson_ratio))


@dataclass(frozen=True, kw_only=True)
class FullStick:
    """A round contact that slips nowhere under a tangential force.

    Parameters
    ----------
    contact_radius : float, m
    young_modulus : float, Pa
    poisson_ratio : float
    shear : float, N
        Along one direction.
    """

    contact_radius: float
    young_modulus: float
    poisson_ratio: float
    shear: float

    def __post_init__(self) -> None:
        check_positive("shear", self.shear, "tangential force, in newtons")
        tangential_stiffness(self.young_modulus, self.poisson_ratio, self.contact_radius)

    @property
    def displacement(self) -> float:
        """Of the whole contact along the force, m."""
        return self.shear / tangential_stiffness(
            self.young_modulus, self.poisson_ratio, self.contact_radius
        )

    def traction(self, r: ArrayLike) -> Floats:
        """Along the force, Pa, at r in m: Q/(2 pi a sqrt(a² - r²)); infinite at the edge."""
        share = np.abs(as_floats("r", r)) / self.contact_radius
        root = np.sqrt(np.maximum(1.0 - share**2, 0.0))
        mean = self.shear / (2.0 * np.pi * self.contact_radius**2)
        inside = np.where(root > 0.0, mean / np.where(root > 0.0, root, 1.0), np.inf)
        return np.where(share <= 1.0, inside, 0.0)


@dataclass(frozen=True, kw_only=True)
class PartialSlip:
    """A sphere on a half-space whose contact slips in a ring and sticks inside it.

    Parameters
    ----------
    normal : HertzSphere
        The contact before the tangential load.
    young_modulus : float, Pa
    poisson_ratio : float
    friction : float
        Coefficient of Coulomb.
    shear : float, N
        Along one direction, below friction times the normal force.
    """

    normal: HertzSphere
    young_modulus: float
    poisson_ratio: float
    friction: float
    shear: float

    def __post_init__(self) -> None:
        check_positive("friction", self.friction, "coefficient of friction")
        check_positive("shear", self.shear, "tangential force, in newtons")
        tangential_stiffness(self.young_modulus, self.poisson_ratio, self.normal.contact_radius)
        if self.shear >= self.friction * self.normal.force:
            raise InputError(
                f"shear is {self.shear!r} N, expected below {self.friction * self.normal.force:g} "
                "N, friction times the normal force: beyond, the body slides"
            )

    @property
    def _stuck_share(self) -> float:
        """1 - Q/(mu F)."""
        return 1.0 - self.shear / (self.friction * self.normal.force)

    @property
    def stick_radius(self) -> float:
        """Of the stuck disc, c = a (1 - Q/(mu F))^(1/3), m."""
        return float(self.normal.contact_radius * np.cbrt(self._stuck_share))

    @property
    def displacement(self) -> float:
        """Of the sphere along the force, m."""
        stiffness = tangential_stiffness(
            self.young_modulus, self.poisson_ratio, self.normal.contact_radius
        )
        sliding = self.friction * self.normal.force
        return float(1.5 * sliding / stiffness * (1.0 - np.cbrt(self._stuck_share) ** 2))

    def traction(self, r: ArrayLike) -> Floats:
        """Along the force, Pa, at r in m: sliding traction less a smaller Hertzian inside c."""
        inner = HertzSphere(
            radius=self.normal.radius,
            modulus=self.normal.modulus,
            contact_radius=self.stick_radius,
        )
        return self.friction * (self.normal.pressure(r) - inner.pressure(r))
