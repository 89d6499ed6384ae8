"""How the area of a region moves with the pressure."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.layout import Grid

# Variance, in cells, of the count in a disc at random per side of its border: 0.4576 R over 8 R
# (Kendall, On the number of lattice points inside a random oval, Quart. J. Math. 19, 1948).
ROUNDING = 0.0572
ALONG = ((0, 1), (0, -1), (1, 0), (-1, 0))  # row, column: from a cell to those beside it


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
        Cells on both sides of the border, and the peak; some come more than once.
    weights : (M,) array, m²/Pa
    rounding : float, m²
        One standard deviation of an area that is counted in whole cells.
    """
    rows, columns = grid.shape
    picture = pressure.reshape(grid.shape)
    slope = np.gradient(picture) if min(grid.shape) > 1 else [np.zeros_like(picture)] * 2
    inside = np.zeros(grid.shape, dtype=bool)
    inside.ravel()[cells] = True
    row, column = np.divmod(cells, columns)
    peak = int(cells[np.argmax(pressure[cells])])
    level = edge * pressure[peak]
    around, weights, sides = [], [], 0
    for down, right in ALONG:
        there = row + down, column + right
        on = (there[0] >= 0) & (there[0] < rows) & (there[1] >= 0) & (there[1] < columns)
        here = cells[on]
        beside = there[0][on] * columns + there[1][on]
        border = ~inside.ravel()[beside]
        sides += int(border.sum()) + int((~on).sum())
        crossed = border & (pressure[beside] < level) & (pressure[here] > level)
        here, beside = here[crossed], beside[crossed]
        across = pressure[here] - pressure[beside]
        tangent = slope[1 if down else 0].ravel()
        along = (tangent[here] + tangent[beside]) / 2
        share = (pressure[here] - level) / across  # of the way to the cell beside
        per_pascal = grid.cell_area * across / (across**2 + along**2)
        around += [here, beside]
        weights += [per_pascal * (1 - share), per_pascal * share]
    moves = np.concatenate(weights)
    around.append(np.array([peak]))
    total = np.append(moves, -edge * moves.sum())
    return np.concatenate(around), total, float(grid.cell_area * np.sqrt(ROUNDING * sides))
