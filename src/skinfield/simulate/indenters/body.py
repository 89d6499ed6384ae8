"""What all rigid bodies share: where they are, how they lean and how they are pushed."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)

STEEPEST = np.radians(80.0)


@dataclass(frozen=True, kw_only=True)
class Body:
    """Pose and load of a rigid body; shapes add their own sizes and `height`.

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
        """See `Indenter.lowest`."""
        return self.position

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
