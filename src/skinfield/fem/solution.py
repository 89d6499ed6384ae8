"""What an axisymmetric press has done to the layer."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, as_floats, check_positive
from skinfield.fem.trace import Trace
from skinfield.mechanics import Layer


@dataclass(frozen=True, eq=False)
class AxisymmetricSolution:
    """A round body at rest on the layer; pressure and compression are positive.

    Attributes
    ----------
    layer : Layer
    force : float, N
        Into the layer.
    depth : float, m
        Of the body's lowest point below the undeformed surface.
    surface : Trace
        Radii (n,) m of the nodes of the surface and of the base before the press.
    nodal_displacement : (n, 2) array, m
        Of the surface, outwards and upwards.
    nodal_force : (n,) array, N
        Into the layer, consistent with the elements.
    nodal_base_stress : (n,) array, Pa
        From the reactions of the base.
    contact : (n,) array of bool
        Nodes that touch.
    large : bool
        Whether surface and pressure belong to the deformed places of the nodes.
    """

    layer: Layer
    force: float
    depth: float
    surface: Trace
    nodal_displacement: Floats
    nodal_force: Floats
    nodal_base_stress: Floats
    contact: NDArray[np.bool_]
    large: bool = False

    @property
    def deformed(self) -> Trace:
        """Radii of the surface's nodes during the press; those before it at small strain."""
        moved = self.nodal_displacement[:, 0] if self.large else 0.0
        return Trace(self.surface.nodes + moved)

    @property
    def contact_radius(self) -> float:
        """Outermost place of touch, m: midway between the last node that does and the next."""
        touching = np.flatnonzero(self.contact)
        if not len(touching):
            return 0.0
        nodes, last = self.deformed.nodes, touching[-1]
        return float((nodes[last] + nodes[last + 1]) / 2)

    def pressure(self, radius: ArrayLike) -> Floats:
        """Contact pressure (N,) Pa at radii (N,) m of the deformed surface; zero outside."""
        at, nodes = as_floats("radius", radius), self.deformed
        touched = self._span(at)
        return np.where(touched, nodes.at(self._nodal_pressure(), at), 0.0)

    def displacement(self, radius: ArrayLike) -> Floats:
        """Displacement (N, 2) m, outwards and upwards, of points first at radii (N,) m."""
        at = as_floats("radius", radius)
        parts = [self.surface.at(column, at) for column in self.nodal_displacement.T]
        return np.stack(parts, axis=-1)

    def indentation(self, radius: ArrayLike) -> Floats:
        """Depth (N,) m of the deformed surface at the radii (N,) m."""
        return -self.deformed.at(self.nodal_displacement[:, 1], as_floats("radius", radius))

    def base_stress(self, radius: ArrayLike) -> Floats:
        """Normal stress (N,) Pa on the base at radii (N,) m."""
        return self.surface.at(self.nodal_base_stress, as_floats("radius", radius))

    def pad_stress(self, distance: ArrayLike, pad_diameter: float) -> Floats:
        """Mean normal stress (N,) Pa below round pads at distances (N,) m from the axis."""
        check_positive("pad_diameter", pad_diameter, "of the electrode, in metres")
        return disc_mean(self.base_stress, as_floats("distance", distance), pad_diameter)

    def _nodal_pressure(self) -> Floats:
        return self.deformed.density(self.nodal_force)

    def _span(self, at: Floats) -> NDArray[np.bool_]:
        """Whether a radius lies in an element that touches at one end or in the middle."""
        touched = self.contact[:-2:2] | self.contact[1::2] | self.contact[2::2]
        corners = self.deformed.nodes[::2]
        element = np.clip(np.searchsorted(corners, at, "right") - 1, 0, len(touched) - 1)
        return touched[element]


def disc_mean(function: Callable[[Floats], Floats], distance: Floats, diameter: float) -> Floats:
    """Mean of a function of the radius over discs whose centres are at distances (N,) m."""
    points, weights = np.polynomial.legendre.leggauss(24)
    radius = diameter / 4 * (points + 1)
    angle = (np.arange(48) + 0.5) * np.pi / 48
    weight = (weights * radius)[:, None] * np.ones(48)
    along = distance[:, None, None] + radius[:, None] * np.cos(angle)
    across = radius[:, None] * np.sin(angle)
    values = function(np.hypot(along, across))
    return np.asarray((values * weight).sum(axis=(1, 2)) / weight.sum())
