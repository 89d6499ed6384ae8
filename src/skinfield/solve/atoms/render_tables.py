r"""Tables over the radius of round contacts: what they look like on the surface.

With t² = 1 - r²/a², the pressure of 1 N is

.. math:: p = \frac{1}{\pi a^2} \sum_{j=0}^{J-1} c_j\, t^{2j \pm 1},

plus for a ball, minus for a flat end; J = 1 are Hertz and Boussinesq, and more terms the exact
solution on a layer. Displacements are polynomials in t below the contact and functions of
sqrt(r² - a²) beside it; they come from the mechanics' response to a small loaded square, integrated
in polar coordinates about the point that moves, so that neither pole nor edge is left.
"""

from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from skinfield.elastic import Layer, Mechanics
from skinfield.errors import Floats
from skinfield.solve.atoms.table import BALL, FLAT, log_radii, splines, unit_pressure

LOG_STEP = 0.2  # of ln(a/h)
SMALLEST, LARGEST = 0.15, 8.0  # radii in thicknesses that are rendered as they are
LOGS = log_radii(SMALLEST, LARGEST, LOG_STEP)  # nodes of ln(a/h)
TERMS = 8  # of the pressure
INNER = 10  # of the displacement below the contact
OUTER = 64  # intervals of the displacement beside it
FOLD = 2.0  # thicknesses beside the contact at which half of them are used up
REACH = 12.0  # thicknesses beside the contact where a bonded layer is at rest: to 2e-4 of the peak
NODES, NODES_PER_THICKNESS = 14, 3.0  # of quadrature along each coordinate
PROBE = 1e-4  # thicknesses: side of the loaded square that stands for a point
NEAREST, FARTHEST = 1e-3, 1e3  # thicknesses from it between which its response is tabulated

Kernel = Callable[[Floats], Floats]


class PressureTable(NamedTuple):
    """Cubic B-splines over ln(a/h), the nodes `LOG_STEP` apart.

    Attributes
    ----------
    pressure : (2, radii, TERMS) array
        The coefficients c of balls and of flat ends.
    first_log : float
        ln(a/h) of the first node.
    thickness : float, m
    """

    pressure: Floats
    first_log: float
    thickness: float


class DisplacementTable(NamedTuple):
    """The same of the displacement: it takes much longer to make, and not all need it.

    Attributes
    ----------
    displacement : (2, radii, 2, INNER + 4 OUTER) array
        Of 1 N, times the radius: along the outward normal, m²/N, and away from the axis over the
        distance from it, m/N. First the coefficients of powers of t, then per interval of
        x = s / (s + FOLD h), s² = r² - a², those of the cubic, the highest power first.
    reach : float, m
        Beside the contact, beyond which nothing moves.
    """

    displacement: Floats
    reach: float


@lru_cache(maxsize=8)
def pressure_table(layer: Layer, mechanics: Mechanics) -> PressureTable:
    """Tabulate, once for each layer."""
    coefficients = splines(_all_pressure_terms(layer, cast(Hashable, mechanics)), (1,))
    return PressureTable(coefficients, float(LOGS[0]), layer.thickness)


@lru_cache(maxsize=8)
def displacement_table(layer: Layer, mechanics: Mechanics) -> DisplacementTable:
    """Tabulate, once for each layer."""
    h, coefficients = layer.thickness, _all_pressure_terms(layer, cast(Hashable, mechanics))
    response = _point_response(layer, mechanics)
    moved = [
        _displacement_terms(response, h, h * float(a), terms)
        for a, terms in zip(np.exp(LOGS), coefficients.transpose(1, 0, 2), strict=True)
    ]
    finite = np.isfinite(mechanics.reach(layer))
    return DisplacementTable(
        splines(np.stack(moved, axis=1), (1,)), REACH * h if finite else np.inf
    )


@lru_cache(maxsize=8)
def _all_pressure_terms(layer: Layer, mechanics: Mechanics) -> Floats:
    """Coefficients c (2, radii, TERMS)."""
    radii = layer.thickness * np.exp(LOGS)
    return np.array(
        [[_pressure_terms(layer, mechanics, family, a) for a in radii] for family in (BALL, FLAT)]
    )


def _pressure_terms(layer: Layer, mechanics: Mechanics, family: int, a: float) -> Floats:
    """Coefficients c (TERMS,) that add up to 1 N."""
    t = 0.5 - 0.5 * np.cos((np.arange(4 * TERMS) + 0.5) * np.pi / (4 * TERMS))
    weight = t if family == FLAT else np.ones_like(t)  # bounded: the edge of a flat end is not
    each = unit_pressure(layer, mechanics, family, a, a * np.sqrt(1.0 - t**2)) * (np.pi * a**2)
    power = 2.0 * np.arange(TERMS) + (1.0 if family == BALL else -1.0)  # of t
    terms = np.linalg.lstsq(t[:, None] ** power * weight[:, None], each * weight, rcond=None)[0]
    return np.asarray(terms / (terms @ (2.0 / (power + 2.0))))


def _point_response(layer: Layer, mechanics: Mechanics) -> Callable[[Floats], Floats]:
    """Displacement of 1 N into the skin times the distance rho: (2, ...) m²/N at rho in m.

    Along the outward normal, and away from the load.
    """
    from scipy.interpolate import CubicSpline

    h = layer.thickness
    logs = np.linspace(np.log(NEAREST * h), np.log(FARTHEST * h), 300)
    rho, side = np.exp(logs), PROBE * h
    offset = np.column_stack([rho, np.zeros_like(rho)])
    each = mechanics.surface_displacement(layer, offset, side) / -(side**2)
    values = np.stack([each[:, 2, 2] * rho, each[:, 0, 2] * rho])
    spline = CubicSpline(logs, values, axis=1)

    def response(distance: Floats) -> Floats:
        inside = np.clip(np.log(np.maximum(distance, 1e-30)), logs[0], logs[-1])
        return np.asarray(spline(inside))

    return response


def _displacement_terms(response: Kernel, h: float, a: float, terms: Floats) -> Floats:
    """Coefficients (2, 2, INNER + 4 OUTER) of one radius, see `DisplacementTable`.

    `terms` (2, TERMS) are those of the pressure of both families.
    """
    from scipy.interpolate import CubicSpline

    t = 0.5 - 0.5 * np.cos((np.arange(2 * INNER) + 0.5) * np.pi / (2 * INNER))
    below = np.stack([_below(response, h, a, terms, r) for r in a * np.sqrt(1.0 - t**2)])
    inner = np.linalg.lstsq(t[:, None] ** np.arange(INNER), below.reshape(-1, 4), rcond=None)[0]
    x = np.arange(OUTER) / OUTER
    s = FOLD * h * x / (1.0 - x)
    beside = np.stack([_outside(response, h, a, terms, r) for r in np.hypot(s, a)])
    spline = CubicSpline(np.arange(OUTER + 1), np.vstack([beside.reshape(-1, 4), np.zeros(4)]))
    outer = spline.c.transpose(1, 0, 2).reshape(4 * OUTER, 4)
    return np.asarray(a * np.vstack([inner, outer]).T.reshape(2, 2, -1))


@lru_cache(maxsize=64)
def _rule(a: float, h: float) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights on [0, 1] that resolve a response of the layer."""
    node, weight = np.polynomial.legendre.leggauss(NODES + int(NODES_PER_THICKNESS * a / h))
    return (node + 1.0) / 2.0, weight / 2.0


def _densities(terms: Floats, t: Floats) -> Floats:
    """Pressure (2, ...) of 1 N, times t, times pi a², of both families."""
    square = t**2
    ball, flat = (np.polynomial.polynomial.polyval(square, c) for c in terms)
    return np.stack([ball * square, flat])


def _moved(load: Floats, response: Floats, direction: Floats, r: float) -> Floats:
    """Sums (2, 2) of loads (2, ...): along the normal, and away from the axis over r."""
    normal, radial = response
    return np.stack([(load * normal).sum((1, 2)), (load * radial * direction).sum((1, 2)) / r], 1)


def _below(response: Kernel, h: float, a: float, terms: Floats, r: float) -> Floats:
    """Displacement (2, 2) at a point below the contact of each family, over all lines through it.

    On a line at the angle theta from the outward radius, the chord is -r cos(theta) + b sin(psi),
    b² = a² - r² sin²(theta), and t = (b/a) cos(psi): what is singular at the edge is not in psi.
    """
    u, weight = _rule(a, h)
    # Finer towards pi/2, where lines graze the edge of a close contact.
    angle = np.hstack([np.pi / 2 * (1.0 - u**3), np.pi / 2 * (1.0 + u**3)])[:, None]
    width = np.tile(np.pi / 2 * 3.0 * u**2 * weight, 2)[:, None]
    cosine, half = np.cos(angle), np.sqrt(a**2 - (r * np.sin(angle)) ** 2)
    start = np.arcsin(np.clip(r * cosine / half, -1.0, 1.0))
    psi = start + (np.pi / 2 - start) * u
    rho = np.maximum(-r * cosine + half * np.sin(psi), 0.0)
    load = _densities(terms, half / a * np.cos(psi)) / (np.pi * a)
    element = 2.0 * width * (np.pi / 2 - start) * weight  # dtheta drho / t, both sides
    return _moved(load * element, response(rho), -cosine, r)


def _outside(response: Kernel, h: float, a: float, terms: Floats, r: float) -> Floats:
    """Displacement (2, 2) at a point beside the contact, as `_below`.

    Lines at the angle alpha from the one through the middle, sin(alpha) = (a/r) sin(phi).
    """
    u, weight = _rule(a, h)
    phi = (np.pi / 2 * u)[:, None]
    cosine = np.sqrt(1.0 - (a / r * np.sin(phi)) ** 2)
    half = a * np.cos(phi)
    psi = np.pi * (u - 0.5)
    rho = r * cosine + half * np.sin(psi)
    load = _densities(terms, half / a * np.cos(psi)) / (np.pi * a)
    turn = np.pi / 2 * weight[:, None] * (a / r) * np.cos(phi) / cosine
    return _moved(load * (2.0 * np.pi * turn * weight), response(rho), cosine, r)
