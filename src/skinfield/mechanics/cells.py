"""Integrals of radial and tensor kernels over square cells."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

SMALLEST_ORDER, LARGEST_ORDER = 3, 40
DIGITS = 15.0
WIDEST = 2.0  # depths: a wider cell is cut into squares, each with few points and its own reach
FAR = 3.0  # sides between a cell and a pole beyond which plain quadrature is exact

Kernel = Callable[[Floats, Floats], Floats]


def quadrature_order(
    distance: Floats, cell: float, depth: float, rim: float = 0.0
) -> NDArray[np.int64]:
    """Points per side that integrate, to `DIGITS`, a kernel with singularities off the plane.

    Gauss-Legendre on [-cell/2, cell/2] converges as B^(-2n), with B the size of the ellipse that
    touches the nearest singularity, here `depth` under the circle of radius `rim`.
    """
    apart = np.maximum(distance - rim - 0.71 * cell, 0.0)
    nearest = np.hypot(apart, depth) / (cell / 2)
    ellipse = np.maximum(nearest + np.hypot(nearest, 1.0), 1.0 + 1e-9)
    order = np.ceil(DIGITS * np.log(10.0) / (2 * np.log(ellipse)))
    return np.asarray(np.clip(order, SMALLEST_ORDER, LARGEST_ORDER).astype(np.int64))


def integrate_over_cell(
    function: Kernel,
    offset: Floats,
    cell: float,
    depth: float,
    reach: float,
    rim: float = 0.0,
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
        Distance from the plane to the kernel's nearest singularity. If it is 0, offsets must keep
        `FAR` cells away from the rim.
    reach : float
        Beyond it the kernel is zero.
    rim : float
        Radius of the circle over which, at `depth`, the singularities lie; 0 is one point.

    Returns
    -------
    (..., N) array
    """
    centres, side = squares(cell, WIDEST * depth if depth > 0.0 else cell)
    parts = (
        _integrate_over_square(function, offset - centre, side, depth, reach, rim)
        for centre in centres
    )
    return np.asarray(sum(parts))


def integrate_with_pole(
    smooth: Kernel,
    sharp: Kernel,
    sharp_integral: Callable[[Floats, float], Floats],
    offset: Floats,
    cell: float,
    depth: float,
    reach: float,
    rim: float = 0.0,
) -> Floats:
    """Integrate `smooth` + `sharp`, the latter singular in the plane, its integral known.

    Where the cell is far from the pole the sum is integrated by quadrature, because the closed
    form of the integral is a small difference of large terms there.

    Parameters
    ----------
    smooth, sharp : see `integrate_over_cell`
        Their sum is zero beyond `reach`.
    sharp_integral : of offset (M, 2) and the cell's side
        Gives (..., M): the integral of `sharp` over the cell.
    offset, cell, depth, reach
        See `integrate_over_cell`; `depth` is that of `smooth`.
    rim : float
        Radius of the circle on which `sharp` is singular, and above which `smooth` is.
    """

    def both(x: Floats, y: Floats) -> Floats:
        near = np.hypot(x, y) < reach
        return np.asarray(np.where(near, smooth(x, y) + sharp(x, y), 0.0))

    def over_square(place: Floats, side: float) -> Floats:
        near = np.hypot(place[:, 0], place[:, 1]) < rim + FAR * side
        inside = sharp_integral(place[near], side)
        out = np.empty((*inside.shape[:-1], len(place)))
        rest = integrate_over_cell(smooth, place[near], side, depth, reach, rim)
        out[..., near] = inside + rest
        out[..., ~near] = integrate_over_cell(both, place[~near], side, 0.0, reach, rim)
        return out

    centres, side = squares(cell, WIDEST * depth)
    return np.asarray(sum(over_square(offset - centre, side) for centre in centres))


def squares(cell: float, widest: float) -> tuple[Floats, float]:
    """Cut a cell into equal squares of at most `widest`: their centres (P, 2) and their side."""
    count = int(np.ceil(cell / widest - 1e-9))
    axis = ((np.arange(count) + 0.5) / count - 0.5) * cell
    return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2), cell / count


@lru_cache(maxsize=LARGEST_ORDER)
def _rule(points: int) -> tuple[Floats, Floats, Floats]:
    """Nodes x and y, and weights, on the square from -1 to 1: each (points²,)."""
    node, weight = np.polynomial.legendre.leggauss(points)
    x, y = np.meshgrid(node, node)
    return x.ravel(), y.ravel(), np.outer(weight, weight).ravel()


def _integrate_over_square(
    function: Kernel, offset: Floats, cell: float, depth: float, reach: float, rim: float
) -> Floats:
    """One rule of Gauss and Legendre, of the order that each distance needs."""
    distance = np.hypot(offset[:, 0], offset[:, 1])
    order = quadrature_order(distance, cell, depth, rim)
    order[distance > reach + cell] = 0
    shape = np.shape(function(np.ones((1, 1)), np.ones((1, 1))))[:-2]
    out = np.zeros((*shape, len(offset)))
    scales = (cell / 2, cell / 2, cell**2 / 4)
    for points in np.unique(order[order > 0]):
        x, y, area = (part * scale for part, scale in zip(_rule(int(points)), scales, strict=True))
        rows = np.flatnonzero(order == points)
        for start in range(0, len(rows), 4096):
            part = rows[start : start + 4096]
            values = function(offset[part, :1] - x, offset[part, 1:] - y)
            out[..., part] = values @ area
    return out
