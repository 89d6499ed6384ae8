"""Which taxels of a curved skin are neighbours, and how far they are from each other along it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

Ints = NDArray[np.int64]

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
