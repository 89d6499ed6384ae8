"""From the newest counts of all channels to what taxels read, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import UNUSABLE, Octets
from skinfield.errors import Floats, Ints

Flags = NDArray[np.bool_]

CHANGE, STRAIN = 0, 1  # what a reading becomes: ΔC/C₀ as it is, or v = c / (1 + c)


@njit(cache=True, nogil=True)
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
    lowest: float,
    how: int,
    scale: float,
    oldest_ns: int,
    now_ns: int,
    patience_ns: int,
    starts: Ints,
    values: Floats,
    valid: Flags,
    given: Flags,
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
    lowest : float
        Of the quantity: what no skin reads.
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
                good = lowest < value < np.inf
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
