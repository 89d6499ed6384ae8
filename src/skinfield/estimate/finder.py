"""Contact finder: regions of pressure that stand out of the noise, and what they amount to."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, check_range, check_shape
from skinfield.estimate.contact import Contact
from skinfield.estimate.ranking import falling_order
from skinfield.estimate.uncertainty import ModelError, PressureError
from skinfield.estimate.uncertainty import compiled as load_covariances
from skinfield.skin import Grid

# Variance, in cells, of the count in a disc at random per side of its border: 0.4576 R over 8 R
# (Kendall, On the number of lattice points inside a random oval, Quart. J. Math. 19, 1948).
SIDE_VARIANCE = 0.0572
NEXT, AFTER = [1, 2, 0], [2, 0, 1]  # axes of a cross product
SIDES = ((0, 1), (0, -1), (1, 0), (-1, 0))  # rows and columns from a cell to those beside it


def border(cells: NDArray[np.int64], shape: tuple[int, int]) -> Floats:
    """Corners of the way around a connected region of cells, closed, in units of cells.

    Parameters
    ----------
    cells : (N,) int array
        Flat, sorted; connected by sides or corners.
    shape : (rows, columns)

    Returns
    -------
    (N, 2) array
        Column and row coordinates; the centre of cell (row, column) is (column, row). The region
        lies to the left of the way; holes are not walked around. Where two cells touch at a corner
        only, the way turns right, into the other: such cells are neighbours.
    """
    inside = {divmod(cell, shape[1]) for cell in cells.tolist()}
    row, column = divmod(int(cells[0]), shape[1])
    x, y, dx, dy = column, row, 1, 0
    way = [(x, y)]
    while len(way) == 1 or way[-1] != way[0]:
        x, y = x + dx, y + dy
        way.append((x, y))
        if (y + (dy - dx - 1) // 2, x + (dx + dy - 1) // 2) in inside:  # on the right
            dx, dy = dy, -dx
        elif (y + (dy + dx - 1) // 2, x + (dx - dy - 1) // 2) not in inside:
            dx, dy = -dy, dx
    return np.array(way) - 0.5


def area_moves(
    grid: Grid, pressure: Floats, cells: Ints, edge: float
) -> tuple[Ints, Floats, float]:
    r"""How the area of a region moves with the pressure of cells, m²/Pa, to first order.

    The region ends where the pressure falls to `edge` of its peak, so by the implicit function
    theorem its border moves outwards by (dp - edge dp_peak) / \|grad p\|. The border is summed over
    the sides of cells at which it is crossed; each stands for a length pitch \|d_x p\| / \|grad p\|
    of it (pitch \|d_y p\| / \|grad p\| for a side along x).

    Returns cells, their weights, and one standard deviation of an area counted in whole cells.
    """
    (rows, columns), picture = grid.shape, pressure.reshape(grid.shape)
    slopes: list[Floats] = [
        np.asarray(np.gradient(picture, axis=axis)) if size > 1 else np.zeros(grid.shape)
        for axis, size in enumerate(grid.shape)
    ]
    inside, moves = np.zeros(len(grid), np.bool_), np.zeros(len(grid))
    inside[cells] = True
    peak, sides = cells[pressure[cells].argmax()], 0
    level = edge * pressure[peak]
    for down, right in SIDES:
        row, column = cells // columns + down, cells % columns + right
        on = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        here, beside = cells[on], (row * columns + column)[on]
        outer = ~inside[beside]
        sides += int(np.count_nonzero(outer) + np.count_nonzero(~on))
        crossed = outer & (pressure[beside] < level) & (level < pressure[here])
        here, beside = here[crossed], beside[crossed]
        across, tangent = pressure[here] - pressure[beside], slopes[abs(down)].ravel()
        along = 0.5 * (tangent[here] + tangent[beside])
        share = (pressure[here] - level) / across  # of the way to the cell beside
        per_pascal = grid.cell_area * across / (across**2 + along**2)
        moves += np.bincount(here, per_pascal * (1.0 - share), len(moves))
        moves += np.bincount(beside, per_pascal * share, len(moves))
    moves[peak] -= edge * moves.sum()
    around = np.flatnonzero(moves)
    return around, moves[around], grid.cell_area * float(np.sqrt(SIDE_VARIANCE * sides))


@lru_cache(maxsize=8)
def loads_per_pressure(grid: Grid) -> Floats:
    """What a pressure of 1 Pa on each cell adds to the sums over a region, (K, 12).

    Force N and its first and second moments in the plane: 1, x, y, xx, xy, yy; the force in the
    patch's frame, and its moment about the origin.
    """
    (x, y), area = grid.plane.T, grid.cell_area
    plane = area * np.stack([np.ones(len(grid)), x, y, x * x, x * y, y * y], axis=1)
    forces = -area * grid.normals
    return np.hstack([plane, forces, cross(grid.positions, forces)])


def cross(one: Floats, other: Floats) -> Floats:
    """Cross products of vectors (N, 3)."""
    return np.asarray(one[:, NEXT] * other[:, AFTER] - one[:, AFTER] * other[:, NEXT])


@dataclass(frozen=True, eq=False)
class FieldRegions:
    """Regions of a field, with what is needed to say more of them.

    Attributes
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    error : PressureError
        Of the pressure.
    model_error : ModelError
        What is wrong with contacts beside.
    edge : float
        Share of its peak at which a region ends.
    starts, cells : (R + 1,) and (N,) int arrays
        Flat cells: those of region n from starts[n] on.
    """

    grid: Grid
    pressure: Floats
    error: PressureError
    model_error: ModelError
    edge: float
    starts: Ints
    cells: Ints

    def contacts(self) -> Iterator[Contact]:
        """One contact for each region, by falling force; some of it comes when asked for."""
        grid, cells, first, surface = (
            self.grid,
            self.cells,
            self.starts[:-1],
            self.grid.patch.surface,
        )
        pressure = self.pressure[cells]
        loads = pressure[:, None] * np.take(loads_per_pressure(grid), cells, axis=0)
        sums = np.add.reduceat(loads, first, axis=0)
        total, means, force = sums[:, 0], sums[:, 1:6] / sums[:, :1], sums[:, 6:9]
        centre = means[:, :2]
        positions = surface.position_from_plane(centre)
        normals = grid.normals[:1]  # on a flat skin one for all
        if not surface.is_flat:
            normals = surface.frame_from_plane(centre)[:, :, 2]
        moment = sums[:, 9:] - cross(positions, force)
        (x, y, xx, xy, yy), own = means.T, grid.cell_area / 12
        xx, xy, yy = xx - x * x + own, xy - x * y, yy - y * y + own
        large = (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy)
        axes = 2.0 * np.sqrt([large, (xx * yy - xy * xy) / large]).T
        angle = 0.5 * np.arctan2(2 * xy, xx - yy)
        angles = np.where(angle < np.pi / 2, angle, angle - np.pi).tolist()
        areas = (np.diff(self.starts) * grid.cell_area).tolist()
        peaks = np.maximum.reduceat(pressure, first).tolist()
        along = -(force * normals).sum(axis=1)
        for index in falling_order(along.tolist(), cells[first].tolist()):
            mine = cells[self.starts[index] : self.starts[index + 1]]
            yield Contact.later(
                Details(self, mine, centre[index], float(total[index])),
                position=positions[index],
                force=force[index],
                moment=moment[index],
                normal=normals[index if len(normals) > 1 else 0],
                area=areas[index],
                peak_pressure=peaks[index],
                radius=(areas[index] / np.pi) ** 0.5,
                shape="other",
                axes=axes[index],
                angle=angles[index],
                cells=mine,
                track_id=None,
                spread=None,
            )


@dataclass(frozen=True, eq=False)
class Details:
    """What of a region's contact is dear, worked out when asked for; see `Contact.later`."""

    field: FieldRegions
    cells: Ints
    centre: Floats
    total: float

    @property
    def covariance(self) -> Floats:
        """That of sums over the region's cells.

        Of the pressure for the force and, to first order, of the pressure's first moments about the
        centre for the place. Which cells make up the region is taken as given.
        """
        field, grid = self.field, self.field.grid
        moves = np.full((3, len(self.cells)), grid.cell_area)
        moves[:2] *= (grid.plane[self.cells] - self.centre).T / self.total
        noise = field.error.covariance_of_sums(self.cells, moves)
        return noise + field.model_error.covariance(self.total)

    @property
    def area_std(self) -> float:
        """By how the border moves, by the rounding to whole cells, and by the model's error."""
        field, grid = self.field, self.field.grid
        around, moves, rounding = area_moves(grid, field.pressure, self.cells, field.edge)
        variance = field.error.covariance_of_sums(around, moves[None])[0, 0]
        beside = len(self.cells) * grid.cell_area * field.model_error.area
        return float(np.sqrt(max(variance, 0.0) + rounding**2 + beside**2))

    @property
    def outline(self) -> Floats:
        """Border of the region on the skin."""
        grid = self.field.grid
        corners = grid.origin + border(self.cells, grid.shape) * grid.pitch
        return grid.patch.surface.position_from_plane(corners)


@lru_cache(maxsize=1)
def kernels() -> Any:
    """The kernels, loaded when first needed; those that wait to be asked for, too."""
    from skinfield.estimate import regions_kernel

    load_covariances()
    return regions_kernel


EXACT = ModelError()


@lru_cache(maxsize=256)
def _significance(false_alarm_rate: float, chances: int) -> float:
    """Standard deviations that one of `chances` normal numbers exceeds at the given rate."""
    from scipy.special import ndtri

    return float(-ndtri(false_alarm_rate / chances))


@dataclass(frozen=True, kw_only=True)
class ContactFinder:
    """Connected regions of pressure above the noise.

    Parameters
    ----------
    false_alarm_rate : float
        Readings of an idle patch in which a contact may be seen. A peak must exceed the noise's
        quantile at this rate over as many chances as there are cells that feel it.
    relative_height : float
        A peak must reach this fraction of the highest: linear solvers ring beside a press.
    prominence : float
        Two peaks are two contacts if the lower stands out of the saddle by this fraction of
        itself; else one.
    edge : float
        A region ends where the pressure falls to this fraction of its peak.
    """

    false_alarm_rate: float = 1e-3
    relative_height: float = 0.2
    prominence: float = 0.3
    edge: float = 0.2

    def __post_init__(self) -> None:
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        for name in ("relative_height", "prominence", "edge"):
            check_range(name, getattr(self, name), 0.0, 1.0, "a fraction of a peak")

    def sigmas(self, noise: PressureError) -> float:
        """Standard deviations by which a peak must exceed the noise of the cells that feel it."""
        return _significance(self.false_alarm_rate, max(noise.felt, 1))

    def heights(self, noise: PressureError) -> tuple[float, float, float, float]:
        """`sigmas`, relative height, prominence and edge: as the kernel takes them."""
        return self.sigmas(noise), self.relative_height, self.prominence, self.edge

    def __call__(
        self,
        grid: Grid,
        pressure: Floats,
        noise: PressureError,
        error: PressureError | None = None,
        model_error: ModelError = EXACT,
    ) -> tuple[Contact, ...]:
        """Contacts of one field.

        Parameters
        ----------
        grid : Grid
        pressure : (K,) array, Pa
        noise : PressureError
            Of the pressure: what stands out of it is a contact.
        error : PressureError, optional
            How far the pressure may be from the truth, if the solver states more than its noise.
        model_error : ModelError
            What is wrong with the contacts beside.

        Returns
        -------
        tuple of Contact
            By falling normal force; of equal ones (to 1e-9), the one with the smallest cell first.
            Their covariance, deviation of the area and outline are worked out when they are first
            asked for.

        Raises
        ------
        InputError
            If the pressure or the noise is not one number for each node.
        """
        flat = np.require(pressure, np.float64, ("C", "W"))  # others would be compiled for anew
        if not flat.shape == noise.std.shape == (len(grid),):
            check_shape("pressure", flat, (len(grid),), "one per node of the grid")
            check_shape("noise.std", noise.std, (len(grid),), "one per node of the grid")
        kernel, columns = kernels(), grid.shape[1]
        work = kernel.room_for(len(flat), columns)
        count = kernel.find(flat, noise.std, columns, *self.heights(noise), *work)
        if not count:
            return ()
        starts = work[2][kernel.STARTS, : count + 1].copy()
        cells = work[2][kernel.REGIONS, : starts[-1]].copy()
        stated = noise if error is None else error
        own = flat.copy()  # what is worked out later is of these
        regions = FieldRegions(grid, own, stated, model_error, self.edge, starts, cells)
        return tuple(regions.contacts())
