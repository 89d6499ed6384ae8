"""A body given by its height on a lattice."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape
from skinfield.simulate.indenters.body import Body
from skinfield.simulate.indenters.mesh import LEVEL, Mesh


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightMap(Body):
    """A body given by its height on a lattice, linear between the samples along x and along y.

    A sample stands for the square of one pixel around it. Where a sample is NaN or infinite there
    is no body, and its neighbours are taken at their own heights up to the border. Upright, the
    sides are vertical; tilted, the map is a thin sheet that leans, without sides.

    Parameters
    ----------
    heights : (rows, columns) array, m
        Lower surface; rows go up along y and columns along x. Only differences count.
    pixel : float, m
        Distance between samples.
    position, rotation, tilt, force, depth, shear
        See `Body`. Its reference point is the middle of the map at its lowest height.
    """

    heights: Floats
    pixel: float
    kind: ClassVar[str] = "height map"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("pixel", self.pixel, "distance between samples, in metres")
        heights = as_floats("heights", self.heights)
        check_shape("heights", heights, (None, None), "rows along y, columns along x")
        there = np.isfinite(heights)
        if not there.any():
            raise InputError(
                f"heights holds {heights.size} samples, none of them finite, expected at least "
                "one: NaN and infinity stand for no body"
            )
        level = np.where(there, heights - heights[there].min(), np.inf)
        object.__setattr__(self, "heights", level)

    @property
    def lowest(self) -> tuple[float, float]:
        """See `Indenter.lowest`."""
        if self.tilt != (0.0, 0.0):
            return self._sheet.lowest
        row, column = np.nonzero(self.heights <= LEVEL)
        rows, columns = self.heights.shape
        right = (column.mean() - (columns - 1) / 2) * self.pixel
        return self.place(right, (row.mean() - (rows - 1) / 2) * self.pixel)

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        if self.tilt != (0.0, 0.0):
            return self._sheet.height(x, y)
        right, ahead = self.own_plane(np.asarray(x), np.asarray(y))
        rows, columns = self.heights.shape
        return self.between(
            ahead / self.pixel + (rows - 1) / 2, right / self.pixel + (columns - 1) / 2
        )

    def between(self, row: Floats, column: Floats) -> Floats:
        """Heights, m, at places counted in samples: 0 is the first one's middle."""
        rows, columns = self.heights.shape
        nearest_row = np.floor(row + 0.5).astype(np.int64)
        nearest_column = np.floor(column + 0.5).astype(np.int64)
        on_map = (nearest_row >= 0) & (nearest_row < rows)
        on_map &= (nearest_column >= 0) & (nearest_column < columns)
        low_row = np.floor(np.clip(row, 0, rows - 1)).astype(np.int64)
        low_column = np.floor(np.clip(column, 0, columns - 1)).astype(np.int64)
        up, right = (
            np.clip(row, 0, rows - 1) - low_row,
            np.clip(column, 0, columns - 1) - low_column,
        )
        total, weight = np.zeros(row.shape), np.zeros(row.shape)
        for r, across in ((low_row, 1.0 - up), (np.minimum(low_row + 1, rows - 1), up)):
            for c, along in (
                (low_column, 1.0 - right),
                (np.minimum(low_column + 1, columns - 1), right),
            ):
                corner = self.heights[r, c]
                share = np.where(np.isfinite(corner), across * along, 0.0)
                total += share * np.where(np.isfinite(corner), corner, 0.0)
                weight += share
        own = self.heights[
            np.clip(nearest_row, 0, rows - 1), np.clip(nearest_column, 0, columns - 1)
        ]
        there = on_map & np.isfinite(own) & (weight > 0.0)
        return np.where(there, total / np.where(there, weight, 1.0), np.inf)

    @cached_property
    def _sheet(self) -> Mesh:
        """The surface as triangles: eight for each pixel, around its middle."""
        rows, columns = self.heights.shape
        there = np.isfinite(self.heights)
        row, column = np.mgrid[0 : 2 * rows + 1, 0 : 2 * columns + 1] / 2 - 0.5
        z = self._corners(row, column)
        x = (column - (columns - 1) / 2) * self.pixel
        y = (row - (rows - 1) / 2) * self.pixel
        index = np.arange(row.size).reshape(row.shape)
        quads = np.repeat(np.repeat(there, 2, axis=0), 2, axis=1)
        a, b = index[:-1, :-1][quads], index[:-1, 1:][quads]
        c, d = index[1:, 1:][quads], index[1:, :-1][quads]
        faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
        vertices = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
        return Mesh(
            vertices=vertices,
            faces=faces,
            position=self.position,
            rotation=self.rotation,
            tilt=self.tilt,
            force=self.force,
            depth=self.depth,
            shear=self.shear,
        )

    def _corners(self, row: Floats, column: Floats) -> Floats:
        """Heights at middles, sides and corners of pixels, the same from each pixel that meets."""
        total, count = np.zeros(row.shape), np.zeros(row.shape)
        padded = np.pad(self.heights, 1, constant_values=np.inf)
        for low_row in (np.floor(row), np.ceil(row)):
            for low_column in (np.floor(column), np.ceil(column)):
                corner = padded[low_row.astype(np.int64) + 1, low_column.astype(np.int64) + 1]
                finite = np.isfinite(corner)
                total += np.where(finite, corner, 0.0)
                count += finite
        return total / np.maximum(count, 1.0)
