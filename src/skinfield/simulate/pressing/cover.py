"""Where a body is over the cells, and how high: coverage of edges by points within a cell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.simulate.indenters import Indenter

POINTS = 10  # along each side of a cell that holds an edge
ROUNDS = 400  # of following a body that is thinner than a cell
CROSS = 0.73  # share of the dilation by four neighbours, the rest by eight: 0.1 cells in all


@dataclass(frozen=True, eq=False)
class Cover:
    """One body over a lattice of cells.

    Attributes
    ----------
    height : (rows, columns) array, m
        Median over the covered part of each cell, above the body's lowest point; infinite where the
        body is not.
    coverage : (rows, columns) array
        Covered fraction of each cell.
    grown : (rows, columns) array
        The same of a body whose edges stand out by a tenth of a cell, see `mechanics.contact`.
    """

    height: Floats
    coverage: Floats
    grown: Floats


def cover(indenter: Indenter, y: Floats, x: Floats, side: float, search: bool = False) -> Cover:
    """Look at a body over cells with centres at y (rows,) and x (columns,) m.

    Centres decide, but for cells at an edge: there `POINTS` x `POINTS` places do. Edges are
    followed from cell to cell and from the body's lowest point, so what is thinner than a cell is
    seen too. If there is none of it, `search` looks between the centres of all cells.
    """
    from scipy.ndimage import binary_dilation

    height = np.array(indenter.height(*np.meshgrid(x, y)), dtype=np.float64)
    coverage = np.isfinite(height).astype(np.float64)
    seen = Cover(height, coverage, coverage.copy())
    looked = np.zeros(height.shape, dtype=bool)
    block = np.ones((3, 3), dtype=bool)
    todo = _around(indenter.lowest, y, x, side)
    if search and not coverage.any():
        todo |= _between(indenter, y, x, side)
    for _ in range(ROUNDS):
        uncertain = binary_dilation(coverage > 0, block) & binary_dilation(coverage < 1, block)
        todo = (todo | uncertain) & ~looked
        if not todo.any():
            break
        _look_closer(indenter, todo, y, x, side, seen)
        looked |= todo
    return seen


def _around(place: tuple[float, float], y: Floats, x: Floats, side: float) -> NDArray[np.bool_]:
    """The cells within one cell of a place."""
    return (np.abs(y - place[1]) < 1.5 * side)[:, None] & (np.abs(x - place[0]) < 1.5 * side)


def _between(indenter: Indenter, y: Floats, x: Floats, side: float) -> NDArray[np.bool_]:
    """The cells of which one of `POINTS` x `POINTS` places is under the body, a row at a time."""
    shift = ((np.arange(POINTS) + 0.5) / POINTS - 0.5) * side
    across = (x[:, None] + shift).ravel()
    rows = []
    for place in y:
        fine = np.asarray(indenter.height(*np.meshgrid(across, place + shift)))
        rows.append(np.isfinite(fine).any(axis=0).reshape(len(x), POINTS).any(axis=1))
    return np.stack(rows)


def _look_closer(
    indenter: Indenter, cells: NDArray[np.bool_], y: Floats, x: Floats, side: float, seen: Cover
) -> None:
    """Fill in some cells from points within them and in a rim around, for the dilation."""
    row, column = np.nonzero(cells)
    shift = ((np.arange(-1, POINTS + 1) + 0.5) / POINTS - 0.5) * side
    across, along = (part.ravel() for part in np.meshgrid(shift, shift))
    fine = np.asarray(indenter.height(x[column, None] + across, y[row, None] + along))
    fine = fine.reshape(-1, POINTS + 2, POINTS + 2)
    there = np.isfinite(fine)
    seen.coverage[row, column] = there[:, 1:-1, 1:-1].mean(axis=(1, 2))
    four = there[:, 1:-1, 1:-1] | there[:, :-2, 1:-1] | there[:, 2:, 1:-1]
    four |= there[:, 1:-1, :-2] | there[:, 1:-1, 2:]
    eight = four | there[:, :-2, :-2] | there[:, :-2, 2:] | there[:, 2:, :-2] | there[:, 2:, 2:]
    seen.grown[row, column] = CROSS * four.mean(axis=(1, 2)) + (1 - CROSS) * eight.mean(axis=(1, 2))
    # A cell that the edge only nearly reaches has the height of the rim.
    within = there.copy()
    within[:, [0, -1]] = within[:, :, [0, -1]] = False
    some = np.asarray(within.any(axis=(1, 2), keepdims=True))
    counted = np.where(some, within, there)
    # The median, as the steep wall beside the face of a leaning body would spoil a mean.
    ordered = np.sort(np.where(counted, fine, np.inf).reshape(len(fine), -1), axis=1)
    count, every = counted.sum(axis=(1, 2)), np.arange(len(fine))
    low, high = ordered[every, np.maximum(count - 1, 0) // 2], ordered[every, count // 2]
    seen.height[row, column] = np.where(count, (low + np.where(count, high, 0.0)) / 2, np.inf)
