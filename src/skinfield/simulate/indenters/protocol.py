"""What the contact solver asks of a rigid body that presses on the skin."""

from typing import Protocol

from skinfield.errors import Floats


class Indenter(Protocol):
    """A rigid body above the skin, pushed down by a force or to a depth.

    Its pose: the body is tilted about its reference point, then turned about the skin's normal,
    then carried to its position. As the skin is the same everywhere, position and rotation only
    move the whole press in the plane.
    """

    @property
    def kind(self) -> str:
        """What it is, in words for tables: "ball"."""
        ...

    @property
    def position(self) -> tuple[float, float]:
        """Its reference point in the plane, m."""
        ...

    @property
    def rotation(self) -> float:
        """Of the tilted body about the skin's outward normal, rad."""
        ...

    @property
    def tilt(self) -> tuple[float, float]:
        """Rotation vector about the body's own x and y, rad: its length is the angle."""
        ...

    @property
    def force(self) -> float | None:
        """Into the skin, N; None where the depth is given. One of the two is given, never both."""
        ...

    @property
    def depth(self) -> float | None:
        """Of its lowest point below the undeformed surface, m; None where the force is given."""
        ...

    @property
    def shear(self) -> tuple[float, float]:
        """Tangential force on the skin along x and y of the plane, N."""
        ...

    @property
    def lowest(self) -> tuple[float, float]:
        """Where its lowest point is in the plane, m; the middle of a face or edge that is level."""
        ...

    def height(self, x: Floats, y: Floats) -> Floats:
        """Height of its lower surface above its lowest point, m; infinite where it is not."""
        ...
