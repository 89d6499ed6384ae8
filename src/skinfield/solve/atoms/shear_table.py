r"""Table of what a force along the skin below a round contact does to the readings around it.

Who pushes along the skin has it bulge ahead and sink behind; what touches it holds the skin below
itself where it is, with a pressure that is higher ahead. Both are dipoles: at the place
:math:`(r, \varphi)` around the contact, φ from the direction of the push, with the ratio t of the
force along the skin over that into it, all is :math:`t \cos\varphi` times a function of r. With
k in units of 1/h the layer's surface rises by

.. math:: \frac{1+\nu}{2\pi E h}\int_0^\infty c(k)\,P(k)\,J_1(k r/h)\,dk

below a traction along the skin whose Hankel transform of order 0 is P(k), c the layer's `coupling`;
and sinks by the like integral with :math:`2(1-\nu)\,n(k)\,Q(k)`, n its `normal`, below a pressure
whose transform of order 1 is Q. That pressure is

.. math:: \sum_m b_m\,\frac{\rho}{a}\Big(1 - \frac{\rho^2}{a^2}\Big)^{m-1/2},

singular at the rim, which moves; its b are such that the surface stays where it is for r < a, least
squares. The half-space's part of n is integrated in closed form (Weber and Schafheitlin; Watson,
Treatise on the Theory of Bessel Functions, 13.4).

The traction is taken to be even over the contact: it is as the pressure where all of it slides, and
highest at the rim where all of it sticks.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Gap, Physics
from skinfield.elastic.hankel import LayerTransfer, electrostatic, gauss_legendre, jinc
from skinfield.errors import Floats

CUTOFF, PANELS = 46.0, 120  # of integrals over k
TERMS, PLACES = 10, 24  # of the pressure, and where the surface is held
EVEN = 24  # rings of an even traction
SMALLEST_PLACE = 1e-3  # thicknesses: where the slope at the axis is taken


class Traction(NamedTuple):
    """Traction along the skin of 1 N below a round contact; lengths in thicknesses.

    `forces` (M,), of sum 1, on rings of `radii` (M,); the body holds the skin within `held`, 0 for
    nowhere.
    """

    radii: Floats
    forces: Floats
    held: float

    @classmethod
    def even(cls, radius: float) -> "Traction":
        """The same all over a contact that holds the skin."""
        node, share = np.polynomial.legendre.leggauss(EVEN)
        return cls(radius * np.sqrt((node + 1) / 2), share / 2, radius)


def shear_readings(physics: Physics, tractions: Sequence[Traction], r: Floats) -> Floats:
    """Readings over r (N, distances) of N tractions per newton and ratio, r in thicknesses.

    Without distances where no reading tells of a force along the skin, or none is known: below an
    inextensible cover, on a half-space, and of other quantities.
    """
    quantity, mechanics = physics.quantity, physics.mechanics
    bonded = isinstance(mechanics, BondedLayer) and not mechanics.inextensible_cover
    if not bonded or not isinstance(quantity, Capacitance | Gap | BaseStress):
        return np.empty((len(tractions), 0))
    from scipy.special import j1

    k, weight = gauss_legendre(0.0, CUTOFF, PANELS)
    places = np.maximum(r, SMALLEST_PLACE)
    waves = j1(np.outer(places, k)) * weight / places[:, None]
    pushed, held = _by_quantity(physics, k)
    out = np.empty((len(tractions), len(r)))
    for row, each in enumerate(tractions):
        traction, pressure = _loads(physics.layer.poisson_ratio, each)
        out[row] = waves @ (held * pressure - pushed * traction)
    return out


def _by_quantity(physics: Physics, k: Floats) -> tuple[Floats, Floats]:
    """What is read of a traction along the skin and of a pressure, by their transforms."""
    layer, quantity = physics.layer, physics.quantity
    h, nu = layer.thickness, layer.poisson_ratio
    transfer = LayerTransfer(nu)
    averaged = getattr(quantity, "pad_averaged", True)
    pads = jinc(k, physics.pad_diameter / 2 / h if averaged else 0.0) / (2 * np.pi * h)
    if isinstance(quantity, BaseStress):
        pads = pads * k / h
        return pads * transfer.base_normal_from_shear(k), pads * transfer.base_normal(k)
    pads = pads / layer.young_modulus
    if isinstance(quantity, Capacitance):
        pads = pads * electrostatic(k) / h
    return pads * (1 + nu) * transfer.coupling(k), pads * 2 * (1 - nu**2) * transfer.normal(k)


def _loads(nu: float, given: Traction) -> tuple[Floats, Floats]:
    """Transforms of a traction along the skin of 1 N, and of the pressure that holds the skin."""
    from scipy.special import j0, j1

    (k, weight), (rings, forces, a) = gauss_legendre(0.0, CUTOFF, PANELS), given
    traction = j0(np.outer(k, rings)) @ forces
    if a == 0.0:
        return traction, np.zeros_like(k)
    transfer = LayerTransfer(nu)
    x = a * np.sin((np.arange(PLACES) + 0.5) * np.pi / (2 * PLACES))
    waves = j1(np.outer(x, k)) * weight
    rise = waves @ (transfer.coupling_rest(k) * traction)
    rise -= (1 - 2 * nu) * (forces * (rings < x[:, None])).sum(axis=1) / x
    parts = np.stack([_part(m, a, k) for m in range(TERMS)])
    sunk = waves @ (transfer.normal_rest(k) * parts).T
    sunk += np.stack([_held_half_space(m, a, x) for m in range(TERMS)], axis=1)
    sunk *= 2 * (1 - nu)
    size, by_area = np.abs(sunk).max(axis=0), np.sqrt(x / a)
    known = np.linalg.lstsq(by_area[:, None] * sunk / size, by_area * rise, rcond=1e-10)[0]
    return traction, (known / size) @ parts


def _part(m: int, a: float, k: Floats) -> Floats:
    """Transform of order 1 of the m-th part of the pressure, times 2π."""
    from scipy.special import gamma, jv

    power, x = m - 0.5, k * a
    scale = 2 * np.pi * a**2 * 2**power * gamma(power + 1)
    return np.asarray(scale * jv(2 + power, x) / x ** (power + 1))


def _held_half_space(m: int, a: float, x: Floats) -> Floats:
    """Integral over all k of `_part` with J1(k x), for x < a."""
    from scipy.special import gamma, hyp2f1

    power = m - 0.5
    scale = 2 * np.pi * a**2 * 2**power * gamma(power + 1) * a ** -(power + 1)
    below = 2 ** (power + 1) * a ** (1 - power) * gamma(m + 1.0)
    return np.asarray(scale * x * gamma(1.5) * hyp2f1(1.5, -m, 2.0, (x / a) ** 2) / below)
