"""Graded meshes for finite elements: places of vertices, and quadratic functions of the radius.

Lengths are in thicknesses of the layer. Vertices lie close where something happens; a `Trace` is a
quadratic function of the radius on the surface or the base.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError


def scikit_fem() -> Any:
    """Return the package `skfem`.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import skfem
    except ImportError as error:
        raise InputError(
            "finite elements need scikit-fem, which is not installed: pip install 'skinfield[lab]'"
        ) from error
    return skfem


def graded(stops: Sequence[float], size: Callable[[Floats], Floats]) -> Floats:
    """Vertices (n,) from the first to the last stop, all stops among them.

    Parameters
    ----------
    stops : increasing numbers
    size : callable
        Wanted length of the elements at given places; met from below.
    """
    pieces = []
    for start, stop in pairwise(stops):
        places = np.linspace(start, stop, 2001)
        density = 1.0 / size(places)
        steps = np.diff(places) * (density[1:] + density[:-1]) / 2
        count = np.concatenate([[0.0], np.cumsum(steps)])
        elements = max(int(np.ceil(count[-1] - 1e-9)), 1)
        pieces.append(np.interp(np.linspace(0, count[-1], elements + 1), count, places)[:-1])
    return np.concatenate([*pieces, [stops[-1]]])


def towards(
    places: Sequence[float], finest: float, growth: float, coarsest: float
) -> Callable[[Floats], Floats]:
    """Length of elements that grows with the distance from the nearest of some places.

    Parameters
    ----------
    places : numbers
    finest, coarsest : float
        Least and greatest length.
    growth : float
        Of the length per distance.
    """
    centres = np.asarray(places, dtype=float)

    def size(at: Floats) -> Floats:
        distance = np.abs(at[:, None] - centres).min(axis=1)
        return np.minimum(finest + growth * np.asarray(distance), coarsest)

    return size


GAUSS, GAUSS_WEIGHT = (a / 2 for a in np.polynomial.legendre.leggauss(4))
GAUSS = GAUSS + 0.5


def shapes(place: Floats) -> Floats:
    """Quadratic shape functions (..., 3) of start, middle and end at places 0 to 1."""
    start, end = (1 - place) * (1 - 2 * place), place * (2 * place - 1)
    return np.stack([start, 4 * place * (1 - place), end], axis=-1)


@dataclass(frozen=True, eq=False)
class Trace:
    """Nodes of a line of quadratic elements: ends at even indices, middles between them.

    Attributes
    ----------
    nodes : (2n + 1,) array
        Radii, increasing from the axis.
    """

    nodes: Floats

    @cached_property
    def mass(self) -> Floats:
        """Integrals over the plane of products of shape functions, (2n + 1, 2n + 1)."""
        local = np.einsum("eg,gi,gj->eij", self._areas, shapes(GAUSS), shapes(GAUSS))
        total = np.zeros((len(self.nodes), len(self.nodes)))
        for element, block in enumerate(local):
            part = slice(2 * element, 2 * element + 3)
            total[part, part] += block
        return total

    @property
    def _areas(self) -> Floats:
        return 2 * np.pi * self.gauss_radii * np.diff(self.nodes[::2])[:, None] * GAUSS_WEIGHT

    def loads(self, pressure: Floats) -> Floats:
        """Nodal forces of a pressure (elements, 4) at the Gauss points of each element."""
        local = np.einsum("eg,eg,gi->ei", self._areas, pressure, shapes(GAUSS))
        total = np.zeros(len(self.nodes))
        np.add.at(total, np.arange(len(local))[:, None] * 2 + np.arange(3), local)
        return total

    @property
    def gauss_radii(self) -> Floats:
        """Radii (elements, 4) at which `loads` wants the pressure."""
        corners = self.nodes[::2]
        return corners[:-1, None] + np.diff(corners)[:, None] * GAUSS

    def density(self, forces: Floats) -> Floats:
        """Nodal values of the traction whose consistent nodal forces are given."""
        return np.asarray(np.linalg.solve(self.mass, forces))

    def at(self, values: Floats, radius: Floats) -> Floats:
        """The quadratic function with the given nodal values; zero beyond the rim."""
        corners = self.nodes[::2]
        element = np.clip(np.searchsorted(corners, radius, "right") - 1, 0, len(corners) - 2)
        start, length = corners[element], np.diff(corners)[element]
        place = np.clip((radius - start) / length, 0.0, 1.0)
        inside = np.sum(shapes(place) * values[2 * element[..., None] + np.arange(3)], axis=-1)
        return np.where(radius <= corners[-1], inside, 0.0)

    def integral(self, values: Floats) -> float:
        """Of a quadratic function over the plane."""
        return float(np.sum(self.mass @ values))
