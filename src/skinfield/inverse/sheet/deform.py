"""Displacement of a sheet: convolution with long kernels, block by block."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, check_shape
from skinfield.mechanics import Layer, Mechanics, displacement_kernel

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
