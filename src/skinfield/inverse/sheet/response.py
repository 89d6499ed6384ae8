"""What a taxel feels of a pressure on a cell at any offset, and how far that reaches."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Grid, Patch
from skinfield.mechanics import Layer, Mechanics
from skinfield.mechanics.lattice import mirrored
from skinfield.observation import Quantity

FINE = 16  # samples per cell of a kernel
WIDEST = 32  # cells from a taxel to the end of its stamp


@dataclass(frozen=True, eq=False)
class Kernel:
    """What a taxel feels of a pressure on one cell, on a lattice finer than the cells.

    Attributes
    ----------
    quadrant : (FINE reach + 1, FINE reach + 1) array, unit of the reading per Pa
        By the offset in x and y from 0, in steps of 1 / FINE of a cell.
    reach : int
        Cells from the taxel to where it ends.
    dropped : float
        Largest value beyond, as a share of the peak.
    """

    quadrant: Floats
    reach: int
    dropped: float

    @property
    def lattice(self) -> Floats:
        """Values at whole offsets, -reach to reach along both axes."""
        return mirrored(self.quadrant[::FINE, ::FINE])


class Response:
    """What a taxel reads of a cell at any offset, by the quantity's own matrix of one cell."""

    def __init__(
        self,
        mechanics: Mechanics,
        layer: Layer,
        quantity: Quantity,
        pitch: float,
        pad_diameter: float,
    ) -> None:
        corners = np.array([[0.0, 0.0, 0.0], [pitch, 0.0, 0.0], [0.0, pitch, 0.0]])
        self._cell = Grid(Patch(corners, pad_diameter, name="sheet"), (1, 1), pitch)
        self._physics = (mechanics, layer)
        self._quantity, self._pad = quantity, pad_diameter

    def __call__(self, offsets: Floats) -> Floats:
        """Unit of the reading per Pa, (N,), at offsets (N, 2) in cells."""
        places = offsets * self._cell.pitch
        matrix = self._quantity.matrix(*self._physics, self._cell, places, self._pad)
        return np.asarray(matrix[:, 0])

    def kernel(self, cut: float) -> Kernel:
        """Sampled as far as it exceeds `cut` of its peak."""
        ray = np.arange(4 * WIDEST * 2 + 1) / 4.0
        values = np.abs(
            np.concatenate(
                [
                    self(np.column_stack([ray, 0 * ray])),
                    self(np.column_stack([ray, ray])),
                ]
            )
        ).reshape(2, -1)
        away = np.maximum.reduceat(np.maximum(*values), np.arange(0, len(ray) - 1, 4))
        peak = float(values.max())
        reach = int(np.flatnonzero(away > cut * peak)[-1]) + 1
        if reach > WIDEST:
            raise InputError(
                f"a taxel's response falls to {cut:g} of its peak only {reach} cells away, "
                f"expected within {WIDEST}: a sheet is for short kernels; use larger cells, a "
                "larger cut, BaseStress() or BondedLayer()"
            )
        count = reach * FINE + 1
        i, j = np.tril_indices(count)
        quadrant = np.empty((count, count))
        quadrant[i, j] = quadrant[j, i] = self(np.column_stack([i, j]) / FINE)
        return Kernel(quadrant, reach, float(away[reach:].max() / peak))


def smoothed_kernel(kernel: Kernel, correlation: Floats, cut: float) -> Kernel:
    """A kernel convolved with a prior's correlation (2 n + 1, 2 n + 1) of cells, cut anew."""
    from scipy.signal import fftconvolve

    spread = np.zeros(((len(correlation) - 1) * FINE + 1,) * 2)
    spread[::FINE, ::FINE] = correlation
    full = fftconvolve(mirrored(kernel.quadrant), spread)
    quadrant = full[len(full) // 2 :, len(full) // 2 :]
    peak = float(np.abs(quadrant).max())
    away = np.abs(quadrant).max(axis=0)
    reach = int(np.ceil(np.flatnonzero(away > cut * peak)[-1] / FINE))
    reach = max(reach, kernel.reach)  # so that the lattice holds both
    if reach > WIDEST:
        raise InputError(
            f"the prior carries a taxel's reading {reach} cells away, expected at most {WIDEST}: "
            "use a shorter length_scale, larger cells or a larger cut"
        )
    end = reach * FINE
    beyond = float(away[end + 1 :].max(initial=0.0))
    return Kernel(quadrant[: end + 1, : end + 1], reach, beyond / peak)


def neighbour_reach(read: Kernel, spread: Kernel, cut: float) -> float:
    """Cells beyond which two taxels read less than `cut` of each other's pressure.

    As a share of what each reads of its own, for taxels in the middle of cells.
    """
    from scipy.signal import fftconvolve

    product = np.abs(fftconvolve(read.lattice, spread.lattice))
    middle = len(product) // 2
    row, column = np.indices(product.shape) - middle
    far = np.hypot(row, column)
    return float(far[product > cut * product[middle, middle]].max()) + 0.5
