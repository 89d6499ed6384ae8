"""The shape of a curved skin around each taxel: the way from its plane back into space."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.skin.geometry import flat_frames

BLENDED = 8  # quadrics around a point that have a say in it
FLEX = 2.5  # pitches from its taxel up to which a quadric bends; beyond, it runs on straight
TRUST = 0.25  # weight of a normal against that of a position, both in pitches
RIDGE = 1e-3  # holds the terms that the neighbours leave open: isometric, and without curvature


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
