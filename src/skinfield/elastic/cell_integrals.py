"""Integrals over square cells: Love's closed forms, quadrature, and means over round pads.

All vectors point from the loaded place to the place of observation; z points out of the skin.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, as_floats, check_finite, check_positive, check_shape

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
    function: Kernel, offset: Floats, cell: float, depth: float, reach: float, rim: float = 0.0
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
def _square_rule(points: int) -> tuple[Floats, Floats, Floats]:
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
        x, y, area = (
            part * scale for part, scale in zip(_square_rule(int(points)), scales, strict=True)
        )
        rows = np.flatnonzero(order == points)
        for start in range(0, len(rows), 4096):
            part = rows[start : start + 4096]
            values = function(offset[part, :1] - x, offset[part, 1:] - y)
            out[..., part] = values @ area
    return out


class InverseDistances(NamedTuple):
    """The kernels of the half-space's surface, or their integrals over a square in m."""

    inverse: Floats  # 1/r
    xx: Floats  # x²/r³
    xy: Floats  # xy/r³
    yy: Floats  # y²/r³
    x: Floats  # x/r²
    y: Floats  # y/r²


def inverse_distances(x: Floats, y: Floats) -> InverseDistances:
    """The kernels themselves, of arrays of any one shape."""
    square = x**2 + y**2
    one = 1 / np.sqrt(square)
    over = one / square
    return InverseDistances(one, x**2 * over, x * y * over, y**2 * over, x / square, y / square)


def tensor(entries: Sequence[Floats]) -> Floats:
    """Stack the entries 00, 01, 10, 11, 02, 12, 20, 21, 22 of a tensor kernel."""
    return np.stack(np.broadcast_arrays(*entries))


def matrices(entries: Floats) -> Floats:
    """(9, N) entries in the order of `tensor`, as matrices (N, 3, 3)."""
    return entries[[0, 1, 4, 2, 3, 5, 6, 7, 8]].T.reshape(-1, 3, 3)


def surface_tensor(poisson_ratio: float, kernels: InverseDistances) -> Floats:
    r"""Displacement of the half-space's surface under a unit traction, for E = 1, as in `tensor`.

    Boussinesq's and Cerruti's point solutions (Johnson, Contact Mechanics, 3.2 and 3.6), or their
    integrals. With tangential components i, j:

    .. math::

        u_{ij} = \frac{1+\nu}{\pi E} \int \frac{(1-\nu)\delta_{ij}}{r} + \frac{\nu x_i x_j}{r^3},
        \quad u_{zz} = \frac{1-\nu^2}{\pi E} \int \frac1r, \quad
        u_{iz} = -u_{zi} = \frac{(1+\nu)(1-2\nu)}{2 \pi E} \int \frac{x_i}{r^2}
    """
    nu, scale = poisson_ratio, (1 + poisson_ratio) / np.pi
    one, x, y = (1 - nu) * kernels.inverse, (0.5 - nu) * kernels.x, (0.5 - nu) * kernels.y
    xy = nu * kernels.xy
    return scale * tensor([one + nu * kernels.xx, xy, xy, one + nu * kernels.yy, x, y, -x, -y, one])


def _length_asinh(length: Floats, other: Floats) -> Floats:
    """`length` * asinh(`other` / abs(`length`)), with its limit 0 at `length` = 0."""
    return length * np.arcsinh(other / np.where(length == 0.0, 1.0, np.abs(length)))


def inverse_distance_integrals(offset: Floats, cell: float) -> InverseDistances:
    r"""Integrals of 1/r, x²/r³, xy/r³, y²/r³, x/r², y/r² over a loaded square.

    Parameters
    ----------
    offset : (N, 2) array, m
        From the square's centre to the point of observation, inside or outside of it.
    cell : float, m
        Side of the square.

    Returns
    -------
    InverseDistances
        A tuple of six (N,) arrays, m. Exact at the centre, on edges and on corners.

    Notes
    -----
    Antiderivatives, summed over the corners with alternating signs (for 1/r: Love, 1929):

    .. math::

        \frac1r &: x\,\mathrm{asinh}\frac{y}{|x|} + y\,\mathrm{asinh}\frac{x}{|y|}, \quad
        \frac{x^2}{r^3} : y\,\mathrm{asinh}\frac{x}{|y|}, \quad
        \frac{xy}{r^3} : -r, \quad
        \frac{x}{r^2} : \tfrac12 y \ln r^2 + x \arctan\frac yx
    """
    check_positive("cell", cell, "the loaded square's side, in metres")
    offset = as_floats("offset", offset)
    check_shape("offset", offset, (None, 2), "one in-plane (x, y) per point of observation")
    check_finite("offset", offset, "a point without a place has no displacement")
    signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])  # of the four corners
    x, y = np.moveaxis(offset[None] + signs[:, None] * cell / 2.0, -1, 0)
    sign = signs.prod(axis=1)[:, None]
    square = x**2 + y**2
    # The unit of the logarithm cancels in the sum; near 1 it costs the fewest digits.
    log = 0.5 * np.log(np.where(square == 0.0, 1.0, square) / square.max(axis=0))
    over_x, over_y = _length_asinh(x, y), _length_asinh(y, x)
    angle_x = np.abs(x) * np.arctan2(y, np.abs(x))
    angle_y = np.abs(y) * np.arctan2(x, np.abs(y))

    def total(antiderivative: Floats) -> Floats:
        return np.asarray(np.sum(sign * antiderivative, axis=0))

    xx, yy = total(over_y), total(over_x)
    return InverseDistances(
        inverse=xx + yy,
        xx=xx,
        xy=total(-np.sqrt(square)),
        yy=yy,
        x=total(y * log + angle_x),
        y=total(x * log + angle_y),
    )


def mean_inverse(r: Floats, radius: float) -> Floats:
    """1/distance averaged over a disc, at r from its centre in its plane; radius 0 is a point."""
    from scipy.special import ellipe, hyp2f1

    if radius == 0.0:
        return 1.0 / r
    inside, beyond = r < radius, np.maximum(r, radius)
    out = np.asarray(hyp2f1(0.5, 0.5, 2, (radius / beyond) ** 2) / beyond)
    out[inside] = 4 / (np.pi * radius) * ellipe((r[inside] / radius) ** 2)
    return out


def _potential_within(r: Floats, radius: float) -> Floats:
    """Integral of s times the disc's potential from 0 to r."""
    from scipy.special import hyp2f1

    inner, outer = np.minimum(r, radius), np.maximum(r, radius)
    return np.asarray(np.pi * inner**2 * outer * hyp2f1(-0.5, 0.5, 2, (inner / outer) ** 2))


def mean_inverse_distance(offset: Floats, cell: float, radius: float) -> Floats:
    r"""Integral of 1/distance over a square cell, averaged over a disc.

    Parameters
    ----------
    offset : (N, 2) array
        From the cell's centre to the disc's.
    cell, radius : float
        Side of the cell and radius of the disc; 0 is a point.

    Returns
    -------
    (N,) array
        In the unit of length of the arguments; relative error near 1e-12.

    Notes
    -----
    The disc's potential f has a kink at its rim, so a rule over the square stalls. With
    :math:`\Phi(r)=\int_0^r f s\,ds` (closed in elliptic integrals) the divergence theorem leaves
    :math:`\oint \Phi(r)\, r^{-2}\, (\mathbf r\cdot\mathbf n)\, ds` over the square's four sides,
    each split where it crosses the rim.
    """
    if radius == 0.0:
        return inverse_distance_integrals(offset, cell).inverse
    distance = np.hypot(offset[:, 0], offset[:, 1])
    near = distance < radius + FAR * cell
    sides = sum(
        _side_integral(sign * offset[near, axis], offset[near, 1 - axis], cell, radius)
        for axis in (0, 1)
        for sign in (1.0, -1.0)
    )
    out = np.empty(len(offset))
    out[near] = sides / (np.pi * radius**2)
    out[~near] = integrate_over_cell(
        lambda x, y: mean_inverse(np.hypot(x, y), radius),
        offset[~near],
        cell,
        depth=0.0,
        reach=np.inf,
        rim=radius,
    )
    return out


def mean_direction(x: Floats, y: Floats, radius: float) -> Floats:
    """The vector r/r² averaged over a disc, (2, ...): as of a charged rod (Gauss); 0 is a point."""
    square = np.maximum(x**2 + y**2, radius**2)
    return np.stack([x / square, y / square])


def mean_direction_integral(offset: Floats, cell: float, radius: float) -> Floats:
    r"""Integral (2, N) of r/r² over a square cell, averaged over a disc.

    Parameters
    ----------
    offset, cell, radius
        See `mean_inverse_distance`.

    Notes
    -----
    The integrand is the gradient of ln r outside of the disc and of :math:`r^2/2a^2` within, so
    the integral over the square is that of this potential over its sides, in closed form.
    """
    if radius == 0.0:
        parts = inverse_distance_integrals(offset, cell)
        return np.stack([parts.x, parts.y])
    half = cell / 2
    total = []
    for axis in (0, 1):
        across, along = offset[:, axis], offset[:, 1 - axis]
        total.append(
            sum(
                sign * end * _along_side(across + sign * half, along + end * half, radius)
                for sign in (1.0, -1.0)
                for end in (1.0, -1.0)
            )
        )
    return np.asarray(total)


def _along_side(across: Floats, along: Floats, radius: float) -> Floats:
    """Integral of the potential of `mean_direction` along a line, from its middle; odd in `along`.

    The potential is 0 at the rim, so that terms stay small.
    """
    far, x = np.abs(along) / radius, np.abs(across) / radius
    rim = np.sqrt(np.maximum(1.0 - x**2, 0.0))

    def beyond(y: Floats) -> Floats:
        square = np.maximum(x**2 + y**2, 1e-300)
        return np.asarray(y / 2 * np.log(square) - y + x * np.arctan2(y, x))

    inner = np.minimum(far, rim)
    within = ((x**2 - 1.0) * inner + inner**3 / 3) / 2
    outside = np.where(far > rim, beyond(far) - beyond(rim), 0.0)
    return np.asarray(np.sign(along) * radius * (within + outside))


def _side_integral(across: Floats, along: Floats, cell: float, radius: float) -> Floats:
    """Integrate over one side: the line at distance `across` + cell/2 from the disc's centre."""
    reach = across + cell / 2
    low, high = along - cell / 2, along + cell / 2
    crossing = np.sqrt(np.maximum(radius**2 - reach**2, 0.0))
    knots = [-crossing, crossing]
    if cell > 4 * radius:  # beyond the rim the integrand falls as 1/s, too fast for one interval
        knots = [-3 * radius - crossing, *knots, 3 * radius + crossing]
    edges = [low, *(np.clip(knot, low, high) for knot in knots), high]
    node, weight = np.polynomial.legendre.leggauss(32)
    u = (node + 1) / 2
    step = u**3 * (10 - 15 * u + 6 * u**2)  # piles nodes up at the ends, where the kink is
    weight = weight / 2 * 30 * u**2 * (1 - u) ** 2
    total = np.zeros(len(reach))
    for start, stop in pairwise(edges):
        rows = np.flatnonzero(stop > start)
        s = start[rows, None] + (stop - start)[rows, None] * step
        r = np.maximum(np.hypot(reach[rows, None], s), 1e-12 * radius)
        total[rows] += (stop - start)[rows] * ((_potential_within(r, radius) / r**2) @ weight)
    return np.asarray(total * reach)
