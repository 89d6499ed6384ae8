"""Contact: one pressed region, its force, place and their uncertainty."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.estimate.uncertainty import normal_interval, normal_radius
from skinfield.plot import number, plus_minus


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Contact:
    """One pressed region of a patch, in the patch's own frame.

    That of a patch on a robot (`skinfield.load_robot`) is the frame of its link.

    Attributes
    ----------
    position : (3,) array, m
        Centre of pressure, on the skin's undeformed surface.
    force : (3,) array, N
        Resultant of the traction on the skin: it points into the skin in compression.
    moment : (3,) array, N m
        Resultant moment of the traction about `position`, 0: what presses is no torque there.
    normal : (3,) array
        Outward normal of the skin at `position`.
    area : float, m²
        That is pressed.
    peak_pressure : float, Pa
        The highest in the region.
    covariance : (3, 3) array
        Of the place along the surface's two tangents at `position`, m (x and y of a flat patch),
        and of the normal force, N: how sure the solver is of one reading's answer.
    area_std : float, m²
        One standard deviation of `area`; NaN where it is not known, as of a part of a field.
    radius : float, m
        Of the contact, where it is round; else of the circle of equal area.
    shape : "sphere", "flat", "line" or "other"
        What presses, as far as the readings tell: "other" for all that was not fitted.
    outline : (N, 3) array, m
        Border, closed: the last point is the first. That of the ellipse of `axes`; of a line what
        is near to a segment.
    axes : (2,) array, m
        Semi-axes of the ellipse of equal area whose axes are as those of the second moments, the
        longer first.
    angle : float, rad
        From the first tangent of the surface to the longer axis, -pi/2 to pi/2.
    cells : (N,) int array
        Nodes of the grid that make up the region.
    maybe : int
        How many contacts explain the readings nearly as well: 2 in the place of this one, or 1 in
        that of this and the next; 0 where the number is sure. `covariance` is of both cases.
    track_id : int or None
        The same for one contact as long as it lasts; given by a `Tracker`.
    force_covariance : (3, 3) array, N²
        Of the force in the patch's frame. Along the skin it is as wide as before any reading where
        these told of no force there; NaN of contacts that were found in a field.
    tangents : (3, 2) array
        Unit vectors along the skin at `position`, to which `covariance` refers. Default x along
        the skin, and what is across it.
    link : str
        Name of the robot's link that carries the patch; "" where it has none.
    """

    position: Floats
    force: Floats
    moment: Floats
    normal: Floats
    area: float
    peak_pressure: float
    covariance: Floats
    area_std: float
    radius: float
    shape: str
    outline: Floats
    axes: Floats
    angle: float
    cells: NDArray[np.int64]
    maybe: int = field(default_factory=lambda: 0)  # what `later` has not may come
    track_id: int | None = field(default_factory=lambda: None)
    force_covariance: Floats = field(default_factory=lambda: np.full((3, 3), np.nan))
    tangents: Floats = field(default_factory=lambda: np.empty((3, 0)))
    link: str = field(default_factory=str)

    def __post_init__(self) -> None:
        if not np.size(self.tangents):
            self.__dict__["tangents"] = tangents_at(self.normal)

    @classmethod
    def later(cls, rest: Any, /, **known: Any) -> Self:
        """Contact of which some attributes are worked out when they are first asked for.

        Parameters
        ----------
        rest : object
            Whose attributes of the same names are asked for the missing ones, once each; another
            contact will do.
        **known
            Attributes that are known.

        Raises
        ------
        InputError
            For a name that is none of the attributes.
        """
        if not known.keys() <= cls.__dataclass_fields__.keys():
            wrong = sorted(known.keys() - cls.__dataclass_fields__.keys())
            raise InputError(f"{cls.__name__} has no {', '.join(wrong)}: expected its attributes")
        contact = object.__new__(cls)
        contact.__dict__.update(known, _rest=rest)
        return contact

    if not TYPE_CHECKING:  # a type checker shall find misspelt attributes

        def __getattr__(self, name: str) -> Any:
            if name not in type(self).__dataclass_fields__ or "_rest" not in self.__dict__:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            value = self.__dict__[name] = getattr(self.__dict__["_rest"], name)
            return value

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.__dataclass_fields__})

    def __repr__(self) -> str:
        place, force, area = self._words()
        track = "" if self.track_id is None else f", track {self.track_id}"
        return f"{type(self).__name__}({force} N at ({place}) mm, {area} mm², {self.shape}{track})"

    def _words(self) -> tuple[str, str, str]:
        """Place in mm, force in N ± one standard deviation, area in mm²."""
        place = ", ".join(f"{x * 1e3:.1f}" for x in self.position).replace("-", "−")
        return place, plus_minus(self.normal_force, self.force_std), number(self.area * 1e6)

    def __getstate__(self) -> dict[str, Any]:
        """All attributes, for pickles and copies: what they are worked out from stays behind."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def moved(self, pose: Floats) -> "Contact":
        """The same in another frame, by the pose (4, 4) m of its own in it.

        `link`, and whatever does not depend on the frame, stay.
        """
        turn, shift = pose[:3, :3], pose[:3, 3]
        return type(self).later(
            self,
            position=turn @ self.position + shift,
            **{name: turn @ getattr(self, name) for name in ("force", "moment", "normal")},
            tangents=turn @ self.tangents,
            force_covariance=turn @ self.force_covariance @ turn.T,
            outline=self.outline @ turn.T + shift,
        )

    @property
    def normal_force(self) -> float:
        """Force into the skin along its normal, N; positive in compression."""
        return float(-self.force @ self.normal)

    @property
    def shear(self) -> Floats:
        """Force onto the skin along it, (3,) N in the patch's frame; 0 where none is known."""
        return np.asarray(self.force + self.normal_force * self.normal)

    @property
    def force_std(self) -> float:
        """One standard deviation of the normal force, N."""
        return float(np.sqrt(self.covariance[2, 2]))

    @property
    def place_std(self) -> float:
        """Root of the summed variances of the place along both tangents, m."""
        return float(np.sqrt(self.covariance[0, 0] + self.covariance[1, 1]))

    def force_interval(self, level: float = 0.9) -> tuple[float, float]:
        """Interval (N, N) that holds the true normal force with probability `level`."""
        return normal_interval(self.normal_force, self.force_std, level)

    def area_interval(self, level: float = 0.9) -> tuple[float, float]:
        """Interval (m², m²) that holds the true area with probability `level`."""
        return normal_interval(self.area, self.area_std, level)

    def place_radius(self, level: float = 0.9) -> float:
        """Radius, m, of the circle about `position` that holds the true one so often."""
        return normal_radius(self.covariance[:2, :2], level)


def tangents_at(normal: Floats) -> Floats:
    """Unit vectors (3, 2) along a surface: x turned onto it, or y where that is its normal."""
    axis = np.eye(3)[int(abs(normal[0]) > 0.9)]
    east = axis - (axis @ normal) * normal
    return np.asarray(np.stack([east, np.cross(normal, east)], axis=1) / np.linalg.norm(east))
