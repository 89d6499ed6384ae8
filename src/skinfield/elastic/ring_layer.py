r"""Laplace's equation below a round surface by a layer of charge on it, in rings.

Lengths are in thicknesses and the pads' plane is z = 0. What the deformation adds to the potential
1 - z of plates is :math:`\psi`, with :math:`\psi = 0` at the pads and :math:`\psi = g - 1` on the
surface z = g(r). A layer of density :math:`\sigma` on the surface, with its mirror image below
the pads, makes

.. math:: \psi = \int \sigma\,s\,\left[\frac{K(m)}{\pi D} - \frac{K(m')}{\pi D'}\right] dl,
          \quad D^2 = (r + s)^2 + (z - t)^2, \quad m = 4 r s/D^2,

with z + t for z - t in the image, at (s, t) along the surface. The density is linear between nodes
and meets the condition at the nodes. No map of the gap is needed, so a surface may be as steep as
beside the rim of a flat end.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

FAR, NEAR = 2, 6  # points of quadrature in an element: from afar, and near or at one of its ends
APART, CLOSE = 2.0, 0.7  # lengths of an element from which it is far, or one of its ends near


class Rules(NamedTuple):
    """Quadrature along an element, as four rules one after the other.

    `FAR` points; `NEAR` points; `NEAR` points for a logarithm at its start, and as many for one at
    its end.

    Attributes
    ----------
    at, weight : (FAR + 3 NEAR,) array
        From 0 to 1 along the element.
    """

    at: Floats
    weight: Floats


@lru_cache(maxsize=1)
def rules() -> Rules:
    """The rules; a logarithm is taken away by x = u³."""
    far, near = (np.polynomial.legendre.leggauss(count) for count in (FAR, NEAR))
    u, share = (near[0] + 1) / 2, near[1] / 2
    towards = 3 * u**2 * share
    return Rules(
        np.concatenate([(far[0] + 1) / 2, u, u**3, 1 - u**3]),
        np.concatenate([far[1] / 2, share, towards, towards]),
    )


def charge_density(surface: Floats, points: Floats, line: Floats) -> Floats:
    """Charge (M,) on the pads' plane below the nodes, relative to that of plates at rest, less one.

    Parameters
    ----------
    surface : (M, 2) array
        Radius and height of the nodes, from the axis outwards.
    points : (M - 1, FAR + 3 NEAR, 2) array
        The same of the points that `rules` has along each element, by radius.
    line : (M - 1, FAR + 3 NEAR) array
        Length of the surface per radius there.
    """
    from scipy.linalg import lu_factor, lu_solve

    rule = rules()
    weight = rule.weight * np.diff(surface[:, 0])[:, None] * points[..., 0] * line
    potential, below = _layer(surface, points, weight, rule.at)
    factors = lu_factor(potential, overwrite_a=True, check_finite=False)
    return np.asarray(below @ lu_solve(factors, surface[:, 1] - 1.0, check_finite=False))


@inner(error_model="numpy")
def _ring(r: float, s: float, above: float) -> float:
    """Potential of a ring of radius s, per length and radius, `above` the ring's plane."""
    wide = (r + s) ** 2 + above**2
    m = ((r - s) ** 2 + above**2) / wide  # complementary; Abramowitz and Stegun 17.3.34, to 2e-8
    first = 0.03742563713 + m * 0.01451196212
    first = 1.38629436112 + m * (0.09666344259 + m * (0.03590092383 + m * first))
    second = 0.06880248576 + m * (0.03328355346 + m * 0.00441787012)
    second = 0.5 + m * (0.12498593597 + m * second)
    return (first - second * math.log(m)) / (math.pi * math.sqrt(wide))


@inner(error_model="numpy")
def _pull(r: float, s: float, t: float) -> float:
    """Charge on the pads' plane below a ring at the height t and its image, as in `_ring`."""
    wide, near = (r + s) ** 2 + t**2, (r - s) ** 2 + t**2
    m = near / wide  # Abramowitz and Stegun 17.3.36, to 2e-8
    first = 0.06260601220 + m * (0.04757383546 + m * 0.01736506451)
    first = 1.0 + m * (0.44325141463 + m * first)
    second = 0.09200180037 + m * (0.04069697526 + m * 0.00526449639)
    second = m * (0.24998368310 + m * second)
    return -2.0 / math.pi * t * (first - second * math.log(m)) / (near * math.sqrt(wide))


@inner(error_model="numpy")
def _rule(before: float, behind: float, length: float) -> tuple[int, int]:
    """Which points integrate along an element; squares of its length and its ends' distances."""
    if min(before, behind) > APART * APART * length:
        return 0, FAR
    if before < CLOSE * CLOSE * length and before <= behind:
        return FAR + NEAR, FAR + 2 * NEAR
    if behind < CLOSE * CLOSE * length:
        return FAR + 2 * NEAR, FAR + 3 * NEAR
    return FAR, FAR + NEAR


@njit(error_model="numpy")
def _layer(surface: Floats, points: Floats, weight: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Potential at the surface's nodes and charge below them, per density at the nodes."""
    count = len(surface)
    potential, below = np.zeros((count, count)), np.zeros((count, count))
    for row in range(count):
        r, height = surface[row]
        before = (r - surface[0, 0]) ** 2 + surface[0, 1] ** 2  # of the place on the pads' plane
        there = (r - surface[0, 0]) ** 2 + (height - surface[0, 1]) ** 2
        for element in range(count - 1):
            radius, at_height = surface[element + 1]
            length = (radius - surface[element, 0]) ** 2 + (at_height - surface[element, 1]) ** 2
            behind = (r - radius) ** 2 + at_height**2
            first, last = _rule(before, behind, length)
            before = behind
            for point in range(first, last):
                s, t = points[element, point]
                part = weight[element, point] * _pull(r, s, t)
                below[row, element] += part * (1 - at[point])
                below[row, element + 1] += part * at[point]
            behind = (r - radius) ** 2 + (height - at_height) ** 2
            first, last = _rule(there, behind, length)
            there = behind
            for point in range(first, last):
                s, t = points[element, point]
                part = _ring(r, s, height - t) - _ring(r, s, height + t)
                part *= weight[element, point]
                potential[row, element] += part * (1 - at[point])
                potential[row, element + 1] += part * at[point]
    return potential, below


@njit(error_model="numpy")
def add_means(nodes: Floats, at: Floats, share: Floats, pad: Ints, out: Floats) -> None:
    """Add to means over pads (N, M) what points add, which are in order."""
    start = 0
    for n in range(len(at)):
        while start + 3 < len(nodes) - 1 and at[n] >= nodes[start + 2]:
            start += 2
        x = (at[n] - nodes[start]) / (nodes[start + 2] - nodes[start])
        row = out[pad[n]]
        row[start] += share[n] * (1 - x) * (1 - 2 * x)  # an element's functions
        row[start + 1] += share[n] * 4 * x * (1 - x)
        row[start + 2] += share[n] * x * (2 * x - 1)
