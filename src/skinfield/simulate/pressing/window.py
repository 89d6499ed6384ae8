"""Windows of finer squares on the grid's cells: where bodies touch."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.mechanics.contact import rim

ACROSS = 48  # squares across a contact
FINEST = 81  # squares along a cell
MOST = 100_000  # squares of all windows
APART = 4  # cells between windows: nearer ones are one


@dataclass(frozen=True)
class Window:
    """A rectangle of the grid's cells, each cut into split x split squares.

    Attributes
    ----------
    row, column : int
        Its first cell.
    rows, columns : int
        Cells along y and x.
    split : int
        Odd, so that the middle square of a cell has the cell's centre.
    """

    row: int
    column: int
    rows: int
    columns: int
    split: int = 1

    @property
    def shape(self) -> tuple[int, int]:
        """Squares along y and x."""
        return self.rows * self.split, self.columns * self.split

    @property
    def size(self) -> int:
        """Number of squares."""
        return self.shape[0] * self.shape[1]

    @property
    def cells(self) -> tuple[slice, slice]:
        """Its cells in a picture (rows, columns) of the grid."""
        return slice(self.row, self.row + self.rows), slice(self.column, self.column + self.columns)

    def steps(self) -> tuple[Floats, Floats]:
        """Centres of the squares along y and x, in cells from the grid's first node."""
        inside = [(np.arange(n) + 0.5) / self.split - 0.5 for n in self.shape]
        return inside[0] + self.row, inside[1] + self.column

    def means(self, values: Floats) -> Floats:
        """Mean over each cell, (..., rows, columns), of values on the squares."""
        return coarsened(values, self.split)

    def centres(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values on the squares in the middle of each cell, (..., rows, columns)."""
        middle, every = self.split // 2, self.split
        return values[..., middle::every, middle::every]

    def grown(self, margin: int, shape: tuple[int, int]) -> "Window":
        """With so many cells more on every side, as far as the grid of `shape` goes."""
        row, column = max(self.row - margin, 0), max(self.column - margin, 0)
        last = min(self.row + self.rows + margin, shape[0])
        right = min(self.column + self.columns + margin, shape[1])
        return Window(row, column, last - row, right - column, self.split)

    def embedded(self, values: Floats, larger: "Window") -> Floats:
        """Values on the squares of a larger window of the same split, 0 beyond."""
        out = np.zeros((*values.shape[:-2], *larger.shape))
        top = (self.row - larger.row) * self.split
        left = (self.column - larger.column) * self.split
        out[..., top : top + self.shape[0], left : left + self.shape[1]] = values
        return out


def coarsened(values: Floats, factor: int) -> Floats:
    """Mean over blocks of factor x factor of the last two axes."""
    rows, columns = (n // factor for n in values.shape[-2:])
    blocks = values.reshape(*values.shape[:-2], rows, factor, columns, factor)
    return np.asarray(blocks.mean(axis=(-3, -1)))


def resplit(values: Floats, split: int, wanted: int) -> Floats:
    """Loads per area on squares of another split; both are powers of 3."""
    if split >= wanted:
        return coarsened(values, split // wanted)
    factor = wanted // split
    return np.repeat(np.repeat(values, factor, axis=-2), factor, axis=-1)


def touched(windows: list[Window], masks: list[NDArray[np.bool_]]) -> list[Window | None]:
    """Smallest window of cells around each mask of squares; None around none."""
    out: list[Window | None] = []
    for window, mask in zip(windows, masks, strict=True):
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            out.append(None)
            continue
        top, left = rows[0] // window.split, columns[0] // window.split
        bottom, right = rows[-1] // window.split, columns[-1] // window.split
        out.append(
            Window(
                int(window.row + top),
                int(window.column + left),
                int(bottom - top + 1),
                int(right - left + 1),
            )
        )
    return out


def width(mask: NDArray[np.bool_], coverage: Floats) -> float:
    """What a contact measures across, in squares: less than its extent if it is long or hollow.

    Eight times its area over the length of its border, which is twice the diameter of a disc, four
    times the width of a bar and of a ring.
    """
    extent = max(int(mask.any(axis=axis).sum()) for axis in (0, 1))
    area, border = float(coverage[mask].sum()), float(rim(mask).sum())
    return min(float(extent), max(8.0 * area / border, 0.1))


def merged(found: list[tuple[Window, float]]) -> list[tuple[Window, float]]:
    """Join windows that are less than `APART` cells from each other; the smaller width counts."""
    found = list(found)
    index = 0
    while index < len(found):
        one, width = found[index]
        for other_index in range(index + 1, len(found)):
            other, narrower = found[other_index]
            gap = max(
                max(one.row, other.row) - min(one.row + one.rows, other.row + other.rows),
                max(one.column, other.column)
                - min(one.column + one.columns, other.column + other.columns),
            )
            if gap < APART:
                row, column = min(one.row, other.row), min(one.column, other.column)
                bottom = max(one.row + one.rows, other.row + other.rows)
                right = max(one.column + one.columns, other.column + other.columns)
                joined = Window(row, column, bottom - row, right - column)
                found[index] = (joined, min(width, narrower))
                del found[other_index]
                index = -1
                break
        index += 1
    return found


def cut(found: list[tuple[Window, float]]) -> list[Window]:
    """Split windows for `ACROSS` squares over each width, in cells, but `MOST` squares in all."""
    splits = []
    for _, width in found:
        split = 1
        while split * width < ACROSS and split < FINEST:
            split *= 3
        splits.append(split)
    cells = [window.rows * window.columns for window, _ in found]
    while True:
        sizes = [c * s**2 for c, s in zip(cells, splits, strict=True)]
        largest = int(np.argmax(sizes))
        if sum(sizes) <= MOST or splits[largest] == 1:
            break
        splits[largest] //= 3
    return [replace(window, split=s) for (window, _), s in zip(found, splits, strict=True)]
