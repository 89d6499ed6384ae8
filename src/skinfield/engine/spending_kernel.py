"""Which patches get which resolution for the time that is left. Compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.engine.learning_kernel import AT, ENERGY, EXCESS, KIND
from skinfield.errors import Floats

Steps = NDArray[np.int64]
UNKNOWN = -2  # in place of a rung: the patch's best upgrade is to be found anew


@njit(cache=True, nogil=True)
def best_upgrade(
    target: int,
    at: int,
    top: int,
    excess: float,
    energy: float,
    costs: Floats,
    unresolved: Floats,
    affordable: float,
) -> tuple[int, float]:
    """Rung up to `top` that gains most per second beyond `target`, and that ratio; -1: none."""
    error = excess if target < 0 else energy * unresolved[target]
    paid = 0.0 if target < 0 else costs[target]
    best, ratio = -1, 0.0
    first = max(at, 0) if target < 0 else target + 1
    for rung in range(first, top + 1):
        more = max(costs[rung] - paid, 1e-9)
        gain = error - energy * unresolved[rung]
        if gain > 0.0 and more <= affordable and gain > ratio * more:
            best, ratio = rung, gain / more
    return best, ratio


@njit(cache=True, nogil=True)
def most_gaining(hot: Steps, rungs: Steps, ratios: Floats) -> int:
    """Patch whose upgrade gains most per second; -1 where none fits."""
    chosen, highest = -1, 0.0
    for patch in hot:
        if rungs[patch] >= 0 and ratios[patch] > highest:
            chosen, highest = patch, ratios[patch]
    return chosen


@njit(cache=True, nogil=True)
def plan(
    hot: Steps,
    kind: Steps,
    group: Steps,
    at: Steps,
    excess: Floats,
    energy: Floats,
    age: Steps,
    tops: Steps,
    weights: Floats,
    costs: NDArray[np.float64],
    unresolved: Floats,
    left: float,
    target: Steps,
    order: Steps,
    rungs: Steps,
    ratios: Floats,
) -> int:
    """Choose a rung for as many of the patches in `hot` (H,) as the time pays; returns how many.

    Parameters
    ----------
    hot : (H,) array
        Patches, as rows of the arrays (P,) that follow.
    kind, group : (P,) arrays
        Of the step that the patch would take, and of the patch: where its costs stand.
    at : (P,) array
        Rung of the answer that there is; -1 where it is linear.
    excess : (P,) array
        By how much that answer's objective may be above the minimum.
    energy : (P,) array
        Objective of an answer of 0.
    age : (P,) array
        Cycles since the patch was served: weighs what it gains.
    tops : (P,) array
        Finest rung that each may have.
    weights : (P,) array
        Of what each gains.
    costs : (G, kinds, R) array, s
        Of a step on each rung.
    unresolved : (G, R) array
        Part of the energy that each rung leaves unresolved.
    left : float, s
    target : (P,) array
        Receives the rung, or -1.
    order : (P,) array
        Receives the chosen patches, what gains most per second first.
    rungs, ratios : (P,) arrays
        To work in.

    Notes
    -----
    Each patch takes one rung at most, and only that is paid: a knapsack with choices, filled by
    the upgrade that gains most per further second until none fits.
    """
    count = 0
    for patch in hot:
        target[patch], rungs[patch], ratios[patch] = -1, UNKNOWN, 0.0
    while True:
        for patch in hot:
            if rungs[patch] == UNKNOWN:
                its, row = group[patch], costs[group[patch], kind[patch]]
                rungs[patch], ratios[patch] = best_upgrade(
                    target[patch],
                    at[patch],
                    tops[patch],
                    excess[patch],
                    energy[patch],
                    row,
                    unresolved[its],
                    left,
                )
                ratios[patch] *= weights[patch] * (1.0 + age[patch])
        chosen = most_gaining(hot, rungs, ratios)
        if chosen < 0:
            return count
        before, paid = target[chosen], costs[group[chosen], kind[chosen]]
        more = max(paid[rungs[chosen]] - (paid[before] if before >= 0 else 0.0), 1e-9)
        if more <= left:
            left -= more
            target[chosen] = rungs[chosen]
            if before < 0:
                order[count] = chosen
                count += 1
        rungs[chosen] = UNKNOWN


@njit(cache=True, nogil=True)
def plan_within(
    hot: Steps,
    group: Steps,
    integers: Steps,
    numbers: NDArray[np.float64],
    age: Steps,
    tops: Steps,
    weights: Floats,
    times: NDArray[np.float64],
    after: float,
    unresolved: Floats,
    left: float,
    planned: NDArray[np.float64],
    target: Steps,
    order: Steps,
    rungs: Steps,
    ratios: Floats,
) -> int:
    """`plan` with costs that it writes into `planned` (G, kinds, R), from the two `times` of each.

    Of N searches together a high quantile is nearer to what is typical than that of one, by a
    square root of N, as they are slow independently. `after` is what each takes beside.
    """
    share = 1.0 / np.sqrt(max(len(hot), 1))
    high, typical, out = times[0].ravel(), times[1].ravel(), planned.ravel()
    for step in range(len(out)):
        out[step] = typical[step] + share * (high[step] - typical[step]) + after
    return plan(
        hot,
        integers[KIND],
        group,
        integers[AT],
        numbers[EXCESS],
        numbers[ENERGY],
        age,
        tops,
        weights,
        planned,
        unresolved,
        left,
        target,
        order,
        rungs,
        ratios,
    )
