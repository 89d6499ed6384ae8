"""A uniformly loaded square on the half-space, averaged over a round pad."""

import numpy as np

from skinfield.errors import Floats
from skinfield.mechanics.cells import integrate_over_cell

FAR = 3.0  # cells between pad and cell beyond which plain quadrature is exact to 1e-12


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

    inner, outer = np.minimum(r, radius), np.maximum(r, radius)
    m = (inner / outer) ** 2
    rest = np.maximum((outer - inner) * (outer + inner) / outer**2, 1e-300)
    outside = 4 * outer * (ellipe(m) - rest * ellipkm1(rest))
    far = np.pi * radius**2 / outer * (1 + m / 8 + 3 * m**2 / 64 + 25 * m**3 / 1024)
    return np.where(r < radius, 4 * radius * ellipe(m), np.where(m < 1e-3, far, outside))


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
        Side of the cell and radius of the disc.

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
    distance = np.hypot(offset[:, 0], offset[:, 1])
    near = distance < radius + FAR * cell
    out = np.empty(len(offset))
    out[near] = sum(
        _side_integral(sign * offset[near, axis], offset[near, 1 - axis], cell, radius)
        for axis in (0, 1)
        for sign in (1.0, -1.0)
    )
    out[~near] = integrate_over_cell(
        lambda x, y: disc_potential(np.hypot(x, y), radius),
        offset[~near],
        cell,
        depth=FAR * cell / 2,
        reach=np.inf,
    )
    return out / (np.pi * radius**2)


def _side_integral(across: Floats, along: Floats, cell: float, radius: float) -> Floats:
    """Integrate over one side: the line at distance `across` + cell/2 from the disc's centre."""
    reach = across + cell / 2
    low, high = along - cell / 2, along + cell / 2
    crossing = np.sqrt(np.maximum(radius**2 - reach**2, 0.0))
    edges = [low, np.clip(-crossing, low, high), np.clip(crossing, low, high), high]
    node, weight = np.polynomial.legendre.leggauss(32)
    u = (node + 1) / 2
    step = u**3 * (10 - 15 * u + 6 * u**2)  # piles nodes up at the ends, where the kink is
    weight = weight / 2 * 30 * u**2 * (1 - u) ** 2
    total = np.zeros(len(reach))
    for start, stop in zip(edges[:-1], edges[1:], strict=True):
        s = start[:, None] + (stop - start)[:, None] * step
        r = np.maximum(np.hypot(reach[:, None], s), 1e-12 * radius)
        total += (stop - start) * ((_potential_within(r, radius) / r**2) @ weight)
    return np.asarray(total * reach)
