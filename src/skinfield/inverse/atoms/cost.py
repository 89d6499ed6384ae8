"""Cost of a set of atoms, with its derivatives, compiled.

It is half the sum of squares of the whitened residuals and of the priors: for a ball, a normal one
on the logarithm of its radius of curvature, which force and contact radius give; for a flat end or
a ring, on that of its radius; and for all, on the half-length. An offset that all taxels share is
integrated out, as its prior is normal and it enters linearly.
"""

from typing import Any, NamedTuple

from skinfield.errors import Floats
from skinfield.inverse.atoms.compiled import inner
from skinfield.inverse.atoms.kernel import Tables, along, predict


class Priors(NamedTuple):
    """What is known of contacts before any reading; lengths in thicknesses.

    `ball_log` and `ball_std` are of ln(radius of curvature/m), the others of ln(radius/thickness);
    `length_std` is of each component of the half-length, `force_*` of ln(force/N).
    """

    ball_log: float
    ball_std: float
    flat_log: float
    flat_std: float
    ring_log: float
    ring_std: float
    length_std: float


class Given(NamedTuple):
    """What atoms are to explain, and what is known beside; lengths in thicknesses.

    `readings` (L,), `white` (L,) one over their deviations, `taxels` (L, 2). `shared` is the
    posterior variance of an offset that all taxels share, about which the readings are silent;
    `places` (2, 2) are the lowest and highest x and y that atoms may have.
    """

    readings: Floats
    white: Floats
    taxels: Floats
    tables: Tables
    priors: Priors
    shared: float
    places: Floats


class Normal(NamedTuple):
    """What N atoms predict, and the cost about them to second order.

    `predicted` (L,), and its derivatives twice: as `jacobian` (L, N, 6) and, the same memory, as
    `flat` (L, 6 N); the cost's `gradient` (6 N,) and Gauss-Newton `hessian` (6 N, 6 N).
    """

    predicted: Floats
    jacobian: Floats
    flat: Floats
    gradient: Floats
    hessian: Floats


@inner
def _prior(
    atoms: Floats, n: int, family: int, tables: Tables, priors: Priors, normal: Normal
) -> float:
    """Cost of the n-th atom's prior; adds to gradient and Hessian."""
    gradient, hessian, first = normal.gradient, normal.hessian, 6 * n
    if family == 0:
        place = (atoms[n, 3] - tables.first_log) / tables.log_step
        value, slope = along(tables.curvature, place)
        slope /= tables.log_step
        off = (value - atoms[n, 2] - priors.ball_log) / priors.ball_std
        by_force, by_radius = -1.0 / priors.ball_std, slope / priors.ball_std
    else:
        middle, std = priors.flat_log, priors.flat_std
        if family == 2:
            middle, std = priors.ring_log, priors.ring_std
        off = (atoms[n, 3] - middle) / std
        by_force, by_radius = 0.0, 1.0 / std
    gradient[first + 2] += off * by_force
    gradient[first + 3] += off * by_radius
    hessian[first + 2, first + 2] += by_force * by_force
    hessian[first + 2, first + 3] += by_force * by_radius
    hessian[first + 3, first + 2] += by_force * by_radius
    hessian[first + 3, first + 3] += by_radius * by_radius
    cost = 0.5 * off * off
    weight = 1.0 / (priors.length_std * priors.length_std)
    for k in range(4, 6):
        gradient[first + k] += atoms[n, k] * weight
        hessian[first + k, first + k] += weight
        cost += 0.5 * atoms[n, k] * atoms[n, k] * weight
    return float(cost)


@inner
def assemble(atoms: Floats, family: Any, given: Given, normal: Normal, sums: Floats) -> float:
    """Cost of N atoms; writes all else into `normal`, and into `sums` (6 N,) what it likes."""
    count, taxels = atoms.shape[0], given.taxels.shape[0]
    gradient, hessian, flat = normal.gradient, normal.hessian, normal.flat
    predict(atoms, family, given.taxels, given.tables, normal.predicted, normal.jacobian)
    for i in range(6 * count):
        gradient[i] = 0.0
        sums[i] = 0.0  # how the weighted sum of the readings moves
        for j in range(6 * count):
            hessian[i, j] = 0.0
    cost, total = 0.0, 0.0
    for taxel in range(taxels):
        weight = given.white[taxel] * given.white[taxel]
        residual = given.readings[taxel] - normal.predicted[taxel]
        cost += 0.5 * residual * residual * weight
        total += residual * weight
        for i in range(6 * count):
            slope = flat[taxel, i]
            if slope == 0.0:
                continue
            gradient[i] -= slope * residual * weight
            sums[i] += slope * weight
            for j in range(i + 1):
                hessian[i, j] += slope * flat[taxel, j] * weight
    cost -= 0.5 * given.shared * total * total
    for i in range(6 * count):
        gradient[i] += given.shared * sums[i] * total
        for j in range(i + 1):
            hessian[i, j] -= given.shared * sums[i] * sums[j]
            hessian[j, i] = hessian[i, j]
    for n in range(count):
        cost += _prior(atoms, n, family[n], given.tables, given.priors, normal)
    return cost
