"""Peaks of a field, the region that belongs to each, and its border."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

Regions = tuple[Ints, Ints]  # starts (R + 1,) and flat cells: those of n from starts[n] on


def regions(values: Floats, least_drop: Floats, floor: float, edge: float) -> list[Ints]:
    """Split a picture into the regions of its peaks.

    Water falls from the highest cell; each cell joins the hill of its highest neighbour (eight of
    them). Where two hills meet, the lower one stays its own only if its peak stands out of the
    saddle by `least_drop` there; else it is a shoulder of the higher.

    Parameters
    ----------
    values, least_drop : (rows, columns) arrays
    floor : float
        Cells at or below it belong to no region.
    edge : float
        A region ends at this fraction of its own peak.

    Returns
    -------
    list of int arrays
        Flat cells of each region, rising; by falling peak.
    """
    flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
    least = np.ascontiguousarray(least_drop, dtype=np.float64).ravel()
    kernel, (rows, columns) = compiled(), values.shape
    work = kernel.room_for(rows, columns)
    count = kernel.flood(flat, least, columns, 1.0, 0.0, floor, edge, work)
    starts, cells = work[2][kernel.STARTS], work[2][kernel.REGIONS]
    return [cells[starts[n] : starts[n + 1]].copy() for n in range(count)]


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
    from skinfield.contacts.sum_kernel import walk_around

    return np.asarray(walk_around(cells, *shape) - 0.5)


@lru_cache(maxsize=1)
def compiled() -> Any:
    """The kernels, loaded when first needed."""
    from skinfield.contacts import flood_kernel

    return flood_kernel
