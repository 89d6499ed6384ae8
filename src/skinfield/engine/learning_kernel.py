"""What a plan's searches came to, taken into the arrays of a cycle in one call. Compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.engine.state import FEASIBLE, WARM
from skinfield.errors import Floats, Ints

PATCH, RUNG, GAP, MISSING, SETTLED, STEPS, COST, PREDICTED, START, END = range(10)  # of `found`
ANSWER, ON, AT, ITERATIONS, KIND = range(5)  # of `State.integers`
ITS_GAP, EXCESS, ENERGY, SPENT, EXPECTED = range(5)  # of `State.numbers`
UP, DOWN, LEAST = range(3)  # of `CostModel.moves`
NS = 1e-9


@njit(cache=True, nogil=True)
def take_in(
    found: Floats,
    group: Ints,
    integers: Ints,
    numbers: Floats,
    settled: NDArray[np.bool_],
    unresolved: Floats,
    times: NDArray[np.float64],
    moves: Floats,
) -> None:
    """Learn from searches, and keep their answers where they are better than what there is.

    Parameters
    ----------
    found : (N, 10) array
        Receives in `PREDICTED` what was predicted by the first of the two models.
    group, integers, numbers, settled
        Of `State`.
    unresolved : (G, R) array
    times : (2, G, kinds, R) array, s
        Predictions of two cost models, which are corrected; of a search that was cut short only
        upwards.
    moves : (2, 3) array
        Of both models.
    """
    for row in found:
        patch, rung, seconds = int(row[PATCH]), int(row[RUNG]), NS * (row[END] - row[START])
        its = times[:, group[patch], integers[KIND, patch], rung]
        row[PREDICTED] = its[0]
        for model in range(2):
            slower = seconds > its[model]
            if slower or row[SETTLED] > 0.0:
                its[model] *= moves[model, UP if slower else DOWN]
                its[model] = max(its[model], moves[model, LEAST])
        keep(patch, rung, seconds, row, group, integers, numbers, settled, unresolved)


@njit(cache=True, nogil=True)
def keep(
    patch: int,
    rung: int,
    seconds: float,
    row: Floats,
    group: Ints,
    integers: Ints,
    numbers: Floats,
    settled: NDArray[np.bool_],
    unresolved: Floats,
) -> None:
    """Keep what one search found, if it is better, and what it took."""
    integers[ITERATIONS, patch] += int(row[STEPS])
    integers[KIND, patch] = WARM
    numbers[SPENT, patch] += seconds
    numbers[EXPECTED, patch] += row[COST]
    error = numbers[ENERGY, patch] * unresolved[group[patch], rung] + row[MISSING]
    if integers[AT, patch] < 0 or error <= numbers[EXCESS, patch]:
        integers[ANSWER, patch] = FEASIBLE
        integers[ON, patch] = integers[AT, patch] = rung
        numbers[ITS_GAP, patch], numbers[EXCESS, patch] = row[GAP], error
        settled[patch] = row[SETTLED] > 0.0
