r"""Readings of pads beside round indentations, from Laplace's equation in the gap below them.

Pads and guard lie in one plane at one potential, so the field below a round indentation is round,
wherever the pad is. A pad's reading is the mean over the pad of the charge on that plane, one
product with a matrix that pads and mesh alone determine.

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
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, InputError, Ints, check_shape

FINEST, SHARPEST, COARSEST = 0.05, 2e-4, 0.3  # elements at the axis, at edges and anywhere
GROWTH = 0.6  # of elements with the distance from there
REST = 1e-4  # of the greatest strain: with less, a surface is flat
BEYOND = 3.0  # thicknesses of surface around the furthest pad: the field forgets as exp(-pi r/h)
RADII, ANGLES = 24, 48  # of the points that average over a pad
FAR, NEAR = 2, 6  # points of quadrature in an element: from afar, and near or at one of its ends
APART, CLOSE = 2.0, 0.7  # lengths of an element from which it is far, or one of its ends near


def _rules() -> tuple[Floats, Floats]:
    """Points and weights, each (FAR + 3 NEAR,), from 0 to 1 along an element: four rules.

    `FAR` points; `NEAR` points; `NEAR` points for a logarithm at its start, taken away by x = u³,
    and as many for one at its end.
    """
    far, near = (np.polynomial.legendre.leggauss(count) for count in (FAR, NEAR))
    u, share = (near[0] + 1) / 2, near[1] / 2
    towards = 3 * u**2 * share
    return (
        np.concatenate([(far[0] + 1) / 2, u, u**3, 1 - u**3]),
        np.concatenate([far[1] / 2, share, towards, towards]),
    )


AT, WEIGHT = _rules()


@dataclass(frozen=True, eq=False)
class RoundGap:
    """A mesh along the radius and the pads that read it; all lengths in thicknesses.

    Made by `RoundGap.of`.

    Attributes
    ----------
    nodes : (M,) array
        Radii at which the strain is to be given, from 0.
    averages : (N, M) array
        Readings from the charge at the nodes.
    """

    nodes: Floats
    averages: Floats

    @classmethod
    def of(cls, pad_diameter: float, distances: ArrayLike, edges: ArrayLike = ()) -> "RoundGap":
        """Prepare for pads whose centres are at some distances from the axis.

        Parameters
        ----------
        pad_diameter : float
            In thicknesses; 0 for the density of charge at the point itself.
        distances : (N,) array
            In thicknesses.
        edges : (E,) array
            Radii in thicknesses at which a surface may bend sharply, as at the rim of a flat end:
            there the mesh is fine.
        """
        away, sharp = np.asarray(distances, np.float64), np.asarray(edges, np.float64)
        nodes = _nodes(float(away.max(initial=0.0)) + pad_diameter / 2 + BEYOND, sharp)
        return cls(nodes, _averages(nodes, away, pad_diameter / 2))

    def readings(self, strain: Floats) -> Floats:
        """Relative change of capacitance (P, N) of the pads.

        Parameters
        ----------
        strain : (P, M) array
            Of the gap, w/h, at the nodes, below 1: one row per indentation.

        Raises
        ------
        InputError
            If the surface reaches the pads.
        """
        check_shape("strain", strain, (None, len(self.nodes)), "one row per indentation, at nodes")
        return np.asarray(self._charge(strain) @ self.averages.T)

    def _charge(self, strain: Floats) -> Floats:
        """Density of charge (P, M) at the nodes, relative to that of plates at rest, less one.

        None where all surfaces are long at rest.
        """
        from scipy.interpolate import Akima1DInterpolator

        out, size = np.zeros(strain.shape), np.abs(strain)
        _check_open(strain)
        bent = np.flatnonzero((size > REST * size.max(axis=1, keepdims=True)).any(axis=0))
        if not len(bent):
            return out
        last = int(np.searchsorted(self.nodes, self.nodes[bent[-1]] + BEYOND)) + 1
        nodes, heights = self.nodes[:last], 1.0 - strain[:, :last]
        rings = nodes[:-1, None] + np.diff(nodes)[:, None] * AT
        mirrored = np.concatenate([-nodes[2:0:-1], nodes])
        surface = Akima1DInterpolator(mirrored, np.hstack([heights[:, 2:0:-1], heights]), axis=1)
        line, between = np.hypot(1.0, surface.derivative()(rings)), surface(rings)
        _check_open(1.0 - between)
        for row, height in enumerate(heights):
            ends, points = np.stack([nodes, height], -1), np.stack([rings, between[row]], -1)
            out[row, :last] = _charge_density(ends, points, line[row])
        return out


def _check_open(strain: Floats) -> None:
    if strain.max(initial=0.0) >= 1.0:
        raise InputError(
            f"strain reaches {strain.max():.2f}, expected below 1: the skin would touch its base; "
            "lower the load or raise the modulus"
        )


def _nodes(furthest: float, edges: Floats) -> Floats:
    """Ends and middles of the elements, which are short at the axis and at the edges."""
    stops = [0.0, *np.unique(edges[(edges > 0.0) & (edges < furthest)])]
    ends = [np.zeros(1)]
    for start, stop in pairwise(stops):
        middle = (start + stop) / 2
        ends.append(start + _growing(SHARPEST if start else FINEST, middle - start))
        ends.append(stop - _growing(SHARPEST, stop - middle)[-2::-1])
        ends.append(np.array([stop]))
    last = stops[-1]
    ends.append(last + _growing(SHARPEST if last else FINEST, furthest - last))
    edge = np.concatenate(ends)
    return np.sort(np.concatenate([edge, (edge[1:] + edge[:-1]) / 2]))


def _growing(first: float, span: float) -> Floats:
    """Ends of elements that grow from a first one until they have filled a span."""
    ends = [0.0]
    while ends[-1] < span:
        ends.append(ends[-1] + min(first + GROWTH * ends[-1], COARSEST))
    return np.array(ends[1:]) * (span / ends[-1])


@lru_cache(maxsize=4)
def _pad_points(distances: bytes, radius: float) -> tuple[Floats, Floats, Ints]:
    """Points that average over pads: distance from the axis, rising; weight; and whose they are.

    The same for all meshes: `distances` are the bytes of an array (N,).
    """
    node, weight = np.polynomial.legendre.leggauss(RADII)
    share = np.repeat(weight * (node + 1) / (2 * ANGLES), ANGLES)
    rho, angle = radius * (node[:, None] + 1) / 2, (np.arange(ANGLES) + 0.5) * np.pi / ANGLES
    away = np.frombuffer(distances)[:, None, None]
    at = np.hypot(away + rho * np.cos(angle), rho * np.sin(angle)).reshape(len(away), -1)
    order = np.argsort(at, axis=None, kind="stable")
    return at.ravel()[order], np.tile(share, len(away))[order], order // max(len(share), 1)


def _averages(nodes: Floats, distances: Floats, radius: float) -> Floats:
    """Means over pads (N, M) of the functions that belong to the nodes."""
    out = np.zeros((len(distances), len(nodes)))
    _add_means(nodes, *_pad_points(distances.tobytes(), radius), out)
    return out


def _charge_density(surface: Floats, points: Floats, line: Floats) -> Floats:
    """Charge (M,) on the pads' plane below the nodes, relative to that of plates at rest, less one.

    Parameters
    ----------
    surface : (M, 2) array
        Radius and height of the nodes, from the axis outwards.
    points : (M - 1, FAR + 3 NEAR, 2) array
        The same of the points that `AT` has along each element, by radius.
    line : (M - 1, FAR + 3 NEAR) array
        Length of the surface per radius there.
    """
    from scipy.linalg import lu_factor, lu_solve

    weight = WEIGHT * np.diff(surface[:, 0])[:, None] * points[..., 0] * line
    potential, below = _layer(surface, points, weight, AT)
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


@njit(heavy=True, error_model="numpy")
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


@njit(heavy=True, error_model="numpy")
def _add_means(nodes: Floats, at: Floats, share: Floats, pad: Ints, out: Floats) -> None:
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
