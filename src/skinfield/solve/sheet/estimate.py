"""Estimate of a sheet: deviations, displacement and contacts, worked out window by window."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Layer, Mechanics, displacement_kernel
from skinfield.errors import Floats, InputError, Ints, check_offers, check_shape
from skinfield.estimate import Contact
from skinfield.estimate.ranking import by_falling_force
from skinfield.estimate.uncertainty import PressureError
from skinfield.skin import Grid, Patch
from skinfield.solve.sheet.plan import TOO_DENSE, SheetPlan

if TYPE_CHECKING:
    from skinfield.solve.sheet.sheet import Sheet


TILE = 16  # cells along a side: some contacts wide
TOUCHING = np.ones((3, 3), dtype=bool)  # tiles that touch, at corners too


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
    labels, _ = ndimage.label(hot, TOUCHING)
    for index, (y, x) in enumerate(ndimage.find_objects(labels), start=1):
        y = slice(max(y.start - 1, 0), min(y.stop + 1, down))
        x = slice(max(x.start - 1, 0), min(x.stop + 1, right))
        mine = ndimage.binary_dilation(labels[y, x] == index, TOUCHING)
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


FAINT = 1e-5  # of the largest: what a displacement kernel is cut at
LONGEST = 256  # cells from a load to the end of its displacement
BLOCK = 8  # lengths of the kernel per side of a block


@dataclass(frozen=True, eq=False)
class SheetDeformation:
    """Displacement of the surface by a pressure on many cells.

    The response depends on the offset alone. The sheet is cut into blocks, each transformed with
    as much around it as the kernel reaches (overlap-save), so memory does not grow with the sheet
    and the time is in proportion to its cells.

    Attributes
    ----------
    mechanics : Mechanics
    layer : Layer
    pitch : float, m
        Side of a cell.
    shape : (rows, columns)
        Of the sheet's cells.
    """

    mechanics: Mechanics
    layer: Layer
    pitch: float
    shape: tuple[int, int]

    @cached_property
    def _sizes(self) -> Floats:
        """Largest displacement (LONGEST + 2,) m/Pa at each whole distance along x or y, or more."""
        ray = np.arange(LONGEST + 2) * self.pitch
        offsets = np.column_stack([ray, np.zeros_like(ray)])
        response = self.mechanics.surface_displacement(self.layer, offsets, self.pitch)
        size = np.abs(response[:, :, 2]).max(axis=1)
        return np.asarray(np.maximum.accumulate(size[::-1])[::-1])

    @cached_property
    def reach(self) -> int:
        """Cells from a load to where its displacement is cut."""
        small = np.flatnonzero(self._sizes <= FAINT * self._sizes[0])
        return min(int(small[0]), LONGEST) if len(small) else LONGEST

    @property
    def dropped(self) -> float:
        """Displacement just beyond the reach as a share of the largest."""
        return float(self._sizes[self.reach + 1] / self._sizes[0])

    @cached_property
    def _sides(self) -> list[int]:
        """Rows and columns of a block with what is around it."""
        from scipy import fft

        most = BLOCK * (2 * self.reach + 1)
        return [
            fft.next_fast_len(min(most, cells + 2 * self.reach), real=True) for cells in self.shape
        ]

    @cached_property
    def _spectra(self) -> NDArray[Any]:
        """Transforms of the three kernels."""
        from scipy import fft

        reach = self.reach
        outward = displacement_kernel(self.mechanics, self.layer, self.pitch, reach, reach)
        kernel = np.zeros((3, *self._sides), dtype=np.float32)
        row, column = (np.arange(-reach, reach + 1) % side for side in self._sides)
        kernel[:, row[:, None], column] = -outward  # pressure pushes inwards
        return np.asarray(fft.rfft2(kernel))

    def __call__(self, pressure: NDArray[Any], along: tuple[int, ...] = (0, 1, 2)) -> NDArray[Any]:
        """Displacement (rows, columns, len(along)) m of a pressure (rows, columns) Pa, float32.

        `along` are the components: 0 and 1 along x and y of the sheet, 2 out of it.
        """
        from scipy import fft

        check_shape("pressure", pressure, self.shape, "one per cell")
        reach, (rows, columns) = self.reach, self.shape
        down_step, right_step = (side - 2 * reach for side in self._sides)
        out = np.empty((rows, columns, len(along)), dtype=np.float32)
        part = np.zeros(self._sides, dtype=np.float32)
        for row in range(0, rows, down_step):
            for column in range(0, columns, right_step):
                part[:] = 0.0
                low, left = max(row - reach, 0), max(column - reach, 0)
                here = pressure[low : row + down_step + reach, left : column + right_step + reach]
                down, right = low - row + reach, left - column + reach
                part[down : down + here.shape[0], right : right + here.shape[1]] = here
                spectrum = fft.rfft2(part)
                to = out[row : row + down_step, column : column + right_step]
                for index, component in enumerate(along):
                    moved = fft.irfft2(spectrum * self._spectra[component], part.shape)
                    to[..., index] = moved[reach:, reach:][: to.shape[0], : to.shape[1]]
        return out


SAMPLES = 9  # tiles by which the deviation of a sheet's cells is known
MOST = 0.99  # of the cells, whose deviation is no higher


def contacts_on(estimate: "SheetEstimate", finder: Finder) -> tuple[Contact, ...]:
    """See `SheetEstimate.contacts`."""
    from scipy.special import ndtri

    check_offers("finder", finder, ("false_alarm_rate",), "an object such as ContactFinder()")
    sheet = estimate.sheet
    sigmas = float(-ndtri(finder.false_alarm_rate / estimate.pressure.size))
    valid = estimate.valid[sheet.plan.placing.order]
    high = estimate.pressure > sigmas * sheet.highest_std
    corners = np.pad(
        sheet.origin + np.array([[0, 0], [1, 0], [0, 1]]) * sheet.pitch, ((0, 0), (0, 1))
    )
    patch = Patch(corners, sheet.pad_diameter, name="sheet")
    contacts: list[Contact] = []
    for window in windows(high):
        part = estimate.pressure[window.rows, window.columns]
        first = np.array([window.columns.start, window.rows.start])
        grid = Grid(patch, part.shape, sheet.pitch, sheet.origin + first * sheet.pitch)
        noise = SheetNoise(sheet.plan, valid, window.rows, window.columns)
        found = finder(grid, part.astype(np.float64).ravel(), noise)
        contacts += contacts_of(grid, window, found, sheet.shape[1], sigmas * noise.std)
    return by_falling_force(contacts)


def highest_std(plan: SheetPlan) -> float:
    """Deviation that few cells exceed, Pa, by those about some taxels, where all answer."""
    valid = np.ones(len(plan.placing.order), dtype=bool)
    some = np.linspace(0, len(valid) - 1, SAMPLES).astype(int)
    found = []
    for column, row in plan.placing.cell[some] - TILE // 2:
        rows, columns = (slice(max(int(at), 0), max(int(at), 0) + TILE) for at in (row, column))
        found.append(SheetNoise(plan, valid, rows, columns).std)
    return float(np.quantile(np.concatenate(found), MOST))


@dataclass(frozen=True, eq=False)
class SheetEstimate:
    """Pressure on all cells of a sheet; what follows from it is computed when asked for.

    Attributes
    ----------
    sheet : Sheet
        That made it.
    readings : (L,) array
        Linearised, in the quantity's unit; NaN for taxels that were left out.
    pressure : (rows, columns) array, Pa
        Positive in compression.
    weights : (L,) array
        What each taxel adds: the solution in taxel space, times what whitens it.
    iterations : int
        Of conjugate gradients.
    relative_residual : float
        That they left, as a share of the whitened readings.
    latency : float, s
        From the reading to the pressure.
    deadline_met : bool
        True where none was set.
    """

    sheet: "Sheet"
    readings: Floats
    pressure: NDArray[Any]
    weights: NDArray[Any]
    iterations: int
    relative_residual: float
    latency: float
    deadline_met: bool = True

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Taxels that were used, (L,)."""
        return ~np.isnan(self.readings)

    @property
    def normal_force(self) -> float:
        """Sum of the pressure over the sheet, N."""
        return float(self.pressure.sum(dtype=np.float64)) * self.sheet.pitch**2

    @cached_property
    def displacement(self) -> NDArray[Any]:
        """Displacement of the surface, (rows, columns, 3) m: along x, along y and outwards."""
        return self.sheet.deformation(self.pressure)

    @cached_property
    def indentation(self) -> NDArray[Any]:
        """Displacement into the skin, (rows, columns) m."""
        if "displacement" in self.__dict__:
            return np.asarray(-self.displacement[..., 2])
        return np.asarray(-self.sheet.deformation(self.pressure, (2,))[..., 0])

    def contacts(self, finder: Finder) -> tuple[Contact, ...]:
        """Pressed regions, by falling normal force.

        The sheet is searched where the pressure exceeds what noise alone reaches on it (on all but
        1 % of its cells), and each such window is given to the finder as a patch of its own: two
        contacts far from each other do not know of each other, and no finder sees a million taxels.

        Parameters
        ----------
        finder : Finder
            Such as `skinfield.ContactFinder()`. Its rate of false alarms is that of the sheet.

        Returns
        -------
        tuple of Contact
            In the sheet's plane, z = 0; `cells` are flat indices of `pressure`. Their covariance is
            that of the readings' noise.
        """
        return contacts_on(self, finder)

    @cached_property
    def residual(self) -> Floats:
        """Linearised reading less what the pressure predicts, (L,) in the quantity's unit."""
        return np.asarray(self.readings - self.sheet.predict(self.pressure))

    @property
    def defect(self) -> float:
        """How far the answer is from the exact one's condition, as a share of the readings.

        At the exact solution the residual over the noise's variance is the taxels' weights. This
        holds the iterations' residual and what was cut off the matrix, measured on all cells.
        """
        white = np.where(self.valid, self.residual, 0.0) / self.sheet.noise_std
        weights = self.weights * self.sheet.noise_std
        whole = np.linalg.norm(np.where(self.valid, self.readings, 0.0) / self.sheet.noise_std)
        return float(np.linalg.norm(white - weights) / whole) if whole > 0.0 else 0.0
