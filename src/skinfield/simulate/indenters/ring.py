"""A tube that stands on its end, or the lower half of an O-ring."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.simulate.indenters.rounded import Rounded

CLOSE = 1e-11
"""Metres from the surface at which a line is straight enough for one last Newton step."""


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
        """See `Rounded.climb`; by steps as long as the distance, as a ring is not convex."""
        way = np.full(len(starts), np.inf)
        rising = np.zeros(len(starts))
        todo = np.arange(len(starts))
        for _ in range(500):
            points = starts[todo] + rising[todo, None] * up
            apart = points - self.nearest(points)
            far = np.sqrt(np.einsum("ki,ki->k", apart, apart))
            distance = far - self.edge_radius
            there = distance <= CLOSE
            slope = np.minimum(apart @ up / np.maximum(far, 1e-300), -1e-3)
            last = np.where(distance > 0.0, -distance / slope, 0.0)
            way[todo[there]] = (rising[todo] + last)[there]
            going = ~there & (rising[todo] < 4 * self.outer_radius)
            todo = todo[going]
            if not len(todo):
                break
            rising[todo] += distance[going]
        return way
