"""What regions of pressure amount to, and how sure that is."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.contacts.regions import Regions, border
from skinfield.errors import Floats, Ints
from skinfield.fields import Contact, ModelError, PressureError
from skinfield.fields.noise import compiled as load_covariances
from skinfield.layout import Grid


@dataclass(frozen=True, eq=False)
class Found:
    """All regions of a field, with what is needed to say more of them.

    Attributes
    ----------
    grid : Grid
    error : PressureError
        Of the pressure.
    model_error : ModelError
        What is wrong with contacts beside.
    regions : Regions
    borders : (M + 1,) int array, (B,) int array, (B,) array
        How areas move with the pressure: starts, cells and weights, m²/Pa; see `area_moves`.
    table : (R, WIDTH) array
        Sums over the regions, in the columns of `sum_kernel`.
    """

    grid: Grid
    error: PressureError
    model_error: ModelError
    regions: Regions
    borders: tuple[Ints, Ints, Floats]
    table: Floats

    @classmethod
    def of(
        cls,
        grid: Grid,
        pressure: Floats,
        error: PressureError,
        model_error: ModelError,
        regions: Regions,
        edge: float,
    ) -> "Found":
        """Add up the pressure (K,) Pa over regions that end at `edge` of their peaks."""
        sums, columns = compiled(), grid.shape[1]
        places, normals = grid.positions, grid.normals
        table = sums.sum_regions(
            pressure, places, normals, grid.origin, grid.pitch, columns, *regions
        )
        borders = sums.borders(pressure, columns, grid.cell_area, edge, *regions, table)
        return cls(grid, error, model_error, regions, borders, table)

    def contacts(self) -> Iterator[Contact]:
        """One contact for each region, by falling force; some of it comes when asked for."""
        sums, grid, table = compiled(), self.grid, self.table
        centres = table[:, sums.CENTRE : sums.CENTRE + 2]
        positions = grid.patch.surface.position_from_plane(centres)
        normals = _normals(grid, centres)
        order = sums.set_places(table, positions, normals).tolist()
        starts, cells, rows = self.regions[0].tolist(), self.regions[1], table.tolist()
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

    found: Found
    index: int

    @property
    def covariance(self) -> Floats:
        """That of sums over the region's cells.

        Of the pressure for the force and, to first order, of the pressure's first moments about the
        centre for the place. Which cells make up the region is taken as given.
        """
        found, sums, cells = self.found, compiled(), self._cells
        grid, row = found.grid, found.table[self.index]
        origin = float(grid.origin[0]), float(grid.origin[1])
        moves = sums.first_moments(cells, grid.shape[1], grid.pitch, origin, row)
        noise = found.error.covariance_of_sums(cells, moves)
        return noise + found.model_error.covariance(float(row[sums.TOTAL]))

    @property
    def area_std(self) -> float:
        """By how the border moves, by the rounding to whole cells, and by the model's error."""
        found = self.found
        starts, around, moves = found.borders
        here = slice(starts[self.index], starts[self.index + 1])
        variance = found.error.covariance_of_sums(around[here], moves[None, here])[0, 0]
        rounding = found.table[self.index, compiled().ROUNDING]
        beside = len(self._cells) * found.grid.cell_area * found.model_error.area
        return float(np.sqrt(max(variance, 0.0) + rounding**2 + beside**2))

    @property
    def outline(self) -> Floats:
        """Border of the region on the skin."""
        grid = self.found.grid
        corners = grid.origin + border(self._cells, grid.shape) * grid.pitch
        return grid.patch.surface.position_from_plane(corners)

    @property
    def _cells(self) -> Ints:
        starts, cells = self.found.regions
        return cells[starts[self.index] : starts[self.index + 1]]


def _normals(grid: Grid, centres: Floats) -> Floats:
    """Outward normals at points of the plane, (R, 3); on a flat skin one for all, (1, 3)."""
    surface = grid.patch.surface
    if surface.is_flat:
        return grid.normals[:1]
    return surface.frame_from_plane(centres)[:, :, 2]


@lru_cache(maxsize=1)
def compiled() -> Any:
    """The kernels, loaded when first needed; those that wait to be asked for, too."""
    from skinfield.contacts import sum_kernel

    load_covariances()
    cell = np.zeros(1, np.int64)
    sum_kernel.first_moments(cell, 1, 1.0, (0.0, 0.0), np.ones(sum_kernel.WIDTH))
    sum_kernel.walk_around(cell, 1, 1)
    return sum_kernel
