"""Precision of a field on a lattice: the inverse of its covariance, by Fourier transform."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Grid
from skinfield.mechanics.lattice import mirrored

VANISHED = 20.0  # length scales at which the correlation is below 1e-13
LONGEST = 32.0  # length scale in pitches: beyond, the covariance is singular to rounding
DROPPED = 1e-8  # of the least eigenvalue: what may be cut off the precision


@dataclass(frozen=True, eq=False)
class Precision:
    """Inverse covariance of two nodes by their offset.

    Attributes
    ----------
    table : (2 n - 1, 2 n - 1) array
        By the offset in rows and columns, from 1 - n to n - 1; 0 farther away.
    largest_variance : float
        Of any combination of nodes with squared weights that sum to 1: the largest eigenvalue of
        the covariance.
    """

    table: Floats
    largest_variance: float

    @property
    def of_node(self) -> float:
        """Of a node with itself."""
        middle = len(self.table) // 2
        return float(self.table[middle, middle])


def matern_precision(grid: Grid, length: float, variance: float) -> Precision:
    """Of the Matérn-3/2 field on a lattice without end, of which the grid is a part.

    On the grid alone it is the precision of a field that is known to be 0 beyond the grid.

    Parameters
    ----------
    grid : Grid
    length : float, m
        Scale of the covariance.
    variance : float
        Of a node.

    Raises
    ------
    InputError
        If the nodes are too close for the length scale.
    """
    from scipy import fft

    if not length <= LONGEST * grid.pitch:
        raise InputError(
            f"length_scale is {length * 1e3:.4g} mm on nodes {grid.pitch * 1e3:.4g} mm apart, "
            f"expected at most {LONGEST:g} times their distance: neighbours could not differ; use "
            "a shorter length_scale or a coarser grid"
        )
    count = fft.next_fast_len(int(2 * np.ceil(VANISHED * length / grid.pitch)) + 32)
    offset = np.minimum(np.arange(count), count - np.arange(count)) * grid.pitch
    scaled = np.sqrt(3.0) * np.hypot(offset[:, None], offset) / length
    spectrum = fft.fft2((1 + scaled) * np.exp(-scaled)).real  # above 1e-9 of its largest value
    full = fft.ifft2(1 / spectrum).real
    reach = _reach(full, 1 / float(spectrum.max()))
    reach = min(reach, max(grid.shape), count // 2)
    table = mirrored(full[:reach, :reach]) / variance
    return Precision(table, float(spectrum.max()) * variance)


def _reach(full: Floats, least: float) -> int:
    """Offset beyond which the entries of a periodic table add up to next to nothing."""
    index = np.arange(len(full))
    ring = np.maximum.outer(*2 * (np.minimum(index, len(full) - index),))
    weight = np.bincount(ring.ravel(), np.abs(full).ravel())
    beyond = weight.sum() - np.cumsum(weight)
    return int(np.argmax(beyond <= DROPPED * least)) + 1
