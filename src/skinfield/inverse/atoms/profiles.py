r"""Pressure below a round contact: a ball, or a flat end, pressed on the elastomer.

On a layer much thicker than the contact is wide they are Hertz's
:math:`\frac{3F}{2\pi a^2}\sqrt{1 - r^2/a^2}` and Boussinesq's
:math:`\frac{F}{2\pi a^2}/\sqrt{1 - r^2/a^2}`; on a thinner one, the exact solution of
`mechanics.axisymmetric`. Both depend on the force as a factor alone.
"""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats
from skinfield.mechanics import BondedLayer, Layer, Mechanics

if TYPE_CHECKING:
    from skinfield.mechanics.axisymmetric import Indentation

BALL, FLAT = 0, 1
RINGS = 12  # Gauss-Legendre nodes in sqrt(1 - r²/a²), in which both pressures are smooth


def unit_pressure(
    layer: Layer, mechanics: Mechanics, family: int, radius: float, r: Floats
) -> Floats:
    """Pressure in Pa per N at distances `r` in m from the axis; 0 outside the contact.

    Parameters
    ----------
    layer : Layer
    mechanics : Mechanics
        One without reach stands for a half-space.
    family : BALL or FLAT
        The pressure of a flat end is infinite at its edge.
    radius : float, m
        Of the contact.
    r : array, m
    """
    r = np.asarray(r, dtype=np.float64)
    if np.isfinite(mechanics.reach(layer)):
        state = _indentation(layer, family, radius)
        return np.asarray(state.pressure(r)) / state.force
    inside = r < radius
    root = np.sqrt(np.where(inside, 1.0 - (np.minimum(r, radius) / radius) ** 2, 1.0))
    shape = 1.5 * root if family == BALL else 0.5 / root
    return np.where(inside, shape, 0.0) / (np.pi * radius**2)


def load_quadrature(
    layer: Layer, mechanics: Mechanics, family: int, radius: float
) -> tuple[Floats, Floats]:
    """Rings that carry 1 N together as the contact does.

    Returns
    -------
    radii : (M,) array, m
    forces : (M,) array, N
        Sum 1. Integrals of the pressure with a smooth function become sums.
    """
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    root, weight = (node + 1.0) / 2.0, weight / 2.0  # of 1 - r²/a²: r dr = a² root d(root)
    radii = radius * np.sqrt(1.0 - root**2)
    pressure = unit_pressure(layer, mechanics, family, radius, radii)
    forces = 2.0 * np.pi * radius**2 * pressure * root * weight
    return radii, forces / forces.sum()


def curvature_force(layer: Layer, radius: float) -> float:
    """Force in N times radius of curvature in m of a ball that touches within `radius` m."""
    return float(_indentation(layer, BALL, radius).force)


def unit_indentation(
    layer: Layer, mechanics: Mechanics, family: int, radius: float, r: Floats
) -> Floats:
    """Displacement into the skin, m per N, at distances `r` (N,) m from the axis."""
    if isinstance(mechanics, BondedLayer) and not mechanics.inextensible_cover:
        state = _indentation(layer, family, radius)
        return np.asarray(state.indentation(r)) / state.force
    cell = 0.1 * min(radius, layer.thickness)  # a ring of squares: the pole of one is smoothed
    radii, forces = load_quadrature(layer, mechanics, family, radius)
    angle = (np.arange(48) + 0.5) * np.pi / 48
    out = np.zeros(len(r))
    for ring, force in zip(radii, forces, strict=True):
        x = np.asarray(r)[:, None] - ring * np.cos(angle)
        offsets = np.stack([x, np.broadcast_to(ring * np.sin(angle), x.shape)], axis=-1)
        each = mechanics.indentation(layer, offsets.reshape(-1, 2), cell) / cell**2
        out += force * each.reshape(x.shape).mean(axis=1)
    return out


@lru_cache(maxsize=256)
def _indentation(layer: Layer, family: int, radius: float) -> "Indentation":
    """The contact, with a unit radius of curvature or depth."""
    from skinfield.mechanics.axisymmetric import indent_to_radius, punch
    from skinfield.mechanics.profiles import Paraboloid

    if family == BALL:
        return indent_to_radius(layer, Paraboloid(radius=1.0), radius)
    return punch(layer, radius, depth=1.0)
