"""A uniformly loaded square on the half-space, averaged over a round pad."""

from itertools import pairwise

import numpy as np

from skinfield.errors import Floats
from skinfield.mechanics.cells import FAR, integrate_over_cell
from skinfield.mechanics.love import inverse_distance_integrals

# Gauss's 2F1(1/2, 1/2; 2; m), to 1e-16 for m < 1/9
_MULTIPOLES = np.cumprod([1.0, *((n - 0.5) ** 2 / (n * (n + 1.0)) for n in range(1, 16))])


def _ratio_function(m: Floats) -> Floats:
    """Gauss's 2F1(-1/2, 1/2; 2; m) for 0 <= m <= 1."""
    from scipy.special import ellipe, ellipkm1

    rest = np.maximum(1.0 - m, 1e-300)
    large = np.maximum(m, 0.05)
    closed = 4 / (3 * np.pi) * ((1 + large) * ellipe(large) - rest * ellipkm1(rest)) / large
    series, term = np.ones_like(m), np.ones_like(m)
    small = np.minimum(m, 0.05)
    for n in range(10):
        term = term * small * (n - 0.5) * (n + 0.5) / ((n + 2.0) * (n + 1.0))
        series = series + term
    return np.where(m < 0.05, series, closed)


def disc_potential(r: Floats, radius: float) -> Floats:
    """Integral of 1/distance over a disc, at r from its centre in its plane; same unit as r."""
    from scipy.special import ellipe, ellipkm1

    r = np.asarray(r, dtype=np.float64)
    out = np.empty(r.shape)
    inside, far = r < radius, r > 3 * radius
    outside = ~(inside | far)
    out[inside] = 4 * radius * ellipe((r[inside] / radius) ** 2)
    near = r[outside]
    rest = np.maximum((near - radius) * (near + radius) / near**2, 1e-300)
    out[outside] = 4 * near * (ellipe((radius / near) ** 2) - rest * ellipkm1(rest))
    out[far] = np.pi * radius**2 / r[far] * np.polyval(_MULTIPOLES[::-1], (radius / r[far]) ** 2)
    return out


def mean_inverse(r: Floats, radius: float) -> Floats:
    """1/distance averaged over a disc, at r from its centre; radius 0 is a point."""
    return disc_potential(r, radius) / (np.pi * radius**2) if radius > 0.0 else 1.0 / r


def _potential_within(r: Floats, radius: float) -> Floats:
    """Integral of s * disc_potential(s) from 0 to r."""
    inner, outer = np.minimum(r, radius), np.maximum(r, radius)
    return np.pi * inner**2 * outer * _ratio_function((inner / outer) ** 2)


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
