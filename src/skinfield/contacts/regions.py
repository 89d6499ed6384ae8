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


def _walk(inside: NDArray[np.bool_], row: int, column: int) -> NDArray[np.int64]:
    """Corners (column, row) of the way around a region, from the lower left one of a lowest cell.

    The region stays on the left. Where two cells touch at a corner only, the way turns right, into
    the other: such cells are neighbours.
    """
    rows, columns = inside.shape
    way = np.empty((4 * rows * columns + 1, 2), dtype=np.int64)
    x, y, dx, dy = column, row, 1, 0
    way[0] = x, y
    for length in range(1, len(way)):
        x, y = x + dx, y + dy
        way[length] = x, y
        if x == column and y == row:
            break
        right_x, right_y = x + (dx + dy - 1) // 2, y + (dy - dx - 1) // 2
        left_x, left_y = x + (dx - dy - 1) // 2, y + (dy + dx - 1) // 2
        if 0 <= right_x < columns and 0 <= right_y < rows and inside[right_y, right_x]:
            dx, dy = dy, -dx
        elif not (0 <= left_x < columns and 0 <= left_y < rows and inside[left_y, left_x]):
            dx, dy = -dy, dx
    return way[: length + 1]


@lru_cache(maxsize=1)
def _compiled() -> Any:
    """`_flood` as machine code: it runs per reading, over every cell above the floor."""
    from numba import njit

    return njit(cache=True, nogil=True)(_flood)


@lru_cache(maxsize=1)
def _compiled_walk() -> Any:
    """`_walk` as machine code: it runs per contact."""
    from numba import njit

    return njit(cache=True, nogil=True)(_walk)


def border(cells: NDArray[np.int64], shape: tuple[int, int]) -> Floats:
    """Corners of the way around a connected region of cells, closed, in units of cells.

    Parameters
    ----------
    cells : (N,) int array
        Flat, sorted; connected by sides or corners.
    shape : (rows, columns)

    Returns
    -------
    (N, 2) array
        Column and row coordinates; the centre of cell (row, column) is (column, row). The region
        lies to the left of the way; holes are not walked around.
    """
    inside = np.zeros(shape, dtype=np.bool_)
    inside.ravel()[cells] = True
    row, column = divmod(int(cells[0]), shape[1])
    return np.asarray(_compiled_walk()(inside, row, column) - 0.5)
