"""From pressure on a grid to the displacement of its nodes."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skinfield.errors import Floats
from skinfield.layout import Grid
from skinfield.mechanics import LatticeConvolution, Layer, Mechanics, displacement_kernel


@dataclass(frozen=True, eq=False)
class Deformation:
    """Linear map from pressure (K,) Pa to displacement (K, 3) m in the patch's frame.

    On a regular grid the response depends on the offset alone, so the map is a convolution.
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics

    @cached_property
    def _convolution(self) -> LatticeConvolution:
        rows, columns = self.grid.shape
        pitch = self.grid.pitch
        outward = displacement_kernel(self.mechanics, self.layer, pitch, rows - 1, columns - 1)
        return LatticeConvolution(-outward)  # pressure pushes inwards

    def on(self, grid: Grid) -> "Deformation":
        """The same map for nodes at the same places of another patch's plane; it is shared."""
        other = replace(self, grid=grid)
        vars(other)["_convolution"] = self._convolution
        return other

    def __call__(self, pressure: Floats) -> Floats:
        """Displacement (..., K, 3) of pressures (..., K)."""
        flat = pressure.reshape(-1, *self.grid.shape)
        out = np.empty((len(flat), len(self.grid), 3))
        for index, load in enumerate(flat):
            local = self._convolution(load).reshape(3, -1)
            out[index] = np.einsum("kij,jk->ki", self.grid.frames, local)
        return out.reshape(*pressure.shape, 3)
