"""Joint refinement of atoms: Levenberg's method on all their parameters, compiled."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse.atoms.compiled import inner
from skinfield.inverse.atoms.cost import Given, Normal, assemble
from skinfield.inverse.atoms.kernel import along

LOWEST_LOG, HIGHEST_LOG = np.log(0.18), np.log(7.0)  # of radius/thickness
DEEPEST = 0.93  # strain of the gap at the axis
RISE, FALL = 8.0, 0.2  # of the damping, after a step that failed or succeeded
FIRST_DAMPING = 1e-3
LONGEST_STEP = 1.0  # of any parameter: thicknesses, or e-foldings


class Refined(NamedTuple):
    """What became of S sets of N atoms: `cost` (S,), and how many steps were `tried` (S,).

    `predicted` (S, L) and the cost's `hessian` (S, 6 N, 6 N) are of where the atoms are then.
    """

    cost: Floats
    tried: NDArray[np.int64]
    predicted: Floats
    hessian: Floats


def refined(
    atoms: Floats,
    family: NDArray[np.int64],
    free: NDArray[np.bool_],
    given: Given,
    iterations: int,
    tolerance: float,
) -> Refined:
    """Move each of S sets of atoms (S, N, 6) in place to a minimum of its cost.

    `family` (S, N); `free` (S, N, 6) says what may move. A set has settled when the last step
    gains less than `tolerance`.
    """
    sets, count, taxels = atoms.shape[0], atoms.shape[1], len(given.taxels)
    made = Refined(
        np.empty(sets),
        np.empty(sets, np.int64),
        np.empty((sets, taxels)),
        np.empty((sets, 6 * count, 6 * count)),
    )
    now, trial = _room(taxels, count), _room(taxels, count)
    refine(atoms, family, free, given, iterations, tolerance, made, now, trial)
    return made


def _room(taxels: int, atoms: int) -> Normal:
    """Arrays for as many taxels and atoms."""
    flat, size = np.empty((taxels, 6 * atoms)), 6 * atoms
    jacobian = flat.reshape(taxels, atoms, 6)
    return Normal(np.empty(taxels), jacobian, flat, np.empty(size), np.empty((size, size)))


@inner
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


@inner
def _hold(atoms: Floats, family: Any, given: Given) -> None:
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


@inner
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
            for j in range(size):
                factor[i, j] = 0.0
                factor[j, i] = 0.0
            factor[i, i] = 1.0
    return cholesky_solve(factor, step)


@inner
def _keep(trial: Normal, normal: Normal) -> None:
    """Copy all but the derivatives, element by element: quick to compile."""
    for taxel in range(len(trial.predicted)):
        normal.predicted[taxel] = trial.predicted[taxel]
    for i in range(len(trial.gradient)):
        normal.gradient[i] = trial.gradient[i]
        for j in range(len(trial.gradient)):
            normal.hessian[i, j] = trial.hessian[i, j]


@inner
def _descend(
    atoms: Floats,
    family: Any,
    free: Any,
    given: Given,
    iterations: int,
    tolerance: float,
    normal: Normal,
    trial: Normal,
) -> tuple[float, int]:
    """Refine one set of atoms (N, 6) in place; its cost, and the steps that were tried."""
    count, size = atoms.shape[0], 6 * atoms.shape[0]
    step, sums, factor = np.empty(size), np.empty(size), np.empty((size, size))
    moved = np.empty((count, 6))
    _hold(atoms, family, given)
    cost = assemble(atoms, family, given, normal, sums)
    damping = FIRST_DAMPING
    for iteration in range(iterations):
        if not _damped_step(normal, free, damping, factor, step):
            damping *= RISE
            continue
        longest = 1e-300
        for i in range(size):
            longest = max(longest, abs(step[i]))
        share = min(1.0, LONGEST_STEP / longest)
        for i in range(size):
            moved[i // 6, i % 6] = atoms[i // 6, i % 6] + share * step[i]
        _hold(moved, family, given)
        gain = cost - assemble(moved, family, given, trial, sums)
        if gain > 0.0:
            cost -= gain
            for i in range(size):
                atoms[i // 6, i % 6] = moved[i // 6, i % 6]
            _keep(trial, normal)
            damping = max(damping * FALL, 1e-9)
        else:
            damping *= RISE
        settled = 0.0 < gain < tolerance
        if settled or (gain <= 0.0 and (longest < 1e-6 or damping > 1e8)):
            return cost, iteration + 1
    return cost, iterations


@njit(cache=True, nogil=True)
def refine(
    atoms: Floats,
    family: Any,
    free: Any,
    given: Given,
    iterations: int,
    tolerance: float,
    made: Refined,
    normal: Normal,
    trial: Normal,
) -> None:
    """Write into `made` what becomes of S sets of atoms; `normal` and `trial` are room for one.

    One function for all that is refined, as compiling it takes seconds: see `refined`.
    """
    for index in range(atoms.shape[0]):
        made.cost[index], made.tried[index] = _descend(
            atoms[index], family[index], free[index], given, iterations, tolerance, normal, trial
        )
        for taxel in range(len(normal.predicted)):
            made.predicted[index, taxel] = normal.predicted[taxel]
        for i in range(len(normal.gradient)):
            for j in range(len(normal.gradient)):
                made.hessian[index, i, j] = normal.hessian[i, j]
