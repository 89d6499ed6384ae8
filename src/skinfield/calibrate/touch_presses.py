"""Presses in readings: means of readings that stand still, and the noise by which they do not.

Noise of a reading is told by what repeats itself: by differences between one reading and the next,
most of which are of taxels that nothing touches, and then by what readings of one press are off
their mean. So it is that of pressed taxels, too, which boards that clip at rest do not show there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from skinfield.errors import Floats, InputError
from skinfield.signal.noise import PRIOR

STRONG = 12.0  # deviations, that the highest reading of a press is above rest at least
MOST = 250  # presses
TOGETHER = 0.05  # part of a reading, by which another may differ and both be one press
STANDS = 4.0  # deviations of chi-squared, to which readings are one press
REST = 0.25  # of the noise of one reading: how well rest is known, and so a mean at best
MOST_SPREAD = 3.0  # of differences: their half over their quarter, 2.117 if normal
MOST_LARGER = 4.0  # times the noise that differences show, and least
PASSES = 2
SMALL = 0.5  # of the noise: what a press may change by and tell it
FEWEST, LEAST_QUIET = 16, 0.1  # quiet readings, and part of all, that tell a rest
SHORT = 0.25  # of what most presses last: less is on the way, or a jump
OFTEN = 0.1  # share of readings, that are at a board's end if so many are the very same


@dataclass(frozen=True, eq=False)
class Presses:
    """Readings of presses.

    Attributes
    ----------
    readings : (P, L) array
        NaN where a taxel did not answer.
    noise : (P, L) array
        Standard deviation of each.
    clipped : (P, L) bool array
        Where a board that clips at rest tells that nothing is above that, and no more.
    row : (T,) int array
        Press that each reading is part of; -1 of none.
    noise_std : (L,) array
        Of one reading.
    """

    readings: Floats
    noise: Floats
    clipped: NDArray[np.bool_]
    row: NDArray[np.int64]
    noise_std: Floats


def presses(table: Floats, noise: Floats | None) -> Presses:
    """Presses in readings (T, L), at most `MOST`: those that stand longest, of equals any.

    Parameters
    ----------
    table : (T, L) array
        In order of time; NaN where a taxel did not answer.
    noise : (L,) array, optional
        Standard deviation of one reading. Default as differences between readings have it.

    Raises
    ------
    InputError
        If readings do not tell their noise, or fall where they should rise.
    """
    own = noise if noise is not None else noise_of_differences(table)
    table = table - between(table, own)
    end = _end(table)
    for _ in range(PASSES):
        first = _starts(table, own)
        numbers, count, mean = _means(table, first)
        spread = own * np.sqrt(np.maximum(1.0 / np.maximum(count, 1.0), REST**2))
        over = np.nan_to_num(mean) / spread
        strong = np.maximum(over.max(axis=1), -over.min(axis=1)) > STRONG
        if noise is None:
            own = _noise_within(table, mean[numbers], count[numbers], own, end, strong[numbers])
    _check_rises(mean[strong], over[strong])
    pressed = np.flatnonzero(strong & (over.max(axis=1) > -over.min(axis=1)))
    length = np.bincount(numbers, minlength=len(mean))
    chosen = pressed[_longest(np.nan_to_num(mean[pressed]).argmax(axis=1), length[pressed])]
    chosen = chosen[length[chosen] > SHORT * np.median(length[chosen])] if len(chosen) else chosen
    chosen = np.random.default_rng(0).permutation(chosen)
    chosen = np.sort(chosen[np.argsort(-length[chosen], kind="stable")][:MOST])
    rows = np.full(len(mean), -1)
    rows[chosen] = np.arange(len(chosen))
    clipped = (mean < end + own)[chosen]
    values = np.where(clipped, end + own, mean[chosen]) - _rest(table, end, own, strong[numbers])
    return Presses(values, spread[chosen], clipped, rows[numbers], own)


def between(table: Floats, noise: Floats) -> Floats:
    """What taxels (L,) read between the presses in readings (T, L); 0 where none are between.

    Those are readings in which every taxel reads as it mostly does, as in the ones before and
    after. Of boards that clip at rest `_rest` tells.
    """
    heard, rest = np.isfinite(table).any(axis=0), np.zeros(table.shape[1])
    off = table[:, heard] - np.nanmedian(table[:, heard], axis=0)
    still = np.all(~(np.abs(off) > STANDS * noise[heard]), axis=1)
    quiet = table[1:-1][still[:-2] & still[1:-1] & still[2:]]
    if len(quiet) > max(FEWEST, LEAST_QUIET * len(table)):
        count = np.isfinite(quiet).sum(axis=0)
        told = np.isneginf(_end(table)) & (count > FEWEST)
        rest[told] = np.nansum(quiet, axis=0)[told] / count[told]
    return rest


def _end(table: Floats) -> Floats:
    """What each taxel (L,) reads at the end of a board that clips at rest; -infinity of others.

    So many readings are the very same only there.
    """
    least = np.min(table, axis=0, where=np.isfinite(table), initial=np.inf)
    same = (table == least).sum(axis=0)
    return np.where(same > max(OFTEN * len(table), 1.0), least, -np.inf)


def _rest(table: Floats, end: Floats, noise: Floats, touched: NDArray[np.bool_]) -> Floats:
    """Rest (L,) below the end of a board, as the share of quiet readings there tells; else 0."""
    quiet = table[~touched]
    if len(quiet) < FEWEST:
        return np.zeros(len(end))
    share = np.clip((quiet == end).mean(axis=0), 0.5 / len(quiet), 1.0 - 0.5 / len(quiet))
    return np.where(end > -np.inf, np.nan_to_num(end, neginf=0.0) - noise * norm.ppf(share), 0.0)


def _longest(peak: NDArray[np.int64], length: NDArray[np.int64]) -> NDArray[np.int64]:
    """Of runs one after the other that press one taxel most, the longest: they are one press.

    Where most readings are of runs of one, each is a press of its own.
    """
    if 2 * np.sum(length == 1) >= length.sum():
        return np.arange(len(peak))
    touch = np.cumsum(np.r_[True, peak[1:] != peak[:-1]])
    order = np.lexsort((-length, touch))
    return order[np.r_[True, np.diff(touch[order]) > 0]]


def _check_rises(mean: Floats, over: Floats) -> None:
    """Refuse presses that most readings fall by."""
    if len(mean) >= FEWEST and np.median(over.max(axis=1) + over.min(axis=1)) < 0.0:
        raise InputError(
            f"readings fall under touch, by up to {-np.nanmin(mean):.3g}, expected ones that rise: "
            "change their sign, or that of the counts per ΔC/C₀ (gain=, --gain)"
        )


def noise_of_differences(table: Floats) -> Floats:
    """Noise (L,) of one reading, by the median difference to the next."""
    apart = np.abs(np.diff(table, axis=0))
    apart[apart == 0.0] = np.nan  # clipped, rounded or lost
    heard = np.isfinite(apart).any(axis=0)
    refuse = InputError(
        "readings do not tell their noise: no quiet ones are among them, and none that repeat "
        "themselves; expected noise_std= (--noise), the standard deviation of one reading at rest"
    )
    if not heard.any():
        raise refuse
    quarter, half = np.nanpercentile(apart[:, heard], [25.0, 50.0], axis=0)
    if np.median(half / quarter) > MOST_SPREAD:
        raise refuse
    patch = float(np.median(half))
    noise = np.full(table.shape[1], patch)
    noise[heard] = np.clip(half, patch / 20.0, 20.0 * patch)
    return np.asarray(1.4826 / np.sqrt(2.0) * noise)


def _noise_within(
    table: Floats,
    mean: Floats,
    count: Floats,
    noise: Floats,
    end: Floats,
    strong: NDArray[np.bool_],
) -> Floats:
    """Noise (L,) of one reading, by what readings of presses are off their mean, all (T, L)."""
    away = np.square(np.nan_to_num(table - mean)) * count / np.maximum(count - 1.0, 1.0)
    felt = (count > 1.0) & np.isfinite(table) & strong[:, None]
    felt &= (mean > end + noise) & (TOGETHER * mean < SMALL * noise)
    squares, numbers = np.sum(away, axis=0, where=felt), felt.sum(axis=0)
    if not numbers.any():
        return noise
    larger = float(np.sqrt(squares.sum() / (numbers * noise**2).sum()))
    prior = PRIOR * np.square(np.clip(larger, 1.0 / MOST_LARGER, MOST_LARGER) * noise)
    squares = np.maximum(squares, numbers * np.square(noise / MOST_LARGER))  # if sent twice
    return np.asarray(np.sqrt((squares + prior) / (numbers + PRIOR)))


def _starts(table: Floats, noise: Floats) -> NDArray[np.bool_]:
    """Where (T,) a reading is off the mean of those before, so that another press begins."""
    first = np.ones(len(table), np.bool_)
    total, count = np.zeros(table.shape[1]), np.zeros(table.shape[1])
    for row, values in enumerate(table):
        both = (count > 0.0) & np.isfinite(values)
        mean = total[both] / count[both]
        spread = noise[both] ** 2 * (1.0 + 1.0 / count[both]) + (TOGETHER * mean) ** 2
        chi = float((np.square(values[both] - mean) / spread).sum())
        first[row] = chi > len(mean) + STANDS * np.sqrt(2.0 * len(mean))
        if first[row] or not row:
            first[row], total, count = True, np.zeros_like(total), np.zeros_like(count)
        heard = np.isfinite(values)
        total[heard] += values[heard]
        count[heard] += 1.0
    return first


def _means(table: Floats, first: NDArray[np.bool_]) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Number (T,) of the run that each reading is of; counts and means (R, L) of runs."""
    heard, starts = np.isfinite(table), np.flatnonzero(first)
    count = np.add.reduceat(heard.astype(float), starts)
    total = np.add.reduceat(np.where(heard, table, 0.0), starts)
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0.0)
    return np.cumsum(first) - 1, count, mean
