"""Pieces of a sheet in which something stands out, so that each can be looked at as a patch is."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.fields import Contact
from skinfield.fields.noise import PressureError
from skinfield.layout import Grid

TILE = 16  # cells along a side: some contacts wide
AROUND = np.ones((3, 3), dtype=bool)  # tiles that touch, at corners too


class Finder(Protocol):
    """What finds contacts in a pressure; `ContactFinder` does."""

    @property
    def false_alarm_rate(self) -> float:
        """Readings of an idle sheet in which a contact may be seen."""
        ...

    def __call__(
        self, grid: Grid, pressure: Floats, noise: PressureError, /
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,) Pa."""
        ...


@dataclass(frozen=True)
class Window:
    """A rectangle of cells, and the tiles of it that are its own.

    Attributes
    ----------
    rows, columns : slice
        Of the sheet: the tiles in which something stands out and those around them.
    mine : (rows, columns) bool array
        By tile, from the window's first; a contact whose middle lies elsewhere is another's.
    """

    rows: slice
    columns: slice
    mine: NDArray[np.bool_]

    def owns(self, row: float, column: float) -> bool:
        """Whether a place, in cells from the window's first, is in its own tiles."""
        at = int((row + 0.5) // TILE), int((column + 0.5) // TILE)
        inside = all(0 <= index < count for index, count in zip(at, self.mine.shape, strict=True))
        return inside and bool(self.mine[at])


def windows(high: NDArray[np.bool_]) -> Iterator[Window]:
    """Windows about the cells (rows, columns) that are marked: one for each group of tiles.

    Groups do not touch, so what stands in one cannot be a part of another.
    """
    from scipy import ndimage

    rows, columns = high.shape
    down, right = -(-rows // TILE), -(-columns // TILE)
    row, column = np.nonzero(high)
    hot = np.zeros((down, right), dtype=bool)
    hot[row // TILE, column // TILE] = True
    labels, _ = ndimage.label(hot, AROUND)
    for index, (y, x) in enumerate(ndimage.find_objects(labels), start=1):
        y = slice(max(y.start - 1, 0), min(y.stop + 1, down))
        x = slice(max(x.start - 1, 0), min(x.stop + 1, right))
        mine = ndimage.binary_dilation(labels[y, x] == index, AROUND)
        mine &= (labels[y, x] == index) | (labels[y, x] == 0)
        yield Window(
            slice(y.start * TILE, min(y.stop * TILE, rows)),
            slice(x.start * TILE, min(x.stop * TILE, columns)),
            mine,
        )


def contacts_of(
    grid: Grid, window: Window, found: tuple[Contact, ...], columns: int, least: NDArray[Any]
) -> Iterator[Contact]:
    """Contacts of one window that are its own, their cells those of a sheet with some columns.

    `least` (K,) Pa is what one cell of a contact has to exceed.
    """
    for contact in found:
        column, row = (contact.position[:2] - grid.origin) / grid.pitch
        if not window.owns(row, column) or contact.peak_pressure < least[contact.cells].min():
            continue
        down, right = np.divmod(contact.cells, grid.shape[1])
        cells = (down + window.rows.start) * columns + right + window.columns.start
        yield Contact.later(contact, cells=cells)
