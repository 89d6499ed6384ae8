"""Tangential load on a round contact with a half-space: full stick and partial slip.

Cattaneo (1938) and Mindlin (1949), as in Johnson, Contact Mechanics, 7.2. The normal contact is
taken as given: exact on an incompressible half-space, where pressure and tangential displacement
do not act on each other. Transverse displacements outside the direction of the load are neglected
in partial slip, as there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range
from skinfield.mechanics.hertz import HertzSphere


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
    def _held(self) -> float:
        """1 - Q/(mu F)."""
        return 1.0 - self.shear / (self.friction * self.normal.force)

    @property
    def stick_radius(self) -> float:
        """Of the stuck disc, c = a (1 - Q/(mu F))^(1/3), m."""
        return float(self.normal.contact_radius * np.cbrt(self._held))

    @property
    def displacement(self) -> float:
        """Of the sphere along the force, m."""
        stiffness = tangential_stiffness(
            self.young_modulus, self.poisson_ratio, self.normal.contact_radius
        )
        sliding = self.friction * self.normal.force
        return float(1.5 * sliding / stiffness * (1.0 - np.cbrt(self._held) ** 2))

    def traction(self, r: ArrayLike) -> Floats:
        """Along the force, Pa, at r in m: sliding traction less a smaller Hertzian inside c."""
        inner = HertzSphere(
            radius=self.normal.radius,
            modulus=self.normal.modulus,
            contact_radius=self.stick_radius,
        )
        return self.friction * (self.normal.pressure(r) - inner.pressure(r))
