"""Repair of lost taxels: what they would read, by the answer and by their neighbours, with a σ.

An answer foretells a lost taxel as well as it explains the others, if enough are left to test it.
On a skin unlike its model a few contacts more explain every reading, as a field always does, and
say nothing of what lies between. There the neighbours tell more. Each of the two has an error that
the other taxels tell; they are averaged by their variances, and where they disagree σ is wider.
Under a narrow contact only the answer knows the peak: its contacts tell how sure they are of it,
and, as far as they are believed, how far off the mean of the neighbours is.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.solve.linear import taxel_distance
from skinfield.solve.operator import Solution

REACH = 0.8  # pitches: width of the mean over neighbours
FELT = 1.2  # pitches: width of the surroundings of which an answer's error is a part
AROUND = 1.5  # pitches: width within which others' errors are those of a lost taxel
NEAREST = 48  # taxels that are looked at
LIKENESS = 0.05  # of what is read around: the least that an answer is off by
TOUCHED, FORETOLD = 3.0, 1.0  # deviations that are read, or would be of the answer
EVEN = 0.5  # odds against contacts that no other taxel tests
ALONE = 1e3  # pitches: too far for a neighbour

Flags = NDArray[np.bool_]


def readings_of(
    solution: Solution,
    valid: Flags,
    predict: Callable[[], Floats],
    given: tuple[Floats, Floats | float] | None = None,
) -> tuple[Floats, Floats]:
    """Readings (L,) in the quantity's unit, of lost taxels what they would be; and deviations.

    Those of measured readings are their noise.

    Parameters
    ----------
    solution : Solution
        That nothing overwrites.
    valid : (L,) bool array
    predict : function
        What the taxels would read of it, (L,) as its readings.
    given : tuple of (L,) arrays, optional
        Readings, and the rest that was taken from them. Default the solution's, and 0.
    """
    model, fit = solution.operator.model, solution.fit
    physics = model.physics if fit is None else None  # else they were not linearised

    def unlinearised(linear: Floats) -> Floats:
        return linear if physics is None else physics.quantity.from_linear(linear)

    read, rest = (unlinearised(solution.readings), 0.0) if given is None else given
    noise = np.array(model.noise_std)
    if valid.all():
        return np.array(read), noise
    parameters = np.inf if fit is None else fit.keep().parameters
    places = model.taxels / taxel_distance(model.taxels, model.grid.pitch)
    unsure = None
    if fit is not None:
        spread = solution.operator.pressure_std(solution)
        unsure = np.zeros(len(noise))
        unsure[~valid] = np.abs(model.matrix[~valid] @ spread)
    known = valid, noise, places, unlinearised(predict()), parameters, unsure
    value, std = repaired(read - rest, *known)
    return np.where(valid, read, value + rest), std


def repaired(
    read: Floats,
    valid: Flags,
    noise: Floats,
    places: Floats,
    predicted: Floats,
    parameters: float = np.inf,
    unsure: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Readings (L,) with those of lost taxels repaired, and the deviation of each.

    Parameters
    ----------
    read : (L,) array
        Numbers, whatever those of lost taxels.
    valid : (L,) bool array
    noise : (L,) array
    places : (L, 2) array, in pitches
    predicted : (L,) array
        By the answer.
    parameters : float
        Numbers of the answer that these readings told. Default as many as there are.
    unsure : (L,) array, optional
        Deviation of what is predicted, by that of the contacts. Default: there are none.
    """
    from scipy.spatial import cKDTree

    if not valid.any():  # nothing is known
        return predicted, np.full(len(read), np.inf)
    read, std, lost = read.copy(), noise.copy(), np.flatnonzero(~valid)
    known, values, own, foretold = (each[valid] for each in (places, read, noise, predicted))
    part = error_part(values, foretold, own, parameters)
    tree, ranks = cKDTree(known), np.arange(1, min(NEAREST, len(known)) + 1)
    for taxel in lost:
        apart, near = map(np.asarray, tree.query(places[taxel], k=ranks))
        around = np.exp(-np.square(apart / FELT)) @ np.square(values[near])
        mean, variance = neighbour_mean(known[near], values[near], own[near], apart)
        if unsure is not None:  # contacts tell what lies between taxels
            explained, _ = neighbour_mean(known[near], foretold[near], own[near], apart)
            unseen = (predicted[taxel] - explained) ** 2 + unsure[taxel] ** 2
            variance += (1.0 - EVEN * part) * unseen
        away = -np.expm1(-(max(apart[0] - 1.0, 0.0) ** 2))  # what is read elsewhere may be here
        unknown = away * np.square(values).mean()
        unlike = part * (predicted[taxel] ** 2 + around) + unknown
        answer = predicted[taxel], unlike + (0.0 if unsure is None else unsure[taxel] ** 2)
        read[taxel], std[taxel] = averaged(answer, (mean, variance + unknown), noise[taxel])
    return read, std


def averaged(one: tuple[float, float], other: tuple[float, float], noise: float) -> Floats:
    """Mean of two means by their variances; the deviation of a reading with noise from it.

    It is as much wider as they disagree.
    """
    (first, narrow), (second, wide), own = one, other, noise * noise
    weight = (wide + own) / (narrow + wide + 2.0 * own)
    independent = weight**2 * narrow + (1.0 - weight) ** 2 * wide
    apart = weight * (1.0 - weight) * (first - second) ** 2
    mean = weight * first + (1.0 - weight) * second
    return np.array([mean, np.sqrt(own + independent + apart)])


def error_part(read: Floats, predicted: Floats, noise: Floats, parameters: float) -> float:
    """Part of what is read around a taxel that its answer is off by, squared; 1 at most.

    By generalised cross-validation of what is touched (Golub, Heath and Wahba 1979, Technometrics
    21, 215-223): what is left over, over the share of taxels that no parameter takes up.
    """
    touched = (np.abs(read) > TOUCHED * noise) | (np.abs(predicted) > FORETOLD * noise)
    count, squares = int(touched.sum()), float(np.square(read[touched]).sum())
    if not count:
        return 0.0
    free = max(1.0 - parameters / count, 0.0)
    left = np.square((read - predicted)[touched]).sum() - free * np.square(noise[touched]).sum()
    own = LIKENESS**2 + (max(left, 0.0) / squares if squares > 0.0 else 1.0)
    return float(own / free**2) if own < free**2 else 1.0


def neighbour_mean(
    places: Floats, read: Floats, noise: Floats, apart: Floats
) -> tuple[float, float]:
    """Mean of what neighbours of a lost taxel read, and its variance.

    That is the mean square of what the same mean of the taxels around is off by.

    Parameters
    ----------
    places : (N, 2) array, in pitches
        Of the taxels around.
    read, noise, apart : (N,) arrays
        Of these; in pitches from the lost one.
    """
    if len(read) == 1:
        return float(read[0]), float(read[0] ** 2)
    steps = np.linalg.norm(places[:, None] - places, axis=-1)
    np.fill_diagonal(steps, ALONE)  # no taxel is its own neighbour
    steps = np.vstack([apart, steps])
    weights = np.exp((np.square(steps.min(axis=1, keepdims=True)) - np.square(steps)) / REACH**2)
    mean = weights @ read / weights.sum(axis=1)
    alike = np.exp((apart.min() ** 2 - np.square(apart)) / AROUND**2)
    off = np.maximum(np.square(read - mean[1:]) - np.square(noise), 0.0)
    return float(mean[0]), float(alike @ off / alike.sum())
