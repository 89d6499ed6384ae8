"""A tube that stands on its end, or the lower half of an O-ring."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.simulate.indenters.cylinder import Cylinder
from skinfield.simulate.indenters.rounded import Rounded

CLOSE = 1e-12
"""Metres from the rim at which a line has reached it."""
NEAR = 1e-9
"""Metres from the rim at which a line that skims it is taken to have reached it."""


@dataclass(frozen=True, kw_only=True)
class Ring(Rounded):
    """A tube that stands on its end; tilted, it touches with its outer rim.

    Parameters
    ----------
    inner_radius, outer_radius : float, m
        Of the tube, rounded edges included.
    edge_radius : float, m
        Of its edges; at half of the wall's thickness the ring is round like an O-ring.
    position, rotation, tilt, force, depth, shear
        See `Rounded` and `Body`. Its reference point is the middle of its face.
    """

    inner_radius: float
    outer_radius: float
    kind: ClassVar[str] = "ring"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("inner_radius", self.inner_radius, "of the ring, in metres")
        check_positive("outer_radius", self.outer_radius, "of the ring, in metres")
        if self.outer_radius <= self.inner_radius:
            raise InputError(
                f"outer_radius is {self.outer_radius!r}, expected more than the inner_radius "
                f"{self.inner_radius!r}: the wall of the ring lies between them"
            )
        self.check_edge((self.outer_radius - self.inner_radius) / 2)

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        least, most = self.inner_radius + self.edge_radius, self.outer_radius - self.edge_radius
        from_axis = np.hypot(points[:, 0], points[:, 1])
        wanted = np.clip(from_axis, least, most)
        scale = wanted / np.maximum(from_axis, 1e-300)
        found = points * scale[:, None]
        found[from_axis == 0.0, 0] = least  # on the axis every direction is as near
        found[:, 2] = np.maximum(points[:, 2], self.edge_radius)
        return found

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        lean = float(np.hypot(up[0], up[1]))
        outward = (self.outer_radius - self.edge_radius) / lean if lean > 0.0 else 0.0
        return np.array([-up[0] * outward, -up[1] * outward, self.edge_radius])

    def climb(self, starts: Floats, up: Floats) -> Floats:
        """See `Rounded.climb`: as for a filled cylinder, and on from the mouth of the hole."""
        lid = Cylinder(radius=self.outer_radius, edge_radius=self.edge_radius)
        way = lid.climb(starts, up)
        hit = np.flatnonzero(np.isfinite(way))
        points = starts[hit] + way[hit, None] * up
        mouth = np.hypot(points[:, 0], points[:, 1]) < self.inner_radius + self.edge_radius
        hit, points = hit[mouth], points[mouth]
        way[hit] += self._up_the_hole(points, up)
        return way

    def _up_the_hole(self, points: Floats, up: Floats) -> Floats:
        """Way (K,) from points in the mouth to the rim or wall of the hole; infinite past it.

        To the rim, which is not convex, by steps as long as the distance; to the wall in closed
        form.
        """
        rising = np.zeros(len(points))
        for _ in range(200):
            places = points + rising[:, None] * up
            apart = places - self.nearest(places)
            distance = np.sqrt(np.einsum("ki,ki->k", apart, apart)) - self.edge_radius
            step = np.where(places[:, 2] < self.edge_radius, distance, 0.0)
            if step.max(initial=0.0) < CLOSE:
                break
            rising += step
        to_wall = _way_out(places, up, self.inner_radius)
        return np.where(distance < NEAR, rising, rising + to_wall)


def _way_out(points: Floats, up: Floats, radius: float) -> Floats:
    """Way (K,) along `up` out of a cylinder about z that holds the points; infinite if upright."""
    lean = float(up[0] ** 2 + up[1] ** 2)
    if lean == 0.0:
        return np.full(len(points), np.inf)
    along = points[:, :2] @ up[:2] / lean
    inside = np.maximum(radius**2 - points[:, 0] ** 2 - points[:, 1] ** 2, 0.0) / lean
    return np.asarray(np.sqrt(along**2 + inside) - along)
