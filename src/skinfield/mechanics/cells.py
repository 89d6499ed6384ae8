"""Integrals of smooth kernels over square cells."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

SMALLEST_ORDER, LARGEST_ORDER = 3, 40
DIGITS = 13.0


def quadrature_order(distance: Floats, cell: float, depth: float) -> NDArray[np.int64]:
    """Points per side that integrate, to `DIGITS`, a kernel with a singularity `depth` below.

    Gauss-Legendre on [-cell/2, cell/2] converges as B^(-2n), with B the size of the ellipse that
    touches the nearest singularity, here `depth` under the nearest edge of the cell.
    """
    nearest = np.hypot(np.maximum(distance - 0.71 * cell, 0.0), depth) / (cell / 2)
    ellipse = nearest + np.hypot(nearest, 1.0)
    order = np.ceil(DIGITS * np.log(10.0) / (2 * np.log(ellipse)))
    return np.clip(order, SMALLEST_ORDER, LARGEST_ORDER).astype(np.int64)


def integrate_over_cell(
    function: Callable[[Floats, Floats], Floats],
    offset: Floats,
    cell: float,
    depth: float,
    reach: float,
) -> Floats:
    """Integrate a kernel over the square cell at the origin, seen from each offset.

    Parameters
    ----------
    function : of x and y, each (N, Q)
        Gives (..., N, Q): the kernel from a source point to the point of observation.
    offset : (N, 2) array
        From the cell's centre to the points of observation.
    cell : float
        Side of the cell.
    depth : float
        Distance from the plane to the kernel's nearest singularity.
    reach : float
        Beyond it the kernel is zero.

    Returns
    -------
    (..., N) array
    """
    distance = np.hypot(offset[:, 0], offset[:, 1])
    order = quadrature_order(distance, cell, depth)
    order[distance > reach + cell] = 0
    shape = np.shape(function(np.ones((1, 1)), np.ones((1, 1))))[:-2]
    out = np.zeros((*shape, len(offset)))
    for points in np.unique(order[order > 0]):
        node, weight = np.polynomial.legendre.leggauss(int(points))
        x, y = (grid.ravel() * cell / 2 for grid in np.meshgrid(node, node))
        area = np.outer(weight, weight).ravel() * cell**2 / 4
        rows = np.flatnonzero(order == points)
        for start in range(0, len(rows), 4096):
            part = rows[start : start + 4096]
            values = function(offset[part, :1] - x, offset[part, 1:] - y)
            out[..., part] = values @ area
    return out
