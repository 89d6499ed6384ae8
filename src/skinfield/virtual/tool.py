"""Bodies that press a virtual skin: round ones, so that one table over the distance holds each."""

from dataclasses import dataclass
from typing import Any

from skinfield.errors import check_choice, check_positive, check_range
from skinfield.simulate import Cylinder, Sphere

SHAPES = ("ball", "flat")
FINGER = 10e-3  # m: about that of a fingertip
EDGE = 0.5e-3  # m: rounding of a flat end, at most
LARGEST = 30e-3  # m
STEP = 0.1e-3  # m: radii are rounded to it, so that a dragged slider makes no thousand tables


@dataclass(frozen=True)
class Tool:
    """What presses.

    Parameters
    ----------
    radius : float, m
        0.5 to 30 mm; rounded to 0.1 mm. The default is about a fingertip's.
    shape : "ball" or "flat"
        A sphere, or the flat end of a cylinder with a rounded edge.
    """

    radius: float = FINGER
    shape: str = "ball"

    def __post_init__(self) -> None:
        check_choice("shape", self.shape, SHAPES, "what presses")
        check_positive("radius", self.radius, "of the body, in metres: 4 mm is 4e-3")
        check_range("radius", self.radius, 0.5e-3, LARGEST, "of the body, in metres")
        object.__setattr__(self, "radius", round(round(float(self.radius) / STEP) * STEP, 6))

    def body(self, **load: float) -> Any:
        """As an indenter of `skinfield.simulate`, with a `force` or a `depth`."""
        if self.shape == "ball":
            return Sphere(radius=self.radius, **load)  # type: ignore[arg-type]
        edge = min(EDGE, self.radius / 2.0)
        return Cylinder(radius=self.radius, edge_radius=edge, **load)  # type: ignore[arg-type]
