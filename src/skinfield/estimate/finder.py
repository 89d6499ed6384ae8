"""Contact finder: regions of pressure that stand out of the noise, and what they amount to."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.errors import Floats, Ints, check_range, check_shape
from skinfield.estimate.contact import Contact
from skinfield.estimate.ranking import falling_order
from skinfield.estimate.uncertainty import ModelError, PressureError
from skinfield.estimate.uncertainty import compiled as load_covariances
from skinfield.skin import Grid

# Variance, in cells, of the count in a disc at random per side of its border: 0.4576 R over 8 R
# (Kendall, On the number of lattice points inside a random oval, Quart. J. Math. 19, 1948).
SIDE_VARIANCE = 0.0572


@lru_cache(maxsize=8)
def loads_per_pressure(grid: Grid) -> Floats:
    """What a pressure of 1 Pa on each cell adds to the sums over a region, (K, 12).

    Of the force N: its first moments x, y in the plane and itself; then the force in the patch's
    frame and its moment about the origin; then its second moments xx, xy, yy.
    """
    (x, y), area = grid.plane.T, grid.cell_area
    plane = area * np.stack([x, y, np.ones(len(grid)), x * x, x * y, y * y], axis=1)
    forces = -area * grid.normals
    return np.hstack([plane[:, :3], forces, np.cross(grid.positions, forces), plane[:, 3:]])


def area_moves(
    grid: Grid, pressure: Floats, cells: Ints, edge: float
) -> tuple[Ints, Floats, float]:
    """How the area of a region moves with the pressure of cells: these, and their m²/Pa.

    Also one standard deviation of an area counted in whole cells, m².
    """
    moves, sides = kernels().area_moves(pressure, grid.shape[1], edge, cells)
    around = np.flatnonzero(moves)
    rounding = grid.cell_area * float(np.sqrt(SIDE_VARIANCE * sides))
    return around, grid.cell_area * moves[around], rounding


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
        kernel, grid, starts, cells = kernels(), self.grid, self.starts, self.cells
        loads, surface = loads_per_pressure(grid), grid.patch.surface
        table = kernel.sum_regions(self.pressure, loads, grid.cell_area, starts, cells)
        centre = table[:, : kernel.TOTAL]
        positions = surface.position_from_plane(centre)
        normals = grid.normals[:1]  # on a flat skin one for all
        if not surface.is_flat:
            normals = surface.frame_from_plane(centre)[:, :, 2]
        along = kernel.move_moments(table, positions, normals).tolist()
        numbers, ends = table.tolist(), starts.tolist()
        for index in falling_order(along, cells[starts[:-1]].tolist()):
            row, mine = table[index], cells[ends[index] : ends[index + 1]]
            area = len(mine) * grid.cell_area
            yield Contact.later(
                Details(self, mine, centre[index], numbers[index][kernel.TOTAL]),
                position=positions[index],
                force=row[kernel.FORCE : kernel.MOMENT],
                moment=row[kernel.MOMENT : kernel.AXES],
                normal=normals[index if len(normals) > 1 else 0],
                area=area,
                peak_pressure=numbers[index][kernel.PEAK],
                radius=(area / np.pi) ** 0.5,
                shape="other",
                axes=row[kernel.AXES : kernel.ANGLE],
                angle=numbers[index][kernel.ANGLE],
                cells=mine,
                maybe=0,
                track_id=None,
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
        loads, (x, y) = loads_per_pressure(grid), self.centre.tolist()
        moves = kernels().place_moves(loads, grid.cell_area, self.cells, x, y, self.total)
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
        corners = grid.origin + (kernels().border(self.cells, *grid.shape) - 0.5) * grid.pitch
        return grid.patch.surface.position_from_plane(corners)


@lru_cache(maxsize=1)
def kernels() -> Any:
    """The kernels, loaded when first needed; those that wait to be asked for, too."""
    from skinfield.estimate import regions_kernel

    load_covariances()
    one, cell = np.ones(1), np.zeros(1, np.int64)
    regions_kernel.area_moves(one, 1, 0.5, cell)
    regions_kernel.place_moves(np.ones((1, 3)), 1.0, cell, 0.0, 0.0, 1.0)
    regions_kernel.border(cell, 1, 1)
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
        kernel, heights, columns = kernels(), self.heights(noise), grid.shape[1]
        if not kernel.stands_out(flat, noise.std, heights[0]):  # as in most readings
            return ()
        work = kernel.room_for(len(flat), columns)
        count = kernel.find(flat, noise.std, columns, *heights, *work)
        starts = work[2][kernel.STARTS, : count + 1].copy()
        cells = work[2][kernel.REGIONS, : starts[-1]].copy()
        stated = noise if error is None else error
        own = flat.copy()  # what is worked out later is of these
        regions = FieldRegions(grid, own, stated, model_error, self.edge, starts, cells)
        return tuple(regions.contacts())
