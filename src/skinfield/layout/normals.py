"""Which way a skin faces, from where its taxels are."""

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
