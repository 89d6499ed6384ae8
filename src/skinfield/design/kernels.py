"""Readings of one and of two round contacts at many places, compiled. Lengths in thicknesses."""

from typing import Any, NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.atom_readings import PARAMETERS, predict
from skinfield.solve.atoms.cholesky_kernel import factor, solve_factored
from skinfield.solve.atoms.fit_kernel import HIGHEST_LOG, LOWEST_LOG
from skinfield.solve.atoms.table import Tables


@njit
def picked(points: Floats, rows: Ints) -> Floats:
    """Rows of points (N, 2): indexing by an array, but quick to compile."""
    out = np.empty((len(rows), 2))
    for n in range(len(rows)):
        out[n, 0], out[n, 1] = points[rows[n], 0], points[rows[n], 1]
    return out


@njit
def grams(
    places: Floats,
    log_force: Floats,
    log_radius: float,
    taxels: Floats,
    white: Floats,
    start: Ints,
    rows: Ints,
    tables: Tables,
    out: Floats,
) -> None:
    """Write into `out` (P, 5, 5) the inner products of readings and their derivatives.

    Lengths in thicknesses. `rows[start[p]:start[p + 1]]` are the taxels near place p; `white` is 1
    over their noise. Of the five, the first is the reading, then its derivatives by x, y, ln force
    and ln radius.
    """
    atoms, family = np.zeros((1, PARAMETERS)), np.zeros(1, np.int64)
    atoms[0, 3] = log_radius
    five = np.empty(5)
    out[:] = 0.0
    for p in range(len(places)):
        near = rows[start[p] : start[p + 1]]
        count = len(near)
        readings, slopes = np.empty(count), np.empty((1, PARAMETERS, count))
        atoms[0, 0], atoms[0, 1], atoms[0, 2] = places[p, 0], places[p, 1], log_force[p]
        predict(atoms, family, picked(taxels, near), tables, readings, slopes)
        for n in range(count):
            five[0] = readings[n]
            for i in range(4):
                five[i + 1] = slopes[0, i, n]
            weight = white[near[n]] ** 2
            for i in range(5):
                for j in range(i + 1):
                    out[p, i, j] += five[i] * five[j] * weight
        for i in range(5):
            for j in range(i):
                out[p, j, i] = out[p, i, j]


STEPS = 30  # of one fit
SETTLED = 3e-3  # relative fall of the misfit in one step: below it the fit has settled
LONGEST = 0.7  # step of any parameter: thicknesses, or e-foldings
HALVINGS = 4  # of the bracket of a distance


class Pair(NamedTuple):
    """Two equal contacts: which, and what they are judged by."""

    log_force: float
    log_radius: float
    needed: float  # noncentrality that tells them from one


class Ground(NamedTuple):
    """Where a second contact may stand: a grid, and which of its nodes lie on the patch."""

    inside: Any  # (rows, columns) of bool
    x: float
    y: float
    pitch: float


@njit
def copy(source: Floats, target: Floats) -> None:
    """Copy one atom: assignment to a slice, but quick to compile."""
    for i in range(len(source)):
        target[i] = source[i]


@njit
def fits(
    atom: Floats, readings: Floats, white: Floats, taxels: Floats, tables: Tables, enough: float
) -> float:
    """Move x, y, ln force, ln radius of `atom` (1, 8) towards the least squared whitened misfit.

    Levenberg's method from where `atom` stands, until it settles or is below `enough`; returns
    the misfit.
    """
    count = len(taxels)
    family, hessian, gradient = np.zeros(1, np.int64), np.empty((4, 4)), np.empty(4)
    found, slopes = np.empty(count), np.empty((1, PARAMETERS, count))
    trial = atom.copy()
    damping, misfit = 1e-3, np.inf
    for _ in range(STEPS):
        predict(trial, family, taxels, tables, found, slopes)
        now = 0.0
        for n in range(count):
            found[n] = readings[n] - found[n]
            now += (found[n] * white[n]) ** 2
        if now < misfit:
            done = misfit - now < SETTLED * misfit or now < enough
            copy(trial[0], atom[0])
            misfit, damping = now, max(damping * 0.2, 1e-7)
            if done:
                break
            _normal_equations(found, white, slopes, hessian, gradient)
        else:
            damping *= 8.0
            if damping > 1e6:
                break
        damped, step = hessian.copy(), gradient.copy()
        for i in range(4):
            damped[i, i] += damping * hessian[i, i] + 1e-9
        if not factor(damped.reshape(-1), 4):
            break
        solve_factored(damped.reshape(-1), 4, step)
        for i in range(4):
            trial[0, i] = atom[0, i] + min(max(step[i], -LONGEST), LONGEST)
        trial[0, 3] = min(max(trial[0, 3], LOWEST_LOG), HIGHEST_LOG)
    return misfit


@inner
def _normal_equations(
    residual: Floats, white: Floats, slopes: Floats, hessian: Floats, gradient: Floats
) -> None:
    hessian[:], gradient[:] = 0.0, 0.0
    for n in range(len(residual)):
        weight = white[n] * white[n]
        for i in range(4):
            gradient[i] += slopes[0, i, n] * residual[n] * weight
            for j in range(4):
                hessian[i, j] += slopes[0, i, n] * slopes[0, j, n] * weight


@inner
def noncentrality(
    atoms: Floats, last: Floats, white: Floats, taxels: Floats, tables: Tables, enough: float
) -> float:
    """Squared whitened misfit of the best single contact to two, `atoms` (2, 8) of one radius.

    Where it is below `enough`, any misfit below will do. The fit starts from `last` (1, 8), from
    both contacts and from their middle; `last` becomes the best found.
    """
    count = len(taxels)
    readings, slopes = np.empty(count), np.empty((2, PARAMETERS, count))
    predict(atoms, np.zeros(2, np.int64), taxels, tables, readings, slopes)
    least, best, trial = np.inf, np.empty((1, PARAMETERS)), np.empty((1, PARAMETERS))
    half = np.hypot(atoms[1, 0] - atoms[0, 0], atoms[1, 1] - atoms[0, 1]) / 2
    for start in range(4):
        if start == 0:
            copy(last[0], trial[0])
        elif start == 1:
            copy(atoms[0], trial[0])
            for i in range(2):
                trial[0, i] = (atoms[0, i] + atoms[1, i]) / 2
            trial[0, 2] += np.log(2.0)
            trial[0, 3] = min(0.5 * np.log(np.exp(2 * atoms[0, 3]) + half**2), HIGHEST_LOG)
        else:
            copy(atoms[start - 2], trial[0])
        misfit = fits(trial, readings, white, taxels, tables, enough)
        if misfit < least:
            least = misfit
            copy(trial[0], best[0])
        if least < enough:
            break
    copy(best[0], last[0])
    return least


@njit
def first_distance(
    place: Floats,
    way: Floats,
    distances: Floats,
    pair: Pair,
    ground: Ground,
    taxels: Floats,
    white: Floats,
    counts: Ints,
    tables: Tables,
) -> float:
    """Smallest distance along `way` (2,) at which a second contact is told from one.

    Infinite if none of `distances` does, NaN where the patch ends before. `counts` are the taxels,
    nearest first, within sight of a contact at each distance.
    """
    atoms, last = np.zeros((2, PARAMETERS)), np.zeros((1, PARAMETERS))
    for atom in (atoms[0], atoms[1], last[0]):
        atom[0], atom[1], atom[2], atom[3] = place[0], place[1], pair.log_force, pair.log_radius
    low, high = 0.0, np.inf
    for k in range(len(distances)):
        x, y = place[0] + distances[k] * way[0], place[1] + distances[k] * way[1]
        column, row = round((x - ground.x) / ground.pitch), round((y - ground.y) / ground.pitch)
        height, width = ground.inside.shape
        if not (0 <= row < height and 0 <= column < width and ground.inside[row, column]):
            return np.nan
        atoms[1, 0], atoms[1, 1], n = x, y, counts[k]
        if noncentrality(atoms, last, white[:n], taxels[:n], tables, pair.needed) >= pair.needed:
            high = distances[k]
            break
        low = distances[k]
    if high == np.inf:
        return high
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        atoms[1, 0], atoms[1, 1] = place[0] + middle * way[0], place[1] + middle * way[1]
        if noncentrality(atoms, last, white[:n], taxels[:n], tables, pair.needed) >= pair.needed:
            high = middle
        else:
            low = middle
    return (low + high) / 2


@njit
def smallest_distances(
    places: Floats,
    ways: Floats,
    distances: Floats,
    pair: Pair,
    ground: Ground,
    taxels: Floats,
    white: Floats,
    sight: float,
    start: Ints,
    rows: Ints,
    tables: Tables,
    out: Floats,
) -> None:
    """Write into `out` (P, D) the distance of `first_distance` from each place along ways (D, 2).

    `rows[start[p]:start[p + 1]]` are the taxels near place p, nearest first.
    """
    counts = np.zeros(len(distances), np.int64)
    for p in range(len(places)):
        near = rows[start[p] : start[p + 1]]
        counts[:] = 0
        for taxel in near:
            away = np.hypot(taxels[taxel, 0] - places[p, 0], taxels[taxel, 1] - places[p, 1])
            for k in range(len(distances)):
                counts[k] += away < distances[k] + sight
        close, quiet = picked(taxels, near), np.empty(len(near))
        for n in range(len(near)):
            quiet[n] = white[near[n]]
        for d in range(len(ways)):
            out[p, d] = first_distance(
                places[p], ways[d], distances, pair, ground, close, quiet, counts, tables
            )
