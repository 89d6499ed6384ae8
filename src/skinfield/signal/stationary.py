"""Stationary stretches of a recording, and medians and deviations that skip NaN."""

import math
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_positive, check_shape
from skinfield.signal.boards import Bools, Convention


def recorded(counts: Floats) -> Floats:
    """The argument as (T, L) readings: numbers, NaN where a taxel did not answer.

    Raises
    ------
    InputError
        If it is no matrix, holds an infinity, or no number at all.
    """
    counts = np.asarray(counts, dtype=np.float64)
    check_shape("counts", counts, (None, None), "one row per reading, one column per taxel")
    endless = np.argwhere(np.isinf(counts))
    if len(endless):
        reading, taxel = (int(i) for i in endless[0])
        raise InputError(
            f"counts[{reading}, {taxel}] is {counts[reading, taxel]}, expected a number, or NaN "
            f"where a taxel did not answer ({len(endless)} of {counts.size} are infinite)"
        )
    if np.isnan(counts).all():
        raise InputError(
            f"counts of shape {counts.shape} hold no number, expected readings: "
            "is this the right port, and was the skin switched on?"
        )
    return counts


def median(x: Floats) -> Floats:
    """Median over readings of (T, L), (L,); NaN for a column without a number."""
    if not len(x):
        return np.full(x.shape[1], np.nan)
    gone = np.isnan(x)
    if not gone.any():
        return np.asarray(np.median(x, axis=0))
    ordered = np.sort(x, axis=0)  # NaN comes last
    numbers = len(x) - gone.sum(axis=0)
    low = np.maximum((numbers - 1) // 2, 0)[None]
    high = np.minimum(numbers // 2, len(x) - 1)[None]
    pick = np.take_along_axis
    middle = (pick(ordered, low, axis=0)[0] + pick(ordered, high, axis=0)[0]) / 2.0
    return np.asarray(np.where(numbers > 0, middle, np.nan))


def deviation(x: Floats) -> Floats:
    """Standard deviation over readings of (T, L), (L,); NaN for a column without a number."""
    there = ~np.isnan(x)
    numbers = there.sum(axis=0)
    divisor = np.maximum(numbers, 1)
    mean = np.sum(x, axis=0, where=there) / divisor
    power = np.sum((x - mean) ** 2, axis=0, where=there) / divisor
    return np.asarray(np.where(numbers > 0, np.sqrt(power), np.nan))


def whole_numbers(x: Floats) -> bool:
    """Whether every number is an integer, as raw counts are."""
    return bool(np.all(x == np.rint(x), where=~np.isnan(x)))


def trend(x: Floats) -> Floats:
    """Slope per reading between the medians of the first and the last third of (T, L), (L,).

    0 where either third has no number.
    """
    third = len(x) // 3
    rise = median(x[len(x) - third :]) - median(x[:third])
    return np.nan_to_num(rise / (len(x) - third))


def level_and_noise(x: Floats, step: float = 0.0) -> tuple[Floats, Floats]:
    """Median and noise of (T, L), each (L,).

    The noise is the standard deviation of the readings within 4 robust deviations (1.4826 MAD) of
    the median: the efficiency of a standard deviation, safe against touches, and no staircase on
    quantised data as the MAD itself has. Readings within 2 steps of the median always count: where
    most are equal the MAD is 0, and the few that differ are the noise.

    Parameters
    ----------
    x : (T, L) array
    step : float
        Of the quantisation, in the unit of x.
    """
    middle = median(x)
    away = np.abs(x - middle)
    scale = 1.4826 * median(away)
    mostly_constant = scale < 1e-9
    scale = np.where(mostly_constant, 0.5 * deviation(x), scale)
    return middle, deviation(np.where(away <= np.maximum(4.0 * scale, 2.0 * step), x, np.nan))


def readings_per_independent(x: Floats) -> float:
    """Readings that carry as much as one independent one: 1 + 2 Σ ρₖ, over the patch.

    ρₖ is the mean autocorrelation of the columns of (T, L), summed while it stays above 0.05.
    """
    there = ~np.isnan(x)
    mean = np.sum(x, axis=0, where=there) / np.maximum(there.sum(axis=0), 1)
    x = np.where(there, x - mean, 0.0)
    power = np.mean(x**2, axis=0)
    x = x[:, power > 0] / np.sqrt(power[power > 0])
    total = 1.0
    for lag in range(1, len(x) // 4 if x.size else 0):
        rho = float(np.mean(x[lag:] * x[:-lag]))
        if rho < 0.05:
            break
        total += 2.0 * rho
    return total


MOVING = 3.0
"""A taxel moves where its spread over a stretch is more than so many times its fast noise."""
LEAST_READINGS = 16
"""Readings in a stretch: below, spread and fast noise cannot be told apart."""


@dataclass(frozen=True, eq=False)
class QuietStretch:
    """The stillest stretch of a recording, and how still it is.

    Still means that nothing moves beyond the noise. It does not mean unloaded: a robot that stands
    still loads its feet without motion.

    Attributes
    ----------
    start, stop : int
        Readings, stop excluded.
    ratio : float
        Spread over fast noise, 95 % of the taxels below it: about 1 for noise alone.
    moving : (L,) bool array
        Taxels above `MOVING`.
    still : bool
        At most 2 % of the taxels (one of a small patch) move.
    hold : float
        Readings for which a port repeats one value; 1 where every reading is fresh.
    """

    start: int
    stop: int
    ratio: float
    moving: Bools
    still: bool
    hold: float


def readings_per_value(counts: Floats) -> float:
    """Readings for which a port repeats one value, 1 where every reading is fresh.

    Loggers often read a port faster than the board sends. A noisy taxel changes with every value
    that is sent, so the most active tenth of the taxels tells; 10 at most, as quiet and coarsely
    quantised taxels look alike.
    """
    steps = np.diff(counts, axis=0)
    compared = np.maximum((~np.isnan(steps)).sum(axis=0), 1)
    changed = np.sort(np.sum(np.nan_to_num(steps) != 0, axis=0) / compared)
    share = float(changed[int(0.9 * (len(changed) - 1))])
    return float(np.clip(1.0 / share, 1.0, 10.0)) if share > 0 else 1.0


def fast_noise(counts: Floats, hold: float) -> Floats:
    """Standard deviation of what changes from value to value of (T, L) counts, (L,).

    From the median absolute difference of readings that lie a whole value apart, so that neither
    slow motion nor repeated readings enter; half a count at least, for quantised data. Where most
    readings are clamped to one value that median is 0, so the smaller nine tenths of the
    differences count by their mean square too: less than the median's figure on normal noise, and
    free of the few large ones of a touch.
    """
    lag = max(1, math.ceil(hold))
    difference = np.abs(counts[lag:] - counts[:-lag])
    usual = 1.4826 * median(difference)
    number = np.maximum(0.9 * (~np.isnan(difference)).sum(axis=0), 1.0).astype(np.int64)
    there = np.sort(np.nan_to_num(difference, nan=np.inf), axis=0)
    small = (np.arange(len(there))[:, None] < number) & np.isfinite(there)
    square = np.sum(there**2, axis=0, where=small) / np.maximum(small.sum(axis=0), 1)
    spread = np.fmax(usual, np.sqrt(square)) / math.sqrt(2.0)
    return np.asarray(np.maximum(spread, 0.5) if whole_numbers(counts) else spread)


def judge(counts: Floats, start: int, stop: int, hold: float) -> QuietStretch:
    """How still readings `start` to `stop` are; taxels that rarely answer do not count."""
    window = counts[start:stop]
    present = (~np.isnan(window)).mean(axis=0) > 0.5
    ratio = np.zeros(counts.shape[1])
    if present.any():
        spread, fast = deviation(window[:, present]), fast_noise(window[:, present], hold)
        noiseless = np.where(spread > 0, np.inf, 0.0)
        ratio[present] = np.divide(spread, fast, out=noiseless, where=fast > 0)
    moving = ratio > MOVING
    allowed = max(1, int(0.02 * present.sum())) if present.sum() > 1 else 0
    still = bool(present.any() and moving.sum() <= allowed)
    typical = (
        float(np.percentile(ratio[present], 95, method="lower")) if present.any() else math.inf
    )
    return QuietStretch(start, stop, typical, moving, still, hold)


def quiet_stretch(
    counts: Floats, rate: float, *, seconds: float = 2.0, convention: Convention | None = None
) -> QuietStretch:
    """Find the stillest stretch of a recording.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    rate : float, 1/s
        Readings per second.
    seconds : float
        Length of the stretch; half of a recording that is shorter than twice that.
    convention : Convention, optional
        Tells which way pressure moves the counts: of several still stretches the least loaded one
        is then taken.

    Raises
    ------
    InputError
        If there are fewer than 16 readings, or no finite number.

    Notes
    -----
    Per taxel, the spread over the stretch is divided by the noise from one fresh value to the
    next (the square root of von Neumann's ratio, robustly): 1 for white noise, large for motion.
    """
    counts = recorded(counts)
    check_positive("rate", rate, "readings per second")
    check_positive("seconds", seconds, "the length of the stretch")
    if len(counts) < LEAST_READINGS:
        raise InputError(
            f"counts hold {len(counts)} readings, expected at least {LEAST_READINGS}: "
            "noise and motion cannot be told apart in fewer"
        )
    longest = max(LEAST_READINGS, len(counts) // 2)  # so that a press can lie outside
    length = int(np.clip(round(seconds * rate), LEAST_READINGS, longest))
    hold = readings_per_value(counts)
    starts = range(0, len(counts) - length + 1, max(1, length // 4))
    found = [judge(counts, start, start + length, hold) for start in starts]
    still = [stretch for stretch in found if stretch.still]
    if still and convention is not None:
        sign = convention.direction
        return min(still, key=lambda s: sign * float(np.nanmean(counts[s.start : s.stop])))
    return min(still or found, key=lambda s: (s.moving.sum(), s.ratio))
