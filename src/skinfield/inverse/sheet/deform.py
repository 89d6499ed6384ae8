"""Displacement of a sheet: convolution with long kernels, block by block."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.mechanics import Layer, Mechanics, displacement_kernel

FAINT = 1e-5  # of the largest: what a displacement kernel is cut at
LONGEST = 256  # cells from a load to the end of its displacement
BLOCK = 8  # lengths of the kernel per side of a block


@dataclass(frozen=True, eq=False)
class SheetDeformation:
    """Displacement of the surface by a pressure on any number of cells.

    The response depends on the offset alone. The sheet is cut into blocks, each transformed with
    as much around it as the kernel reaches (overlap-save), so memory does not grow with the sheet
    and the time is in proportion to its cells.

    Attributes
    ----------
    mechanics : Mechanics
    layer : Layer
    pitch : float, m
        Side of a cell.
    """

    mechanics: Mechanics
    layer: Layer
    pitch: float

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
    def _spectra(self) -> tuple[int, NDArray[Any]]:
        """Side of a block with what is around it, and the kernels' transforms (3, ...)."""
        from scipy import fft

        reach = self.reach
        outward = displacement_kernel(self.mechanics, self.layer, self.pitch, reach, reach)
        side = fft.next_fast_len(BLOCK * (2 * reach + 1), real=True)
        kernel = np.zeros((3, side, side), dtype=np.float32)
        at = np.arange(-reach, reach + 1) % side
        kernel[:, at[:, None], at] = -outward  # pressure pushes inwards
        return side, fft.rfft2(kernel)

    def __call__(self, pressure: NDArray[Any], along: tuple[int, ...] = (0, 1, 2)) -> NDArray[Any]:
        """Displacement (rows, columns, len(along)) m of a pressure (rows, columns) Pa, float32.

        `along` are the components: 0 and 1 along x and y of the sheet, 2 out of it.
        """
        from scipy import fft

        side, spectra = self._spectra
        reach, (rows, columns) = self.reach, pressure.shape
        step = side - 2 * reach
        out = np.empty((rows, columns, len(along)), dtype=np.float32)
        part = np.zeros((side, side), dtype=np.float32)
        for row in range(0, rows, step):
            for column in range(0, columns, step):
                part[:] = 0.0
                low, left = max(row - reach, 0), max(column - reach, 0)
                here = pressure[low : row + step + reach, left : column + step + reach]
                down, right = low - row + reach, left - column + reach
                part[down : down + here.shape[0], right : right + here.shape[1]] = here
                spectrum = fft.rfft2(part)
                to = out[row : row + step, column : column + step]
                for index, component in enumerate(along):
                    moved = fft.irfft2(spectrum * spectra[component], part.shape)
                    to[..., index] = moved[reach:, reach:][: to.shape[0], : to.shape[1]]
        return out
