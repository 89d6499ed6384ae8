"""How the noise of the readings moves the pressure in a window of a sheet."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints
from skinfield.inverse.sheet.gram import TOO_DENSE
from skinfield.inverse.sheet.plan import SheetPlan
from skinfield.inverse.sheet.windows import TILE

AROUND = 1.5  # reaches of a taxel's neighbours, beyond which the matrix' inverse has died away


@dataclass(frozen=True, eq=False)
class SheetNoise:
    """Noise of the pressure in a window, from the taxels that are near it.

    Attributes
    ----------
    plan : SheetPlan
    valid : (L,) bool array
        Taxels that answered, in the sheet's order.
    rows, columns : slice
        Of the sheet's cells.
    """

    plan: SheetPlan
    valid: NDArray[np.bool_]
    rows: slice
    columns: slice

    @property
    def _width(self) -> int:
        return int(self.columns.stop - self.columns.start)

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa; tile by tile."""
        out = np.zeros((self.rows.stop - self.rows.start, self._width))
        for row in range(0, len(out), TILE):
            for column in range(0, self._width, TILE):
                part = out[row : row + TILE, column : column + TILE]
                corner = np.array([column + self.columns.start, row + self.rows.start])
                part[:] = self._tile(corner, part.shape)
        return out.ravel()

    @property
    def felt(self) -> int:
        """Number of cells whose deviation is not 0."""
        return int(np.count_nonzero(self.std))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        from scipy.sparse.linalg import spsolve

        row, column = np.divmod(cells, self._width)
        place = np.column_stack([column + self.columns.start, row + self.rows.start])
        near = self._near(place.min(axis=0), place.max(axis=0))
        if not len(near):
            return np.zeros((len(weights), len(weights)))
        sums = np.stack([self._read(place, weight, near) for weight in weights], axis=1)
        moved = spsolve(self._matrix(near).tocsc(), sums).reshape(len(near), -1)
        moved *= self._per_std(near)[:, None]
        return np.asarray(moved.T @ moved)

    def _tile(self, corner: Ints, shape: tuple[int, int]) -> Floats:
        """Deviation of the cells of one tile."""
        near = self._near(corner, corner + np.array(shape[::-1]) - 1)
        if not len(near):
            return np.zeros(shape)
        matrix = self._matrix(near).toarray()
        factor = _solved(matrix, self._stamps(corner, shape, near)) * self._per_std(near)[:, None]
        return np.asarray(np.sqrt(np.square(factor).sum(axis=0)).reshape(shape))

    def _per_std(self, near: Ints) -> Floats:
        """What one standard deviation of each reading adds to the system's right side."""
        return np.asarray(self.plan.scale[near] * self.plan.noise_std[near], dtype=np.float64)

    def _near(self, low: Ints, high: Ints) -> Ints:
        """Taxels that have a say in the cells low .. high (2,): column and row."""
        plan = self.plan
        far = plan.stamps.spread.reach + AROUND * plan.stamps.neighbours
        place = plan.placing.place
        strip, height = plan.placing.strip, plan.placing.height
        first = max(int((low[1] - far) // height), 0)
        last = min(max(int((high[1] + far) // height) + 1, first), len(strip) - 1)
        near = np.arange(strip[min(first, len(strip) - 1)], strip[last])
        inside = np.all((place[near] > low - far) & (place[near] < high + far), axis=1)
        return np.asarray(near[inside & self.valid[near]])

    def _matrix(self, near: Ints) -> Any:
        """Rows and columns of some taxels of the system, sparse."""
        from scipy.sparse import csr_array, eye_array

        gram = self.plan.gram
        first, count = gram.start[near], gram.start[near + 1] - gram.start[near]
        row = np.repeat(np.arange(len(near)), count)
        entry = np.repeat(first - np.append(0, np.cumsum(count)[:-1]), count) + np.arange(len(row))
        column = np.minimum(np.searchsorted(near, gram.other[entry]), len(near) - 1)
        kept = near[column] == gram.other[entry]
        value = gram.value[entry[kept]].astype(np.float64)
        shape = len(near), len(near)
        lower = csr_array((value, (row[kept], column[kept])), shape=shape)
        return lower + lower.T + eye_array(len(near))

    def _stamps(self, corner: Ints, shape: tuple[int, int], near: Ints) -> Floats:
        """What each of some taxels adds to the cells of a tile, (N, K)."""
        plan, (rows, columns) = self.plan, shape
        stamp = plan.stamps.spread
        values = stamp.at(plan.offset[near].astype(np.float64))
        out = np.zeros((len(near), rows, columns))
        begin = plan.placing.cell[near] - (stamp.reach - 1) - corner
        for index, (x, y) in enumerate(begin.tolist()):
            to = out[index, max(y, 0) : max(y + 2 * stamp.reach, 0)]
            to = to[:, max(x, 0) : max(x + 2 * stamp.reach, 0)]
            to[:] = values[index, max(-y, 0) :, max(-x, 0) :][: to.shape[0], : to.shape[1]]
        return np.asarray(out.reshape(len(near), -1) * plan.gain[near, None])

    def _read(self, place: Ints, weight: Floats, near: Ints) -> Floats:
        """Weighted sum, over some cells, of what each of some taxels adds, (N,)."""
        low = place.min(axis=0)
        width, height = place.max(axis=0) - low + 1
        field = np.zeros((height, width))
        np.add.at(field, (place[:, 1] - low[1], place[:, 0] - low[0]), weight)
        return np.asarray(self._stamps(low, field.shape, near) @ field.ravel())


def _solved(matrix: Floats, sides: Floats) -> Floats:
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    try:
        return np.asarray(cho_solve(cho_factor(matrix, overwrite_a=True), sides, overwrite_b=True))
    except LinAlgError:
        raise InputError(TOO_DENSE) from None
