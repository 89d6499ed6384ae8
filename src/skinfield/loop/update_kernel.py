"""Kernels of an update, compiled: counts to readings, low-pass and threshold, copy into a slot."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats, Ints
from skinfield.signal.block import UNUSABLE, Octets

Flags = NDArray[np.bool_]
Rows = NDArray[Any]

CHANGE, STRAIN = 0, 1  # what a reading becomes: ΔC/C₀ as it is, or v = c / (1 + c)


@njit
def condition(
    channel: Ints,
    counts: Floats,
    stamps: Ints,
    status: Octets,
    fresh: Octets,
    baseline: Floats,
    per_gain: Floats,
    alive: Flags,
    clamps: tuple[float, float],
    limits: tuple[float, float],
    how: int,
    scale: float,
    oldest_ns: int,
    now_ns: int,
    patience_ns: int,
    starts: Ints,
    values: Floats,
    valid: Flags,
    given: Flags,
    lacking: Floats,
    newest: Ints,
    arrived: Ints,
) -> int:
    """Write what the taxels of all patches read; returns how many patches have a new reading.

    Parameters
    ----------
    channel : (L,) array
        Of each taxel, among all channels.
    counts, stamps, status, fresh : (C,) arrays
        Of `Channels`; those of answered patches in `fresh` are set back to 0.
    baseline, per_gain, alive : (L,) arrays
        Of the calibration; `per_gain` is 1 / gain.
    clamps : pair of float, counts
        At or beyond these a count tells nothing.
    limits : pair of float
        Of the quantity: between these are all that a skin may read.
    how, scale : int, float
        `CHANGE` or `STRAIN`, and what that is multiplied by.
    oldest_ns : int, ns
        Taxels that were read before that are not valid.
    now_ns, patience_ns : int, ns
        A reading comes in several messages. It is answered when every taxel that answers has a new
        count, or when its first one has waited for `patience_ns`.
    starts : (P + 1,) array
        Where each patch's taxels begin.
    values, valid : (L,) arrays
        Receive readings in the quantity's unit, 0 where not valid.
    given : (L,) array
        Receives which of them to answer now: those that are valid, of patches with a whole reading.
    lacking : (L,) array
        Receives how much less than nothing a taxel reads that is left out for that; else 0.
    newest, arrived : (P,) arrays
        Receive each patch's newest stamp, and how many of its taxels are new; 0 as long as its
        reading is not whole.
    """
    with_reading = 0
    for patch in range(len(newest)):
        first, last = starts[patch], starts[patch + 1]
        count, whole, latest, earliest = 0, 0, np.int64(0), np.int64(2**62)
        for taxel in range(first, last):
            its = channel[taxel]
            stamp, number = stamps[its], counts[its]
            lacking[taxel] = 0.0
            value, good, young = 0.0, False, alive[taxel] and stamp >= oldest_ns
            latest = max(latest, stamp)
            whole += young
            if fresh[its]:
                earliest = min(earliest, stamp)
                count += 1 if young else 0
            if young and (status[its] & UNUSABLE) == 0 and clamps[0] < number < clamps[1]:
                value = (number - baseline[taxel]) * per_gain[taxel]
                if how == STRAIN and value > -1.0:
                    value = value / (1.0 + value)
                value *= scale
                good = limits[0] < value < limits[1]
                if value <= limits[0]:
                    lacking[taxel] = -value
            values[taxel] = value if good else 0.0
            valid[taxel] = good
        complete = count > 0 and (count >= whole or now_ns - earliest >= patience_ns)
        newest[patch], arrived[patch] = latest, count if complete else 0
        for taxel in range(first, last):
            given[taxel] = valid[taxel] and complete
            if complete:
                fresh[channel[taxel]] = 0
        with_reading += 1 if complete else 0
    return with_reading


BULGE, BULGE_REACH = 0.1, 4.0  # of a press, read beside it, and how far, in thicknesses


@njit
def doubt_neighbours(
    lacking: Floats,
    arrived: Ints,
    plane: Floats,
    starts: Ints,
    thickness: float,
    deviation: Floats,
) -> None:
    """Widen deviations (L,) beside taxels that read less than nothing.

    Something pressed these while the baseline was taken, and what rose beside it then read less.

    Parameters
    ----------
    lacking, arrived : (L,) and (P,) arrays
        As `condition` writes them; patches without a new reading keep their deviations.
    plane : (L, 2) array, m
    starts : (P + 1,) array
        Where each patch's taxels begin.
    thickness : float, m
        Of the layer.
    """
    for patch in range(len(arrived)):
        for low in range(starts[patch], starts[patch + 1] if arrived[patch] > 0 else 0):
            if lacking[low] <= 0.0:
                continue
            for taxel in range(starts[patch], starts[patch + 1]):
                x, y = plane[taxel, 0] - plane[low, 0], plane[taxel, 1] - plane[low, 1]
                apart = (x * x + y * y) / (BULGE_REACH * thickness) ** 2
                doubt = BULGE * lacking[low] * np.exp(-apart)
                deviation[taxel] = np.sqrt(deviation[taxel] ** 2 + doubt * doubt)


NS = 1e-9


@njit
def smooth(
    channel: Ints,
    stamps: Ints,
    valid: Flags,
    given: Flags,
    stale_ns: int,
    seconds: float,
    values: Floats,
    state: Floats,
    at_ns: Ints,
) -> None:
    """First-order low-pass of each taxel: y += (x - y) dt / (T + dt), which is stable for any dt.

    Parameters
    ----------
    channel : (L,) array
        Of each taxel, among the `stamps` of all channels.
    valid, given : (L,) arrays
        As `condition` writes them.
    stale_ns : int, ns
        A taxel that was away for longer begins anew.
    seconds : float, s
        The time constant T.
    values : (L,) array
        Readings, which become smoothed ones; of taxels that are not to be answered now, the last.
    state, at_ns : (L,) arrays
        Smoothed readings, and stamps of what came last; 0: nothing yet.
    """
    for taxel in range(len(values)):
        if not valid[taxel]:
            continue
        if given[taxel]:
            stamp = stamps[channel[taxel]]
            since = stamp - at_ns[taxel]
            if at_ns[taxel] == 0 or since < 0 or since > stale_ns:
                state[taxel] = values[taxel]
            else:
                step = NS * since
                state[taxel] += step / (seconds + step) * (values[taxel] - state[taxel])
            at_ns[taxel] = stamp
        if at_ns[taxel] > 0:
            values[taxel] = state[taxel]


@njit
def drop_weak(
    rows: Rows, words: NDArray[np.int64], width: int, count: int, threshold: float
) -> int:
    """Move the contacts of at least this force to the front of `rows`; how many there are.

    `words` (R width,) is the memory of the rows, of `width` words each.
    """
    kept = 0
    for place in range(count):
        if rows[place].normal_force >= threshold:
            if kept < place:
                for word in range(width):
                    words[kept * width + word] = words[place * width + word]
            kept += 1
    return kept


@njit
def presses_within(rows: Rows, count: int, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether one of the contacts lies in a window of the patch's plane."""
    found = False
    for place in range(count):
        found |= x0 <= rows[place].x <= x1 and y0 <= rows[place].y <= y1
    return found


MISSING, IDLE, LINEAR = 0, 1, 2  # as `Answer`


@njit
def take_over(
    arrived: Ints,
    newest: Ints,
    answer: Ints,
    rung: Ints,
    gap: Floats,
    iterations: Ints,
    invalid: Ints,
    settled: Flags,
    sides: Ints,
    readings: Ints,
    patient: bool,
    now_ns: int,
    oldest_ns: int,
    patches: Rows,
    followed: Ints,
    touched: Ints,
    unended: Ints,
) -> int:
    """Take over the answers of patches with a new reading; drop those that are too old.

    Parameters
    ----------
    arrived, newest : (P,) arrays
        As `condition` writes them.
    answer, rung, gap, iterations, invalid, settled : (P,) arrays
        Of the engine's results.
    sides : (R,) array
        Nodes a side of each rung.
    readings : (P,) array
        That were averaged.
    patient : bool
        Whether a patch whose turn has not come keeps a searched answer, rather than a linear one.
    now_ns, oldest_ns : int, ns
        Of this cycle; stamp before which an answer is dropped.
    patches : (P,) array of PATCH
        What is kept.
    followed : (P,) array
        Not 0 where a patch has contacts that may come back.
    touched : (P,) array
        Receives the patches with a new answer that something touches, or whose contacts may.
    unended : (P,) array, ns
        Since when each search has not come to its end; 0: it has, or nothing touches.

    Returns
    -------
    int
        How many of them.
    """
    count = 0
    for patch in range(len(patches)):
        row = patches[patch]
        if arrived[patch] > 0 and (settled[patch] or answer[patch] <= IDLE):
            unended[patch] = 0
        elif arrived[patch] > 0 and unended[patch] == 0:
            unended[patch] = now_ns
        waits = patient and answer[patch] == LINEAR and row.answer > LINEAR
        row.fresh = 0 if waits and row.stamp_ns >= oldest_ns else arrived[patch]
        if row.fresh > 0:
            row.readings = readings[patch]
            row.answer, row.iterations = answer[patch], iterations[patch]
            row.invalid, row.gap = invalid[patch], gap[patch]
            row.rung = sides[rung[patch]] if rung[patch] >= 0 else 0
            row.stamp_ns, row.answered_ns = newest[patch], now_ns
            if row.answer <= IDLE:
                clear(row)
            if row.answer > IDLE or (row.answer == IDLE and followed[patch]):
                touched[count] = patch
                count += 1
        elif row.answer > MISSING and row.stamp_ns < oldest_ns:
            row.answer, row.rung, row.gap = MISSING, 0, np.nan
            unended[patch] = 0
            clear(row)
    return count


@njit
def clear(row: Any) -> None:
    """Nothing touches this patch."""
    row.contacts, row.force, row.peak_pressure = 0, 0.0, 0.0


@njit
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


@njit
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
