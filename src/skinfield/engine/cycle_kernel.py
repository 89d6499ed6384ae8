"""Bookkeeping of a cycle over all patches, each part in one call. Compiled.

`integers` and `numbers` are those of `State`; their rows are named in `learning_kernel`.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.engine.atlas_kernel import idle_patches
from skinfield.engine.cost import FORGET
from skinfield.engine.learning_kernel import (
    ANSWER,
    AT,
    ENERGY,
    EXCESS,
    ITS_GAP,
    KIND,
    ON,
    take_in,
)
from skinfield.engine.state import COLD, FEASIBLE, IDLE, LINEAR, MISSING, WARM
from skinfield.errors import Floats, Ints

Flags = NDArray[np.bool_]


@njit(cache=True, nogil=True)
def take(
    given: Floats, asked: Flags, places: Ints, lowest: float, raw: Floats, valid: Flags
) -> bool:
    """Gather readings, 0 for those that are not `valid`; whether all are."""
    complete = True
    for taxel in range(len(places)):
        place = places[taxel]
        value = given[place]
        good = np.isfinite(value) and value > lowest and asked[place]
        raw[taxel] = value if good else 0.0
        valid[taxel] = good
        complete &= good
    return complete


@njit(cache=True, nogil=True)
def open_cycle(
    straight: Floats,
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
) -> None:
    """Keep linearised readings, also in units of their noise, and forget the answers of before.

    `present` (P,) stays so for patches with a valid taxel; without `fills`, with valid ones only.
    """
    for taxel in range(len(straight)):
        linear[taxel] = straight[taxel]
        white[taxel] = straight[taxel] * per_noise[taxel]
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


@njit(cache=True, nogil=True)
def take_and_open(
    given: Floats,
    asked: Flags,
    places: Ints,
    lowest: float,
    strain: bool,
    per_noise: Floats,
    valid: Flags,
    starts: Ints,
    fills: bool,
    straight: Floats,
    linear: Floats,
    white: Any,
    present: Flags,
    invalid: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    settled: Flags,
    was_hot: Flags,
) -> bool:
    """`take` and `open_cycle`; between them readings c become c / (1 + c) if they are a `strain`'s.

    Whether all readings are valid.
    """
    complete = take(given, asked, places, lowest, straight, valid)
    if strain:
        for taxel in range(len(straight)):
            straight[taxel] /= straight[taxel] + 1.0
    open_cycle(
        straight,
        per_noise,
        valid,
        starts,
        fills,
        linear,
        white,
        present,
        invalid,
        integers,
        numbers,
        settled,
        was_hot,
    )
    return bool(complete)


@njit(cache=True, nogil=True)
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
    """Idle test of all patches, by an `Atlas`, and `sort_idle`."""
    idle_patches(values, taxels, firsts, cells, table, dropped, thresholds, white, scores, idle)
    return int(sort_idle(idle, rung, present, invalid, integers, numbers, masked, before))


@njit(cache=True, nogil=True)
def sort_idle(
    idle: Flags,
    rung: int,
    present: Flags,
    invalid: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    masked: Ints,
    before: Ints,
) -> int:
    """Take in an idle test of all patches that had no contact so far.

    Those with missing taxels that are idle are listed in `masked`, with the rung on which they
    were idle before; returns how many.
    """
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


@njit(cache=True, nogil=True)
def answered(
    present: Flags, rung: int, integers: Ints, numbers: NDArray[np.float64], settled: Flags
) -> None:
    """Take in linear answers of all patches that are there."""
    for patch in range(len(present)):
        if present[patch]:
            integers[ANSWER, patch] = LINEAR
            integers[ON, patch] = integers[AT, patch] = rung
            numbers[ITS_GAP, patch] = 0.0
            settled[patch] = True


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def all_settled(hot: Ints, settled: Flags, integers: Ints, tops: Ints) -> bool:
    """Whether all contacts are solved on the finest rung (P,) that each may have."""
    settled_all = True
    for patch in hot:
        settled_all &= settled[patch] and integers[AT, patch] >= tops[patch]
    return settled_all


@njit(cache=True, nogil=True)
def longest_waiting(hot: Ints, age: Ints) -> int:
    """Patch in `hot` that waited longest; the first of several."""
    found = hot[0]
    for patch in hot:
        if age[patch] > age[found]:
            found = patch
    return int(found)


@njit(cache=True, nogil=True)
def learn(
    found: Floats,
    group: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
    settled: Flags,
    unresolved: Floats,
    times: Floats,
    moves: Floats,
    hot: Ints,
    tops: Ints,
) -> bool:
    """`learning_kernel.take_in`, and `all_settled` then."""
    take_in(found, group, integers, numbers, settled, unresolved, times, moves)
    return bool(all_settled(hot, settled, integers, tops))


@njit(cache=True, nogil=True)
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
        age[patch] = 0 if integers[ANSWER, patch] == FEASIBLE else age[patch] + 1
    longest = 0
    for patch in range(len(age)):
        if not was_hot[patch]:
            age[patch] = 0
        longest = max(longest, age[patch])
    relax(steps, base)
    relax(around, around_base)
    return int(longest)


@njit(cache=True, nogil=True)
def relax(steps: Floats, base: Floats) -> None:
    """Let predictions that are above their start come down a little."""
    for step in range(len(steps)):
        steps[step] = min(steps[step], max(FORGET * steps[step], base[step]))


@njit(cache=True, nogil=True)
def touch(octets: NDArray[np.uint8]) -> int:
    """Read one of each 64 octets, so that the processor has them at hand."""
    total = 0
    for place in range(0, len(octets), 64):
        total += octets[place]
    return total
