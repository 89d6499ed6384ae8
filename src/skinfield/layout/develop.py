"""Curved patches laid flat, and the way back onto the skin."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.layout.links import Ints, Links, links_between, parts_of
from skinfield.layout.quadrics import Quadrics, quadrics_through
from skinfield.layout.surface import Surface, flat_frame, mean_normal
from skinfield.layout.unroll import holds, middle, relax, unroll

GAP = 3.0  # median links between parts that are laid side by side


@dataclass(frozen=True, eq=False)
class DevelopedSurface:
    """A curved skin laid flat, as nearly isometric as it goes; see `Surface`.

    Parameters
    ----------
    plane : (L, 2) array, m
        Taxel centres in the developed plane.
    distortion : float
        99th percentile of abs(length in the plane / length on the skin - 1) over neighbours.
    severed : int
        Pairs of neighbours that the cut tore apart.
    shape : Quadrics
        The way back.
    """

    plane: Floats
    distortion: float
    severed: int
    shape: Quadrics
    is_flat = False

    def position_from_plane(self, plane: Floats) -> Floats:
        """See `Surface.position_from_plane`.

        Taxels come out where they are; between them the skin is smooth, and it runs on for some
        pitches beyond its border as it bends there, then straight.
        """
        return self.shape.positions(np.asarray(plane, dtype=np.float64))

    def frame_from_plane(self, plane: Floats) -> Floats:
        """See `Surface.frame_from_plane`; the normals of the taxels are kept."""
        return self.shape.frames(np.asarray(plane, dtype=np.float64))


def develop(positions: Floats, normals: Floats) -> Surface:
    """Develop the surface through taxels (L, 3) m with outward unit normals (L, 3).

    The skin is unrolled from its middle and relaxed until distances between neighbours agree with
    those along the skin. What cannot be flat without a cut is cut: a sleeve comes out as a sheet,
    severed opposite to its middle (or at its seam, where it has one). Parts that lie apart are
    joined over the narrowest gap; those that face away from each other, as the two sides of a
    plate, are laid side by side. The plane is the picture seen from outside: as closely as a turn
    and a shift allow, the patch's own axes laid into the plane of its mean normal.

    Parameters
    ----------
    positions : (L, 3) array, m
        At least two distinct ones; repeated positions are one point of the surface.
    normals : (L, 3) array
        Unit length, outward.
    """
    _, row, back = np.unique(positions.round(7), axis=0, return_index=True, return_inverse=True)
    back = back.reshape(-1)
    points = positions[row]
    facing = _merged(normals, back, normals[row])
    links = links_between(points, facing)
    plane = _laid_flat(points, facing, links)
    held = holds(plane, links)
    shape = quadrics_through(plane, points, facing, links.pairs[held])
    laid = plane[back]
    laid.setflags(write=False)
    severed = int(np.count_nonzero(links.near & ~held))
    return DevelopedSurface(laid, _distortion(plane, links), severed, shape)


def _merged(normals: Floats, point: Ints, fallback: Floats) -> Floats:
    """Unit mean normals (M, 3) of the taxels at each point; `fallback` (M, 3) where they cancel."""
    total = np.zeros_like(fallback)
    np.add.at(total, point, normals)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 1e-6, total / np.maximum(length, 1e-6), fallback)


def _laid_flat(points: Floats, normals: Floats, links: Links) -> Floats:
    """Plane coordinates (M, 2) m of points (M, 3) m; parts without links side by side, along x."""
    plane, right_end = np.zeros((len(points), 2)), -np.inf
    gap = GAP * float(np.median(links.length)) if len(links.length) else 10e-3
    for rows in sorted(parts_of(len(points), links.pairs), key=len, reverse=True):
        mine, part, facing = links.among(rows), points[rows], normals[rows]
        root = middle(facing, mine)
        laid = relax(unroll(part, facing, mine, root), part, mine)
        laid = _aligned(laid, part, facing, root)
        if np.isfinite(right_end):
            laid[:, 0] += right_end + gap - laid[:, 0].min()
        plane[rows], right_end = laid, float(laid[:, 0].max())
    return plane


def _aligned(plane: Floats, points: Floats, normals: Floats, root: int) -> Floats:
    """Turn and shift the plane (M, 2) onto the view of the patch against its mean normal."""
    mean = normals.mean(axis=0)
    front = mean_normal(normals) if np.linalg.norm(mean) > 0.3 else normals[root]
    view = points @ flat_frame(front)[:, :2]
    weight = np.maximum(normals @ front, 0.0) + 1e-9
    weight /= weight.sum()
    centre, middle_of_view = weight @ plane, weight @ view
    plane, view = plane - centre, view - middle_of_view
    sine = weight @ (plane[:, 0] * view[:, 1] - plane[:, 1] * view[:, 0])
    cosine = weight @ (plane * view).sum(axis=1)
    angle = np.arctan2(sine, cosine)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray(plane @ turn + middle_of_view)


def _distortion(plane: Floats, links: Links) -> float:
    use = links.near & holds(plane, links)
    ends = plane[links.pairs[use]]
    ratio = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / links.length[use]
    return float(np.percentile(np.abs(ratio - 1.0), 99)) if len(ratio) else 0.0
