"""What several bodies have done to the layer."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, as_floats, check_shape
from skinfield.fem.lines import Line
from skinfield.mechanics import Layer


@dataclass(frozen=True, eq=False)
class BoxSolution:
    """Bodies at rest on the layer; pressure and compression are positive.

    Attributes
    ----------
    layer : Layer
    depths : (bodies,) array, m
        Of the bodies' lowest points below the undeformed surface.
    forces : (bodies,) array, N
        Into the layer.
    lines : (Line, Line)
        The mesh along x and y, in thicknesses.
    mirror : bool
        Whether the mesh ends at y = 0, beyond which all is its mirror image.
    surface : (3, nx, ny) array, m
        Displacement of the nodes of the surface; z is upwards.
    nodal_force, nodal_base_stress : (nx, ny) arrays, N and Pa
        Of the bodies on the surface, consistent with the elements; of the base.
    contact : (nx, ny) array of bool
        Nodes that touch.
    """

    layer: Layer
    depths: Floats
    forces: Floats
    lines: tuple[Line, Line]
    mirror: bool
    surface: Floats
    nodal_force: Floats
    nodal_base_stress: Floats
    contact: NDArray[np.bool_]

    def displacement(self, points: ArrayLike) -> Floats:
        """Displacement (N, 3) m of points (N, 2) m of the surface."""
        x, y, side = self._weights(points)
        moved = np.einsum("pi,cij,pj->pc", x, self.surface, y)
        moved[:, 1] *= side
        return np.asarray(moved)

    def indentation(self, points: ArrayLike) -> Floats:
        """Depth (N,) m of the surface at points (N, 2) m."""
        return -self.displacement(points)[:, 2]

    def base_stress(self, points: ArrayLike) -> Floats:
        """Normal stress (N,) Pa on the base at points (N, 2) m."""
        x, y, _ = self._weights(points)
        return np.asarray(np.einsum("pi,ij,pj->p", x, self.nodal_base_stress, y))

    def pressure(self, points: ArrayLike) -> Floats:
        """Contact pressure (N,) Pa at points (N, 2) m, smeared over an element at the edge."""
        x, y, _ = self._weights(points)
        density = densities(self.lines, self.nodal_force) / self.layer.thickness**2
        return np.asarray(np.einsum("pi,ij,pj->p", x, density, y))

    def _weights(self, points: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Weights of the nodes along x and y, and on which side of the mirror a point lies."""
        at = as_floats("points", points)
        check_shape("points", at, (None, 2), "x and y on the layer, in metres")
        x, y = at.T / self.layer.thickness
        side = np.where(self.mirror & (y < 0), -1.0, 1.0)
        return self.lines[0].interpolation(x), self.lines[1].interpolation(side * y), side


def densities(lines: tuple[Line, Line], forces: Floats) -> Floats:
    """Nodal values (nx, ny) of a traction from its nodal forces, per squared thickness."""
    along = np.linalg.solve(lines[0].mass, forces)
    return np.asarray(np.linalg.solve(lines[1].mass, along.T).T)
