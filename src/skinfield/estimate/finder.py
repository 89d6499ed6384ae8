"""Contact finder: regions of pressure that stand out of the noise, and what they amount to."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, check_range, check_shape
from skinfield.estimate.contact import Contact
from skinfield.estimate.uncertainty import ModelError, PressureError
from skinfield.estimate.uncertainty import compiled as load_covariances
from skinfield.skin import Grid

Regions = tuple[Ints, Ints]  # starts (R + 1,) and flat cells: those of n from starts[n] on


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
        lies to the left of the way; holes are not walked around.
    """
    from skinfield.estimate.regions_kernel import walk_around

    return np.asarray(walk_around(cells, *shape) - 0.5)


class FieldRegions:
    """All regions of a field, with what is needed to say more of them.

    Parameters
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    error : PressureError
        Of the pressure.
    model_error : ModelError
        What is wrong with contacts beside.
    regions : Regions
    edge : float
        Share of its peak at which a region ends.

    Attributes
    ----------
    borders : (M + 1,) int array, (B,) int array, (B,) array
        How areas move with the pressure: starts, cells and weights, m²/Pa; see
        `regions_kernel.borders`.
    table : (R, WIDTH) array
        Sums over the regions, in the columns of `regions_kernel`.
    """

    def __init__(
        self,
        grid: Grid,
        pressure: Floats,
        error: PressureError,
        model_error: ModelError,
        regions: Regions,
        edge: float,
    ) -> None:
        self.grid, self.error, self.model_error, self.regions = grid, error, model_error, regions
        sums, columns = kernels(), grid.shape[1]
        where = grid.positions, grid.normals, grid.origin, grid.pitch, columns
        self.table = sums.sum_regions(pressure, *where, *regions)
        self.borders = sums.borders(pressure, columns, grid.cell_area, edge, *regions, self.table)

    def contacts(self) -> Iterator[Contact]:
        """One contact for each region, by falling force; some of it comes when asked for."""
        sums, grid, table = kernels(), self.grid, self.table
        centres = table[:, sums.CENTRE : sums.CENTRE + 2]
        surface = grid.patch.surface
        positions = surface.position_from_plane(centres)
        normals = grid.normals[:1]  # on a flat skin one for all
        if not surface.is_flat:
            normals = surface.frame_from_plane(centres)[:, :, 2]
        starts, cells, rows = self.regions[0].tolist(), self.regions[1], table.tolist()
        firsts = cells[self.regions[0][:-1]]
        order = sums.set_places(table, positions, normals, firsts).tolist()
        for index in order:
            row, mine = table[index], cells[starts[index] : starts[index + 1]]
            area = len(mine) * grid.cell_area
            yield Contact.later(
                Details(self, index),
                position=positions[index],
                force=row[sums.FORCE : sums.FORCE + 3],
                moment=row[sums.MOMENT : sums.MOMENT + 3],
                normal=normals[index if len(normals) > 1 else 0],
                area=area,
                peak_pressure=rows[index][sums.PEAK],
                radius=(area / np.pi) ** 0.5,
                shape="other",
                axes=row[sums.MAJOR : sums.MINOR + 1],
                angle=rows[index][sums.ANGLE],
                cells=mine,
                track_id=None,
                spread=None,
            )


@dataclass(frozen=True, eq=False)
class Details:
    """What of a region's contact is dear, worked out when asked for; see `Contact.later`."""

    field: FieldRegions
    index: int

    @property
    def covariance(self) -> Floats:
        """That of sums over the region's cells.

        Of the pressure for the force and, to first order, of the pressure's first moments about the
        centre for the place. Which cells make up the region is taken as given.
        """
        found, sums, cells = self.field, kernels(), self._cells
        grid, row = found.grid, found.table[self.index]
        origin = float(grid.origin[0]), float(grid.origin[1])
        moves = sums.first_moments(cells, grid.shape[1], grid.pitch, origin, row)
        noise = found.error.covariance_of_sums(cells, moves)
        return noise + found.model_error.covariance(float(row[sums.TOTAL]))

    @property
    def area_std(self) -> float:
        """By how the border moves, by the rounding to whole cells, and by the model's error."""
        found = self.field
        starts, around, moves = found.borders
        here = slice(starts[self.index], starts[self.index + 1])
        variance = found.error.covariance_of_sums(around[here], moves[None, here])[0, 0]
        rounding = found.table[self.index, kernels().ROUNDING]
        beside = len(self._cells) * found.grid.cell_area * found.model_error.area
        return float(np.sqrt(max(variance, 0.0) + rounding**2 + beside**2))

    @property
    def outline(self) -> Floats:
        """Border of the region on the skin."""
        grid = self.field.grid
        corners = grid.origin + border(self._cells, grid.shape) * grid.pitch
        return grid.patch.surface.position_from_plane(corners)

    @property
    def _cells(self) -> Ints:
        starts, cells = self.field.regions
        return cells[starts[self.index] : starts[self.index + 1]]


@lru_cache(maxsize=1)
def kernels() -> Any:
    """The kernels, loaded when first needed; those that wait to be asked for, too."""
    from skinfield.estimate import regions_kernel

    load_covariances()
    cell = np.zeros(1, np.int64)
    regions_kernel.first_moments(cell, 1, 1.0, (0.0, 0.0), np.ones(regions_kernel.WIDTH))
    regions_kernel.walk_around(cell, 1, 1)
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
        flood = kernels()
        sigmas = self.sigmas(noise)
        flat = np.require(pressure, np.float64, ("C", "W"))  # others would be compiled for anew
        if not flat.shape == noise.std.shape == (len(grid),):
            check_shape("pressure", flat, (len(grid),), "one per node of the grid")
            check_shape("noise.std", noise.std, (len(grid),), "one per node of the grid")
        if not flood.stands_out(flat, noise.std, sigmas):
            return ()
        heights = sigmas, self.relative_height, self.prominence, self.edge
        regions = flood.find(flat, noise.std, grid.shape[1], *heights)
        if not len(regions[1]):
            return ()
        stated = noise if error is None else error
        found = FieldRegions(grid, flat, stated, model_error, regions, self.edge)
        return tuple(found.contacts())
