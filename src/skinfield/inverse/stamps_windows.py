"""Smallest window that holds nearly all of a column's energy, compiled."""

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.stamps_kernel import Ints32

ROW = 4  # what a further row costs beside its numbers, in numbers


@njit(cache=True, nogil=True)
def window_of(energy: Floats, lost: float, unit: int, window: Ints32, sums: Floats) -> None:
    """Write first row, first column, rows and columns of the cheapest window into `window` (4,).

    `energy` (rows, columns) sums to 1, of which the window holds 1 - `lost`. Its columns are a
    multiple of `unit`, or all there are. Of those of one size it is the one that holds most.
    `sums` (rows + 1, columns + 1) is space to work in.
    """
    height, width = energy.shape
    sums[:] = 0.0
    for row in range(height):
        for column in range(width):
            above = sums[row, column + 1] - sums[row, column]
            sums[row + 1, column + 1] = sums[row + 1, column] + above + energy[row, column]
    needed = sums[height, width] - lost
    least = np.inf
    for step in range(1, (width + unit - 1) // unit + 1):
        columns = min(step * unit, width)
        low, high = 0, height  # the whole height of so few columns may hold too little
        if _most(sums, height, columns)[0] < needed:
            continue
        while high - low > 1:
            middle = (low + high) // 2
            if _most(sums, middle, columns)[0] >= needed:
                high = middle
            else:
                low = middle
        if high * (columns + ROW) < least:
            least = high * (columns + ROW)
            _, top, left = _most(sums, high, columns)
            window[:] = top, left, high, columns


@njit(cache=True, nogil=True)
def _most(sums: Floats, rows: int, columns: int) -> tuple[float, int, int]:
    """Most energy that a window of this size holds, and the window's first row and column."""
    best, top, left = -1.0, 0, 0
    for row in range(len(sums) - rows):
        for column in range(sums.shape[1] - columns):
            held = (
                sums[row + rows, column + columns]
                - sums[row, column + columns]
                - sums[row + rows, column]
                + sums[row, column]
            )
            if held > best:
                best, top, left = held, row, column
    return best, top, left
