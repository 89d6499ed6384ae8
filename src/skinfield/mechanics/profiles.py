"""Bodies of revolution that press on an elastic body, as the closed forms need them."""

from dataclasses import dataclass
from math import gamma
from typing import Protocol

import numpy as np

from skinfield.errors import Floats, InputError, check_positive


class Profile(Protocol):
    r"""A rigid body of revolution with its tip down.

    An elastic half-space under it acts as a row of independent springs that are pressed by the
    plane profile :math:`g(x) = x \int_0^x f'(r) / \sqrt{x^2 - r^2}\, dr` (Sneddon 1965; Popov,
    Contact Mechanics and Friction, method of dimensionality reduction).
    """

    @property
    def reach(self) -> float:
        """Radius in m up to which the surface is given; infinite if everywhere."""
        ...

    @property
    def kink(self) -> float:
        """Radius in m beyond which `springs` is another analytic function; 0 if none."""
        ...

    def height(self, r: Floats) -> Floats:
        """Height f in m of the surface above its lowest point at the distance r in m."""
        ...

    def springs(self, x: Floats) -> Floats:
        """The function g above, m."""
        ...

    def springs_slope(self, x: Floats) -> Floats:
        """Derivative of `springs`."""
        ...


@dataclass(frozen=True, kw_only=True)
class Paraboloid:
    """f = r²/(2R), which a sphere is close to its tip; Hertz's body.

    Parameters
    ----------
    radius : float, m
        Of curvature at the tip, R.
    """

    radius: float
    reach = float("inf")
    kink = 0.0

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of curvature at the tip, in metres")

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`."""
        return r**2 / (2.0 * self.radius)

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        return x**2 / self.radius

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        return 2.0 * x / self.radius


@dataclass(frozen=True, kw_only=True)
class Ball:
    """A true sphere, f = R - sqrt(R² - r²), touched below its equator.

    Parameters
    ----------
    radius : float, m
    """

    radius: float
    kink = 0.0

    def __post_init__(self) -> None:
        check_positive("radius", self.radius, "of the sphere, in metres")

    @property
    def reach(self) -> float:
        """The equator, m."""
        return self.radius

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`; infinite beyond the equator."""
        inside = r <= self.radius
        root = np.sqrt(np.where(inside, self.radius**2 - r**2, 0.0))
        return np.where(inside, self.radius - root, np.inf)

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        return np.asarray(x * np.arctanh(x / self.radius))

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        return np.asarray(np.arctanh(x / self.radius) + x * self.radius / (self.radius**2 - x**2))


@dataclass(frozen=True, kw_only=True)
class Taper:
    """A cone, f = slope r.

    Parameters
    ----------
    slope : float
        Tangent of the angle between its side and the skin, the cotangent of the half angle.
    """

    slope: float
    reach = float("inf")
    kink = 0.0

    def __post_init__(self) -> None:
        check_positive("slope", self.slope, "tangent of the angle between side and skin")

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`."""
        return self.slope * r

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        return np.pi / 2.0 * self.slope * x

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        return np.full_like(x, np.pi / 2.0 * self.slope)


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """f = scale (r / scale)^exponent, Galin's and Sneddon's family.

    Parameters
    ----------
    exponent : float
        Above 0; 2 is a paraboloid, 1 a cone; larger is flatter.
    scale : float, m
        Where height and distance are equal.
    """

    exponent: float
    scale: float
    reach = float("inf")
    kink = 0.0

    def __post_init__(self) -> None:
        check_positive("scale", self.scale, "where height and distance are equal, in metres")
        if not 1.0 <= self.exponent < 100.0:
            raise InputError(
                f"exponent is {self.exponent!r}, expected from 1 to 100: below it the tip is a "
                "needle whose pressure no linear theory holds"
            )

    @property
    def stretch(self) -> float:
        """Ratio of `springs` to `height`: 2 for a paraboloid, pi / 2 for a cone."""
        n = self.exponent
        return float(np.sqrt(np.pi) / 2 * n * gamma(n / 2) / gamma((n + 1) / 2))

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`."""
        return np.asarray(self.scale * (r / self.scale) ** self.exponent)

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        return self.stretch * self.height(x)

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        return np.asarray(self.stretch * self.exponent * (x / self.scale) ** (self.exponent - 1.0))


@dataclass(frozen=True, kw_only=True)
class RoundedFlat:
    """A flat end with a parabolic rim: f = 0 up to `flat_radius` b, then (r - b)²/(2 edge_radius).

    Parameters
    ----------
    flat_radius : float, m
    edge_radius : float, m
        Of curvature of the rim; a circular rim is met while little of it touches.
    """

    flat_radius: float
    edge_radius: float
    reach = float("inf")

    def __post_init__(self) -> None:
        check_positive("flat_radius", self.flat_radius, "of the flat part, in metres")
        check_positive("edge_radius", self.edge_radius, "of the rim's curvature, in metres")

    @property
    def kink(self) -> float:
        """Where the rim starts, m."""
        return self.flat_radius

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`."""
        return np.maximum(r - self.flat_radius, 0.0) ** 2 / (2.0 * self.edge_radius)

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        root, angle, beyond = self._rim(x)
        return beyond * (root - self.flat_radius * angle) / self.edge_radius

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        root, angle, _ = self._rim(x)
        return (2.0 * root - self.flat_radius * angle) / self.edge_radius

    def _rim(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        beyond = np.maximum(x, self.flat_radius)
        root = np.sqrt(beyond**2 - self.flat_radius**2)
        return root, np.arctan2(root, self.flat_radius), beyond


def kink_of(profile: Profile | None) -> float:
    """Its kink, m; None is a flat end, which has none."""
    return 0.0 if profile is None else profile.kink


def springs_of(profile: Profile | None, x: Floats) -> Floats:
    """Its `springs`, m; None is a flat end."""
    return np.zeros_like(x) if profile is None else profile.springs(x)


def height_of(profile: Profile | None, r: Floats) -> Floats:
    """Its `height`, m; None is a flat end."""
    return np.zeros_like(r) if profile is None else profile.height(r)
