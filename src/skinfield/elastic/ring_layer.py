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
MANTISSA = 0x000FFFFFFFFFFFFF  # bits of a double
ROOT, LN2 = 0x0006A09E667F3BCD, math.log(2.0)  # mantissa of sqrt(2)


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
    m = ((r - s) ** 2 + above**2) / ((r + s) ** 2 + above**2)
    return _ring_with(r, s, above, math.log(m))


@inner(error_model="numpy")
def _ring_with(r: float, s: float, above: float, log: float) -> float:
    """The same, by the logarithm of the complementary parameter m."""
    wide = (r + s) ** 2 + above**2
    m = ((r - s) ** 2 + above**2) / wide  # complementary; Abramowitz and Stegun 17.3.34, to 2e-8
    first = 0.03742563713 + m * 0.01451196212
    first = 1.38629436112 + m * (0.09666344259 + m * (0.03590092383 + m * first))
    second = 0.06880248576 + m * (0.03328355346 + m * 0.00441787012)
    second = 0.5 + m * (0.12498593597 + m * second)
    return (first - second * log) / (math.pi * math.sqrt(wide))


@inner(error_model="numpy")
def _pull(r: float, s: float, t: float) -> float:
    """Charge on the pads' plane below a ring at the height t and its image, as in `_ring`."""
    return _pull_with(r, s, t, math.log(((r - s) ** 2 + t**2) / ((r + s) ** 2 + t**2)))


@inner(error_model="numpy")
def _pull_with(r: float, s: float, t: float, log: float) -> float:
    """The same, by the logarithm of the complementary parameter."""
    wide, near = (r + s) ** 2 + t**2, (r - s) ** 2 + t**2
    m = near / wide  # Abramowitz and Stegun 17.3.36, to 2e-8
    first = 0.06260601220 + m * (0.04757383546 + m * 0.01736506451)
    first = 1.0 + m * (0.44325141463 + m * first)
    second = 0.09200180037 + m * (0.04069697526 + m * 0.00526449639)
    second = m * (0.24998368310 + m * second)
    return -2.0 / math.pi * t * (first - second * log) / (near * math.sqrt(wide))


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


@inner(error_model="numpy")
def _logarithms(values: Floats, bits: Ints, room: Floats, room_bits: Ints, out: Floats) -> None:
    """Natural logarithms (N,) of normal positive numbers; each of the `bits` is the same memory.

    Without branches and calls, and from one memory into another, so that several are computed at
    once: ln(2^k f) by the series of 2 artanh((f - 1)/(f + 1)), f from sqrt(1/2) to sqrt(2).
    """
    for n in range(len(values)):
        mantissa = bits[n] & MANTISSA
        up = 1 if mantissa > ROOT else 0  # f above sqrt(2): half of it, with the next k
        out[n] = float((bits[n] >> 52) - 1023 + up)
        room_bits[n] = mantissa | ((1023 - up) << 52)
    for n in range(len(values)):
        s = (room[n] - 1.0) / (room[n] + 1.0)
        z = s * s
        odd = 1.0 / 15.0 + z * (1.0 / 17.0 + z * (1.0 / 19.0 + z * (1.0 / 21.0)))
        odd = 1.0 / 7.0 + z * (1.0 / 9.0 + z * (1.0 / 11.0 + z * (1.0 / 13.0 + z * odd)))
        odd = z * (1.0 / 3.0 + z * (1.0 / 5.0 + z * odd))
        out[n] = out[n] * LN2 + 2.0 * (s + s * odd)


@njit(error_model="numpy")
def _far(r: float, height: float, rings: Floats, room: Floats, bits: Ints, out: Floats) -> None:
    """Potential and pull (2, P) at a place of all rings (3, P) of radius, height and weight.

    As `_ring` less its image and as `_pull`, for many at once; `room` (3, 3 P) and `bits`, the same
    memory, are overwritten.
    """
    count = rings.shape[1]
    radius, heights, weight = rings[0], rings[1], rings[2]
    parameter, log = room[0], room[2]
    for n in range(count):
        s, t = radius[n], heights[n]
        apart, together = (r - s) ** 2, (r + s) ** 2
        parameter[n] = (apart + (height - t) ** 2) / (together + (height - t) ** 2)
        parameter[count + n] = (apart + (height + t) ** 2) / (together + (height + t) ** 2)
        parameter[2 * count + n] = (apart + t**2) / (together + t**2)
    _logarithms(parameter, bits[0], room[1], bits[1], log)
    potential, pull = out[0], out[1]
    for n in range(count):
        s, t = radius[n], heights[n]
        above = _ring_with(r, s, height - t, log[n])
        image = _ring_with(r, s, height + t, log[count + n])
        potential[n] = weight[n] * (above - image)
        pull[n] = weight[n] * _pull_with(r, s, t, log[2 * count + n])


@njit(error_model="numpy")
def _layer(surface: Floats, points: Floats, weight: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Potential at the surface's nodes and charge below them, per density at the nodes."""
    count = len(surface)
    potential, below = np.zeros((count, count)), np.zeros((count, count))
    rings, lengths = np.empty((3, FAR * (count - 1))), np.empty(count - 1)
    for element in range(count - 1):
        wide = surface[element + 1, 0] - surface[element, 0]
        lengths[element] = wide**2 + (surface[element + 1, 1] - surface[element, 1]) ** 2
        for point in range(FAR):
            rings[0, FAR * element + point] = points[element, point, 0]
            rings[1, FAR * element + point] = points[element, point, 1]
            rings[2, FAR * element + point] = weight[element, point]
    room, far = np.empty((3, 3 * rings.shape[1])), np.empty((2, rings.shape[1]))
    bits = room.view(np.int64)
    for row in range(count):
        r, height = surface[row]
        _far(r, height, rings, room, bits, far)
        before = (r - surface[0, 0]) ** 2 + surface[0, 1] ** 2  # of the place on the pads' plane
        there = (r - surface[0, 0]) ** 2 + (height - surface[0, 1]) ** 2
        for element in range(count - 1):
            radius, at_height = surface[element + 1]
            behind = (r - radius) ** 2 + at_height**2
            first, last = _rule(before, behind, lengths[element])
            before = behind
            for point in range(first, last):
                if last == FAR:
                    part = far[1, FAR * element + point]
                else:
                    s, t = points[element, point]
                    part = weight[element, point] * _pull(r, s, t)
                below[row, element] += part * (1 - at[point])
                below[row, element + 1] += part * at[point]
            behind = (r - radius) ** 2 + (height - at_height) ** 2
            first, last = _rule(there, behind, lengths[element])
            there = behind
            for point in range(first, last):
                if last == FAR:
                    part = far[0, FAR * element + point]
                else:
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
