"""Smooth fields as sums of bumps: a root of the Matérn covariance that is nowhere negative."""

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Grid
from skinfield.mechanics import LatticeConvolution

VANISHED = 20.0  # length scales at which the correlation is below 1e-13
CUT = 1e-3  # of a bump's peak: what is less is no part of it
LONGEST = 100  # cells that a length scale may span: its table is a square of 40 times as many


def bump_of(grid: Grid, length: float) -> Floats:
    r"""Bump whose sums, each of an independent random amount, are a Matérn-3/2 field.

    The spectrum of the covariance is that of the bump squared. On the plane the root of
    Matérn-3/2, of a spectrum like :math:`(\kappa^2 + k^2)^{-5/2}`, is the Matérn function of order
    1/4 (Rasmussen and Williams, Gaussian Processes for Machine Learning, section 4.2), which is
    positive; what the lattice leaves below 0, and below a thousandth of the peak, is cut off.

    Parameters
    ----------
    grid : Grid
    length : float, m
        Scale of the covariance; 0 for cells that are independent.

    Returns
    -------
    (2 n + 1, 2 n + 1) array
        By the offset in rows and columns; its squares sum to 1.

    Raises
    ------
    InputError
        For a length of more than 100 cells.
    """
    from scipy import fft

    if length == 0.0:
        return np.ones((1, 1))
    if length > LONGEST * grid.pitch:
        raise InputError(
            f"length_scale is {length * 1e3:g} mm on nodes {grid.pitch * 1e3:g} mm apart, "
            f"expected at most {LONGEST * grid.pitch * 1e3:g} mm: give a coarser grid"
        )
    count = fft.next_fast_len(int(2 * np.ceil(VANISHED * length / grid.pitch)) + 32)
    offset = np.minimum(np.arange(count), count - np.arange(count)) * grid.pitch
    scaled = np.sqrt(3.0) * np.hypot(offset[:, None], offset) / length
    spectrum = np.maximum(fft.fft2((1 + scaled) * np.exp(-scaled)).real, 0.0)
    root = fft.ifft2(np.sqrt(spectrum)).real
    seen = np.flatnonzero(root[0, : count // 2] > CUT * root[0, 0])
    reach = min(int(seen[-1]), max(grid.shape) - 1)
    table = np.roll(root, (reach, reach), (0, 1))[: 2 * reach + 1, : 2 * reach + 1]
    table = np.where(table > CUT * root[0, 0], table, 0.0)
    return np.asarray(table / np.sqrt(np.square(table).sum()))


def seen_through(bump: Floats, rows: Floats, grid: Grid) -> Floats:
    """What each node's bump does to the taxels, from what each node's own pressure does: (L, K).

    A bump near the border loses what would stand beyond it.
    """
    height, width = grid.shape
    reach = len(bump) // 2
    table = np.zeros((2 * height - 1, 2 * width - 1))
    down, aside = min(reach, height - 1), min(reach, width - 1)
    part = bump[reach - down : reach + down + 1, reach - aside : reach + aside + 1]
    table[height - 1 - down : height + down, width - 1 - aside : width + aside] = part
    blur = LatticeConvolution(table)
    return np.stack([blur(row.reshape(height, width)).ravel() for row in rows])
