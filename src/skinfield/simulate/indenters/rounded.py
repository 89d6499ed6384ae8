"""Bodies as a core with a skin of constant thickness, so that sharp and rounded are one shape.

A body is all points within `edge_radius` of its core. The core is convex and knows its point that
is nearest to a given one, in closed form; with that a vertical line is followed up to the surface
of the tilted body.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_range
from skinfield.simulate.indenters.body import Body

TOUCH = 1e-15
"""Metres within which a line counts as touching: rounding, and no more."""


@dataclass(frozen=True, kw_only=True)
class Rounded(Body, ABC):
    """A rigid body with edges of one radius.

    Parameters
    ----------
    edge_radius : float, m
        Of its edges; 0 for sharp ones.
    position, rotation, tilt, force, depth, shear
        See `Body`.
    """

    edge_radius: float = 0.0

    def check_edge(self, largest: float) -> None:
        """Raise InputError unless the edges fit a body whose smallest half-width is `largest`."""
        why = "radius of the edges in metres, at most half of the body's width"
        check_range("edge_radius", self.edge_radius, 0.0, largest, why)

    @abstractmethod
    def nearest(self, points: Floats) -> Floats:
        """Points (K, 3) of the core nearest to (K, 3), in the axes of the body, m."""

    @abstractmethod
    def core_support(self, up: Floats) -> Floats:
        """Point (3,) of the core that is lowest along the unit vector `up` (3,), m."""

    @property
    def lowest(self) -> tuple[float, float]:
        """See `Indenter.lowest`."""
        matrix = self.own_from_body()
        right, ahead, _ = matrix @ self.core_support(matrix[2])
        return self.place(right, ahead)

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        right, ahead = self.own_plane(np.asarray(x), np.asarray(y))
        matrix = self.own_from_body()
        up = matrix[2]
        bottom = float(up @ self.core_support(up)) - self.edge_radius
        plane = np.stack([right.ravel(), ahead.ravel(), np.full(right.size, bottom)], axis=1)
        # matrix.T @ point for every point: the body's axes from the upright ones
        return self.climb(plane @ matrix, up).reshape(right.shape)

    def climb(self, starts: Floats, up: Floats) -> Floats:
        """Way (K,) from points below the body along `up` to its surface, m; infinite past it.

        Newton's steps on the distance to the body, which is convex along a line: from below they
        never pass the surface, and a line on which the distance grows will not meet it.
        """
        way = np.full(len(starts), np.inf)
        rising = np.zeros(len(starts))
        todo = np.arange(len(starts))
        for _ in range(100):
            points = starts[todo] + rising[todo, None] * up
            apart = points - self.nearest(points)
            far = np.sqrt(np.einsum("ki,ki->k", apart, apart))
            distance = far - self.edge_radius
            there = distance <= TOUCH
            way[todo[there]] = rising[todo[there]]
            slope = apart @ up / np.maximum(far, TOUCH)
            going = ~there & (slope < -1e-9)
            todo = todo[going]
            if not len(todo):
                break
            rising[todo] -= distance[going] / slope[going]
        way[todo] = rising[todo]
        return way
