"""A truth carried over the skin, which is the same everywhere."""

from dataclasses import dataclass, replace

import numpy as np

from skinfield.errors import Floats, as_floats, check_finite
from skinfield.experiments.cases.truth import TrueContact, Truth
from skinfield.simulate import Press


@dataclass(frozen=True)
class Pose:
    """A turn about the plane's origin, then a shift: x and y in m, the angle in rad."""

    x: float
    y: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        check_finite("pose", as_floats("pose", [self.x, self.y, self.angle]), "m, m and rad")

    @property
    def turn(self) -> Floats:
        """Rotation matrix (2, 2)."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return np.array([[cos, -sin], [sin, cos]])

    def there(self, plane: Floats) -> Floats:
        """Points (N, 2) m carried with the press."""
        return np.asarray(plane @ self.turn.T + [self.x, self.y])

    def back(self, plane: Floats) -> Floats:
        """Points (N, 2) m as the press at the origin sees them."""
        return np.asarray((plane - [self.x, self.y]) @ self.turn)


def posed(truth: Truth, pose: Pose) -> Truth:
    """Truth of the press carried by a pose."""
    displacement = truth.displacement.copy()
    displacement[:, :2] = displacement[:, :2] @ pose.turn.T
    places = pose.there(np.array([c.position for c in truth.contacts]).reshape(-1, 2))
    return replace(
        truth,
        plane=pose.there(truth.plane),
        displacement=displacement,
        contacts=tuple(
            replace(contact, position=(float(x), float(y)))
            for contact, (x, y) in zip(truth.contacts, places, strict=True)
        ),
    )


def contacts_of_press(press: Press) -> tuple[TrueContact, ...]:
    """One contact per indenter that touches, at its centre of pressure."""
    contacts = []
    for index, body in enumerate(press.indenters):
        force = float(press.forces[index])
        if force <= 0.0:
            continue
        about_x, about_y, _ = press.moments[index]  # of a push: (-y, x) times the force
        area = sum(
            float(touch.share[touch.body == index].sum())
            * (press.grid.pitch / touch.window.split) ** 2
            for touch in press.touches
        )
        place = (float(about_y / force), float(-about_x / force))
        contacts.append(TrueContact(place, force, area, body.kind))
    return tuple(contacts)
