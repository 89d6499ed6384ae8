"""Peaks of a field and the region that belongs to each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


@dataclass
class _Hill:
    """A peak and the cells that drain to it while the water falls."""

    peak: int
    cells: list[int]


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
    rows, columns = values.shape
    flat, drop = values.ravel(), least_drop.ravel()
    order = np.flatnonzero(flat > floor.ravel())
    order = order[np.argsort(-flat[order], kind="stable")]
    owner: dict[int, _Hill] = {}
    hills: list[_Hill] = []
    for cell in order.tolist():
        around = _distinct([owner[n] for n in _neighbours(cell, rows, columns) if n in owner])
        if not around:
            hill = _Hill(cell, [cell])
            hills.append(hill)
        else:
            around.sort(key=lambda h: -flat[h.peak])
            hill = around[0]
            hill.cells.append(cell)
            for lower in around[1:]:
                if flat[lower.peak] - flat[cell] < drop[lower.peak]:
                    for member in lower.cells:
                        owner[member] = hill
                    hill.cells += lower.cells
                    hills = [kept for kept in hills if kept is not lower]
        owner[cell] = hill
    found = [np.sort(np.array(hill.cells)) for hill in hills]
    return [cells[flat[cells] >= edge * flat[cells].max()] for cells in found]


def _distinct(hills: list[_Hill]) -> list[_Hill]:
    return list({id(hill): hill for hill in hills}.values())


def _neighbours(cell: int, rows: int, columns: int) -> list[int]:
    row, column = divmod(cell, columns)
    return [
        r * columns + c
        for r in range(max(row - 1, 0), min(row + 2, rows))
        for c in range(max(column - 1, 0), min(column + 2, columns))
        if (r, c) != (row, column)
    ]


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
