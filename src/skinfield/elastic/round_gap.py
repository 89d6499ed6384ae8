"""Readings of pads beside round indentations, from Laplace's equation in the gap below them.

Pads and guard lie in one plane at one potential, so the field below a round indentation is round,
wherever the pad is. `ring_layer` has the charge on that plane; a pad's reading is its mean over the
pad, one product with a matrix that pads and mesh alone determine.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_finite,
    check_range,
    check_shape,
)

FINEST, SHARPEST, COARSEST = 0.05, 2e-4, 0.3  # elements at the axis, at edges and anywhere
GROWTH = 0.6  # of elements with the distance from there
REST = 1e-4  # of the greatest strain: with less, a surface is flat
BEYOND = 3.0  # thicknesses of surface around the furthest pad: the field forgets as exp(-pi r/h)
RADII, ANGLES = 24, 48  # of the points that average over a pad


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
        away = np.abs(as_floats("distances", distances))
        check_shape("distances", away, (None,), "one per pad")
        check_finite("distances", away, "of the pads' centres from the axis, in thicknesses")
        check_range("pad_diameter", pad_diameter, 0.0, 1e3, "in thicknesses")
        sharp = as_floats("edges", edges)
        check_finite("edges", sharp, "radii at which the surface bends, in thicknesses")
        nodes = _nodes(float(away.max(initial=0.0)) + pad_diameter / 2 + BEYOND, sharp)
        return cls(nodes, _averages(nodes, away, float(pad_diameter) / 2))

    def charge(self, strain: ArrayLike) -> Floats:
        """Density of charge at the nodes, relative to that of plates at rest, less one.

        Parameters
        ----------
        strain : (P, M) array
            Of the gap, w/h, at the nodes, below 1: one row per indentation.

        Returns
        -------
        (P, M) array

        Raises
        ------
        InputError
            If the surface reaches the pads.
        """
        v = as_floats("strain", strain)
        check_shape("strain", v, (None, len(self.nodes)), "one row per indentation, at the nodes")
        check_finite("strain", v, "of the gap, in thicknesses")
        _check_open(v)
        return np.stack([self._charge(each) for each in v]) if len(v) else np.zeros_like(v)

    def readings(self, strain: ArrayLike) -> Floats:
        """Relative change of capacitance (P, N) of the pads; see `charge`."""
        return np.asarray(self.charge(strain) @ self.averages.T)

    def _charge(self, strain: Floats) -> Floats:
        """Charge (M,) of one indentation; none where the surface is long at rest."""
        from scipy.interpolate import Akima1DInterpolator

        from skinfield.elastic.ring_layer import charge_density, rules

        out = np.zeros(len(strain))
        bent = np.flatnonzero(np.abs(strain) > REST * np.abs(strain).max())
        if not len(bent):
            return out
        last = int(np.searchsorted(self.nodes, self.nodes[bent[-1]] + BEYOND)) + 1
        nodes, heights = self.nodes[:last], 1.0 - strain[:last]
        rings = nodes[:-1, None] + np.diff(nodes)[:, None] * rules().at
        mirrored = np.concatenate([-nodes[2:0:-1], nodes])
        surface = Akima1DInterpolator(mirrored, np.concatenate([heights[2:0:-1], heights]))
        line, between = np.hypot(1.0, surface.derivative()(rings)), surface(rings)
        _check_open(1.0 - between)
        out[:last] = charge_density(
            np.stack([nodes, heights], axis=-1), np.stack([rings, between], axis=-1), line
        )
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
    from skinfield.elastic.ring_layer import add_means

    out = np.zeros((len(distances), len(nodes)))
    add_means(nodes, *_pad_points(distances.tobytes(), radius), out)
    return out
