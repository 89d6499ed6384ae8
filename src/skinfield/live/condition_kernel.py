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
        Of `Channels`; those of our channels in `fresh` are set back to 0.
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
    starts : (P + 1,) array
        Where each patch's taxels begin.
    values, valid : (L,) arrays
        Receive readings in the quantity's unit, 0 where not valid.
    given : (L,) array
        Receives which of them to answer now: those that are valid, of patches with a new reading.
    newest, arrived : (P,) arrays
        Receive each patch's newest stamp, and how many of its taxels were read since the last time.
    """
    with_reading = 0
    for patch in range(len(newest)):
        latest, count = np.int64(0), 0
        for taxel in range(starts[patch], starts[patch + 1]):
            its = channel[taxel]
            stamp, number = stamps[its], counts[its]
            count += fresh[its]
            latest = max(latest, stamp)
            value, good = 0.0, False
            usable = alive[taxel] and stamp >= oldest_ns and (status[its] & UNUSABLE) == 0
            if usable and clamps[0] < number < clamps[1]:
                value = (number - baseline[taxel]) * per_gain[taxel]
                if how == STRAIN and value > -1.0:
                    value = value / (1.0 + value)
                value *= scale
                good = lowest < value < np.inf
            values[taxel] = value if good else 0.0
            valid[taxel] = good
        for taxel in range(starts[patch], starts[patch + 1]):
            given[taxel] = valid[taxel] and count > 0
        newest[patch], arrived[patch] = latest, count
        with_reading += 1 if count else 0
    for taxel in range(len(channel)):
        fresh[channel[taxel]] = 0
    return with_reading
