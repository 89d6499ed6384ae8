"""Shapes of skin, ways from its plane back into space: plane, sphere, cylinder, and quadrics."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.skin.geometry import flat_frame, flat_frames, mean_normal

BLENDED = 8  # quadrics around a point that have a say in it
FLEX = 2.5  # pitches from its taxel up to which a quadric bends; beyond, it runs on straight
TRUST = 0.25  # weight of a normal against that of a position, both in pitches
RIDGE = 1e-3  # holds the terms that the neighbours leave open: isometric, and without curvature


@dataclass(frozen=True, eq=False)
class Flat:
    """A rigid plane in space: a point (3,) m of it and an orthonormal frame (3, 3)."""

    origin: Floats
    frame: Floats

    def positions(self, points: Floats) -> Floats:
        """Points of the plane (N, 2) m in space (N, 3) m."""
        return np.asarray(self.origin + points @ self.frame[:, :2].T, dtype=np.float64)

    def frames(self, points: Floats) -> Floats:
        """The frame at each point, (N, 3, 3)."""
        return np.broadcast_to(self.frame, (len(points), 3, 3))


@dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere in Lambert's azimuthal equal-area plane [1]_, whose middle is its third axis.

    A place at the angle θ from the middle lies 2 R sin(θ/2) from it in the plane, so that every
    part of the plane has its true area, out to 2 R, the point opposite.

    Parameters
    ----------
    centre : (3,) array, m
    frame : (3, 3) array
        The plane's axes, and the normal at the middle, as columns.
    radius : float, m

    References
    ----------
    .. [1] J. P. Snyder, Map Projections: A Working Manual, USGS Professional Paper 1395, 1987.
    """

    centre: Floats
    frame: Floats
    radius: float

    def plane(self, positions: Floats) -> Floats:
        """Points of the sphere (N, 3) m in the plane (N, 2) m."""
        unit = (positions - self.centre) @ self.frame
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        stretch = np.sqrt(2.0 / np.maximum(1.0 + unit[:, 2:], 1e-12))
        return np.asarray(self.radius * stretch * unit[:, :2] + self.centre @ self.frame[:, :2])

    def _polar(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Sine of θ/2 (N,), and directions (N, 2) from the middle, of points of the plane."""
        offset = points - self.centre @ self.frame[:, :2]
        away = np.linalg.norm(offset, axis=1)
        outwards = np.where(away[:, None] > 0.0, offset / np.maximum(away, 1e-30)[:, None], [1, 0])
        sine = np.minimum(away / (2 * self.radius), 1.0)
        return sine, np.sqrt(1.0 - sine**2), outwards

    def positions(self, points: Floats) -> Floats:
        """See `Flat.positions`; beyond 2 R, the point opposite to the middle."""
        return np.asarray(self.centre + self.radius * self.frames(points)[:, :, 2])

    def frames(self, points: Floats) -> Floats:
        """See `Flat.frames`: the frame of the middle, turned along the great circle."""
        sine, cosine, outwards = self._polar(points)
        x, y = outwards.T
        up, along = 1.0 - 2.0 * sine**2, 2.0 * sine * cosine  # cos θ and sin θ
        rows = [
            [up * x**2 + y**2, (up - 1.0) * x * y, along * x],
            [(up - 1.0) * x * y, up * y**2 + x**2, along * y],
            [-along * x, -along * y, up],
        ]
        return np.asarray(np.einsum("ij,jkn->nik", self.frame, np.array(rows)))

    def held(self, points: Floats, side: float) -> Floats:
        """See `Surface.held`."""
        away = np.linalg.norm(points - self.centre @ self.frame[:, :2], axis=1)
        return np.asarray(np.clip((2 * self.radius - away) / side + 0.5, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder unrolled from a line along its axis, and cut opposite to it.

    Parameters
    ----------
    point : (3,) array, m
        Of the axis.
    frame : (3, 3) array
        As columns, the direction around, the axis, and the normal at the line.
    radius : float, m
    view : (3, 2) array
        The plane's axes; they lie across the normal.
    """

    point: Floats
    frame: Floats
    radius: float
    view: Floats

    def plane(self, positions: Floats) -> Floats:
        """Points of the cylinder (N, 3) m in the plane (N, 2) m."""
        around, along, up = ((positions - self.point) @ self.frame).T
        flat = np.column_stack([self.radius * np.arctan2(around, up), along])
        return np.asarray(flat @ self._turn + self.point @ self.view)

    @property
    def _turn(self) -> Floats:
        """Axes of the plane (2, 2) in the directions around and along."""
        return np.asarray(self.frame[:, :2].T @ self.view)

    def _unrolled(self, points: Floats) -> tuple[Floats, Floats]:
        """Angle from the line (N,) and place along the axis (N,) m of points of the plane."""
        flat = (points - self.point @ self.view) @ self._turn.T
        return flat[:, 0] / self.radius, flat[:, 1]

    def positions(self, points: Floats) -> Floats:
        """See `Flat.positions`; beyond the cut it goes around once more."""
        angle, along = self._unrolled(points)
        local = np.column_stack([self.radius * np.sin(angle), along, self.radius * np.cos(angle)])
        return np.asarray(self.point + local @ self.frame.T)

    def frames(self, points: Floats) -> Floats:
        """See `Flat.frames`."""
        angle = self._unrolled(points)[0]
        c, s, nil = np.cos(angle), np.sin(angle), np.zeros_like(angle)
        turn = np.array([[c, nil, s], [nil, nil + 1.0, nil], [-s, nil, c]])
        local = np.eye(3)
        local[:2, :2] = self._turn
        return np.asarray(np.einsum("ij,jkn,kl->nil", self.frame, turn, local))

    def held(self, points: Floats, side: float) -> Floats:
        """See `Surface.held`."""
        width = side * float(np.abs(self._turn[0]).sum())  # of a cell, around
        before = (np.pi - np.abs(self._unrolled(points)[0])) * self.radius
        return np.asarray(np.clip(before / width + 0.5, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Quadrics:
    """One osculating quadric per taxel, x(δ) = p + A δ + B [δ₁²/2, δ₁δ₂, δ₂²/2].

    Here δ is the offset in the developed plane from the taxel. The quadrics are blended by
    modified Shepard weights, so that the skin is smooth and goes through every taxel [1]_.

    Parameters
    ----------
    parts : tuple of six arrays
        Of the M taxels: distinct places in the plane (M, 2) m, positions (M, 3) m, unit normals
        (M, 3), A (M, 3, 2), B (M, 3, 3) 1/m, and the change of the normal with δ (M, 3, 2) 1/m.
    pitch : float, m
        Between neighbours.

    References
    ----------
    .. [1] R. Franke and G. Nielson, "Smooth interpolation of large sets of scattered data",
       Int. J. Numer. Methods Eng. 15, 1980.
    """

    parts: tuple[Floats, ...]
    pitch: float

    def positions(self, points: Floats) -> Floats:
        """Points of the plane (N, 2) m in space (N, 3) m."""
        return self._at(points)[0]

    def frames(self, points: Floats) -> Floats:
        """Tangent, tangent and outward normal (N, 3, 3) at points of the plane (N, 2) m."""
        return self._at(points)[1]

    def _at(self, points: Floats) -> tuple[Floats, Floats]:
        from skinfield.skin.quadrics_kernel import places_and_frames

        return places_and_frames(_plain(points), self.parts, BLENDED, FLEX * self.pitch)


Shape = Flat | Sphere | Cylinder | Quadrics


FEWEST = 6  # taxels that tell a sphere or a cylinder
EXACT = 1e-6  # of the radius: how far they may be from it
UPRIGHT = np.cos(np.radians(25.0))  # normals that nobody gave are estimates
WHOLE = np.cos(np.radians(110.0))  # a sphere farther from its middle is stretched too much


def round_through(points: Floats, normals: Floats) -> Sphere | Cylinder | None:
    """The sphere or cylinder on whose outside points (M, 3) m lie, if they lie on one.

    Two rings of points about an axis lie on both: that is taken whose normals agree better.
    """
    ball, lean = None, 0.0
    if len(points) < FEWEST:
        return None
    middle, flat = _centre(points)
    if middle is not None and flat:
        upright, radius = _directions(points - middle)
        front = mean_normal(upright)
        if _fits(upright, radius, normals) and (upright @ front).min() >= WHOLE:
            ball = Sphere(middle, flat_frame(front), float(radius.mean()))
            lean = np.sum(upright * normals, axis=1).mean()
    axis = np.linalg.svd(normals)[2][2]
    sides = flat_frame(axis)[:, :2]
    foot, flat = _centre(points @ sides)
    if foot is None or not flat or np.ptp(points @ axis) < EXACT:
        return ball
    point = sides @ foot
    across = points - point
    upright, radius = _directions(across - np.outer(across @ axis, axis))
    if not _fits(upright, radius, normals):
        return ball
    if ball is not None and lean >= np.sum(upright * normals, axis=1).mean():
        return ball
    front = _opposite_to_the_widest_gap(upright, sides)
    frame = np.column_stack([np.cross(axis, front), axis, front])
    return Cylinder(point, frame, float(radius.mean()), flat_frame(front)[:, :2])


def _centre(points: Floats) -> tuple[Floats | None, bool]:
    """Centre of the circle or sphere through points (M, 2 or 3), and whether they tell it."""
    middle = points.mean(axis=0)
    offset = points - middle
    values = np.linalg.svd(offset, compute_uv=False)
    if values[-1] < 1e-4 * values[0]:
        return None, False
    square = np.sum(offset**2, axis=1)
    unknowns = np.column_stack([2 * offset, np.ones(len(offset))])
    return middle + np.linalg.lstsq(unknowns, square)[0][:-1], True


def _directions(arms: Floats) -> tuple[Floats, Floats]:
    radius = np.linalg.norm(arms, axis=1)
    return arms / np.maximum(radius, 1e-12)[:, None], radius


def _fits(upright: Floats, radius: Floats, normals: Floats) -> bool:
    off = np.abs(radius - radius.mean()).max()
    return bool(off <= EXACT * radius.mean() and np.sum(upright * normals, axis=1).min() >= UPRIGHT)


def _opposite_to_the_widest_gap(upright: Floats, sides: Floats) -> Floats:
    """Direction (3,) across an axis; of gaps that tie to 1 %, it faces +z most, then +x."""
    x, y = (upright @ sides).T
    angle = np.sort(np.arctan2(y, x))
    gap = np.diff(angle, append=angle[0] + 2 * np.pi)
    half = angle + gap / 2 + np.pi
    ways = np.column_stack([np.cos(half), np.sin(half)])[gap >= 0.99 * gap.max()] @ sides.T
    facing = -ways.round(6)
    return np.asarray(ways[np.lexsort([facing[:, 0], facing[:, 2]])[0]])


def quadrics_through(plane: Floats, positions: Floats, normals: Floats, pairs: Ints) -> Quadrics:
    """Fit quadrics to neighbours.

    Parameters
    ----------
    plane : (M, 2) array, m
        Distinct points in the developed plane.
    positions, normals : (M, 3) array
        The same in space; m, and unit length.
    pairs : (E, 2) int array
        Neighbours, in the plane and in space; a taxel without any is flat around.
    """
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    first, second = pairs.T
    length = np.linalg.norm(plane[second] - plane[first], axis=1)
    nearest = np.full(len(plane), np.inf)
    np.minimum.at(nearest, first, length)
    pitch = float(np.median(nearest[np.isfinite(nearest)])) if len(length) else 1.0
    offset = (plane[second] - plane[first]) / pitch  # in pitches, to keep the equations balanced
    rise = (positions[second] - positions[first]) / pitch
    weight = np.exp(-((length / (1.5 * np.maximum(nearest[first], pitch))) ** 2))
    frames = _rigid_frames(first, offset, rise, weight, normals)
    slope, bend = _fit(pairs, offset, rise, weight, normals, frames)
    turn = _fit_turn(pairs, offset, weight, normals)
    parts = plane, positions, normals, slope, bend / pitch, turn / pitch
    return Quadrics(tuple(_plain(part) for part in parts), pitch)


def _squares(offset: Floats) -> Floats:
    x, y = offset[..., 0], offset[..., 1]
    return np.stack([x * x / 2, x * y, y * y / 2], axis=-1)


def _frames_along(tangents: Floats, normal: Floats) -> Floats:
    """Right-handed frames (N, 3, 3) about unit normals, as near to tangents (N, 3, 2) as can be."""
    frames = flat_frames(normal)
    inside = np.einsum("nij,nik->njk", frames[:, :, :2], tangents)
    angle = np.arctan2(inside[:, 1, 0] - inside[:, 0, 1], inside[:, 0, 0] + inside[:, 1, 1])
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    first = cosine * frames[:, :, 0] + sine * frames[:, :, 1]
    return np.stack([first, np.cross(normal, first), normal], axis=2)


def _rigid_frames(
    first: Ints, offset: Floats, rise: Floats, weight: Floats, normals: Floats
) -> Floats:
    """Frame (M, 3, 3) of each taxel that turns offsets in the plane best into those in space."""
    outer = np.zeros((len(normals), 3, 2))
    np.add.at(outer, first, weight[:, None, None] * rise[:, :, None] * offset[:, None, :])
    return _frames_along(outer, normals)


def _fit(
    pairs: Ints, offset: Floats, rise: Floats, weight: Floats, normals: Floats, frames: Floats
) -> tuple[Floats, Floats]:
    """Least squares for A (M, 3, 2) and B (M, 3, 3) in pitches.

    Neighbours lie on the quadric (three equations each) and their normals, like the taxel's own,
    stand upright on it (two each).
    """
    first, second = pairs.T
    count, terms = len(normals), np.concatenate([offset, _squares(offset)], axis=1)
    one, nil = np.ones(len(offset)), np.zeros(len(offset))
    x, y = offset.T
    slopes = np.array([[one, nil, x, y, nil], [nil, one, nil, x, y]])  # of the terms along δ₁, δ₂
    matrix = np.zeros((count, 3, 5, 3, 5))
    blocks = np.einsum("n,ni,nj,ab->naibj", weight, terms, terms, np.eye(3))
    upright = TRUST * weight[:, None] * normals[second]
    blocks += np.einsum("na,nb,cin,cjn->naibj", upright, normals[second], slopes, slopes)
    np.add.at(matrix, first, blocks)
    own = np.einsum("na,nb,ij->naibj", normals, normals, np.diag([1.0, 1.0, 0.0, 0.0, 0.0]))
    ridge = RIDGE * np.einsum("ab,ij->aibj", np.eye(3), np.eye(5))
    right = np.zeros((count, 3, 5))
    np.add.at(right, first, weight[:, None, None] * rise[:, :, None] * terms[:, None, :])
    right[:, :, :2] += RIDGE * frames[:, :, :2]
    matrix = (matrix + own + ridge).reshape(count, 15, 15)
    solution = np.linalg.solve(matrix, right.reshape(count, 15, 1)).reshape(count, 3, 5)
    return solution[:, :, :2], solution[:, :, 2:]


def _fit_turn(pairs: Ints, offset: Floats, weight: Floats, normals: Floats) -> Floats:
    """Least squares for the change (M, 3, 2) of the normal per pitch."""
    first, second = pairs.T
    matrix = np.zeros((len(normals), 2, 2))
    right = np.zeros((len(normals), 2, 3))
    change = normals[second] - normals[first]
    np.add.at(matrix, first, weight[:, None, None] * offset[:, :, None] * offset[:, None, :])
    np.add.at(right, first, weight[:, None, None] * offset[:, :, None] * change[:, None, :])
    turn = np.linalg.solve(matrix + RIDGE * np.eye(2), right)
    return np.asarray(turn.transpose(0, 2, 1), dtype=np.float64)


def _plain(array: Floats) -> Floats:
    """Of one layout, so that the kernel is compiled once."""
    return np.require(array, np.float64, ("C", "W"))
