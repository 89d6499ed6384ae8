"""Stationary means of live readings: each patch's, for as long as what touches it rests.

Noise falls with the root of the readings that are averaged, as long as they are of the same touch.
How many that are, the readings tell: they lie in blocks of 1, 1, 2, 4, ... of them, the newest
ones first, and the mean ends before the first block that differs from all that is newer by more
than noise (Bifet and Gavaldà 2007, Learning from time-changing data with adaptive windowing, with
the tests below in place of Hoeffding's). So a touch that rests is weighed ever more finely, and one
that moves is followed at once. A reading costs a few sums over the taxels, and allocates nothing.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

BLOCKS = 20  # rows of sums of each taxel: enough for MOST readings
MOST = 512  # readings that are averaged
GAP_NS = 500_000_000  # between readings, after which those before do not count any more
CLEAR = 5.0  # deviations from which a taxel reads something of a touch
ODD = 6.0  # deviations of a normal number, as seldom as what ends a mean of what rests
LEAST = 1e-12  # deviation of a reading
BASELINE = 100.0  # readings that a baseline is the mean of, about
HARMONICS = 20  # of what rounding does to a mean
Flags = NDArray[np.bool_]


class StationaryMeans:
    """Means of the newest readings of each patch that agree with each other.

    Parameters
    ----------
    starts : (P + 1,) int array
        Where each patch's taxels begin.

    Attributes
    ----------
    values : (N,) array
        The means, in the unit of the readings.
    noise_std : (N,) array
        One standard deviation of each mean less its baseline.
    readings : (P,) int array
        How many were averaged.
    """

    def __init__(self, starts: Ints) -> None:
        taxels, patches = int(starts[-1]), len(starts) - 1
        self.values, self.noise_std = np.zeros(taxels), np.ones(taxels)
        self.readings = np.ones(patches, np.int64)
        self._starts, self._noise, self._rounding = starts, np.ones(taxels), np.zeros(taxels)
        self._sums = np.zeros((2, BLOCKS, taxels), np.float64)
        self._sizes, self._filled = np.zeros((patches, BLOCKS), np.int64), np.zeros_like(starts)
        self._last_ns = np.zeros(patches, np.int64)
        self._newer = np.zeros((2, taxels))

    def calibrate(self, noise_std: Floats, rounding: Floats) -> None:
        """Go by this noise of one reading (N,), and what rounding leaves of any mean (N,)."""
        self._noise[:], self._rounding[:] = np.maximum(noise_std, LEAST), rounding
        self.noise_std[:] = self._noise
        self.reset()

    def take(
        self, values: Floats, valid: Flags, arrived: Ints, stamps_ns: Ints, touched: Flags
    ) -> None:
        """Add the newest readings (N,).

        Parameters
        ----------
        values, valid : (N,) arrays
        arrived, stamps_ns : (P,) arrays
            Patches with an `arrived` of 0 have no new reading.
        touched : (P,) bool array
            Of the others, where nothing touches no mean is wanted: each reading stands for itself.
        """
        average(
            values,
            valid,
            arrived,
            stamps_ns,
            touched,
            self._starts,
            self._noise,
            self._rounding,
            self._sums,
            self._sizes,
            self._filled,
            self._last_ns,
            self._newer,
            self.values,
            self.noise_std,
            self.readings,
        )

    def reset(self) -> None:
        """Forget all readings."""
        self._filled[:] = 0
        self.readings[:] = 1


@njit
def average(
    values: Floats,
    valid: Flags,
    arrived: Ints,
    stamps_ns: Ints,
    touched: Flags,
    starts: Ints,
    noise: Floats,
    rounding: Floats,
    sums: Floats,
    sizes: Ints,
    filled: Ints,
    last_ns: Ints,
    newer: Floats,
    means: Floats,
    deviations: Floats,
    readings: Ints,
) -> None:
    """See `StationaryMeans.take`; `sums` (2, B, N) of values and how many, `newer` (2, N) room."""
    for patch in range(len(arrived)):
        if arrived[patch] == 0:
            continue
        low, high = starts[patch], starts[patch + 1]
        readings[patch] = 1
        since = stamps_ns[patch] - last_ns[patch]
        last_ns[patch] = stamps_ns[patch]
        if not touched[patch]:
            filled[patch] = 0
            for taxel in range(low, high):
                means[taxel], deviations[taxel] = values[taxel], noise[taxel]
            continue
        if since > GAP_NS or since <= 0:
            filled[patch] = 0
        filled[patch] = add(values, valid, low, high, sums, sizes[patch], filled[patch])
        first = newest_alike(low, high, noise, sums, sizes[patch], filled[patch], newer)
        for block in range(first, filled[patch]):
            sizes[patch, block - first] = sizes[patch, block]
            for taxel in range(low, high):
                for part in range(2):
                    sums[part, block - first, taxel] = sums[part, block, taxel]
        filled[patch] -= first
        total = 0
        for block in range(filled[patch]):
            total += sizes[patch, block]
        readings[patch] = total
        for taxel in range(low, high):
            count = newer[1, taxel] if valid[taxel] else 0.0
            if count > 0.0:
                means[taxel] = newer[0, taxel] / count
                variance = noise[taxel] * noise[taxel] * (1.0 / count + 1.0 / BASELINE)
                deviations[taxel] = np.sqrt(variance + rounding[taxel] * rounding[taxel])
            else:
                means[taxel], deviations[taxel] = values[taxel], noise[taxel]
        if total == 1:
            for taxel in range(low, high):
                deviations[taxel] = noise[taxel]


@inner
def add(
    values: Floats, valid: Flags, low: int, high: int, sums: Floats, sizes: Ints, count: int
) -> int:
    """Add a block of one reading; of three blocks of a size the older two are joined.

    The oldest block goes where there are too many readings. Returns how many blocks there are.
    """
    total = 1
    for block in range(count):
        total += sizes[block]
    if total > MOST or count == len(sizes):
        for block in range(1, count):
            move(block, block - 1, low, high, sums, sizes)
        count -= 1
    sizes[count] = 1
    for taxel in range(low, high):
        good = valid[taxel]
        sums[0, count, taxel] = values[taxel] if good else 0.0
        sums[1, count, taxel] = 1.0 if good else 0.0
    count += 1
    newest = count - 1
    while newest >= 2 and sizes[newest] == sizes[newest - 2]:
        sizes[newest - 2] += sizes[newest - 1]
        for taxel in range(low, high):
            for part in range(2):
                sums[part, newest - 2, taxel] += sums[part, newest - 1, taxel]
        for block in range(newest, count):
            move(block, block - 1, low, high, sums, sizes)
        count -= 1
        newest -= 2
    return count


@inner
def move(source: int, target: int, low: int, high: int, sums: Floats, sizes: Ints) -> None:
    """Copy a block's sums."""
    sizes[target] = sizes[source]
    for taxel in range(low, high):
        for part in range(2):
            sums[part, target, taxel] = sums[part, source, taxel]


@inner
def newest_alike(
    low: int, high: int, noise: Floats, sums: Floats, sizes: Ints, count: int, newer: Floats
) -> int:
    """Oldest block that agrees with all that is newer; `newer` receives the sums from there on."""
    first = count - 1
    for taxel in range(low, high):
        for part in range(2):
            newer[part, taxel] = sums[part, first, taxel]
    while first > 0 and alike(low, high, noise, newer, sums, first - 1):
        first -= 1
        for taxel in range(low, high):
            for part in range(2):
                newer[part, taxel] += sums[part, first, taxel]
    return first


@inner
def alike(low: int, high: int, noise: Floats, newer: Floats, sums: Floats, block: int) -> bool:
    """Whether a block and what is newer differ by no more than noise.

    Three things that noise seldom does: many taxels a little, one taxel much, and all that the new
    ones read of a touch more or less, which finds a faint one that began or ended. The bound of
    the squares is Wilson and Hilferty's (1931) of chi-squared.
    """
    squares, largest, taxels = 0.0, 0.0, 0
    less, all_of_it = 0.0, 0.0
    for i in range(low, high):
        count, before = newer[1, i], sums[1, block, i]
        if count > 0.0 and before > 0.0:
            total, weight = newer[0, i], 1.0 / (noise[i] * noise[i] * count * (count + before))
            off = total * before - sums[0, block, i] * count
            square = off * off * weight / before
            squares += square
            largest = max(largest, square)
            taxels += 1
            if total * total > CLEAR * CLEAR * count * noise[i] * noise[i]:
                less += off * total * weight
                all_of_it += total * total * before * weight
    if taxels == 0:
        return False
    share = 2.0 / (9.0 * taxels)
    bound = taxels * (1.0 - share + ODD * np.sqrt(share)) ** 3
    same = less * less <= ODD * ODD * all_of_it
    return bool(same and squares <= bound and largest <= ODD * ODD)


def rounding_of(calibration: Floats, noise_std: Floats) -> Floats:
    """What rounding to whole counts leaves of an average (L,), in the unit of `noise_std` (L,).

    Of a count with normal noise of s before it is rounded, the mean is off by the sawtooth's
    Fourier series, each term damped by the noise: up to exp(-2 pi² k² s²) / (pi k), k = 1, 2, ...
    This is the root of the mean square over all levels, 1/12 of a count without noise.

    Parameters
    ----------
    calibration : (L, 4) array
        As a tare has it: `calibration[:, 2]` is the noise in counts, rounding included.
    """
    counts: Any = np.maximum(calibration[:, 2], 1e-9)
    before = np.maximum(counts**2 - 1.0 / 12.0, 0.0)
    term = np.arange(1.0, HARMONICS + 1.0)[:, None]
    squares = np.exp(-4.0 * np.pi**2 * term**2 * before) / (2.0 * np.pi**2 * term**2)
    off = np.sqrt(squares.sum(axis=0))
    return np.asarray(off / np.maximum(counts, np.sqrt(1.0 / 12.0)) * noise_std)
