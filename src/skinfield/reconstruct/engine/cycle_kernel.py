"""Bookkeeping of a cycle over all patches, compiled: each part in one call.

`integers` and `numbers` are those of `State`; their rows are named below.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.reconstruct.engine.block_sparse_kernel import idle_patches
from skinfield.reconstruct.engine.state import COLD, FEASIBLE, IDLE, LINEAR, MISSING, WARM
from skinfield.reconstruct.engine.timing_model import FORGET

PATCH, RUNG, GAP, LACKING, SETTLED, STEPS, COST, PREDICTED, START, END = range(10)  # of `found`
ANSWER, ON, AT, ITERATIONS, KIND = range(5)  # of `State.integers`
ITS_GAP, EXCESS, ENERGY, SPENT, EXPECTED = range(5)  # of `State.numbers`
UP, DOWN, LEAST = range(3)  # of `CostModel.moves`
NS = 1e-9


Flags = NDArray[np.bool_]


@njit
def open_cycle(
    given: Floats,
    asked: Flags,
    places: Ints,
    lowest: float,
    how: int,
    per_noise: Floats,
    valid: Flags,
    starts: Ints,
    fills: bool,
    linear: Floats,
    white: Any,
    present: Flags,
    invalid: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    settled: Flags,
    was_hot: Flags,
) -> bool:
    """Take readings, also in units of their noise, and forget the answers of before.

    A reading c becomes c / (1 + c) if `how` is 1; if it is 2, they are in `linear` and checked
    already. Those that are not `valid` are 0. `present` (P,) stays so for patches with a valid
    taxel; without `fills`, with valid ones only. Returns whether all readings are valid.
    """
    complete = True
    for taxel in range(len(places)):
        value, good = linear[taxel], valid[taxel]
        if how < 2:
            place = places[taxel]
            value = given[place]
            good = np.isfinite(value) and value > lowest and asked[place]
            if not good:
                value = 0.0
            elif how == 1:
                value /= value + 1.0
        linear[taxel], valid[taxel], white[taxel] = value, good, value * per_noise[taxel]
        complete &= good
    integers[:, :] = 0
    numbers[:, :] = 0.0
    for patch in range(len(present)):
        first, last, missing = starts[patch], starts[patch + 1], 0
        for taxel in range(first, last):
            missing += not valid[taxel]
        invalid[patch] = missing
        present[patch] &= missing < last - first and (fills or missing == 0)
        integers[ANSWER, patch], integers[KIND, patch] = MISSING, WARM if was_hot[patch] else COLD
        integers[ON, patch] = integers[AT, patch] = -1
        numbers[ITS_GAP, patch] = np.nan
        settled[patch] = False
    return complete


@njit
def test_idle(
    values: Any,
    taxels: Any,
    firsts: Any,
    cells: Any,
    table: Ints,
    dropped: Any,
    thresholds: Any,
    scores: Any,
    white: Any,
    idle: Flags,
    rung: int,
    present: Flags,
    invalid: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    masked: Ints,
    before: Ints,
) -> int:
    """Idle test, by an `Atlas`, of all patches that had no contact so far.

    Those with missing taxels that are idle are listed in `masked`, with the rung on which they
    were idle before; returns how many.
    """
    idle_patches(values, taxels, firsts, cells, table, dropped, thresholds, white, scores, idle)
    count = 0
    for patch in range(len(idle)):
        if not present[patch] or integers[ANSWER, patch] > IDLE:
            continue
        if idle[patch]:
            if invalid[patch] > 0:
                masked[count], before[count] = patch, integers[ON, patch]
                count += 1
            integers[ANSWER, patch], integers[ON, patch] = IDLE, rung
            numbers[ITS_GAP, patch] = 0.0
        else:
            integers[ANSWER, patch], integers[ON, patch] = LINEAR, -1
            numbers[ITS_GAP, patch] = np.nan
    return count


@njit
def take_answers(
    present: Flags, rung: int, integers: Ints, numbers: NDArray[np.float64], settled: Flags
) -> None:
    """Take in linear answers of all patches that are there."""
    for patch in range(len(present)):
        if present[patch]:
            integers[ANSWER, patch] = LINEAR
            integers[ON, patch] = integers[AT, patch] = rung
            numbers[ITS_GAP, patch] = 0.0
            settled[patch] = True


@njit
def list_touched(
    white: Any, starts: Ints, integers: Ints, numbers: NDArray[np.float64], hot: Ints
) -> int:
    """List the patches with a contact; how many there are.

    Of those whose contact was just seen, what an answer of 0 would cost is set.
    """
    count = 0
    for patch in range(len(starts) - 1):
        if integers[ANSWER, patch] < LINEAR:
            continue
        hot[count] = patch
        count += 1
        if numbers[ENERGY, patch] == 0.0:
            square = 0.0
            for taxel in range(starts[patch], starts[patch + 1]):
                square += white[taxel] * white[taxel]
            numbers[ENERGY, patch] = numbers[EXCESS, patch] = 0.5 * square
    return count


@njit
def list_turns(hot: Ints, age: Ints, weights: Floats, order: Ints) -> None:
    """Write the patches in `hot` (H,) into `order`: what weighs most, then what waited longest."""
    for count in range(len(hot)):
        patch, place = hot[count], count
        while place > 0:
            before = order[place - 1]
            if weights[before] > weights[patch]:
                break
            if weights[before] == weights[patch] and age[before] >= age[patch]:
                break
            order[place] = before
            place -= 1
        order[place] = patch


@njit
def all_settled(hot: Ints, settled: Flags, integers: Ints, tops: Ints) -> bool:
    """Whether all contacts are solved on the finest rung (P,) that each may have."""
    settled_all = True
    for patch in hot:
        settled_all &= settled[patch] and integers[AT, patch] >= tops[patch]
    return settled_all


@njit
def take_in(
    found: Floats,
    group: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    settled: Flags,
    unresolved: Floats,
    times: NDArray[np.float64],
    moves: Floats,
    hot: Ints,
    tops: Ints,
) -> bool:
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
    hot, tops
        As of `all_settled`, which is returned then.
    """
    for row in found:
        patch, rung, seconds = int(row[PATCH]), int(row[RUNG]), NS * (row[END] - row[START])
        its, kind = group[patch], integers[KIND, patch]
        row[PREDICTED] = times[0, its, kind, rung]
        for model in range(2):
            predicted = times[model, its, kind, rung]
            slower = seconds > predicted
            if slower or row[SETTLED] > 0.0:
                predicted *= moves[model, UP if slower else DOWN]
                times[model, its, kind, rung] = max(predicted, moves[model, LEAST])
        integers[ITERATIONS, patch] += int(row[STEPS])
        integers[KIND, patch] = WARM
        numbers[SPENT, patch] += seconds
        numbers[EXPECTED, patch] += row[COST]
        error = numbers[ENERGY, patch] * unresolved[its, rung] + row[LACKING]
        if integers[AT, patch] < 0 or error <= numbers[EXCESS, patch]:
            integers[ANSWER, patch] = FEASIBLE
            integers[ON, patch] = integers[AT, patch] = rung
            numbers[ITS_GAP, patch], numbers[EXCESS, patch] = row[GAP], error
            settled[patch] = row[SETTLED] > 0.0
    return bool(all_settled(hot, settled, integers, tops))


@njit
def close_cycle(
    hot: Ints,
    integers: Ints,
    age: Ints,
    was_hot: Flags,
    steps: Floats,
    base: Floats,
    around: Floats,
    around_base: Floats,
) -> int:
    """Remember which patches had a contact and which were served, and `relax` all predictions.

    Returns how long the one waited that waited longest.
    """
    was_hot[:] = False
    for patch in hot:
        was_hot[patch] = True
        age[patch] = 0 if integers[ANSWER, patch] >= FEASIBLE else age[patch] + 1
    longest = 0
    for patch in range(len(age)):
        if not was_hot[patch]:
            age[patch] = 0
        longest = max(longest, age[patch])
    relax(steps, base)
    relax(around, around_base)
    return int(longest)


@njit
def relax(steps: Floats, base: Floats) -> None:
    """Let predictions that are above their start come down a little."""
    for step in range(len(steps)):
        steps[step] = min(steps[step], max(FORGET * steps[step], base[step]))


UNKNOWN = -2  # in place of a rung: the patch's best upgrade is to be found anew


@njit
def plan(
    hot: Ints,
    group: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    age: Ints,
    tops: Ints,
    weights: Floats,
    times: NDArray[np.float64],
    after: float,
    unresolved: Floats,
    left: float,
    planned: NDArray[np.float64],
    target: Ints,
    order: Ints,
    rungs: Ints,
    ratios: Floats,
) -> int:
    """Choose a rung for as many of the patches in `hot` (H,) as the time pays; returns how many.

    Parameters
    ----------
    hot : (H,) array
        Patches, as rows of the arrays (P,) that follow.
    group, integers, numbers, age
        Of `State`: `KIND` is the step that a patch would take, `AT` the rung of the answer that
        there is, `EXCESS` by how much its objective may be above the minimum, `ENERGY` that of an
        answer of 0; the age weighs what a patch gains.
    tops : (P,) array
        Finest rung that each may have.
    weights : (P,) array
        Of what each gains.
    times : (2, G, kinds, R) array, s
        High quantile, and what is typical, of a step on each rung.
    after : float, s
        What each takes beside.
    unresolved : (G, R) array
        Part of the energy that each rung leaves unresolved.
    left : float, s
    planned : (G, kinds, R) array, s
        Receives the costs.
    target : (P,) array
        Receives the rung, or -1.
    order : (P,) array
        Receives the chosen patches, what gains most per second first.
    rungs, ratios : (P,) arrays
        To work in.

    Notes
    -----
    Of N searches together a high quantile is nearer to what is typical than that of one, by a
    square root of N, as they are slow independently. Each patch takes one rung at most, and only
    that is paid: a knapsack with choices, filled by the upgrade that gains most per further second
    until none fits.
    """
    share = 1.0 / np.sqrt(max(len(hot), 1))
    for its in range(planned.shape[0]):
        for kind in range(planned.shape[1]):
            for rung in range(planned.shape[2]):
                typical = times[1, its, kind, rung]
                high = times[0, its, kind, rung] - typical
                planned[its, kind, rung] = typical + share * high + after
    count = 0
    for patch in hot:
        target[patch], rungs[patch] = -1, UNKNOWN
    while True:
        chosen, highest = -1, 0.0
        for patch in hot:
            if rungs[patch] == UNKNOWN:
                rungs[patch], ratios[patch] = best_upgrade(
                    target[patch],
                    integers[AT, patch],
                    tops[patch],
                    numbers[EXCESS, patch],
                    numbers[ENERGY, patch],
                    planned[group[patch], integers[KIND, patch]],
                    unresolved[group[patch]],
                    left,
                )
                ratios[patch] *= weights[patch] * (1.0 + age[patch])
            if rungs[patch] >= 0 and ratios[patch] > highest:
                chosen, highest = patch, ratios[patch]
        if chosen < 0:
            return count
        before, paid = target[chosen], planned[group[chosen], integers[KIND, chosen]]
        more = max(paid[rungs[chosen]] - (paid[before] if before >= 0 else 0.0), 1e-9)
        if more <= left:
            left -= more
            target[chosen] = rungs[chosen]
            if before < 0:
                order[count] = chosen
                count += 1
        rungs[chosen] = UNKNOWN


@inner
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
