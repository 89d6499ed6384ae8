"""What a cycle keeps of its answers, and what it copies into its slot, compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

MISSING, IDLE = 0, 1  # as `Answer`
Rows = NDArray[Any]
Flags = NDArray[np.bool_]


@njit(cache=True, nogil=True)
def take_over(
    arrived: Ints,
    newest: Ints,
    answer: Ints,
    rung: Ints,
    gap: Floats,
    iterations: Ints,
    invalid: Ints,
    sides: Ints,
    now_ns: int,
    oldest_ns: int,
    patches: Rows,
    touched: Ints,
) -> int:
    """Take over the answers of patches with a new reading; drop those that are too old.

    Parameters
    ----------
    arrived, newest : (P,) arrays
        As `condition` writes them.
    answer, rung, gap, iterations, invalid : (P,) arrays
        Of the engine's results.
    sides : (R,) array
        Nodes a side of each rung.
    now_ns, oldest_ns : int, ns
        Of this cycle; stamp before which an answer is dropped.
    patches : (P,) array of PATCH
        What is kept.
    touched : (P,) array
        Receives the patches with a new answer that something touches.

    Returns
    -------
    int
        How many of them.
    """
    count = 0
    for patch in range(len(patches)):
        row = patches[patch]
        row.fresh = arrived[patch]
        if arrived[patch] > 0:
            row.answer, row.iterations = answer[patch], iterations[patch]
            row.invalid, row.gap = invalid[patch], gap[patch]
            row.rung = sides[rung[patch]] if rung[patch] >= 0 else 0
            row.stamp_ns, row.answered_ns = newest[patch], now_ns
            if row.answer > IDLE:
                touched[count] = patch
                count += 1
            else:
                clear(row)
        elif row.answer > MISSING and row.stamp_ns < oldest_ns:
            row.answer, row.rung, row.gap = MISSING, 0, np.nan
            clear(row)
    return count


@njit(cache=True, nogil=True)
def clear(row: Any) -> None:
    """Nothing touches this patch."""
    row.contacts, row.force, row.peak_pressure = 0, 0.0, 0.0


@njit(cache=True, nogil=True)
def sum_up(patches: Rows, contacts: Rows, tracks: int) -> int:
    """Force and highest pressure of every patch, from its contacts; how many contacts in all."""
    total = 0
    for patch in range(len(patches)):
        row = patches[patch]
        row.tracks = tracks
        count = min(row.contacts, contacts.shape[1])
        total += count
        force, peak = 0.0, 0.0
        for place in range(count):
            force += contacts[patch, place].normal_force
            peak = max(peak, contacts[patch, place].peak_pressure)
        row.force, row.peak_pressure = force, peak
    return total


@njit(cache=True, nogil=True)
def copy_out(
    patches: Rows,
    contacts: NDArray[np.int64],
    pressure: NDArray[np.float32],
    words: int,
    channel: Ints,
    counts: Floats,
    values: Floats,
    valid: Flags,
    to_patches: Rows,
    to_contacts: NDArray[np.int64],
    to_pressure: NDArray[np.float32],
    to_counts: NDArray[np.float32],
    to_values: NDArray[np.float32],
    to_valid: NDArray[np.uint8],
) -> None:
    """Copy what is kept, and the taxels' newest counts and values, into a slot.

    Of contacts (P, R words) and pressures (P, K) only what there is.
    """
    for patch in range(len(patches)):
        to_patches[patch] = patches[patch]
        for word in range(patches[patch].contacts * words):
            to_contacts[patch, word] = contacts[patch, word]
        if patches[patch].answer > IDLE:
            side = patches[patch].rung
            for node in range(side * side):
                to_pressure[patch, node] = pressure[patch, node]
    for taxel in range(len(channel)):
        to_counts[taxel] = counts[channel[taxel]]
        to_values[taxel] = values[taxel]
        to_valid[taxel] = valid[taxel]
