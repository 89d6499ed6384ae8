"""A curved skin laid flat: unrolled from its middle, then relaxed until lengths agree."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.layout.links import Ints, Links
from skinfield.layout.surface import flat_frame

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
    from scipy.sparse.csgraph import dijkstra

    count = len(positions)
    net = _net(count, links)
    found = dijkstra(net, directed=False, indices=np.array([root]), return_predecessors=True)
    far, parent = found[0][0], found[1][0]
    around = _around(count, links)
    plane, frames = np.zeros((count, 2)), np.zeros((count, 3, 3))
    frames[root] = flat_frame(normals[root])
    placed = np.zeros(count, np.bool_)
    placed[root] = True
    for taxel in np.argsort(far, kind="stable")[1:]:
        near, length = around[taxel]
        near, length = near[placed[near]], length[placed[near]]
        guess, tangent = _carried(positions, normals, plane, frames, near, taxel, length)
        lead = int(np.flatnonzero(near == parent[taxel])[0])
        agree = np.linalg.norm(guess - guess[lead], axis=1) <= 0.5 * length[lead]
        agree &= tangent @ tangent[lead] > 0.7
        weight = agree / length**2
        plane[taxel] = weight @ guess / weight.sum()
        frames[taxel] = _frame_of(weight @ tangent, normals[taxel])
        placed[taxel] = True
    return plane


def relax(plane: Floats, positions: Floats, links: Links, rounds: int = 4) -> Floats:
    """Move the taxels of `plane` (M, 2) m until links have their lengths along the skin.

    Least squares of the relative errors (Levenberg-Marquardt). Links that came out torn are left
    out, and taxels that are no neighbours are kept at least their distance in space apart, up to
    the reach of a link, so that the picture does not fold over itself.
    """
    for _ in range(rounds):
        held = holds(plane, links)
        pairs, length = links.pairs[held], links.length[held]
        plane = _least_squares(plane, positions, pairs, length)
    return plane


def holds(plane: Floats, links: Links) -> NDArray[np.bool_]:
    """Which links (E,) the plane keeps; the others are torn by the cut."""
    ratio = _distance(plane, links.pairs)[0] / links.length
    return np.asarray((ratio >= STRETCH[0]) & (ratio <= STRETCH[1]))


def _net(count: int, links: Links) -> Any:
    from scipy.sparse import csr_array

    return csr_array((links.length, (links.pairs[:, 0], links.pairs[:, 1])), shape=(count, count))


def _around(count: int, links: Links) -> list[tuple[Ints, Floats]]:
    """Neighbours of each taxel and their distances."""
    first = np.concatenate([links.pairs[:, 0], links.pairs[:, 1]])
    second = np.concatenate([links.pairs[:, 1], links.pairs[:, 0]])
    length = np.concatenate([links.length, links.length])
    order = np.argsort(first, kind="stable")
    cuts = np.searchsorted(first[order], np.arange(1, count))
    return list(zip(np.split(second[order], cuts), np.split(length[order], cuts), strict=True))


def turned(vectors: Floats, start: Floats, end: Floats) -> Floats:
    """Turn `vectors` (N, 3) by the smallest rotation from unit `start` to unit `end` (N, 3).

    Where they are opposite, tangent vectors are kept as they are: they are tangent to both sides.
    """
    axis = np.cross(start, end)
    cosine = np.einsum("ni,ni->n", start, end)[:, None]
    cross = np.cross(axis, vectors)
    smooth = vectors + cross + np.cross(axis, cross) / np.maximum(1.0 + cosine, 0.01)
    return np.where(cosine > -0.99, smooth, vectors)


def _carried(
    positions: Floats,
    normals: Floats,
    plane: Floats,
    frames: Floats,
    near: Ints,
    taxel: int,
    length: Floats,
) -> tuple[Floats, Floats]:
    """Where each of `near` sees `taxel` in the plane (n, 2), and its first tangent there (n, 3)."""
    start, end = normals[near], np.broadcast_to(normals[taxel], (len(near), 3))
    chord = positions[taxel] - positions[near]
    half = start + end
    half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-9)
    along = chord - half * np.einsum("ni,ni->n", half, chord)[:, None]
    along = turned(along, half, start)
    step = np.einsum("nij,ni->nj", frames[near][:, :, :2], along)
    size = np.maximum(np.linalg.norm(step, axis=1), 1e-12)
    return plane[near] + step * (length / size)[:, None], turned(frames[near][:, :, 0], start, end)


def _frame_of(tangent: Floats, normal: Floats) -> Floats:
    first = tangent - normal * (tangent @ normal)
    size = np.linalg.norm(first)
    if size < 1e-9:
        return flat_frame(normal)
    return np.column_stack([first / size, np.cross(normal, first / size), normal])


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


@dataclass(frozen=True, eq=False)
class _Misfit:
    """Relative errors (E,) of the lengths of pairs (E, 2), slopes (E, 2) by the second end."""

    pairs: Ints
    error: Floats
    slope: Floats

    @property
    def total(self) -> float:
        return float(self.error @ self.error)


def _misfit(plane: Floats, positions: Floats, pairs: Ints, length: Floats, reach: float) -> _Misfit:
    crowded, least = _crowded(plane, positions, pairs, reach)
    pairs, length = np.concatenate([pairs, crowded]), np.concatenate([length, least])
    distance, offset = _distance(plane, pairs)
    slope = offset / np.maximum(distance * length, 1e-15)[:, None]
    return _Misfit(pairs, distance / length - 1.0, slope)


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
    misfit = _misfit(plane, positions, pairs, length, reach)
    for _ in range(STEPS):
        step = _newton_step(misfit, len(plane), damping)
        trial = _misfit(plane + step, positions, pairs, length, reach)
        if trial.total < misfit.total:
            plane, misfit, damping = plane + step, trial, max(damping * 0.2, 1e-6)
            if np.abs(step).max() < 1e-4 * reach:
                break
        else:
            damping *= 10.0
    return plane
