"""Joint refinement of atoms: Levenberg's method on all their parameters, compiled.

An offset that all taxels share is integrated out, as its prior is normal and it enters linearly.

The cost is half the sum of squares of the whitened residuals and of the priors: for a ball, a
normal one on the logarithm of its radius of curvature, which force and contact radius give; for a
flat end or a ring, on that of its radius; and for all, on the half-length.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.kernel import Tables, along, predict

LOWEST_LOG, HIGHEST_LOG = np.log(0.18), np.log(7.0)  # of radius/thickness
DEEPEST = 0.93  # strain of the gap at the axis
RISE, FALL = 8.0, 0.2  # of the damping, after a step that failed or succeeded
FIRST_DAMPING = 1e-3
LONGEST_STEP = 1.0  # of any parameter: thicknesses, or e-foldings


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

    `predicted` (L,) and its `jacobian` (L, N, 6); the cost's `gradient` (6 N,) and Gauss-Newton
    `hessian` (6 N, 6 N).
    """

    predicted: Floats
    jacobian: Floats
    gradient: Floats
    hessian: Floats


@njit(cache=True, nogil=True)
def room(taxels: int, atoms: int) -> Normal:
    """Arrays for as many taxels and atoms."""
    size = 6 * atoms
    return Normal(
        np.empty(taxels), np.empty((taxels, atoms, 6)), np.empty(size), np.empty((size, size))
    )


@njit(cache=True, nogil=True)
def prior_terms(
    atom: Floats, family: int, tables: Tables, priors: Priors, gradient: Floats, hessian: Floats
) -> float:
    """Cost of one atom's prior; adds to its gradient (6,) and Hessian (6, 6)."""
    if family == 0:
        place = (atom[3] - tables.first_log) / tables.log_step
        value, slope = along(tables.curvature, place)
        slope /= tables.log_step
        off = (value - atom[2] - priors.ball_log) / priors.ball_std
        by_force, by_radius = -1.0 / priors.ball_std, slope / priors.ball_std
    else:
        middle, std = priors.flat_log, priors.flat_std
        if family == 2:
            middle, std = priors.ring_log, priors.ring_std
        off = (atom[3] - middle) / std
        by_force, by_radius = 0.0, 1.0 / std
    gradient[2] += off * by_force
    gradient[3] += off * by_radius
    hessian[2, 2] += by_force * by_force
    hessian[2, 3] += by_force * by_radius
    hessian[3, 2] += by_force * by_radius
    hessian[3, 3] += by_radius * by_radius
    cost = 0.5 * off * off
    weight = 1.0 / (priors.length_std * priors.length_std)
    for k in (4, 5):
        gradient[k] += atom[k] * weight
        hessian[k, k] += weight
        cost += 0.5 * atom[k] * atom[k] * weight
    return float(cost)


@njit(cache=True, nogil=True)
def assemble(atoms: Floats, family: Any, given: Given, normal: Normal) -> float:
    """Cost of N atoms; writes all else into `normal`."""
    count, taxels = atoms.shape[0], given.taxels.shape[0]
    gradient, hessian = normal.gradient, normal.hessian
    predict(atoms, family, given.taxels, given.tables, normal.predicted, normal.jacobian)
    gradient[:] = 0.0
    hessian[:] = 0.0
    cost, total = 0.0, 0.0
    along_all = np.zeros(6 * count)  # how the weighted sum of the readings moves
    flat = normal.jacobian.reshape(taxels, 6 * count)
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
            along_all[i] += slope * weight
            for j in range(i + 1):
                hessian[i, j] += slope * flat[taxel, j] * weight
    cost -= 0.5 * given.shared * total * total
    for i in range(6 * count):
        gradient[i] += given.shared * along_all[i] * total
        for j in range(i + 1):
            hessian[i, j] -= given.shared * along_all[i] * along_all[j]
            hessian[j, i] = hessian[i, j]
    for n in range(count):
        part = slice(6 * n, 6 * n + 6)
        cost += prior_terms(
            atoms[n], family[n], given.tables, given.priors, gradient[part], hessian[part, part]
        )
    return cost


@njit(cache=True, nogil=True)
def cholesky_solve(matrix: Floats, right: Floats) -> bool:
    """Solve in place, the lower triangle becoming the factor; False if it is not positive."""
    size = len(right)
    for j in range(size):
        pivot = matrix[j, j]
        for k in range(j):
            pivot -= matrix[j, k] * matrix[j, k]
        if not pivot > 0.0:
            return False
        pivot = np.sqrt(pivot)
        matrix[j, j] = pivot
        for i in range(j + 1, size):
            value = matrix[i, j]
            for k in range(j):
                value -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = value / pivot
    for i in range(size):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            right[i] -= matrix[k, i] * right[k]
        right[i] /= matrix[i, i]
    return True


@njit(cache=True, nogil=True)
def hold(atoms: Floats, family: Any, given: Given) -> None:
    """Bring atoms back to the patch and to where they are tabulated: radius and depth."""
    tables = given.tables
    for n in range(atoms.shape[0]):
        for axis in range(2):
            low, high = given.places[0, axis], given.places[1, axis]
            atoms[n, axis] = min(max(atoms[n, axis], low), high)
        atoms[n, 3] = min(max(atoms[n, 3], LOWEST_LOG), HIGHEST_LOG)
        atoms[n, 2] = min(max(atoms[n, 2], -20.0), 12.0)
        if tables.strain.shape[0]:
            place = (atoms[n, 3] - tables.first_log) / tables.log_step
            scale = along(tables.strain[family[n]], place)[0]
            half = np.hypot(atoms[n, 4], atoms[n, 5])
            thin = 1.0 + 4.0 * half / (np.pi * np.exp(atoms[n, 3]))
            atoms[n, 2] = min(atoms[n, 2], np.log(DEEPEST * thin) - scale)


@njit(cache=True, nogil=True)
def _damped_step(normal: Normal, free: Any, damping: float, factor: Floats, step: Floats) -> bool:
    """Write Levenberg's step (6 N,) of the free parameters; False where there is none."""
    size = len(step)
    for i in range(size):
        step[i] = -normal.gradient[i]
        for j in range(size):
            factor[i, j] = normal.hessian[i, j]
        factor[i, i] += damping * normal.hessian[i, i] + 1e-9
    for i in range(size):
        if not free[i // 6, i % 6]:
            step[i] = 0.0
            factor[i, :] = 0.0
            factor[:, i] = 0.0
            factor[i, i] = 1.0
    return cholesky_solve(factor, step)


@njit(cache=True, nogil=True)
def _keep(normal: Normal, trial: Normal) -> None:
    normal.predicted[:] = trial.predicted
    normal.gradient[:] = trial.gradient
    normal.hessian[:] = trial.hessian


@njit(cache=True, nogil=True)
def refine(
    atoms: Floats,
    family: Any,
    free: Any,
    given: Given,
    iterations: int,
    tolerance: float,
    normal: Normal,
) -> tuple[float, int]:
    """Move atoms (N, 6) in place to a minimum of the cost; `free` (N, 6) says which may move.

    Writes predicted readings, gradient and Hessian there into `normal`. Returns the cost and how
    many steps were tried; it has settled when the last step gains less than `tolerance`.
    """
    count = atoms.shape[0]
    size = 6 * count
    step, factor = np.empty(size), np.empty((size, size))
    trial = room(given.taxels.shape[0], count)
    hold(atoms, family, given)
    cost = assemble(atoms, family, given, normal)
    damping = FIRST_DAMPING
    for iteration in range(iterations):
        if not _damped_step(normal, free, damping, factor, step):
            damping *= RISE
            continue
        longest = max(np.abs(step).max(), 1e-300)
        moved = atoms + min(1.0, LONGEST_STEP / longest) * step.reshape(count, 6)
        hold(moved, family, given)
        gain = cost - assemble(moved, family, given, trial)
        if gain > 0.0:
            cost -= gain
            atoms[:] = moved
            _keep(normal, trial)
            damping = max(damping * FALL, 1e-9)
        else:
            damping *= RISE
        settled = 0.0 < gain < tolerance
        if settled or (gain <= 0.0 and (longest < 1e-6 or damping > 1e8)):
            return cost, iteration + 1
    return cost, iterations


@njit(cache=True, nogil=True)
def refine_each(
    atoms: Floats,
    family: Any,
    free: Any,
    given: Given,
    iterations: int,
    tolerance: float,
) -> Floats:
    """Refine each of S atoms (S, 6) alone, in place; `free` (6,). Returns their costs (S,)."""
    costs = np.empty(atoms.shape[0])
    normal = room(given.taxels.shape[0], 1)
    moves = free.reshape(1, 6)
    for index in range(atoms.shape[0]):
        one = slice(index, index + 1)
        costs[index] = refine(atoms[one], family[one], moves, given, iterations, tolerance, normal)[
            0
        ]
    return costs
