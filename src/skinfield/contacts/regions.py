"""Peaks of a field and the region that belongs to each."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


def regions(
    values: Floats, least_drop: Floats, floor: Floats, edge: float
) -> list[NDArray[np.int64]]:
    """Split a picture into the regions of its peaks.

    Water falls from the highest cell; each cell joins the hill of its highest neighbour (eight of
    them). Where two hills meet, the lower one stays its own only if its peak stands out of the
    saddle by `least_drop` there; else it is a shoulder of the higher.

    Parameters
    ----------
    values, least_drop, floor : (rows, columns) arrays
        Cells at or below `floor` belong to no region.
    edge : float
        A region ends at this fraction of its own peak.

    Returns
    -------
    list of int arrays
        Flat cells of each region, by falling peak.
    """
    flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
    above = np.flatnonzero(flat > floor.ravel())
    order = above[np.argsort(-flat[above], kind="stable")]
    peaks = _compiled()(flat, np.ascontiguousarray(least_drop.ravel()), order, values.shape[1])
    kept = order[flat[order] >= edge * flat[peaks[order]]]
    owners = peaks[kept]
    return [np.sort(kept[owners == peak]) for peak in order[peaks[order] == order]]


def _flood(
    flat: Floats, least_drop: Floats, order: NDArray[np.int64], columns: int
) -> NDArray[np.int64]:
    """Cell of the peak that each cell belongs to, -1 for the cells that are not in `order`."""
    parent = np.full(len(flat), -1, dtype=np.int64)
    rows = len(flat) // columns
    for cell in order:
        row, column = cell // columns, cell % columns
        best = -1
        for step in range(9):
            r, c = row + step // 3 - 1, column + step % 3 - 1
            if step == 4 or r < 0 or r >= rows or c < 0 or c >= columns:
                continue
            other = r * columns + c
            if parent[other] < 0:
                continue
            while parent[other] != other:
                other = parent[other]
            if best < 0:
                best = other
            elif other != best:
                higher, lower = (best, other) if flat[best] >= flat[other] else (other, best)
                best = higher
                if flat[lower] - flat[cell] < least_drop[lower]:
                    parent[lower] = higher
        parent[cell] = cell if best < 0 else best
    for cell in order:  # from the top: a parent is always final before its children
        parent[cell] = parent[parent[cell]]
    return parent


@lru_cache(maxsize=1)
def _compiled() -> Any:
    """`_flood` as machine code: it runs per reading, over every cell above the floor."""
    from numba import njit

    return njit(cache=True, nogil=True)(_flood)


def border(cells: NDArray[np.int64], shape: tuple[int, int]) -> Floats:
    """Corners of the longest loop around a region of cells, closed, in units of cells.

    Returns
    -------
    (N, 2) array
        Column and row coordinates; the centre of cell (row, column) is (column, row). The region
        lies to the left of the way.
    """
    inside = set(cells.tolist())
    columns = shape[1]
    following: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for cell in inside:
        r, c = divmod(cell, columns)
        sides = (
            ((0, -1), (c, r), (c + 1, r)),
            ((1, 0), (c + 1, r), (c + 1, r + 1)),
            ((0, 1), (c + 1, r + 1), (c, r + 1)),
            ((-1, 0), (c, r + 1), (c, r)),
        )
        for (step_c, step_r), start, end in sides:
            beside = c + step_c
            outside = not 0 <= beside < columns or (r + step_r) * columns + beside not in inside
            if outside:
                following.setdefault(start, []).append(end)
    best: list[tuple[int, int]] = []
    while following:
        start = next(iter(following))
        loop = [start]
        while True:
            ends = following[loop[-1]]
            end = ends.pop()
            if not ends:
                del following[loop[-1]]
            loop.append(end)
            if end == start:
                break
        if len(loop) > len(best):
            best = loop
    return np.array(best, dtype=np.float64) - 0.5
