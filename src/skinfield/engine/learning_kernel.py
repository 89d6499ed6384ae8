"""What a plan's searches came to, taken into the arrays of a cycle in one call. Compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

PATCH, RUNG, GAP, MISSING, SETTLED, STEPS, COST, PREDICTED, START, END = range(10)  # of `found`
NS = 1e-9


@njit(cache=True, nogil=True)
def followed(step: float, seconds: float, up: float, down: float, least: float) -> float:
    """Prediction after a step that took `seconds`; see `CostModel.observe`."""
    return max(step * (up if seconds > step else down), least)


@njit(cache=True, nogil=True)
def learn_times(
    found: Floats, group: Ints, kind: Ints, steps: Floats, up: float, down: float, least: float
) -> None:
    """Correct `steps` (G, kinds, R), s, by searches; those cut short tell if they took longer.

    What was predicted before is written into `found`.
    """
    for row in range(len(found)):
        patch, rung = int(found[row, PATCH]), int(found[row, RUNG])
        its, seconds = steps[group[patch], kind[patch]], NS * (found[row, END] - found[row, START])
        before = its[rung]
        found[row, PREDICTED] = before
        if found[row, SETTLED] > 0.0:
            its[rung] = followed(before, seconds, up, down, least)
        elif seconds >= before:
            its[rung] = before * up


@njit(cache=True, nogil=True)
def take_answers(
    found: Floats,
    group: Ints,
    energy: Floats,
    unresolved: Floats,
    excess: Floats,
    numbers: tuple[Ints, Ints, Ints, Ints, Ints],
    seconds: tuple[Floats, Floats, Floats],
    settled: NDArray[np.bool_],
    words: tuple[int, int],
) -> None:
    """Keep the answers of searches where they are better than what the patches have.

    `numbers` are at, rung, answer, kind and iterations of `State`, `seconds` its gap, spent and
    predicted, `words` the answer and the kind that such a patch has from now on.
    """
    at, rung, answer, kind, iterations = numbers
    gap, spent, predicted = seconds
    for row in range(len(found)):
        patch, on = int(found[row, PATCH]), int(found[row, RUNG])
        error = energy[patch] * unresolved[group[patch], on] + found[row, MISSING]
        iterations[patch] += int(found[row, STEPS])
        predicted[patch] += found[row, COST]
        spent[patch] += NS * (found[row, END] - found[row, START])
        kind[patch] = words[1]
        if at[patch] < 0 or error <= excess[patch]:
            answer[patch], rung[patch], at[patch] = words[0], on, on
            gap[patch], excess[patch] = found[row, GAP], error
            settled[patch] = found[row, SETTLED] > 0.0
