"""From pressure on a grid to the displacement of its nodes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats
from skinfield.layout import Grid
from skinfield.mechanics import Layer, Mechanics


@dataclass(frozen=True, eq=False)
class Deformation:
    """Linear map from pressure (K,) Pa to displacement (K, 3) m in the patch's frame.

    On a regular grid the response depends on the offset alone, so the map is a convolution.
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics

    @cached_property
    def kernel(self) -> Floats:
        """Response at every offset of two nodes, (3, 2 rows - 1, 2 columns - 1), m/Pa, local."""
        rows, columns = self.grid.shape
        y = np.arange(1 - rows, rows) * self.grid.pitch
        x = np.arange(1 - columns, columns) * self.grid.pitch
        offsets = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        response = self.mechanics.surface_displacement(self.layer, offsets, self.grid.pitch)
        return -response[:, :, 2].T.reshape(3, len(y), len(x))  # pressure pushes inwards

    def __call__(self, pressure: Floats) -> Floats:
        """Displacement (..., K, 3) of pressures (..., K)."""
        from scipy import fft

        rows, columns = self.grid.shape
        shape = [fft.next_fast_len(3 * n - 2, real=True) for n in (rows, columns)]
        spectrum = fft.rfft2(self.kernel, shape)
        lead = pressure.shape[:-1]
        load = fft.rfft2(pressure.reshape(-1, 1, rows, columns), shape)
        out = np.empty((load.shape[0], len(self.grid), 3))
        for index in range(len(load)):
            local = fft.irfft2(load[index] * spectrum, shape)
            local = local[:, rows - 1 : 2 * rows - 1, columns - 1 : 2 * columns - 1]
            out[index] = np.einsum("kij,jk->ki", self.grid.frames, local.reshape(3, -1))
        return out.reshape(*lead, len(self.grid), 3)
