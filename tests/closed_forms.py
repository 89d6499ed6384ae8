"""Closed forms of contact with an elastic half-space: Hertz, Sneddon, Cattaneo and Mindlin.

The half-space enters by E* = E/(1 - nu²) alone. Formulas: K. L. Johnson, Contact Mechanics (1985),
chapters 3, 4, 5 and 7; I. N. Sneddon, Int. J. Engng Sci. 3 (1965) 47-57.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.elastic.cell_integrals import inverse_distance_integrals, matrices, surface_tensor
from skinfield.elastic.half_space import displacement_kernel, traction_kernel


def square_displacement(offset, cell, modulus, nu):
    """Of the half-space's surface under unit traction on a square, (N, 3, 3)."""
    return matrices(surface_tensor(nu, inverse_distance_integrals(offset, cell))) / modulus


def effective_modulus(young_modulus: float, poisson_ratio: float) -> float:
    return young_modulus / (1.0 - poisson_ratio**2)


@dataclass(frozen=True)
class Contact:
    """What every round contact has: by formulas for 0 <= r/a < 1, and for r > a."""

    contact_radius: float
    modulus: float
    depth: float
    force: float
    inside: Any  # pressure by r/a
    height: Any  # of the body by r
    outside: Any  # displacement by r

    def pressure(self, r):
        share = np.minimum(np.abs(r) / self.contact_radius, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(share < 1.0, self.inside(share), 0.0)

    def indentation(self, r):
        r, a = np.abs(r), self.contact_radius
        below = self.depth - self.height(np.minimum(r, a))
        return np.where(r <= a, below, self.outside(np.maximum(r, a)))


def hertz(radius: float, star: float, a: float) -> Contact:
    """A sphere taken as the paraboloid r²/(2R)."""

    def outside(r):
        return ((2 * a**2 - r**2) * np.arcsin(a / r) + a * np.sqrt(r**2 - a**2)) / np.pi / radius

    peak = 2 * star * a / (np.pi * radius)
    return Contact(
        *(a, star, a**2 / radius, 4 / 3 * star * a**3 / radius),
        lambda share: peak * np.sqrt(1 - share**2),
        lambda r: r**2 / (2 * radius),
        outside,
    )


def hertz_by_depth(radius: float, star: float, depth: float) -> Contact:
    return hertz(radius, star, float(np.sqrt(radius * depth)))


def flat_punch(a: float, star: float, depth: float) -> Contact:
    """A flat end with a sharp edge, after Boussinesq."""
    return Contact(
        *(a, star, depth, 2 * star * a * depth),
        lambda share: star * depth / (np.pi * a) / np.sqrt(1 - share**2),
        lambda r: 0 * r,
        lambda r: 2 * depth / np.pi * np.arcsin(a / r),
    )


def sneddon_cone(slope: float, star: float, a: float) -> Contact:
    """A cone whose side leans by `slope` against the surface."""
    return Contact(
        *(a, star, np.pi / 2 * slope * a, np.pi / 2 * star * slope * a**2),
        lambda share: star * slope / 2 * np.arccosh(1 / share),
        lambda r: slope * r,
        lambda r: slope * (a * np.arcsin(a / r) - r + np.sqrt(r**2 - a**2)),
    )


def sneddon_sphere(radius: float, star: float, a: float) -> tuple[float, float]:
    """Depth and force of a true sphere."""
    angle = np.arctanh(a / radius)
    return a * angle, star * ((a**2 + radius**2) * angle - a * radius)


def stuck_displacement(modulus: float, nu: float, a: float, shear: float) -> float:
    """Of a round contact that slips nowhere, along the tangential force."""
    return shear * (1 + nu) * (2 - nu) / (4 * modulus * a)


def stuck_traction(a: float, shear: float, r):
    """Tangential traction of a round contact that slips nowhere, at r below a."""
    return shear / (2 * np.pi * a * np.sqrt(a**2 - r**2))


def partial_slip(
    ball: Contact, modulus: float, nu: float, friction: float, shear: float
) -> tuple[float, float]:
    """Displacement of a sphere along the tangential force, and the radius that sticks."""
    sliding = friction * ball.force
    share = np.cbrt(1 - shear / sliding)
    all_stuck = stuck_displacement(modulus, nu, ball.contact_radius, sliding)
    return 1.5 * all_stuck * (1 - share**2), ball.contact_radius * share


def point_traction(offset, depth: float):
    """Traction (N, 3, 3) at a depth under a unit point force, at offsets (N, 2)."""
    return np.moveaxis(traction_kernel(*np.transpose(offset), depth), -1, 0)


def point_displacement(offset, depth: float, modulus: float, nu: float):
    """Displacement (N, 3, 3) at a depth under a unit point force, at offsets (N, 2)."""
    return np.moveaxis(displacement_kernel(*np.transpose(offset), depth, modulus, nu), -1, 0)
