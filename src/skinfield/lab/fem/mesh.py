"""Graded meshes for finite elements: places of vertices, and quadratic functions of the radius.

Lengths are in thicknesses of the layer. Vertices lie close where something happens; a `Trace` is a
quadratic function of the radius on the surface or the base.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve

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


class Trace:
    """Quadratic functions of the radius on a line of elements.

    Parameters
    ----------
    nodes : (2n + 1,) array
        Radii, increasing from the axis: ends of elements at even indices, middles between them.
    """

    def __init__(self, nodes: Floats) -> None:
        fem = scikit_fem()
        self.nodes = nodes
        self._basis = fem.Basis(fem.MeshLine(nodes[::2]), fem.ElementLineP2(), intorder=7)
        self._order = np.argsort(self._basis.doflocs[0])

    @cached_property
    def _mass(self) -> csc_matrix:
        """Integrals over the plane of products of shape functions, (2n + 1, 2n + 1)."""
        form = scikit_fem().BilinearForm(lambda u, v, w: 2 * np.pi * w.x[0] * u * v)
        return csc_matrix(form.assemble(self._basis)[self._order][:, self._order])

    def loads(self, pressure: Callable[[Floats], Floats]) -> Floats:
        """Nodal forces of a pressure, a function of the radii of any shape."""
        form = scikit_fem().LinearForm(lambda v, w: 2 * np.pi * w.x[0] * pressure(w.x[0]) * v)
        return np.asarray(form.assemble(self._basis)[self._order])

    def density(self, forces: Floats) -> Floats:
        """Nodal values of the traction whose consistent nodal forces are these."""
        return np.asarray(spsolve(self._mass, forces))

    def at(self, values: Floats, radius: Floats) -> Floats:
        """The quadratic function of these nodal values; zero beyond the rim."""
        unordered = np.empty_like(values)
        unordered[self._order] = values
        inside = np.clip(radius, self.nodes[0], self.nodes[-1])
        found = self._basis.interpolator(unordered)(inside.reshape(1, -1)).reshape(radius.shape)
        return np.where(radius <= self.nodes[-1], found, 0.0)

    def integral(self, values: Floats) -> float:
        """Of a quadratic function over the plane."""
        return float(np.sum(self._mass @ values))
