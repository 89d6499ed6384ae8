"""Bookkeeping of a cycle over all patches, compiled: each part in one call.

`integers` and `numbers` are those of `State`; their rows are named below.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats, Ints
from skinfield.reconstruct.engine.state import IDLE, LINEAR, MISSING
from skinfield.solve.atoms.fit_kernel import NOW
from skinfield.solve.atoms.reading_memory import unpack_fit
from skinfield.solve.idle_kernel import rests, unpack_wide

ANSWER, ON, ITERATIONS = range(3)  # of `State.integers`
ITS_GAP, SPENT = range(2)  # of `State.numbers`


Flags = NDArray[np.bool_]


@njit
def open_cycle(
    given: Floats,
    asked: Flags,
    places: Ints,
    limits: tuple[float, float],
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
            good = limits[0] < value < limits[1] and asked[place]
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
        integers[ANSWER, patch], integers[ON, patch] = MISSING, -1
        numbers[ITS_GAP, patch] = np.nan
        settled[patch] = False
    return complete


@njit
def sort_idle(
    idle: Flags,
    rung: int,
    present: Flags,
    invalid: Ints,
    integers: Ints,
    numbers: NDArray[np.float64],
) -> None:
    """Take in an idle test of all patches, on a rung.

    Those with missing taxels are left to a search, which goes by the valid ones: the same readings
    stand out more of a part of a row than of all of it.
    """
    for patch in range(len(idle)):
        if not present[patch]:
            continue
        rests = idle[patch] and invalid[patch] == 0
        integers[ANSWER, patch] = IDLE if rests else LINEAR
        integers[ON, patch] = rung if rests else -1
        numbers[ITS_GAP, patch] = 0.0 if rests else np.nan


@njit
def test_contacts(
    fits: Ints,
    wide: Ints,
    given: Floats,
    places: Ints,
    deviation: Floats,
    noise: Floats,
    valid: Flags,
    starts: Ints,
    rung: int,
    present: Flags,
    integers: Ints,
    numbers: NDArray[np.float64],
) -> None:
    """Idle test of all patches by what finds their contacts, which takes the noise they have now.

    By it, that of means of many readings, contacts stay; whether one comes goes by the `noise` of
    single ones: means of nothing but noise would seem to be touched for many cycles.
    `fits` and `wide` (P,) are addresses; see `idle_kernel`.
    """
    for patch in range(len(present)):
        if not present[patch]:
            continue
        first, last = starts[patch], starts[patch + 1]
        fit, at = unpack_fit(fits[patch]), places[first]
        end = at + last - first
        for taxel in range(last - first):
            fit.own.noise[taxel] = deviation[at + taxel]
        stated = deviation if fit.memory.counts[NOW] else noise
        its = given[at:end], stated[at:end], valid[first:last]
        idle = rests(fit, unpack_wide(wide[patch]), *its)
        integers[ANSWER, patch] = IDLE if idle else LINEAR
        integers[ON, patch] = rung if idle else -1
        numbers[ITS_GAP, patch] = 0.0 if idle else np.nan


@njit
def take_answers(
    present: Flags, rung: int, integers: Ints, numbers: NDArray[np.float64], settled: Flags
) -> None:
    """Take in linear answers of all patches that are there."""
    for patch in range(len(present)):
        if present[patch]:
            integers[ANSWER, patch] = LINEAR
            integers[ON, patch] = rung
            numbers[ITS_GAP, patch] = 0.0
            settled[patch] = True


@njit
def list_touched(integers: Ints, hot: Ints) -> int:
    """List the patches with a contact; how many there are."""
    count = 0
    for patch in range(len(hot)):
        if integers[ANSWER, patch] >= LINEAR:
            hot[count] = patch
            count += 1
    return count


@njit
def list_turns(
    hot: Ints, age: Ints, foremost: int, group: Ints, costs: NDArray[np.float64], order: Ints
) -> float:
    """Write the patches in `hot` (H,) into `order`: the foremost, then what waited longest.

    Returns what linear answers of their kinds take on the coarsest rung, s, by `costs` (G,).
    """
    for count in range(len(hot)):
        patch, place = hot[count], count
        while place > 0:
            before = order[place - 1]
            if before == foremost or (patch != foremost and age[before] >= age[patch]):
                break
            order[place] = before
            place -= 1
        order[place] = patch
    seconds = 0.0
    for its in range(len(costs)):
        for patch in hot:
            if group[patch] == its:
                seconds += costs[its]
                break
    return seconds


@njit
def close_cycle(searches: bool, integers: Ints, age: Ints) -> int:
    """Count cycles without a search where there should be `searches`.

    Returns how long the one waited that waited longest.
    """
    longest = 0
    for patch in range(len(age)):
        age[patch] = age[patch] + 1 if searches and integers[ANSWER, patch] == LINEAR else 0
        longest = max(longest, age[patch])
    return int(longest)
