"""Responses at every offset of a regular lattice, for convolutions."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic.elastomer import Layer, Mechanics
from skinfield.errors import Floats

STENCIL = 6  # nodes of an interpolation along one axis: exact for polynomials of degree 5


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


def displacement_kernel(
    mechanics: Mechanics, layer: Layer, cell: float, half_rows: int, half_columns: int
) -> Floats:
    """Displacement (3, 2 half_rows + 1, 2 half_columns + 1) m per Pa of normal traction."""
    response = mechanics.surface_displacement(layer, lattice(half_rows, half_columns, cell), cell)
    x, y, z = response[:, :, 2].T.reshape(3, half_rows + 1, half_columns + 1)
    return np.stack([mirrored(x, odd_x=True), mirrored(y, odd_y=True), mirrored(z)])


def cached_indentation_kernel(
    mechanics: Mechanics, layer: Layer, cell: float, step: float, half_rows: int, half_columns: int
) -> Floats:
    """Indentation (2 half_rows + 1, 2 half_columns + 1) m per Pa on a cell, every `step` m.

    It is cut from a table for later calls, which is for a modulus of 1 Pa, as every linear medium
    with one modulus scales with it, and for a medium that is the same in all directions.
    """
    size = _size(max(half_rows, half_columns) + 1)
    table = _cached(_indentation_table, mechanics, layer, cell, step, size)
    return mirrored(table[: half_rows + 1, : half_columns + 1]) / layer.young_modulus


def cached_surface_kernel(
    mechanics: Mechanics, layer: Layer, cell: float, step: float, half_rows: int, half_columns: int
) -> Floats:
    """Displacement i per traction j, (3, 3, 2 half_rows + 1, 2 half_columns + 1) m/Pa, kept."""
    size = _size(max(half_rows, half_columns) + 1)
    table = _cached(_surface_table, mechanics, layer, cell, step, size)
    part = table[:, :, : half_rows + 1, : half_columns + 1] / layer.young_modulus
    odd_x = np.zeros((3, 3), dtype=bool)
    odd_x[0, 1:] = odd_x[1:, 0] = True  # one index is x, the other is not
    odd_y = np.zeros((3, 3), dtype=bool)
    odd_y[1, ::2] = odd_y[::2, 1] = True
    every = [mirrored(part[ij], bool(odd_x[ij]), bool(odd_y[ij])) for ij in np.ndindex(3, 3)]
    return np.stack(every).reshape(3, 3, *every[0].shape)


def cached_lift_kernel(
    mechanics: Mechanics, layer: Layer, cell: float, step: float, half_rows: int, half_columns: int
) -> Floats:
    """Displacement along z per traction along x and y, (2, ...) m/Pa, as `cached_surface_kernel`.

    Of a medium that is the same in all directions.
    """
    size = _size(max(half_rows, half_columns) + 1)
    table = _cached(_lift_table, mechanics, layer, cell, step, size) / layer.young_modulus
    part = slice(half_rows + 1), slice(half_columns + 1)
    return np.stack([mirrored(table[part], odd_x=True), mirrored(table.T[part], odd_y=True)])


def _cached(
    table: Callable[..., Floats],
    mechanics: Mechanics,
    layer: Layer,
    cell: float,
    step: float,
    size: int,
) -> Floats:
    """Call `table` for a modulus of 1 Pa; a medium that cannot be hashed is not kept."""
    unit = replace(layer, young_modulus=1.0, relative_permittivity=1.0)
    try:
        hash(mechanics)
    except TypeError:
        table = table.__wrapped__  # type: ignore[attr-defined]
    return table(mechanics, unit, round(cell, 15), round(step, 15), size)


@lru_cache(maxsize=16)
def _indentation_table(
    mechanics: Mechanics, layer: Layer, cell: float, step: float, size: int
) -> Floats:
    """One quadrant (size, size), m; it is its own transpose, so half of it is computed."""
    row, column = np.tril_indices(size)
    offsets = np.column_stack([column, row]).astype(np.float64) * step
    table = np.empty((size, size))
    table[row, column] = table[column, row] = mechanics.indentation(layer, offsets, cell)
    table.setflags(write=False)
    return table


@lru_cache(maxsize=8)
def _surface_table(
    mechanics: Mechanics, layer: Layer, cell: float, step: float, size: int
) -> Floats:
    """One quadrant (3, 3, size, size), m."""
    response = mechanics.surface_displacement(layer, lattice(size - 1, size - 1, step), cell)
    table = np.ascontiguousarray(np.moveaxis(response.reshape(size, size, 3, 3), (2, 3), (0, 1)))
    table.setflags(write=False)
    return table


@lru_cache(maxsize=8)
def _lift_table(mechanics: Mechanics, layer: Layer, cell: float, step: float, size: int) -> Floats:
    """One quadrant (size, size) by traction along x, m."""
    response = mechanics.lift(layer, lattice(size - 1, size - 1, step), cell)[:, 0]
    table = np.ascontiguousarray(response.reshape(size, size))
    table.setflags(write=False)
    return table


def _size(needed: int) -> int:
    """The next of 16, 24, 32, 48, 64 ..., so that few tables serve all windows."""
    power = max(16, 1 << (needed - 1).bit_length())
    return power * 3 // 4 if needed <= power * 3 // 4 else power


class LatticeConvolution:
    """Sum over a lattice of a field times a kernel of the offset, by FFT without wrap-around.

    Parameters
    ----------
    kernel : (..., 2 down + 1, 2 right + 1) array
        At every offset of two nodes, in the precision of the sum; none is farther.
    shape : (rows, columns), optional
        Of the lattice; default that whose farthest nodes are down and right apart.
    """

    def __init__(self, kernel: NDArray[Any], shape: tuple[int, int] | None = None) -> None:
        from scipy import fft

        self.reach = reach = kernel.shape[-2] // 2, kernel.shape[-1] // 2
        self.shape = shape or (reach[0] + 1, reach[1] + 1)
        # Offsets up to `reach` fit a period of n + reach: what wraps around falls outside.
        self._padded = [fft.next_fast_len(int(n), real=True) for n in np.add(self.shape, reach)]
        periodic = np.zeros((*kernel.shape[:-2], *self._padded), dtype=kernel.dtype)
        row, column = (
            np.arange(-far, far + 1) % m for far, m in zip(reach, self._padded, strict=True)
        )
        periodic[..., row[:, None], column] = kernel
        self._spectrum = fft.rfft2(periodic)

    def __call__(self, values: NDArray[Any], total: bool = False) -> NDArray[Any]:
        """Convolve a field (rows, columns): (..., rows, columns).

        With `total` fields (J, rows, columns): the sum over j of kernel [..., j] and field j.
        """
        from scipy import fft

        rows, columns = self.shape
        product = fft.rfft2(values, self._padded) * self._spectrum
        product = product.sum(axis=-3) if total else product
        return np.asarray(fft.irfft2(product, self._padded)[..., :rows, :columns])


def interpolation(places: Floats, count: int) -> Floats:
    """Weights (N, count) of a Lagrange interpolation between the nodes 0 .. count - 1.

    Six nodes around each place, in units of their distance, 2 or more from both ends; the
    transpose carries loads to the nodes with all moments up to the fifth.
    """
    first = np.clip(np.floor(places).astype(int) - 2, 0, count - STENCIL)
    within = places - first
    node = np.arange(STENCIL)
    weights = np.ones((len(places), STENCIL))
    for other in node:
        apart = np.where(node == other, 1, node - other)
        weights *= np.where(node == other, 1.0, (within[:, None] - other) / apart)
    out = np.zeros((len(places), count))
    np.put_along_axis(out, first[:, None] + node, weights, axis=1)
    return out
