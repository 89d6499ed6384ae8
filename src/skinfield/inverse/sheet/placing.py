"""Where taxels stand among the cells, in an order that keeps neighbours near in memory."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints


@dataclass(frozen=True, eq=False)
class Lattice:
    """Cells that hold the stamps of all taxels.

    Attributes
    ----------
    shape : (rows, columns)
    pitch : float, m
        Side of a cell.
    origin : (2,) array, m
        Centre of cell (0, 0) in the sheet's plane.
    """

    shape: tuple[int, int]
    pitch: float
    origin: Floats

    @classmethod
    def around(cls, low: Floats, high: Floats, pitch: float, before: int, after: int) -> "Lattice":
        """Cells over the rectangle low .. high (2,) m and what stamps reach beyond.

        Stamps begin `before` - 1 cells before that of a taxel; their last column is `after` cells
        behind it. The outermost taxels stand half a cell away from where that would not hold, as
        nothing is checked when stamps are written.
        """
        columns, rows = np.floor((high - low) / pitch).astype(int).tolist()
        shape = (rows + 2 * before + 1, columns + before + after + 1)
        return cls(shape, pitch, low - (before - 0.5) * pitch)


@dataclass(frozen=True, eq=False)
class Placing:
    """Taxels in strips of cells, from left to right in each: neighbours lie close in memory.

    Attributes
    ----------
    order : (L,) int array
        Row of each taxel in what the caller hands in.
    place : (L, 2) array
        In cells from the lattice's origin, in that order.
    strip : (N + 1,) int array
        Where each strip begins.
    height : float
        Of a strip, in cells.
    """

    order: Ints
    place: Floats
    strip: Ints
    height: float

    @classmethod
    def of(cls, place: Floats, height: float) -> "Placing":
        """Sort places (L, 2) into strips of some height in cells."""
        row = (place[:, 1] / height).astype(np.int64)
        width = float(place[:, 0].max()) + 1.0
        order = np.argsort(row * width + place[:, 0])  # x is below width: a strip after another
        strip = np.zeros(int(row.max()) + 2, dtype=np.int64)
        np.cumsum(np.bincount(row), out=strip[1:])
        return cls(order, place[order], strip, height)

    @property
    def cell(self) -> NDArray[np.int32]:
        """Cell that holds each taxel, (L, 2): column and row."""
        return self.place.astype(np.int32)

    @property
    def offset(self) -> Floats:
        """Place in the cell, (L, 2), 0 to 1."""
        return self.place - np.floor(self.place)

    def corner(self, reach: int, columns: int) -> Ints:
        """Flat index of the first cell of a stamp that reaches some cells, (L,)."""
        column, row = (self.cell - (reach - 1)).T.astype(np.int64)
        return np.asarray(row * columns + column)


def nearest_distance(placing: Placing) -> float:
    """Median distance of a taxel to the nearest other, in cells; a strip's height at most."""
    from skinfield.inverse.sheet.gram_kernel import nearest

    out = np.empty(len(placing.order))
    nearest(placing.place, placing.strip, placing.height, out)
    return float(np.median(out))
