"""Rigid bodies: pose and load, sharp and rounded edges."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)

STEEPEST = np.radians(80.0)


@dataclass(frozen=True, kw_only=True)
class Indenter(ABC):
    """A rigid body above the skin, pushed down by a force or to a depth.

    The body is tilted about its reference point, then turned about the skin's normal, then carried
    to its position. As the skin is the same everywhere, position and rotation only move the whole
    press in the plane. Shapes add their own sizes, `height`, and `kind`: what they are, in words.

    Parameters
    ----------
    position : (x, y), m
        Of its reference point, the middle of its face, in the plane.
    rotation : float, rad
        Of the tilted body about the skin's outward normal.
    tilt : (about x, about y), rad
        Rotation vector about the body's own axes through its reference point, up to 80 degrees.
    force : float, optional, N
        Into the skin. 1 N where neither force nor depth is given.
    depth : float, optional, m
        Of its lowest point below the undeformed surface, in place of the force.
    shear : (x, y), N
        Tangential force on the skin, along the axes of the plane.

    Raises
    ------
    InputError
        For a value that is out of range, or for both a force and a depth.
    """

    kind: ClassVar[str]
    position: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    force: float | None = None
    depth: float | None = None
    shear: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        pairs = {
            "position": (self.position, "x and y in metres"),
            "tilt": (self.tilt, "rotation about x and about y in radians"),
            "shear": (self.shear, "tangential force along x and y in newtons"),
        }
        for name, (pair, why) in pairs.items():
            values = as_floats(name, pair)
            check_shape(name, values, (2,), why)
            check_finite(name, values, why)
            object.__setattr__(self, name, (float(values[0]), float(values[1])))
        check_finite("rotation", as_floats("rotation", [self.rotation]), "an angle in radians")
        if np.hypot(*self.tilt) > STEEPEST:
            raise InputError(
                f"tilt is {self.tilt} rad, expected an angle of at most "
                f"{STEEPEST:.3g} rad (80 degrees): a body that lies on its side is another shape"
            )
        if self.force is not None and self.depth is not None:
            raise InputError(
                f"force is {self.force!r} and depth is {self.depth!r}, expected one of the two "
                "and None for the other, which follows from it"
            )
        if self.depth is not None:
            check_positive("depth", self.depth, "of the lowest point below the surface, in metres")
        elif self.force is None:
            object.__setattr__(self, "force", 1.0)
        else:
            check_positive("force", self.force, "into the skin, in newtons")

    @property
    def lowest(self) -> tuple[float, float]:
        """Where its lowest point is in the plane, m; the middle of a face or edge that is level."""
        return self.position

    @abstractmethod
    def height(self, x: Floats, y: Floats) -> Floats:
        """Height of its lower surface above its lowest point, m; infinite where it is not."""

    def own_plane(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Places of the plane as seen from the reference point along the turned x and y, m."""
        right, ahead = x - self.position[0], y - self.position[1]
        cos, sin = np.cos(self.rotation), np.sin(self.rotation)
        return cos * right + sin * ahead, cos * ahead - sin * right

    def place(self, right: float, ahead: float) -> tuple[float, float]:
        """Place in the plane, m, of a point that `own_plane` sees at (right, ahead)."""
        cos, sin = np.cos(self.rotation), np.sin(self.rotation)
        return (
            float(self.position[0] + cos * right - sin * ahead),
            float(self.position[1] + sin * right + cos * ahead),
        )

    def own_from_body(self) -> Floats:
        """Rotation matrix (3, 3) of the tilt, by Rodrigues' formula."""
        angle = float(np.hypot(*self.tilt))
        if angle == 0.0:
            return np.eye(3)
        x, y = self.tilt[0] / angle, self.tilt[1] / angle
        cross = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
        return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


TOUCH = 1e-15
"""Metres within which a line counts as touching: rounding, and no more."""


@dataclass(frozen=True, kw_only=True)
class Rounded(Indenter):
    """A rigid body with edges of one radius.

    Parameters
    ----------
    edge_radius : float, m
        Of its edges; 0 for sharp ones.
    position, rotation, tilt, force, depth, shear
        See `Indenter`.
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
