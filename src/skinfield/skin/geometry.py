"""Geometry of taxels in space: normals and frames, neighbours along the skin, their convex hull."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, as_floats, check_finite, check_shape

FLAT = 0.01  # a skin whose taxels leave their plane by less than this part of its extent is flat
SURE = 0.05  # the bulge, as a part of the extent, above which the convex side is told for certain


@dataclass(frozen=True, eq=False)
class Facing:
    """Normals re-estimated from positions.

    Parameters
    ----------
    normals : (N, 3) array
        Unit normals, on one side of the skin.
    certain : (N,) bool array
        Whether the skin bulges, so that its convex side is told. Elsewhere the side is the one
        away from the origin of the link and, where the skin runs through it, +z (or +y, +x).
    is_flat : bool
        Whether all taxels lie in one plane.
    """

    normals: Floats
    certain: NDArray[np.bool_]
    is_flat: bool


def facing_from_positions(positions: Floats) -> Facing:
    """Normals from positions (N, 3) m in the frame of the link that carries the skin.

    The plane of each taxel is the principal plane of its nearest neighbours; the signs are spread
    along the minimum spanning tree of the changes of direction [1]_; each connected piece is then
    turned to its convex side as seen from the centre of the whole skin and, if it has none, away
    from the origin of the link.

    Raises
    ------
    InputError
        When positions are not (N, 3) finite numbers.

    References
    ----------
    .. [1] H. Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992.
    """
    positions = as_floats("positions", positions)
    check_shape("positions", positions, (None, 3), "one row of metres per taxel")
    check_finite("positions", positions, "a taxel without a place has no normal")
    distinct, row = np.unique(positions.round(9), axis=0, return_inverse=True)
    row = row.reshape(-1)
    if len(distinct) < 3:
        return Facing(np.tile([0.0, 0.0, 1.0], (len(positions), 1)), np.zeros(len(row), bool), True)
    plane_normal = _flat_normal(distinct)
    if plane_normal is not None:
        normals = np.tile(plane_normal, (len(distinct), 1))
        piece = np.zeros(len(distinct), np.int64)
    else:
        near = _nearest(distinct)
        normals, piece = _consistent(_local_normals(distinct, near), distinct, near)
    side, sure = _outward(distinct, normals, piece)
    return Facing((normals * side[:, None])[row], sure[row], plane_normal is not None)


def nearest_distance(positions: Floats) -> Floats:
    """Distance from each of (N, 3) positions to the nearest one elsewhere, (N,) m.

    Repeated positions share one distance; infinite when there is no other place.
    """
    from scipy.spatial import cKDTree

    distinct, row = np.unique(positions.round(9), axis=0, return_inverse=True)
    if len(distinct) < 2:
        return np.full(len(positions), np.inf)
    distance = np.asarray(cKDTree(distinct).query(distinct, k=2)[0])
    return np.asarray(distance[:, 1][row.reshape(-1)])


def _flat_normal(points: Floats) -> Floats | None:
    """Normal of the plane through points (N, 3); None when they leave it."""
    centred = points - points.mean(axis=0)
    _, extent, axes = np.linalg.svd(centred, full_matrices=True)
    if extent[1] <= 1e-6 * extent[0]:  # on one line: any plane through it will do
        helper = np.eye(3)[2] if abs(axes[0, 2]) < 0.9 else np.eye(3)[0]
        normal = helper - axes[0] * (helper @ axes[0])
        return np.asarray(normal / np.linalg.norm(normal))
    spread = np.linalg.norm(np.ptp(points, axis=0))
    return axes[2] if np.abs(centred @ axes[2]).max() <= FLAT * spread else None


def _nearest(points: Floats, count: int = 11) -> Ints:
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(points).query(points, k=min(count, len(points)))[1], np.int64)


def _local_normals(points: Floats, near: Ints) -> Floats:
    around = points[near] - points[near].mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0])


def _consistent(normals: Floats, points: Floats, near: Ints) -> tuple[Floats, Ints]:
    """Give each connected piece one side; return normals and the piece of each point."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order, connected_components
    from scipy.sparse.csgraph import minimum_spanning_tree as spanning_tree

    count, reach = len(points), 3.0 * float(np.median(nearest_distance(points)))
    first = np.repeat(np.arange(count), near.shape[1])
    second = near.reshape(-1)
    use = (first != second) & (np.linalg.norm(points[first] - points[second], axis=1) <= reach)
    first, second = first[use], second[use]
    turn = 1.0 + 1e-6 - np.abs(np.einsum("ni,ni->n", normals[first], normals[second]))
    tree = spanning_tree(csr_array((turn, (first, second)), shape=(count, count)))
    pieces, piece = connected_components(tree, directed=False)
    normals = normals.copy()
    for index in range(pieces):
        start = int(np.flatnonzero(piece == index)[0])
        order, parent = breadth_first_order(tree, start, directed=False)
        for point in order[1:]:
            if normals[point] @ normals[parent[point]] < 0:
                normals[point] *= -1
    return normals, np.asarray(piece, np.int64)


def _outward(points: Floats, normals: Floats, piece: Ints) -> tuple[Floats, NDArray[np.bool_]]:
    """Sign (N,) that turns each piece outward, and whether its bulge tells so."""
    side, sure = np.ones(len(points)), np.zeros(len(points), np.bool_)
    for index in range(int(piece.max()) + 1):
        mine = piece == index
        facing = normals[mine]
        for start, is_centre in ((points.mean(axis=0), True), (np.zeros(3), False)):
            arm = points[mine] - start
            bulge = float(np.einsum("ni,ni->n", arm, facing).mean())
            if abs(bulge) > SURE * float(np.linalg.norm(arm, axis=1).mean()):
                side[mine], sure[mine] = np.sign(bulge), is_centre
                break
        else:
            mean = facing.mean(axis=0)
            leading = next((c for c in mean[::-1] if abs(c) > 1e-6), 1.0)
            side[mine] = np.sign(leading)
    return side, sure


def flat_frames(normals: Floats) -> Floats:
    """Right-handed frames (N, 3, 3) whose third columns are `normals`; the identity for +z.

    The first axis is the patch's x axis laid into the plane (its y axis where x is the normal), so
    that a flat patch keeps its own coordinates.
    """
    helper = np.where(np.abs(normals[:, :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    first = helper - normals * np.einsum("ni,ni->n", helper, normals)[:, None]
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first), normals], axis=2)


def flat_frame(normal: Floats) -> Floats:
    """One of `flat_frames`, (3, 3)."""
    return np.asarray(flat_frames(normal[None])[0])


def mean_normal(normals: Floats) -> Floats:
    """Unit mean (3,) of unit normals (N, 3); the first of them where they cancel out."""
    mean = np.asarray(normals.mean(axis=0))
    length = float(np.linalg.norm(mean))
    return mean / length if length > 1e-6 else np.asarray(normals[0], dtype=np.float64)


NEAREST = 12  # taxels around one that may be its neighbours: two rings
REACH = 2.5  # times the median distance between nearest taxels: the longest link
FACING = -0.2  # cosine between normals below which close taxels are on two sides of a thin part
THROUGH = 0.85  # part of a link along both normals above which it runs through the skin


@dataclass(frozen=True, eq=False)
class Links:
    """Pairs of neighbouring taxels.

    Parameters
    ----------
    pairs : (E, 2) int array
        Each once, the lower row first.
    length : (E,) array, m
        Along the skin.
    near : (E,) bool array
        Whether the pair is of the first ring; the others only stiffen the net.
    """

    pairs: Ints
    length: Floats
    near: NDArray[np.bool_]

    def among(self, rows: Ints) -> "Links":
        """Links between the taxels `rows` only, numbered as those are."""
        order = np.searchsorted(rows, self.pairs)
        mine = np.isin(self.pairs, rows).all(axis=1)
        return Links(order[mine], self.length[mine], self.near[mine])


def arc_length(chord: Floats, first: Floats, second: Floats) -> Floats:
    """Length (E,) m along the skin of chords (E, 3) m between unit normals `first`, `second`.

    The arc of the circle through both ends that turns by as much as the normals do in the plane
    of the chord: l = c (θ/2) / sin(θ/2), exact on a cylinder to the fourth order of θ.
    """
    length = np.linalg.norm(chord, axis=1)
    along = chord / np.maximum(length, 1e-12)[:, None]
    start, end = (
        np.arcsin(np.clip(np.einsum("ni,ni->n", normal, along), -0.95, 0.95))
        for normal in (first, second)
    )
    half = np.clip(end - start, -2.0, 2.0) / 2
    return np.asarray(length / np.sinc(half / np.pi))


def links_between(positions: Floats, normals: Floats) -> Links:
    """Neighbours among distinct positions (M, 3) m with unit normals (M, 3).

    Parts of the skin that lie apart are joined by the links across the narrowest gaps, unless
    they face away from each other there, as the two sides of a plate do.
    """
    pairs = _nearest_pairs(positions, normals)
    pairs = np.concatenate([pairs, _bridges(positions, normals, pairs)])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    first, second = pairs.T
    length = arc_length(positions[second] - positions[first], normals[first], normals[second])
    own = np.full(len(positions), np.inf)
    np.minimum.at(own, pairs, length[:, None])
    return Links(pairs, length, length <= 1.5 * np.maximum(own[first], own[second]))


def parts_of(count: int, pairs: Ints) -> list[Ints]:
    """Rows of each part of `count` taxels that pairs (E, 2) hold together."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    net = csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    parts, part = connected_components(net, directed=False)
    return [np.flatnonzero(part == p) for p in range(parts)]


def _nearest_pairs(positions: Floats, normals: Floats) -> Ints:
    from scipy.spatial import cKDTree

    count = min(NEAREST + 1, len(positions))
    if count < 2:
        return np.empty((0, 2), np.int64)
    distance, row = map(np.asarray, cKDTree(positions).query(positions, k=count))
    first = np.repeat(np.arange(len(positions)), count - 1)
    second, distance = row[:, 1:].reshape(-1), distance[:, 1:]
    along = (positions[second] - positions[first]) / distance.reshape(-1, 1)
    through = np.minimum(
        np.abs(np.einsum("ni,ni->n", normals[first], along)),
        np.abs(np.einsum("ni,ni->n", normals[second], along)),
    )
    facing = np.einsum("ni,ni->n", normals[first], normals[second])
    use = (distance.reshape(-1) <= REACH * np.median(distance[:, 0])) & (facing >= FACING)
    use &= through <= THROUGH
    return np.asarray(np.column_stack([first, second])[use], dtype=np.int64)


def _bridges(positions: Floats, normals: Floats, pairs: Ints) -> Ints:
    """Links over the narrowest gaps between the parts that `pairs` leave apart."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import minimum_spanning_tree

    parts = parts_of(len(positions), pairs)
    spans: dict[tuple[int, int], tuple[Ints, Floats]] = {}
    for a, one in enumerate(parts):
        for b, other in enumerate(parts[:a]):
            candidates, length = _across(positions, normals, one, other)
            if len(candidates):
                spans[a, b] = candidates, length
    gaps = csr_array(
        (
            [length.min() for _, length in spans.values()],
            ([a for a, _ in spans], [b for _, b in spans]),
        ),
        shape=(len(parts), len(parts)),
    )
    bridges = [np.empty((0, 2), np.int64)]
    for a, b in np.argwhere(minimum_spanning_tree(gaps).toarray() > 0):
        candidates, length = spans[int(a), int(b)]
        bridges.append(candidates[length <= 1.5 * length.min()])
    return np.concatenate(bridges)


def _across(positions: Floats, normals: Floats, one: Ints, other: Ints) -> tuple[Ints, Floats]:
    """Pairs (n, 2) from the taxels of `other` to the nearest of `one` that face the same way."""
    from scipy.spatial import cKDTree

    near = list(range(1, min(4, len(one)) + 1))
    length, row = map(np.asarray, cKDTree(positions[one]).query(positions[other], k=near))
    second = one[row].reshape(-1)
    first = np.repeat(other, len(near))
    use = np.einsum("ni,ni->n", normals[first], normals[second]) >= FACING
    return np.column_stack([first, second])[use].astype(np.int64), length.reshape(-1)[use]


def spans_plane(points: Floats) -> bool:
    """Whether points (M, 2) have an area: three or more, not on one line to 1e-6 of its length."""
    if len(points) < 3:
        return False
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(extent[1] > max(1e-6 * extent[0], 1e-9))


def inside_hull(points: Floats, queries: Floats) -> NDArray[np.bool_]:
    """Whether each query (N, 2) lies in the convex hull of `points` (M, 2), border included.

    Fewer than three points, or points on one line, have an empty hull.
    """
    from scipy.spatial import ConvexHull

    if not spans_plane(points):
        return np.zeros(len(queries), dtype=np.bool_)
    centre = points.mean(axis=0)
    extent = np.abs(points - centre).max()
    sides = ConvexHull(points - centre).equations  # outward normal and offset of each side
    inside = (queries - centre) @ sides[:, :2].T + sides[:, 2] <= 1e-9 * extent
    return np.asarray(inside.all(axis=1))
