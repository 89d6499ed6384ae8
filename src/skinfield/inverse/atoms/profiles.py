r"""Pressure below a round contact: a ball, a flat end or a ring, pressed on the elastomer.

On a layer much thicker than the contact is wide they are Hertz's
:math:`\frac{3F}{2\pi a^2}\sqrt{1 - r^2/a^2}` and Boussinesq's
:math:`\frac{F}{2\pi a^2}/\sqrt{1 - r^2/a^2}`; on a thinner one, the exact solution of
`mechanics.axisymmetric`. Both depend on the force as a factor alone. A ring is a narrow, even
annulus: what a rim or the edge of a cup leaves, as far as taxels below a layer can tell.
"""

from collections.abc import Hashable
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from skinfield.errors import Floats
from skinfield.inverse.atoms.ring_sums import Point, ring_sums
from skinfield.mechanics import BondedLayer, Layer, Mechanics

if TYPE_CHECKING:
    from skinfield.mechanics.axisymmetric import Indentation

BALL, FLAT, RING = 0, 1, 2
FAMILIES = (BALL, FLAT, RING)
RIM = 0.4  # thicknesses: width of a ring
CELL = 0.08  # thicknesses: side of the square that stands for a point
RIM_RINGS = 4
NEAR, FAR, REACH = 400, 3000, 60.0  # mesh of a point's response: within a thickness, and beyond
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
    family : BALL, FLAT or RING
        The pressure of a flat end is infinite at its edge.
    radius : float, m
        Of the contact.
    r : array, m
    """
    r = np.asarray(r, dtype=np.float64)
    if family == RING:
        inner, outer = _rim(layer, radius)
        return np.where((r > inner) & (r < outer), 1.0 / (np.pi * (outer**2 - inner**2)), 0.0)
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
    if family == RING:
        inner, outer = _rim(layer, radius)
        radii = inner + (outer - inner) * (np.arange(RIM_RINGS) + 0.5) / RIM_RINGS
        return radii, radii / radii.sum()
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
    if isinstance(mechanics, BondedLayer) and family != RING:
        state = _indentation(layer, family, radius)
        moved = state.covered_indentation if mechanics.inextensible_cover else state.indentation
        return np.asarray(moved(r)) / state.force
    cell = max(CELL * layer.thickness, radius / 25.0 if family != RING else 0.0)
    radii, forces = _fine_rings(layer, mechanics, family, radius, cell)
    point = _point_indentation(layer, cast(Hashable, mechanics), cell)
    counts = 16 + np.ceil(2.0 * np.pi * radii / cell).astype(np.int64)
    return ring_sums(np.ascontiguousarray(r, dtype=np.float64), radii, forces, counts, point)


def edges_of(layer: Layer, family: int, radius: float) -> Floats:
    """Distances in m from the axis at which the surface is steep, or bent."""
    return np.array(_rim(layer, radius) if family == RING else (radius,))


def _fine_rings(
    layer: Layer, mechanics: Mechanics, family: int, radius: float, cell: float
) -> tuple[Floats, Floats]:
    """Rings at most half a cell apart, so that squares of that size along them do not ripple."""
    inner, outer = _rim(layer, radius) if family == RING else (0.0, radius)
    count = max(int(np.ceil(2.0 * (outer - inner) / cell)), 4)
    edge = np.linspace(inner, outer, count + 1)
    middle = np.sqrt((edge[1:] ** 2 + edge[:-1] ** 2) / 2.0)
    if family == RING:
        forces = np.diff(np.square(edge))
    else:  # by parts of the smooth integral over sqrt(1 - r²/a²): the edge of a flat end counts
        root = np.sqrt(np.maximum(1.0 - np.square(edge / radius), 0.0))
        node, weight = np.polynomial.legendre.leggauss(4)
        wide = (root[:-1] - root[1:]) / 2.0
        roots = (root[:-1] + root[1:])[:, None] / 2.0 + wide[:, None] * node
        within = radius * np.sqrt(1.0 - roots**2)
        pressure = unit_pressure(layer, mechanics, family, radius, within)
        forces = wide * ((pressure * roots) @ weight)
    return middle, forces / forces.sum()


def _rim(layer: Layer, radius: float) -> tuple[float, float]:
    """Inner and outer radius of a ring of mean radius `radius`, m."""
    half = 0.5 * RIM * layer.thickness
    return max(radius - half, 0.0), radius + half


@lru_cache(maxsize=64)
def _point_indentation(layer: Layer, mechanics: Any, cell: float) -> Point:
    """Displacement in m per N on a small square, whose size hides the pole, by distance in m."""
    from scipy.interpolate import CubicSpline

    h = layer.thickness
    near, far = np.linspace(0.0, h, NEAR, endpoint=False), np.linspace(h, REACH * h, FAR)
    mesh = np.concatenate([near, far])
    offsets = np.column_stack([mesh, np.zeros_like(mesh)])
    spline = CubicSpline(mesh, mechanics.indentation(layer, offsets, cell) / cell**2)
    cubics = np.ascontiguousarray(spline.c.T)
    return Point(mesh, cubics, h / NEAR, (REACH - 1.0) * h / (FAR - 1), NEAR)


@lru_cache(maxsize=256)
def _indentation(layer: Layer, family: int, radius: float) -> "Indentation":
    """The contact, with a unit radius of curvature or depth."""
    from skinfield.mechanics.axisymmetric import indent_to_radius, punch
    from skinfield.mechanics.profiles import Paraboloid

    if family == BALL:
        return indent_to_radius(layer, Paraboloid(radius=1.0), radius)
    return punch(layer, radius, depth=1.0)
