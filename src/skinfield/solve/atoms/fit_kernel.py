"""Least squares of atoms, compiled: predictions, costs and their refinement.

An atom has six parameters: x and y of its middle, ln(force/N), ln(radius/thickness), and the two
components of its half-length, all lengths in thicknesses. A half-length of 0 is a round contact;
else the contact is drawn out along a segment, a mixture of round ones.

It is half the sum of squares of the whitened residuals and of the priors: for a ball, a normal one
on the logarithm of its radius of curvature, which force and contact radius give; for a flat end or
a ring, on that of its radius; and for all, on the half-length. An offset that all taxels share is
integrated out, as its prior is normal and it enters linearly.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats
from skinfield.solve.atoms.table import Tables, cubic, cubic_slopes

PARAMETERS = 6
NODE, WEIGHT = np.polynomial.legendre.leggauss(7)  # along the segment
WEIGHT = WEIGHT / 2.0


@inner
def along(coefficients: Floats, place: float) -> tuple[float, float]:
    """Value and slope per node of a B-spline (N,) at a place inside."""
    at = int(place)
    b0, b1, b2, b3 = cubic(place - at)
    d0, d1, d2, d3 = cubic_slopes(place - at)
    c0, c1 = coefficients[at - 1], coefficients[at]
    c2, c3 = coefficients[at + 1], coefficients[at + 2]
    return b0 * c0 + b1 * c1 + b2 * c2 + b3 * c3, d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3


@inner
def _radial(
    grid: Floats, place: float, log_step: float, power: Floats, nodes: int, out: Floats
) -> None:
    """B-spline coefficients over distance alone of an atom of one radius and depth.

    Of the polynomial in u, of its slope by ln radius, and of that by u, into `out` (3, nodes);
    `grid` is the table (radii, terms, distances), `power` (2, terms) the powers of u and their
    slopes.
    """
    i = int(place)
    weight = np.empty((2, 4))
    weight[0, 0], weight[0, 1], weight[0, 2], weight[0, 3] = cubic(place - i)
    weight[1, 0], weight[1, 1], weight[1, 2], weight[1, 3] = cubic_slopes(place - i)
    out[:, :nodes] = 0.0
    for a in range(4):
        for k in range(power.shape[1]):
            row = grid[i - 1 + a, k]
            value = weight[0, a] * power[0, k]
            by_radius = weight[1, a] / log_step * power[0, k]
            by_u = weight[0, a] * power[1, k]
            for j in range(nodes):
                out[0, j] += value * row[j]
                out[1, j] += by_radius * row[j]
                out[2, j] += by_u * row[j]


@inner
def _look_up(radial: Floats, distance: float, last: int, found: Floats) -> None:
    """Value, slope by distance in nodes, and the other two slopes, at a distance in nodes."""
    j = int(distance)
    first, second, third = abs(j - 1), min(j + 1, last), min(j + 2, last)
    w0, w1, w2, w3 = cubic(distance - j)
    d0, d1, d2, d3 = cubic_slopes(distance - j)
    c0, c1, c2, c3 = radial[0, first], radial[0, j], radial[0, second], radial[0, third]
    found[0] = w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3
    found[1] = d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3
    for k in range(1, 3):
        row = radial[k]
        found[k + 1] = w0 * row[first] + w1 * row[j] + w2 * row[second] + w3 * row[third]


@njit
def predict(
    atoms: Floats, family: Any, taxels: Floats, tables: Tables, out: Floats, jacobian: Floats
) -> None:
    """Write readings (L,) of atoms (N, 6) and derivatives (L, N, 6)."""
    out[:] = 0.0
    jacobian[:] = 0.0
    radial = np.empty((3, tables.coefficients.shape[3]))
    for n in range(atoms.shape[0]):
        _add_atom(n, atoms[n], family[n], taxels, tables, radial, out, jacobian)


@inner
def _depth(
    atom: Floats, family: int, slenderness: float, tables: Tables, power: Floats
) -> tuple[float, float, float, float]:
    """Factor of the table; strain u; slope of ln s by ln radius; how a longer contact is less deep.

    Writes the powers of u and their slopes into `power` (2, terms).
    """
    force, scale, scale_slope, u, thinning = np.exp(atom[2]), 1.0, 0.0, 0.0, 0.0
    if tables.strain.shape[0]:
        place = (atom[3] - tables.first_log) / tables.log_step
        value, slope = along(tables.strain[family], place)
        scale, scale_slope = np.exp(value), slope / tables.log_step
        thin = 4.0 * slenderness / np.pi  # area beside the round ends over theirs
        thinning = thin / (1.0 + thin)
        u = min(force * scale / (1.0 + thin), 0.95)
    power[0, 0], power[1, 0] = 1.0, 0.0
    for k in range(1, power.shape[1]):
        power[0, k] = power[0, k - 1] * u
        power[1, k] = k * power[0, k - 1]
    return force * scale / (1.0 - u), u, scale_slope, thinning


@inner
def _add_atom(
    n: int,
    atom: Floats,
    family: int,
    taxels: Floats,
    tables: Tables,
    radial: Floats,
    out: Floats,
    jacobian: Floats,
) -> None:
    """Add the readings of one atom, and their derivatives at [:, n]."""
    x, y, east, north = atom[0], atom[1], atom[4], atom[5]
    radius, half = np.exp(atom[3]), np.hypot(east, north)
    points = 1 if half == 0.0 else 7
    power = np.empty((2, tables.coefficients.shape[2]))
    gain, u, scale_slope, thinning = _depth(atom, family, half / radius, tables, power)
    place = (atom[3] - tables.first_log) / tables.log_step
    reach = radius + half + tables.pad_radius + tables.sight
    last = min(int((reach + half) / tables.distance_step) + 4, radial.shape[1]) - 1
    _radial(tables.coefficients[family], place, tables.log_step, power, last + 1, radial)
    found = np.empty(4)
    log_slope = scale_slope + thinning  # of u, by ln radius
    stretch = thinning / (half * half) if points > 1 else 0.0  # of u, by the half-length
    for taxel in range(taxels.shape[0]):
        away_x, away_y = taxels[taxel, 0] - x, taxels[taxel, 1] - y
        if away_x * away_x + away_y * away_y > reach * reach:
            continue
        for q in range(points):
            share = gain if points == 1 else gain * WEIGHT[q]
            node = 0.0 if points == 1 else NODE[q]
            rx, ry = away_x - node * east, away_y - node * north
            r = np.hypot(rx, ry)
            if r > (last - 2) * tables.distance_step:
                continue
            _look_up(radial, r / tables.distance_step, last, found)
            reading = share * found[0]
            slope = share * found[1] / tables.distance_step / max(r, 1e-9)
            by_u = u * (share * found[3] + reading / (1.0 - u))  # per d ln u
            out[taxel] += reading
            jacobian[taxel, n, 0] -= slope * rx
            jacobian[taxel, n, 1] -= slope * ry
            jacobian[taxel, n, 2] += reading + by_u
            jacobian[taxel, n, 3] += share * found[2] + reading * scale_slope + by_u * log_slope
            if points > 1:
                jacobian[taxel, n, 4] -= slope * rx * node + by_u * stretch * east
                jacobian[taxel, n, 5] -= slope * ry * node + by_u * stretch * north


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


class Inputs(NamedTuple):
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
def assemble(atoms: Floats, family: Any, given: Inputs, normal: Normal, sums: Floats) -> float:
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
def _hold(atoms: Floats, family: Any, given: Inputs) -> None:
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
    given: Inputs,
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


@inner
def _room(taxels: int, atoms: int) -> Normal:
    """Arrays for as many taxels and atoms."""
    flat, size = np.empty((taxels, 6 * atoms)), 6 * atoms
    jacobian = flat.reshape((taxels, atoms, 6))
    return Normal(np.empty(taxels), jacobian, flat, np.empty(size), np.empty((size, size)))


@njit
def refined(
    atoms: Floats, family: Any, free: Any, given: Inputs, iterations: int, tolerance: float
) -> Refined:
    """Move each of S sets of atoms (S, N, 6) in place to a minimum of its cost.

    `family` (S, N); `free` (S, N, 6) says what may move. A set has settled when the last step
    gains less than `tolerance`. One function for all that is refined: compiling it takes seconds.
    """
    sets, count, taxels = atoms.shape[0], atoms.shape[1], given.taxels.shape[0]
    size, normal, trial = 6 * count, _room(taxels, count), _room(taxels, count)
    cost, tried = np.empty(sets), np.empty(sets, np.int64)
    predicted, hessian = np.empty((sets, taxels)), np.empty((sets, size, size))
    for index in range(sets):
        cost[index], tried[index] = _descend(
            atoms[index], family[index], free[index], given, iterations, tolerance, normal, trial
        )
        for taxel in range(taxels):
            predicted[index, taxel] = normal.predicted[taxel]
        for i in range(size):
            for j in range(size):
                hessian[index, i, j] = normal.hessian[i, j]
    return Refined(cost, tried, predicted, hessian)
