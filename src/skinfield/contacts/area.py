"""How the area of a region moves with the pressure."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.layout import Grid


def area_moves(
    grid: Grid, pressure: Floats, cells: NDArray[np.int64], edge: float
) -> tuple[NDArray[np.int64], Floats, float]:
    r"""First-order change of a region's area with the pressure of cells.

    The region ends where the pressure falls to `edge` of its peak, so by the implicit function
    theorem its border moves outwards by (dp - edge dp_peak) / \|grad p\|. The border is summed over
    the sides of cells at which it is crossed; each stands for a length pitch \|d_x p\| / \|grad p\|
    of it (pitch \|d_y p\| / \|grad p\| for a side along x).

    Parameters
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    cells : (N,) int array
        Of the region.
    edge : float
        Fraction of the peak.

    Returns
    -------
    around : (M,) int array
        Cells on both sides of the border, and last the peak, which may be one of them too.
    weights : (M,) array, m²/Pa
    rounding : float, m²
        One standard deviation of an area that is counted in whole cells.
    """
    from skinfield.contacts import sum_kernel as sums

    starts = np.array([0, len(cells)])
    table = np.zeros((1, sums.WIDTH))
    table[0, sums.PEAK] = pressure[cells].max()
    flat = np.ascontiguousarray(pressure, dtype=np.float64)
    _, around, weights = sums.borders(
        flat, grid.shape[1], grid.cell_area, edge, starts, cells, table
    )
    return around, weights, float(table[0, sums.ROUNDING])
