"""Mesh of the section of a round piece of layer: Taylor-Hood, Q2 displacement, Q1 pressure.

Lengths are in thicknesses of the layer and stresses in Young's moduli. The layer fills 0 <= z <= 1.
Vertices lie close where something happens; a `Trace` is a quadratic function of the radius on the
surface or the base.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints


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


def slopes(place: Floats) -> Floats:
    """Derivatives (..., 3) of `shapes`."""
    return np.stack([4 * place - 3, 4 - 8 * place, 4 * place - 1], axis=-1)


@dataclass(frozen=True, eq=False)
class Trace:
    """Nodes of a line of quadratic elements: ends at even indices, middles between them.

    Attributes
    ----------
    nodes : (2n + 1,) array
        Radii, increasing from the axis.
    """

    nodes: Floats

    @property
    def elements(self) -> Floats:
        """Radii of start, middle and end of each element, (n, 3)."""
        return np.stack([self.nodes[:-2:2], self.nodes[1::2], self.nodes[2::2]], axis=-1)

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
        radius = self.elements @ shapes(GAUSS).T
        return 2 * np.pi * radius * (self.elements @ slopes(GAUSS).T) * GAUSS_WEIGHT

    def loads(self, pressure: Floats) -> Floats:
        """Nodal forces of a pressure (elements, 4) at the Gauss points of each element."""
        local = np.einsum("eg,eg,gi->ei", self._areas, pressure, shapes(GAUSS))
        total = np.zeros(len(self.nodes))
        np.add.at(total, np.arange(len(local))[:, None] * 2 + np.arange(3), local)
        return total

    @property
    def gauss_radii(self) -> Floats:
        """Radii (elements, 4) at which `loads` wants the pressure."""
        return self.elements @ shapes(GAUSS).T

    def density(self, forces: Floats) -> Floats:
        """Nodal values of the traction whose consistent nodal forces are given."""
        return np.asarray(np.linalg.solve(self.mass, forces))

    def at(self, values: Floats, radius: Floats) -> Floats:
        """The quadratic function with the given nodal values; zero beyond the rim."""
        corners = self.nodes[::2]
        element = np.clip(np.searchsorted(corners, radius, "right") - 1, 0, len(corners) - 2)
        local = 2 * element[..., None] + np.arange(3)
        ends, place = self.nodes[local], np.full(radius.shape, 0.5)
        for _ in range(4):  # nodes that moved leave the middle of their element
            miss = np.sum(shapes(place) * ends, axis=-1) - radius
            place = np.clip(place - miss / np.sum(slopes(place) * ends, axis=-1), 0.0, 1.0)
        inside = np.sum(shapes(place) * values[local], axis=-1)
        return np.where(radius <= corners[-1], inside, 0.0)

    def integral(self, values: Floats) -> float:
        """Of a quadratic function over the plane."""
        return float(np.sum(self.mass @ values))


IN_PLANE = ((0, 0), (0, 1), (1, 0), (1, 1))  # component and direction of the gradient's entries


@dataclass(frozen=True, eq=False)
class Section:
    """What any elastic law needs to know about the mesh.

    Attributes
    ----------
    gradient : (elements, points, 18, 5) array
        Of the shape functions: d(u_r)/dr, d(u_r)/dz, d(u_z)/dr, d(u_z)/dz, u_r/r.
    pressure_shape : (elements, points, 4) array
    weight : (elements, points) array
        Volume of a quadrature point, turned about the axis.
    displacement_dofs : (elements, 18) array
    pressure_dofs : (elements, 4) array
    displacements, pressures : int
        Numbers of unknowns.
    free : (displacements,) array of bool
        False where the layer is held: base, rim, and the axis sideways.
    top_r, top_z, base_z : arrays of int
        Unknowns of the surface and of the base, from the axis outwards.
    trace : Trace
        The nodes of surface and base.
    """

    gradient: Floats
    pressure_shape: Floats
    weight: Floats
    displacement_dofs: Ints
    pressure_dofs: Ints
    displacements: int
    pressures: int
    free: NDArray[np.bool_]
    top_r: Ints
    top_z: Ints
    base_z: Ints
    trace: Trace

    @property
    def unknowns(self) -> int:
        """Displacements and pressures together."""
        return self.displacements + self.pressures


def mesh_section(radii: Floats, heights: Floats) -> Section:
    """Elements between the given radii and heights, both in thicknesses."""
    fem = scikit_fem()
    mesh = fem.MeshQuad.init_tensor(radii, heights)
    basis = fem.Basis(mesh, fem.ElementVector(fem.ElementQuad2()), intorder=5)
    pressure = fem.Basis(mesh, fem.ElementQuad1(), intorder=5)
    r, z = basis.doflocs
    component = _components(basis)
    held = (z == 0) | (r == radii[-1]) | ((r == 0) & (component == 0))

    def line(height: float, wanted: int) -> Ints:
        found = np.flatnonzero((z == height) & (component == wanted))
        return found[np.argsort(r[found])]

    top = line(heights[-1], 0)
    return Section(
        gradient=_gradients(basis),
        pressure_shape=np.stack([np.asarray(shape[0]) for shape in pressure.basis], axis=-1),
        weight=2 * np.pi * basis.global_coordinates()[0] * basis.dx,
        displacement_dofs=basis.element_dofs.T.astype(np.int64),
        pressure_dofs=pressure.element_dofs.T.astype(np.int64),
        displacements=basis.N,
        pressures=pressure.N,
        free=~held,
        top_r=top,
        top_z=line(heights[-1], 1),
        base_z=line(0.0, 1),
        trace=Trace(r[top]),
    )


def _components(basis: Any) -> Ints:
    """Component 0 or 1 of the displacement that each unknown stands for."""
    component = np.empty(basis.N, dtype=np.int64)
    for local, shape in enumerate(basis.basis):
        values = np.abs(np.asarray(shape[0])).max(axis=(1, 2))
        component[basis.element_dofs[local]] = int(values[1] > values[0])
    return component


def _gradients(basis: Any) -> Floats:
    radius = basis.global_coordinates()[0]
    columns = []
    for shape in basis.basis:
        field = shape[0]
        entries = [np.asarray(field.grad)[i, j] for i, j in IN_PLANE]
        columns.append(np.stack([*entries, np.asarray(field)[0] / radius], axis=-1))
    return np.stack(columns, axis=-2)
