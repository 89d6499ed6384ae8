"""Noise of each taxel where it is neither Gaussian nor equal: rare jumps, clipping at rest.

Most of a real taxel's noise may be jumps that come once in a hundred readings, so that its own few
quiet readings show none of it. What they show is shrunk towards what all taxels of the patch show
together, as the variance of a normal sample is towards its inverse-gamma prior (Gelman et al. 2013,
Bayesian Data Analysis, section 2.6), and widened where values far out are more than they should be.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.signal.boards import Bools
from skinfield.signal.stationary import median

PRIOR = 10.0  # readings that the patch's noise counts for, beside a taxel's own
TOUCHED = 6.0  # times the usual deviation: where a neighbour is that far out, something may touch
STAYS = 4  # readings in a row that are away from rest to one side under a touch
LYING = 40.0  # the same of what lies on the skin all the time: less is a rest that has drifted
MOST = 5.0  # times the patch's median noise: more is a touch, or a fault
FAR, FARTHER = 1e-2, 1e-3  # shares of values, by which a tail is told
# Degrees of freedom of Student's t that tails are compared with.
FREEDOMS = np.array([3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 30.0])
SURE = 3.0  # standard errors, by which a tail is heavier than a Gaussian's, if it is taken for one
ONCE = 1e4  # readings of all taxels, of which one may have a value so far out
JUMP = 3.0  # deviations: a taxel that is alone beyond, for one reading, jumped
LOW = 20.0  # percent of readings, in which a taxel is not touched
QUIETER = 25.0  # percent of readings, that are not touched
ENOUGH = 5.0  # values beyond, that tell how many there are

Neighbours = NDArray[np.int64]


def touched_readings(apart: Floats, usual: float, neighbours: Neighbours) -> Bools:
    """Where (T, L) a neighbour of a taxel is far from its rest, as a touch makes it.

    Parameters
    ----------
    apart : (T, L) array
        From rest; NaN where a taxel did not answer.
    usual : float
        Deviation of the patch.
    neighbours : (P, 2) int array
        Pairs of taxels, such as `Patch.neighbours`.
    """
    far = np.nan_to_num(np.abs(apart)) > TOUCHED * usual
    count = np.zeros(apart.shape[::-1], np.int64)
    np.add.at(count, neighbours[:, 0], far.T[neighbours[:, 1]])
    np.add.at(count, neighbours[:, 1], far.T[neighbours[:, 0]])
    return np.asarray(count.T > 0)


def is_touched(apart: Floats, usual: float, neighbours: Neighbours) -> Bools:
    """Where (T, L) a taxel is touched, or a neighbour: it stays away from rest, as no jump does."""
    from scipy.ndimage import binary_opening

    held, long = np.nan_to_num(apart), np.ones((STAYS, 1), np.bool_)
    above, below = (binary_opening(sign * held > TOUCHED * usual, long) for sign in (1.0, -1.0))
    return np.asarray(above | below | touched_readings(apart, usual, neighbours))


def draw_in_jumps(values: Floats, noise: Floats, neighbours: Neighbours) -> int:
    """Draw values in that jump: beyond `JUMP` deviations in one reading, alone; how many.

    A touch is read by more than one taxel, or for longer.

    Parameters
    ----------
    values : (T, L) array
        From rest, in order of time; written over.
    noise : (L,) array
    neighbours : (P, 2) int array
        Pairs of taxels.
    """
    most = JUMP * noise
    with np.errstate(invalid="ignore"):
        far = np.abs(values) > most
    beside = np.zeros_like(far)
    np.logical_or.at(beside.T, neighbours[:, 0], far.T[neighbours[:, 1]])
    np.logical_or.at(beside.T, neighbours[:, 1], far.T[neighbours[:, 0]])
    beside[1:] |= far[:-1]
    beside[:-1] |= far[1:]
    jumps = far & ~beside
    values[jumps] = (np.sign(values) * most)[jumps]
    return int(jumps.sum())


def usual_deviation(apart: Floats) -> float:
    """Deviation from rest (T, L) of the median taxel that has any, in the quieter readings."""
    away = np.sort(np.where(apart == 0.0, np.nan, np.abs(apart)), axis=1)  # NaN comes last
    count = (~np.isnan(away)).sum(axis=1)
    if not count.any():
        return 0.0
    middle = away[np.arange(len(away)), np.maximum(count - 1, 0) // 2][count > 0]
    return 1.4826 * float(np.percentile(middle, QUIETER))


def shared_noise(apart: Floats, neighbours: Neighbours | None = None) -> Floats:
    """Noise (L,) of taxels by their own quiet values and those of all others.

    Parameters
    ----------
    apart : (T, L) array
        From rest, drift removed; NaN where a taxel did not answer.
    neighbours : (P, 2) int array, optional
        Pairs of taxels: values are left out where a taxel or a neighbour is touched.

    Returns
    -------
    (L,) array
        NaN of a taxel without a value.
    """
    there = ~np.isnan(apart)
    usual = usual_deviation(apart)
    if not usual > 0.0:
        return np.where(there.any(axis=0), 0.0, np.nan)
    if neighbours is not None:
        there &= ~is_touched(apart, usual, neighbours)
    square = np.square(np.clip(np.nan_to_num(apart), -MOST * usual, MOST * usual))
    squares, count = np.sum(square, axis=0, where=there), there.sum(axis=0)
    patch = float(squares.sum() / max(count.sum(), 1))
    noise = np.sqrt((squares + PRIOR * patch) / (count + PRIOR))
    noise = np.minimum(noise, MOST * float(np.median(noise)))
    if count.sum() * FAR >= ENOUGH:
        noise = noise * tail_factor(np.abs(apart / noise)[there], len(noise))
    return np.where(np.isnan(apart).all(axis=0), np.nan, noise)


def tail_factor(away: Floats, taxels: int) -> float:
    """How many times wider a normal distribution is that reaches as far as values do.

    It does where one reading of all taxels in `ONCE` has a value beyond. Values so rare are not in
    a recording: Student's t leads there from two shares of values that are. At least 1.

    Parameters
    ----------
    away : (N,) array
        Distances from rest, in deviations.
    taxels : int
    """
    from scipy.stats import norm, t

    far, farther = np.quantile(away, [1.0 - FAR, 1.0 - FARTHER])
    factor = max(float(far / norm.isf(FAR / 2)), 1.0)
    count, usual = len(away) * FARTHER, float(norm.isf(FARTHER / 2))
    error = 1.0 / (usual**2 * np.sqrt(max(count, 1e-9)))  # of a quantile, part of it
    gaussian = far * usual / norm.isf(FAR / 2)
    if count < ENOUGH or farther < gaussian * (1.0 + SURE * error):
        return factor
    ratios = t.isf(FARTHER / 2, FREEDOMS) / t.isf(FAR / 2, FREEDOMS)
    freedom = FREEDOMS[int(np.argmin(np.abs(ratios * far - farther)))]
    rare = 0.5 / (ONCE * taxels)
    reach = far * t.isf(rare, freedom) / t.isf(FAR / 2, freedom)
    return max(float(reach / norm.isf(rare)), factor)


def quiet_level(counts: Floats, neighbours: Neighbours) -> Floats:
    """Median (L,) of each taxel where neither it nor a neighbour stands out.

    Of a taxel that always does by far, beside one that does, 0: something lies on the skin all the
    time, and only the board knows the rest. Any other that always does rests there.

    Parameters
    ----------
    counts : (T, L) array
        Of a board that takes the rest off itself, so that most taxels rest near 0.
    neighbours : (P, 2) int array
        Pairs of taxels.
    """
    low = np.nanpercentile(counts, LOW, axis=0)
    apart = counts - low
    usual = usual_deviation(apart)
    lies = touched_readings(low[None], usual, neighbours)[0] & (low > LYING * usual)
    quiet = ~touched_readings(apart, usual, neighbours) & (apart < TOUCHED * usual)
    level = median(np.where(quiet, counts, np.nan))
    return np.where(lies, 0.0, np.where(np.isnan(level), low, level))
