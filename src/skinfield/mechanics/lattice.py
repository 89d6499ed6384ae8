"""Responses at every offset of a regular lattice, for convolutions."""

import numpy as np

from skinfield.errors import Floats
from skinfield.mechanics.elastomer import Layer
from skinfield.mechanics.protocol import Mechanics


def lattice(half_rows: int, half_columns: int, step: float) -> Floats:
    """Offsets of one quadrant, x and y from 0: ((half_rows + 1) * (half_columns + 1), 2) m."""
    x, y = np.arange(half_columns + 1) * step, np.arange(half_rows + 1) * step
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def mirrored(quadrant: Floats, odd_x: bool = False, odd_y: bool = False) -> Floats:
    """All four quadrants (2 n - 1, 2 m - 1) of a function that is even or odd in x and y."""
    left = quadrant[:, :0:-1] * (-1.0 if odd_x else 1.0)
    upper = np.concatenate([left, quadrant], axis=1)
    lower = upper[:0:-1] * (-1.0 if odd_y else 1.0)
    return np.concatenate([lower, upper])


def indentation_kernel(
    mechanics: Mechanics, layer: Layer, cell: float, step: float, half_rows: int, half_columns: int
) -> Floats:
    """Indentation (2 half_rows + 1, 2 half_columns + 1) m per Pa on a cell, every `step` m."""
    offsets = lattice(half_rows, half_columns, step)
    quadrant = mechanics.indentation(layer, offsets, cell)
    return mirrored(quadrant.reshape(half_rows + 1, half_columns + 1))


def displacement_kernel(
    mechanics: Mechanics, layer: Layer, cell: float, half_rows: int, half_columns: int
) -> Floats:
    """Displacement (3, 2 half_rows + 1, 2 half_columns + 1) m per Pa of normal traction."""
    response = mechanics.surface_displacement(layer, lattice(half_rows, half_columns, cell), cell)
    x, y, z = response[:, :, 2].T.reshape(3, half_rows + 1, half_columns + 1)
    return np.stack([mirrored(x, odd_x=True), mirrored(y, odd_y=True), mirrored(z)])


class LatticeConvolution:
    """Sum over a lattice of a field times a kernel of the offset, by FFT without wrap-around.

    Parameters
    ----------
    kernel : (..., 2 rows - 1, 2 columns - 1) array
        At every offset of two nodes of a lattice of rows x columns.
    """

    def __init__(self, kernel: Floats) -> None:
        from scipy import fft

        self.shape = ((kernel.shape[-2] + 1) // 2, (kernel.shape[-1] + 1) // 2)
        self._padded = [fft.next_fast_len(3 * n - 2, real=True) for n in self.shape]
        self._spectrum = fft.rfft2(kernel, self._padded)

    def __call__(self, values: Floats) -> Floats:
        """Convolve a field (rows, columns): (..., rows, columns)."""
        from scipy import fft

        rows, columns = self.shape
        product = fft.rfft2(values, self._padded) * self._spectrum
        full = fft.irfft2(product, self._padded)
        return np.asarray(full[..., rows - 1 : 2 * rows - 1, columns - 1 : 2 * columns - 1])
