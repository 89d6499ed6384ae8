"""Soft finger: a body that yields far more than the skin, known by the pressure below it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, InputError, check_positive, check_range
from skinfield.simulate.indenters.body import Indenter

MOST_GROWTH = 1.0 / 3.0
FINE = (np.arange(5) - 2.0) / 5.0  # of a square, along each side: points that stand for it


@dataclass(frozen=True, kw_only=True)
class Finger(Indenter):
    """A soft finger, round, oval, or with two lobes as of two phalanges that lie flat.

    The skin below it is taken for stiff: the pressure is the finger's, and the skin yields to it.

    Parameters
    ----------
    width, length : float, m
        Of the contact of a lobe with 1 N, across the finger and along its x. Default a round one.
    second : float
        Part of the force that a second lobe takes, as large as the first. 0: there is none.
    apart : float, m
        Between the middles of two lobes, along x.
    growth : float
        Exponent γ by which width and length grow with the force, F^γ.
    position, rotation, force
        See `Indenter`; the position is the centre of pressure. It has no depth, tilt or shear.

    Notes
    -----
    The power law a = c F^γ with γ from 0 to 1/3, Hertz's, is that of Xydas and Kao, Int. J.
    Robotics Research 18(9), 1999; of their family of pressures it is the one with the exponent 2,
    over an ellipse: p = 3F/(2πab) √(1 - ρ²).
    """

    width: float = 9e-3
    length: float | None = None
    second: float = 0.0
    apart: float = 0.0
    growth: float = 0.2
    kind: ClassVar[str] = "finger"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.length is None:
            object.__setattr__(self, "length", self.width)
        for name in ("width", "length"):
            check_positive(name, getattr(self, name), "of the contact with 1 N, in metres")
        check_range("second", self.second, 0.0, 0.5, "part of the force; 0 is one lobe")
        check_range("apart", self.apart, 0.0, 1.0, "between two lobes, in metres")
        check_range("growth", self.growth, 0.0, MOST_GROWTH, "exponent of the force")
        if self.force is None or any(self.tilt) or any(self.shear):
            raise InputError(
                "a finger has a depth, tilt or shear, expected a force alone: it is known by its "
                "pressure"
            )

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`: a soft body has no shape of its own; infinite."""
        return np.full(np.broadcast_shapes(x.shape, y.shape), np.inf)

    @property
    def shares(self) -> tuple[float, ...]:
        """Of the force, by lobe."""
        return (1.0 - self.second, self.second) if self.second else (1.0,)

    @property
    def along(self) -> tuple[float, ...]:
        """Where the middle of each lobe is along x from the centre of pressure, m."""
        near, far = -self.second * self.apart, (1.0 - self.second) * self.apart
        return (near, far) if self.second else (0.0,)

    @property
    def middles(self) -> Floats:
        """Of its lobes, (N, 2) m in the plane."""
        return np.array([self.place(x, 0.0) for x in self.along])

    @property
    def reach(self) -> float:
        """Farthest that it can touch from its position, m."""
        return float(max(map(abs, self.along)) + self._axes.max())

    @property
    def _axes(self) -> Floats:
        """Half the length and half the width (2,) m of a lobe."""
        grown = float(self.force or 0.0) ** self.growth
        return np.asarray(np.array([self.length, self.width], np.float64) * (grown / 2.0))

    def pressure(self, x: Floats, y: Floats, side: float) -> tuple[Floats, Floats]:
        """Mean pressure, Pa, and touched part of squares around (rows, columns) places, m.

        The pressure sums to the force.
        """
        total, touched = np.zeros(x.shape), np.zeros(x.shape)
        for middle, part in zip(self.along, self.shares, strict=True):
            share, inside = np.zeros(x.shape), np.zeros(x.shape)
            for dx in FINE * side:
                for dy in FINE * side:
                    right, ahead = self.own_plane(x + dx, y + dy)
                    square = ((right - middle) / self._axes[0]) ** 2 + (ahead / self._axes[1]) ** 2
                    share += np.sqrt(np.maximum(1.0 - square, 0.0))
                    inside += square < 1.0
            if not share.any():
                raise InputError(
                    f"a finger at {self.position} m touches none of the skin around the origin, "
                    "expected it there: raise extent, or move it in"
                )
            total += share * (part * float(self.force or 0.0) / (share.sum() * side**2))
            touched = np.maximum(touched, inside / FINE.size**2)
        return total, touched
