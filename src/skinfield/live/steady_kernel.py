"""How many of the newest readings agree, and their mean, compiled."""

import numpy as np
from numba import njit

from skinfield.errors import Floats

CLEAR = 5.0  # deviations from which a taxel reads something of a touch


@njit(cache=True, nogil=True)
def average(
    values: Floats, valid: Floats, end: int, held: int, noise: Floats, bounds: Floats, out: Floats
) -> int:
    """Write the mean of the newest readings that agree; returns how many these are.

    As many readings before them as there are by now are added if they agree, then half of these, a
    quarter, ... They agree if the oldest 1, 2, 4, ... of them and all of them do.

    Parameters
    ----------
    values, valid : (N, L) arrays
        Readings, 0 where `valid` is 0, else that is 1.
    end, held : int
        The newest reading is row `end` - 1, and the oldest that counts `end` - `held`.
    noise : (L,) array
        Of one reading.
    bounds : (3,) array
        See `steady.BOUNDS`.
    out : (2, L) array
        Receives the means, and of how many readings they are.
    """
    taxels = len(noise)
    new, count = values[end - 1].copy(), valid[end - 1].copy()
    old, before = np.empty(taxels), np.empty(taxels)
    size = step = 1
    growing = True
    while step > 0:
        good = size + step <= held
        if good:
            old[:] = 0.0
            before[:] = 0.0
            first, part = end - size - step, 1
            for row in range(first, end - size):
                for taxel in range(taxels):
                    old[taxel] += values[row, taxel]
                    before[taxel] += valid[row, taxel]
                if row - first + 1 == part:
                    part = 2 * part
                    if not alike(new, count, old, before, noise, bounds):
                        good = False
                        break
        if good:
            good = alike(new, count, old, before, noise, bounds)
        if good:
            new += old
            count += before
            size += step
        else:
            growing = False
        step = size if growing else step // 2
    for taxel in range(taxels):
        out[0, taxel] = new[taxel] / count[taxel] if count[taxel] > 0.0 else 0.0
        out[1, taxel] = count[taxel]
    return size


@njit(cache=True, nogil=True)
def alike(
    new: Floats, count: Floats, old: Floats, before: Floats, noise: Floats, bounds: Floats
) -> bool:
    """Whether sums (L,) of so many readings each differ by no more than noise.

    Three things that noise seldom does: many taxels a little, one taxel much, and all that the new
    ones read of a touch more or less, which finds a faint one that began or ended.
    """
    squares, largest, taxels = 0.0, 0.0, 0
    less, all_of_it = 0.0, 0.0
    for i in range(len(noise)):
        if count[i] > 0.0 and before[i] > 0.0:
            mean, variance = new[i] / count[i], noise[i] * noise[i]
            off = mean - old[i] / before[i]
            expected = variance * (1.0 / count[i] + 1.0 / before[i])
            squares += off * off / expected
            largest = max(largest, off * off / expected)
            taxels += 1
            if mean * mean * count[i] > CLEAR * CLEAR * variance:
                less += off * mean / expected
                all_of_it += mean * mean / expected
    if taxels == 0:
        return False
    bound = taxels + bounds[0] * np.sqrt(2.0 * taxels)
    same = less * less <= bounds[2] * bounds[2] * all_of_it
    return bool(same and squares <= bound and largest <= bounds[1] * bounds[1])
