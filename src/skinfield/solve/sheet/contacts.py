"""Contact search on a sheet of many taxels: windows about what stands out, and their noise."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints
from skinfield.estimate import Contact, ContactFinder
from skinfield.estimate.ranking import by_falling_force
from skinfield.skin import Grid
from skinfield.solve.sheet.plan import TOO_DENSE, SheetPlan

TILE = 16  # cells along a side: some contacts wide
TOUCHING = np.ones((3, 3), dtype=bool)  # tiles that touch, at corners too
AROUND = 1.5  # reaches of a taxel's neighbours, beyond which the matrix' inverse has died away
SAMPLES = 9  # tiles by which the deviation of a sheet's cells is known
MOST = 0.99  # of the cells, whose deviation is no higher


@dataclass(frozen=True, eq=False)
class WindowNoise:
    """Noise of the pressure in a window of a sheet, from the taxels near it: a `PressureError`.

    Attributes
    ----------
    plan : SheetPlan
    valid : (L,) bool array
        Taxels that answered, in the plan's order.
    felt : int
        Chances of a false alarm: the cells of the whole sheet.
    corner : (column, row)
        First cell of the window.
    shape : (rows, columns)
        Of its cells.
    """

    plan: SheetPlan
    valid: NDArray[np.bool_]
    felt: int
    corner: tuple[int, int]
    shape: tuple[int, int]

    @classmethod
    def whole(cls, plan: SheetPlan, valid: NDArray[np.bool_]) -> "WindowNoise":
        """Of all cells; taxels (L,) in the plan's order."""
        shape = plan.lattice.shape
        return cls(plan, valid, shape[0] * shape[1], (0, 0), shape)

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa; tile by tile."""
        out = np.zeros(self.shape)
        for row in range(0, self.shape[0], TILE):
            for column in range(0, self.shape[1], TILE):
                part = out[row : row + TILE, column : column + TILE]
                near, stamps = self._stamps(np.array([column, row]), part.shape)
                moved = self._moved(near, stamps.toarray())
                part[:] = np.sqrt(np.square(moved).sum(axis=0)).reshape(part.shape)
        return out.ravel()

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        place = np.stack(np.divmod(cells, self.shape[1])[::-1], axis=1)
        low = place.min(axis=0)
        width, height = place.max(axis=0) - low + 1
        near, stamps = self._stamps(low, (height, width))
        column, row = (place - low).T
        sums = stamps[:, row * width + column] @ weights.T
        moved = self._moved(near, np.asarray(sums))
        return np.asarray(moved.T @ moved)

    @cached_property
    def _near(self) -> Ints:
        """Taxels of the plan that answered and have a say in the window."""
        return self._reaching(np.flatnonzero(self.valid), np.zeros(2, dtype=int), self.shape)

    @cached_property
    def _matrix(self) -> Any:
        """Rows and columns of these taxels of the system, sparse."""
        from scipy.sparse import eye_array

        lower = self.plan.gram.lower[self._near][:, self._near].astype(np.float64)
        return (lower + lower.T + eye_array(len(self._near))).tocsc()

    def _reaching(self, taxels: Ints, low: Ints, shape: tuple[int, int]) -> Ints:
        """Those of some taxels that have a say in a box, `low` (2,) cells from the corner."""
        plan = self.plan
        far = plan.stamps.spread.reach + AROUND * plan.stamps.neighbours
        place = plan.placing.place[taxels] - (low + self.corner)
        inside = np.all((place > -far) & (place < np.array(shape[::-1]) - 1 + far), axis=1)
        return np.asarray(taxels[inside])

    def _stamps(self, low: Ints, shape: tuple[int, int]) -> tuple[Ints, Any]:
        """Taxels (N,) with a say in a box, and what each adds to its cells, sparse (N, K)."""
        from scipy.sparse import csr_array

        plan, stamp = self.plan, self.plan.stamps.spread
        near = self._reaching(self._near, low, shape)
        values = stamp.at(plan.offset[near].astype(np.float64)) * plan.gain[near, None, None]
        begin = plan.placing.place[near].astype(int) - (stamp.reach - 1) - (low + self.corner)
        column, row = begin.T[:, :, None] + np.arange(2 * stamp.reach)
        taxel = np.arange(len(near))[:, None, None]
        taxel, row, column = np.broadcast_arrays(taxel, row[:, :, None], column[:, None, :])
        inside = (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
        entries = values[inside], (taxel[inside], (row * shape[1] + column)[inside])
        return near, csr_array(entries, shape=(len(near), shape[0] * shape[1]))

    def _moved(self, near: Ints, sums: Floats) -> Floats:
        """By how much one deviation of each reading moves sums (N, M) of what taxels add."""
        from scipy.sparse.linalg import splu

        if not len(near):
            return np.zeros_like(sums)
        at = np.searchsorted(self._near, near)
        factors = splu(
            self._matrix[at][:, at].tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        if not (factors.U.diagonal() > 0.0).all():
            raise InputError(TOO_DENSE)
        return np.asarray(factors.solve(sums) * self.plan.share[near, None], dtype=np.float64)


def highest_std(plan: SheetPlan) -> float:
    """Deviation that few cells exceed, Pa, by those about some taxels, where all answer."""
    whole = WindowNoise.whole(plan, np.ones(len(plan.placing.order), dtype=bool))
    some = np.linspace(0, len(whole.valid) - 1, SAMPLES).astype(int)
    corners = np.maximum(plan.placing.cell[some] - TILE // 2, 0).tolist()
    tiles = [replace(whole, corner=tuple(corner), shape=(TILE, TILE)) for corner in corners]
    return float(np.quantile(np.concatenate([tile.std for tile in tiles]), MOST))


def windows(high: NDArray[np.bool_]) -> Iterator[tuple[slice, slice, NDArray[np.bool_]]]:
    """Windows about the cells (rows, columns) that are marked: one for each group of tiles.

    Groups do not touch, so what stands in one cannot be a part of another. Each is rows and columns
    of cells, a tile wider than the group, and which of them belong to no other group.
    """
    from scipy import ndimage

    hot = np.zeros([-(-cells // TILE) for cells in high.shape], dtype=bool)
    row, column = np.nonzero(high)
    hot[row // TILE, column // TILE] = True
    labels, _ = ndimage.label(hot, TOUCHING)
    for index, group in enumerate(ndimage.find_objects(labels), start=1):
        tiles = tuple(slice(max(part.start - 1, 0), part.stop + 1) for part in group)
        free = np.isin(labels[tiles], (0, index)).repeat(TILE, axis=0).repeat(TILE, axis=1)
        rows, columns = (
            slice(part.start * TILE, min(part.stop * TILE, cells))
            for part, cells in zip(tiles, high.shape, strict=True)
        )
        yield rows, columns, free[: rows.stop - rows.start, : columns.stop - columns.start]


def contacts_on(
    grid: Grid, pressure: NDArray[Any], finder: ContactFinder, noise: WindowNoise, std: float
) -> tuple[Contact, ...]:
    """Contacts of a pressure (K,) Pa, searched where it exceeds what noise reaches on the sheet.

    `noise` is that of all cells, `std` Pa a deviation that few of them exceed. Each window is given
    to the finder as a patch of its own: two contacts far from each other do not know of each other,
    and no finder sees a million cells.
    """
    field = pressure.reshape(grid.shape)
    least = finder.sigmas(noise) * std
    contacts: list[Contact] = []
    for rows, columns, free in windows(field > least):
        part = np.where(free, field[rows, columns], 0.0).astype(np.float64)
        corner = columns.start, rows.start
        own = Grid(grid.patch, part.shape, grid.pitch, grid.origin + np.array(corner) * grid.pitch)
        of_window = replace(noise, corner=corner, shape=part.shape)
        for contact in finder(own, part.ravel(), of_window):
            if contact.peak_pressure > least:  # else it lies between groups
                down, right = np.divmod(contact.cells, part.shape[1])
                cells = (down + rows.start) * grid.shape[1] + right + columns.start
                contacts.append(Contact.later(contact, cells=cells))
    return by_falling_force(contacts)
