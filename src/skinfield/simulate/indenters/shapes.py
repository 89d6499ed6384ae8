"""Shapes of indenters: ball, flat cylinder, cone, wedge, bar, rod, ring."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.simulate.indenters.body import Indenter, Rounded

Profile = tuple[float, float, float]  # half width, height of the tip, rise of the flank per width


def check_half_angle(half_angle: float, shape: str) -> None:
    """Raise InputError unless the angle from axis to flank is between 0 and 90 degrees."""
    if not 0.0 < half_angle < np.pi / 2:
        raise InputError(
            f"half_angle is {half_angle!r} rad, expected more than 0 and less than pi/2: between "
            f"the axis and the flank of the {shape}; a flat face is another shape"
        )


def nearest_in_profile(
    across: Floats, along: Floats, half_width: float, tip: float, rise: float
) -> tuple[Floats, Floats]:
    """Nearest points of {0 <= r <= half_width, z >= tip + rise r} to (r, z), r >= 0; all in m."""
    shoulder = tip + rise * half_width
    length = np.hypot(half_width, rise * half_width)
    share = (across * half_width + (along - tip) * rise * half_width) / max(length**2, 1e-300)
    share = np.clip(share, 0.0, 1.0)
    flank = share * half_width, tip + share * (shoulder - tip)
    wall = np.full_like(across, half_width), np.maximum(along, shoulder)
    to_flank = np.hypot(across - flank[0], along - flank[1])
    to_wall = np.hypot(across - wall[0], along - wall[1])
    at_wall = (to_wall < to_flank) & (across > half_width)
    inside = (across <= half_width) & (along >= tip + rise * across)
    return (
        np.where(inside, across, np.where(at_wall, wall[0], flank[0])),
        np.where(inside, along, np.where(at_wall, wall[1], flank[1])),
    )


def lowest_of_profile(
    sideways: float, up: float, half_width: float, tip: float, rise: float
) -> tuple[float, float]:
    """Point (r, z) of that profile, r of either sign, lowest along the direction (sideways, up)."""
    shoulder = tip + rise * half_width
    if up * shoulder - abs(sideways) * half_width < up * tip:
        return -float(np.sign(sideways)) * half_width, shoulder
    return 0.0, tip


@dataclass(frozen=True, kw_only=True)
class Sphere(Indenter):
    """A ball, or the half-sphere of the paper. It is the same however it is turned or tilted.

    Parameters
    ----------
    radius : float, m
    position : (x, y), m
        Of its centre in the plane.
    rotation, tilt, force, depth, shear
        See `Indenter`.
    """

    radius: float
    kind: ClassVar[str] = "ball"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the sphere, in metres")

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        square = (x - self.position[0]) ** 2 + (y - self.position[1]) ** 2
        below = np.sqrt(np.maximum(self.radius**2 - square, 0.0))
        return np.where(square < self.radius**2, self.radius - below, np.inf)


class _Round(Rounded):
    """A body of revolution about its z."""

    @property
    @abstractmethod
    def _profile(self) -> Profile:
        """Of the core, as `nearest_in_profile` has it."""

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        from_axis = np.hypot(points[:, 0], points[:, 1])
        across, along = nearest_in_profile(from_axis, points[:, 2], *self._profile)
        inward = across / np.maximum(from_axis, 1e-300)
        return np.stack([points[:, 0] * inward, points[:, 1] * inward, along], axis=1)

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        lean = float(np.hypot(up[0], up[1]))
        across, along = lowest_of_profile(lean, float(up[2]), *self._profile)
        outward = up[:2] / lean if lean > 0.0 else np.zeros(2)
        return np.array([*(across * outward), along])


@dataclass(frozen=True, kw_only=True)
class _Long(Rounded):
    """A body with one profile across its length, cut off upright at both ends."""

    length: float
    width: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("length", self.length, f"of the {self.kind} along its x, in metres")
        check_positive("width", self.width, f"of the {self.kind} across, in metres")
        self.check_edge(min(self.length, self.width) / 2)

    @property
    def _profile(self) -> Profile:
        return self.width / 2 - self.edge_radius, self.edge_radius, 0.0

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        across, up = nearest_in_profile(np.abs(points[:, 1]), points[:, 2], *self._profile)
        end = self.length / 2 - self.edge_radius
        along = np.clip(points[:, 0], -end, end)
        return np.stack([along, np.copysign(across, points[:, 1]), up], axis=1)

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        across, above = lowest_of_profile(float(up[1]), float(up[2]), *self._profile)
        end = self.length / 2 - self.edge_radius
        return np.array([-np.sign(up[0]) * end, across, above])


@dataclass(frozen=True, kw_only=True)
class Cylinder(_Round):
    """A flat-ended cylinder; tilted, it touches with its rim.

    Parameters
    ----------
    radius : float, m
        Of the whole cylinder, rounded edge included.
    edge_radius, position, rotation, tilt, force, depth, shear
        See `Rounded` and `Indenter`. Its reference point is the middle of its face.
    """

    radius: float
    kind: ClassVar[str] = "flat cylinder"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the cylinder, in metres")
        self.check_edge(self.radius)

    @property
    def _profile(self) -> Profile:
        return self.radius - self.edge_radius, self.edge_radius, 0.0


@dataclass(frozen=True, kw_only=True)
class Cone(_Round):
    """A cone that stands on its point, with a cylinder of the same radius above it.

    Parameters
    ----------
    half_angle : float, rad
        Between its axis and its flank; 80 degrees is blunt, 20 degrees is a spike.
    radius : float, m
        Of its base.
    edge_radius : float, m
        Of its tip, which becomes a ball, and of its rim.
    position, rotation, tilt, force, depth, shear
        See `Indenter`. Its reference point is its tip.
    """

    half_angle: float
    radius: float
    kind: ClassVar[str] = "cone"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the cone's base, in metres")
        check_half_angle(self.half_angle, "cone")
        self.check_edge(self.radius)

    @property
    def _profile(self) -> Profile:
        return self.radius - self.edge_radius, self.edge_radius, 1 / np.tan(self.half_angle)


@dataclass(frozen=True, kw_only=True)
class Wedge(_Long):
    """A wedge that stands on its straight edge, which lies along the turned x.

    Parameters
    ----------
    half_angle : float, rad
        Between its middle plane and its flanks.
    length, width : float, m
        Of the edge along x, and of the whole wedge across it.
    edge_radius : float, m
        Of the edge and of its ends.
    position, rotation, tilt, force, depth, shear
        See `Indenter`. Its reference point is the middle of its edge.
    """

    half_angle: float
    kind: ClassVar[str] = "wedge"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_half_angle(self.half_angle, "wedge")

    @property
    def _profile(self) -> Profile:
        half_width, tip, _ = super()._profile
        return half_width, tip, 1 / np.tan(self.half_angle)


@dataclass(frozen=True, kw_only=True)
class Bar(_Long):
    """A bar with a flat rectangular face; tilted, it touches with an edge or a corner.

    Parameters
    ----------
    length, width : float, m
        Of its face along the turned x and y, rounded edges included.
    edge_radius, position, rotation, tilt, force, depth, shear
        See `Rounded` and `Indenter`. Its reference point is the middle of its face.
    """

    kind: ClassVar[str] = "bar"


@dataclass(frozen=True, kw_only=True)
class Rod(Rounded):
    """A round rod that lies along the turned x; tilted about y, it touches with its end.

    Parameters
    ----------
    radius, length : float, m
        Of the rod, rounded ends included.
    edge_radius : float, m
        Of the edges of its ends; as large as `radius`, its ends are half-spheres.
    position, rotation, tilt, force, depth, shear
        See `Indenter`. Its reference point is its lowest point below its middle.
    """

    radius: float
    length: float
    kind: ClassVar[str] = "rod"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("radius", self.radius, "of the rod, in metres")
        check_positive("length", self.length, "of the rod, in metres")
        self.check_edge(min(self.radius, self.length / 2))

    def nearest(self, points: Floats) -> Floats:
        """See `Rounded.nearest`."""
        end, core = self.length / 2 - self.edge_radius, self.radius - self.edge_radius
        sideways, above = points[:, 1], points[:, 2] - self.radius
        inward = np.minimum(1.0, core / np.maximum(np.hypot(sideways, above), 1e-300))
        along = np.clip(points[:, 0], -end, end)
        return np.stack([along, sideways * inward, self.radius + above * inward], axis=1)

    def core_support(self, up: Floats) -> Floats:
        """See `Rounded.core_support`."""
        end, core = self.length / 2 - self.edge_radius, self.radius - self.edge_radius
        around = core * up[1:] / np.hypot(up[1], up[2])
        return np.array([-np.sign(up[0]) * end, -around[0], self.radius - around[1]])


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
        See `Rounded` and `Indenter`. Its reference point is the middle of its face.
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
