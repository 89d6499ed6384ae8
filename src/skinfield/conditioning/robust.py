"""Medians and deviations over readings, column by column, that skip NaN without a warning."""

import numpy as np

from skinfield.errors import Floats, InputError, check_shape


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
