"""Flattening of a curved patch: unrolled from its middle, relaxed, and the way back."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.skin.geometry import Links, flat_frame, links_between, mean_normal, parts_of
from skinfield.skin.quadrics import (
    Cylinder,
    Flat,
    Shape,
    Sphere,
    quadrics_through,
    round_through,
)

OFF_PLANE = 0.01  # of the extent: taxels farther from their plane than this make a curved patch
TILT = np.cos(np.radians(2.0))  # and so do normals that lean more than this


@dataclass(frozen=True, eq=False)
class Surface:
    """A patch's taxels in a plane, as nearly isometric as it goes, and the way back to 3D.

    Attributes
    ----------
    plane : (L, 2) array, m
        Taxel centres in the developed plane; seen from outside, x right and y up.
    shape : Flat, Sphere, Cylinder or Quadrics
        The way back.
    distortion : float
        How far lengths in the plane are from those on the skin, as a part of 1: the 99th
        percentile of abs(length in the plane / length on the skin - 1) over neighbouring taxels;
        0 where the patch is flat.
    severed : int
        Pairs of neighbouring taxels that lie apart in the plane, because it had to be cut.
    """

    plane: Floats
    shape: Shape
    distortion: float = 0.0
    severed: int = 0

    @property
    def is_flat(self) -> bool:
        """Whether the taxels lie in one plane and the way back is a rigid motion."""
        return isinstance(self.shape, Flat)

    def position_from_plane(self, plane: Floats) -> Floats:
        """Points of the developed plane (N, 2) m, as points in the patch's frame (N, 3) m.

        Taxels come out where they are; between them the skin is smooth, and it runs on for some
        pitches beyond its border as it bends there, then straight.
        """
        return self.shape.positions(np.asarray(plane, dtype=np.float64))

    def frame_from_plane(self, plane: Floats) -> Floats:
        """Local frames (N, 3, 3) at points of the plane (N, 2) m: columns tangent, tangent, normal.

        The tangents are the images of the plane's two axes, orthonormalised; the normal points
        out of the skin, as that of the taxels does; right-handed.
        """
        return self.shape.frames(np.asarray(plane, dtype=np.float64))

    def held(self, plane: Floats, side: float) -> Floats:
        """Part (N,) of cells of a side in m, about points of the plane (N, 2) m, that is skin.

        What lies beyond the cut of a cylinder is held on its other side already, and beyond a whole
        sphere there is nothing.
        """
        if isinstance(self.shape, Sphere | Cylinder):
            return self.shape.held(np.asarray(plane, dtype=np.float64), side)
        return np.ones(len(plane))


def surface_through(positions: Floats, normals: Floats) -> Surface:
    """Surface through taxels (L, 3) m with outward unit normals (L, 3).

    Flat when the taxels lie within 1 % of their extent of one plane and no normal leans more than
    2° from it, or when they lie on one line; else developed.
    """
    normal = _plane_normal(positions, mean_normal(normals))
    centre = positions.mean(axis=0)
    spread = float(np.linalg.norm(np.ptp(positions, axis=0)))
    off_plane = float(np.abs((positions - centre) @ normal).max())
    curved = off_plane > OFF_PLANE * spread or float((normals @ normal).min()) < TILT
    if curved and not _is_line(positions - centre, spread):
        return develop(positions, normals)
    frame = flat_frame(normal)
    origin = float(centre @ normal) * normal
    plane = (positions - origin) @ frame[:, :2]
    plane.setflags(write=False)
    return Surface(plane, Flat(origin, frame))


def _is_line(centred: Floats, spread: float) -> bool:
    if len(centred) < 3 or spread < 2e-7:
        return True
    return float(np.linalg.svd(centred, compute_uv=False)[1]) < 1e-6 * spread


def _plane_normal(positions: Floats, outward: Floats) -> Floats:
    """Unit normal (3,) of the best plane through positions (L, 3), on the side of `outward`.

    Of the planes through a line, the one that faces `outward`; exactly `outward` where the
    positions allow it, so that a flat patch keeps the axes it was given.
    """
    centred = positions - positions.mean(axis=0)
    if len(centred) < 3:
        centred = np.pad(centred, ((0, 3 - len(centred)), (0, 0)))
    _, extent, axes = np.linalg.svd(centred, full_matrices=False)
    if extent[0] < 1e-9 or np.abs(centred @ outward).max() <= 1e-9 * extent[0]:
        return outward
    if extent[1] < 1e-6 * extent[0]:
        across = outward - axes[0] * (axes[0] @ outward)
        if np.linalg.norm(across) < 1e-6:  # the line runs along its own normal: any side will do
            across = flat_frame(axes[0])[:, 0]
        return np.asarray(across / np.linalg.norm(across))
    return np.asarray(axes[2] if axes[2] @ outward >= 0 else -axes[2])


STEPS = 8  # of Gauss-Newton in one round of relaxation
STRETCH = (0.45, 1.8)  # plane over skin: a link outside is torn, the skin had to be cut there


def middle(normals: Floats, links: Links, sources: int = 1000) -> int:
    """Row of the taxel with the shortest way to all others.

    Of those that tie to 1 %, as around a sleeve, the one that faces +z most, then +x, then the
    first; of many taxels, about `sources` are tried.
    """
    from scipy.sparse.csgraph import dijkstra

    rows = np.arange(0, len(normals), -(-len(normals) // sources))
    farthest = dijkstra(_net(len(normals), links), directed=False, indices=rows).max(axis=1)
    tied = rows[farthest <= 1.01 * farthest.min()]
    facing = -normals[tied].round(6)
    return int(tied[np.lexsort([facing[:, 0], facing[:, 2]])[0]])


def unroll(positions: Floats, normals: Floats, links: Links, root: int) -> Floats:
    """Plane coordinates (M, 2) m by walking away from `root` along the shortest ways.

    A discrete exponential map: every taxel carries a tangent frame, handed on from the taxels
    nearer to the root by the smallest turn of the normal; a step in the plane is the link to the
    taxel in that frame, at its length along the skin. Predictions from all nearer neighbours that
    agree are averaged. Exact on developable skin; a closed one comes out cut opposite to the root.
    """
    count = len(positions)
    far, parent = _shortest_ways(positions, normals, links, root)
    steps = _steps(positions, normals, links)
    plane, frames = np.zeros((count, 2)), np.zeros((count, 3, 3))
    frames[root] = flat_frame(normals[root])
    placed = np.zeros(count, np.bool_)
    placed[root] = True
    for taxel in np.argsort(far, kind="stable")[1:]:
        mine = slice(*steps.first[taxel : taxel + 2])
        near = steps.start[mine]
        known = placed[near]
        near, along, turn = near[known], steps.along[mine][known], steps.turn[mine][known]
        guess = plane[near] + np.einsum("nij,ni->nj", frames[near, :, :2], along)
        tangent = np.einsum("nij,nj->ni", turn, frames[near, :, 0])
        lead, length = near == parent[taxel], np.einsum("ni,ni->n", along, along) ** 0.5
        agree = np.linalg.norm(guess - guess[lead], axis=1) <= 0.5 * length[lead]
        agree &= tangent @ tangent[lead][0] > 0.7
        weight = agree / length**2
        plane[taxel] = weight @ guess / weight.sum()
        frames[taxel] = _frame_with(normals[taxel], weight @ tangent)
        placed[taxel] = True
    return plane


def relax(plane: Floats, positions: Floats, links: Links, rounds: int = 4) -> Floats:
    """Move the taxels of `plane` (M, 2) m until links have their lengths along the skin.

    Least squares of the relative errors (Levenberg-Marquardt). Links that came out torn are left
    out, and taxels that are no neighbours are kept at least their distance in space apart, up to
    the reach of a link, so that the picture does not fold over itself.
    """
    for _ in range(rounds if len(links.length) else 0):
        held = holds(plane, links)
        before, plane = (
            plane,
            _least_squares(plane, positions, links.pairs[held], links.length[held]),
        )
        if np.abs(plane - before).max() < 1e-4 * float(np.median(links.length)):
            break
    return plane


def holds(plane: Floats, links: Links) -> NDArray[np.bool_]:
    """Which links (E,) the plane keeps; the others are torn by the cut."""
    ratio = _stretch(plane, links)
    return np.asarray((ratio >= STRETCH[0]) & (ratio <= STRETCH[1]))


def _stretch(plane: Floats, links: Links) -> Floats:
    """Length of each link (E,) in the plane over that on the skin."""
    return _distance(plane, links.pairs)[0] / links.length


def _net(count: int, links: Links) -> Any:
    from scipy.sparse import csr_array

    return csr_array((links.length, (links.pairs[:, 0], links.pairs[:, 1])), shape=(count, count))


def _shortest_ways(
    positions: Floats, normals: Floats, links: Links, root: int
) -> tuple[Floats, Ints]:
    """Distance of each taxel from `root`, and the taxel before it on the way, -1 for the root.

    Links on one side of the root count for 0.1 % longer, so that taxels that are as far either
    way round a sleeve come out on one side.
    """
    from scipy.sparse.csgraph import dijkstra

    middles = positions[links.pairs].mean(axis=1) - positions[root]
    right = middles @ flat_frame(normals[root])[:, :2] @ [1.0, 0.5] > 0.0
    uneven = replace(links, length=links.length * np.where(right, 1.0 + 1e-3, 1.0))
    net = _net(len(positions), uneven)
    far, before = dijkstra(net, directed=False, indices=np.array([root]), return_predecessors=True)
    return far[0], np.maximum(before[0], -1).astype(np.int64)


class _Steps(NamedTuple):
    """Links as steps (2E,) towards a taxel, sorted by it: those to t are first[t] : first[t + 1].

    `along` (2E, 3) m is tangent at the start and as long as the link, `turn` (2E, 3, 3) the
    smallest rotation between the normals.
    """

    first: Ints
    start: Ints
    along: Floats
    turn: Floats


def _steps(positions: Floats, normals: Floats, links: Links) -> _Steps:
    start, end = np.concatenate([links.pairs, links.pairs[:, ::-1]]).T
    order = np.argsort(end, kind="stable")
    start, end, length = start[order], end[order], np.tile(links.length, 2)[order]
    half = normals[start] + normals[end]
    half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-9)
    chord = positions[end] - positions[start]
    along = chord - half * np.einsum("ni,ni->n", half, chord)[:, None]
    along = np.einsum("nij,nj->ni", _turns(half, normals[start]), along)
    along *= (length / np.maximum(np.linalg.norm(along, axis=1), 1e-12))[:, None]
    first = np.searchsorted(end, np.arange(len(positions) + 1))
    return _Steps(first, start, along, _turns(normals[start], normals[end]))


def _turns(start: Floats, end: Floats) -> Floats:
    """Smallest rotations (N, 3, 3) from unit vectors `start` to unit vectors `end` (N, 3).

    None at all where they are opposite: a tangent of the one side is tangent to the other.
    """
    x, y, z = np.cross(start, end).T
    nil = np.zeros(len(start))
    skew = np.array([[nil, -z, y], [z, nil, -x], [-y, x, nil]]).transpose(2, 0, 1)
    cosine = np.einsum("ni,ni->n", start, end)[:, None, None]
    turn = np.eye(3) + skew + skew @ skew / np.maximum(1.0 + cosine, 0.01)
    return np.where(cosine > -0.99, turn, np.eye(3))


def _frame_with(normal: Floats, tangent: Floats) -> Floats:
    """Right-handed frame (3, 3) about `normal` whose first axis lies as near to `tangent`."""
    (a, b, c), (x, y, z) = normal, tangent - normal * (tangent @ normal)
    size = (x * x + y * y + z * z) ** 0.5
    if size < 1e-9:
        return flat_frame(normal)
    x, y, z = x / size, y / size, z / size
    return np.array([[x, b * z - c * y, a], [y, c * x - a * z, b], [z, a * y - b * x, c]])


def _distance(plane: Floats, pairs: Ints) -> tuple[Floats, Floats]:
    offset = plane[pairs[:, 1]] - plane[pairs[:, 0]]
    return np.linalg.norm(offset, axis=1), offset


def _crowded(plane: Floats, positions: Floats, pairs: Ints, reach: float) -> tuple[Ints, Floats]:
    """Pairs that are no neighbours yet closer in the plane than in space, and how far to be."""
    from scipy.spatial import cKDTree

    close = cKDTree(plane).query_pairs(reach, output_type="ndarray").astype(np.int64)
    count = len(plane)
    close = close[~np.isin(close @ [count, 1], pairs @ [count, 1])]
    least = np.linalg.norm(np.diff(positions[close], axis=1)[:, 0], axis=1)
    least = np.minimum(least, reach)
    tight = _distance(plane, close)[0] < least
    return close[tight], least[tight]


class _Misfit(NamedTuple):
    """Relative errors (E,) of the lengths of pairs (E, 2), slopes (E, 2) by the second end."""

    pairs: Ints
    error: Floats
    slope: Floats

    @classmethod
    def of(
        cls, plane: Floats, positions: Floats, pairs: Ints, length: Floats, reach: float
    ) -> "_Misfit":
        """Of neighbours, and of those that are crowded within `reach`."""
        crowded, least = _crowded(plane, positions, pairs, reach)
        pairs, length = np.concatenate([pairs, crowded]), np.concatenate([length, least])
        distance, offset = _distance(plane, pairs)
        slope = offset / np.maximum(distance * length, 1e-15)[:, None]
        return cls(pairs, distance / length - 1.0, slope)


def _newton_step(misfit: _Misfit, count: int, damping: float) -> Floats:
    """Damped Gauss-Newton step (count, 2)."""
    from scipy.sparse import csc_array, eye_array
    from scipy.sparse.linalg import spsolve

    edges = np.arange(len(misfit.error))
    column = 2 * misfit.pairs[:, [0, 0, 1, 1]] + [0, 1, 0, 1]
    value = np.concatenate([-misfit.slope, misfit.slope], axis=1)
    row = np.broadcast_to(edges[:, None], column.shape)
    entries = (value.ravel(), (row.ravel(), column.ravel().astype(np.int64)))
    jacobian = csc_array(entries, shape=(len(edges), 2 * count))
    gram = jacobian.T @ jacobian
    shift = damping * float(gram.diagonal().mean())
    step = spsolve((gram + shift * eye_array(2 * count)).tocsc(), -(jacobian.T @ misfit.error))
    return np.asarray(step).reshape(count, 2)


def _least_squares(plane: Floats, positions: Floats, pairs: Ints, length: Floats) -> Floats:
    reach, damping = float(np.median(length)), 1e-3
    misfit = _Misfit.of(plane, positions, pairs, length, reach)
    for _ in range(STEPS):
        step = _newton_step(misfit, len(plane), damping)
        trial = _Misfit.of(plane + step, positions, pairs, length, reach)
        if trial.error @ trial.error < misfit.error @ misfit.error:
            plane, misfit, damping = plane + step, trial, max(damping * 0.2, 1e-6)
            if np.abs(step).max() < 1e-4 * reach:
                break
        else:
            damping *= 10.0
    return plane


GAP = 3.0  # median links between parts that are laid side by side


def develop(positions: Floats, normals: Floats) -> Surface:
    """Develop the surface through taxels (L, 3) m with outward unit normals (L, 3).

    A cylinder is unrolled, and a sphere laid out with the true areas, as closed forms have it.
    Other skin is unrolled from its middle and relaxed until distances between neighbours agree with
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
    body = round_through(points, facing)
    plane = _laid_flat(points, facing, links) if body is None else body.plane(points)
    held = holds(plane, links)
    shape = body or quadrics_through(plane, points, facing, links.pairs[held])
    laid = plane[back]
    laid.setflags(write=False)
    severed = int(np.count_nonzero(links.near & ~held))
    return Surface(laid, shape, _distortion(plane, links), severed)


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
    ratio = _stretch(plane, links)[links.near & holds(plane, links)]
    return float(np.percentile(np.abs(ratio - 1.0), 99)) if len(ratio) else 0.0
