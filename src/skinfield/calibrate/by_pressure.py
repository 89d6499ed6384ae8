r"""Calibration by uniform pressure, as of a vacuum bag or a plenum, with what a foam remembers.

The pressure on a taxel is a sum of what it reads and of what it read before,

.. math:: p = a + b\, y + \sum_k c_k\, (g_k * y) + \sum_j d_j\, H_j(y),

with causal exponentials :math:`g_k` of time constants that all taxels share (a Prony series run
backwards), and play operators :math:`H_j` of widths that are parts of the taxel's span (Prandtl and
Ishlinskii's hysteresis; Kuhnen 2003, European Journal of Control 9, 407). Coefficients of a taxel,
in units of its own slope, are drawn towards those of all taxels as far as these agree (empirical
Bayes; Gelman et al. 2013, Bayesian Data Analysis, chapter 5). Places of taxels are not needed.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.calibrate.level_shifts import BEFORE, REPEATS, LevelTracker
from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape

MEMORIES: tuple[tuple[float, ...], ...] = ((), (15.0, 150.0), (5.0, 25.0, 100.0, 500.0))  # readings
WIDTHS: tuple[tuple[float, ...], ...] = ((), (0.1, 0.4))  # parts of a taxel's span
PARTS = 4  # contiguous parts, of which each is foretold from the others
LEAST = 200  # readings
LEAST_SPAN, MOST_SPAN = 2000.0, 1e7  # Pa: a bag or a plenum presses harder, and less hard
STEADY = 5  # readings, whose medians are compared to see a step
STEPS = 1.5  # times the step that hardly any of a calibration exceeds, and
LEAST_STEP = 0.1  # of the span more: what may be a shift of a board
LAG = 200  # readings, between which the slope of a taxel is looked for
EDGE = 150  # readings before and after a shift, by which its size is known
QUICKER = 1.5  # times as quick as in a calibration may pressure be
AGAIN = 0.05  # of a shift: how far it is another on another day
REST_NOISE = 0.01  # of the highest pressure, at least: what answers at rest vary by
DRIFT = 0.05  # of the highest pressure: what the rest differs from that of the calibration
DRIFT_TIME = 1e6  # readings, in which it drifts by as much
RESTS = 0.03  # of the highest pressure, within which `LEAST` readings of a calibration are rest
FOLLOWS = 0.7  # correlation with the pressure, below which a taxel is broken
SPAN = 4.0  # deviations of its noise, that the readings of a taxel span at least
FAR = 0.5  # of the error of a constant: a taxel that is further off is broken
CORRELATED = 400.0  # readings that tell as much as an independent one: what a foam errs by lasts
Numbers = Sequence[float] | Floats
ERROR = 0.015  # of the highest pressure: what is left over, until it is known


@dataclass(frozen=True, eq=False)
class PressureCalibration:
    """Pressure on each taxel from its readings, causally.

    Attributes
    ----------
    weights : (L, 2 + K + J) array, Pa and Pa per count
        Constant, slope, exponentials, plays; NaN of a broken taxel.
    time_constants : (K,) array, readings
    widths : (J,) array
        Of the plays, parts of `span`.
    rest, span : (L,) array, counts
        Median of the readings at the least pressure, and from there to the highest.
    step : (L,) array, counts
        Within five readings, beyond which pressure hardly moved a taxel.
    shift, shift_std : (L,) array, counts
        How far its board shifts a taxel, and its uncertainty; NaN of one that it did not.
    change_std : float, Pa
        Of the pressure from a reading to the next, as of a random walk.
    low, high : float, Pa
        The least pressure and the highest.
    at_rest : (L,) array, Pa
        What a taxel answers where the calibration rests; NaN if it does not.
    rmse : (L,) array, Pa
        Of parts of the recording foretold from the other parts.
    line_rmse : (L,) array, Pa
        The same of a line per taxel, without memory.
    one_gain_rmse : (L,) array, Pa
        The same of one line for all taxels.
    reasons : tuple of str
        Of each taxel why it is broken; empty of one that is not.
    """

    weights: Floats
    time_constants: Floats
    widths: Floats
    rest: Floats
    span: Floats
    step: Floats
    shift: Floats
    shift_std: Floats
    change_std: float
    low: float
    high: float
    at_rest: Floats
    rmse: Floats
    line_rmse: Floats
    one_gain_rmse: Floats
    reasons: tuple[str, ...]

    def __post_init__(self) -> None:
        taxels, terms = len(self.reasons), 2 + len(self.time_constants) + len(self.widths)
        check_shape("weights", self.weights, (taxels, terms), "taxels and terms")
        figures = "rmse", "line_rmse", "one_gain_rmse"
        for name in ("rest", "span", "step", "shift", "shift_std", "at_rest", *figures):
            check_shape(name, getattr(self, name), (taxels,), "one per taxel")

    def __len__(self) -> int:
        return len(self.rest)

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Taxels that answer, (L,)."""
        return np.isfinite(self.weights[:, 0])

    @property
    def verdict(self) -> str:
        """How good it is, in a sentence."""
        good = self.usable
        ours, line, one = (
            float(np.median(each[good])) * 1e-3
            for each in (self.rmse, self.line_rmse, self.one_gain_rmse)
        )
        better = "" if ours < line else "; memory gains nothing here, a line is as good"
        return (
            f"{int(good.sum())} of {len(self)} taxels answer, {ours:.3g} kPa off (median, foretold "
            f"from other parts of the recording); a line each {line:.3g}, one line for all "
            f"{one:.3g} kPa{better}"
        )

    def __repr__(self) -> str:
        return f"PressureCalibration({self.verdict})"

    def pressure(self, counts: ArrayLike) -> Floats:
        """Pressure (T, L), Pa, from readings (T, L).

        NaN where a taxel is broken, or has not answered for 50 readings, or read what no pressure
        up to half again the calibration's gives. That of a reading depends on it and on those
        before, so that the first is taken to have lasted. Shifts of a board are taken off
        (`level_shifts`); a taxel that reads about what it does at rest is taken to be at rest, and
        its drift since the calibration is learnt.
        """
        table = _table(counts, len(self))
        if not len(table):
            return table
        falls = (self.weights[:, 1:].sum(axis=1) < 0.0).sum() > self.usable.sum() / 2.0
        loaded = -self.span if falls else self.span
        per_pascal = self.span / (self.high - self.low)
        drive = np.square(QUICKER * self.change_std * per_pascal)
        known = self.shift, np.hypot(self.shift_std, AGAIN * self.shift)
        tracker = LevelTracker(self.rest, loaded, self.step, drive, *known)
        levels = np.array([tracker.update(row) for row in table]).reshape(table.shape)
        features = _features(levels - self.rest, self.span, self.time_constants, self.widths)
        pressures = np.einsum("ktl,lk->tl", features, self.weights)
        return np.asarray(pressures - _drift(pressures - self.at_rest, self.high))


def pressure(counts: ArrayLike, pressure_pa: ArrayLike) -> PressureCalibration:
    """Calibrate taxels by a pressure that is the same on all of them.

    Parameters
    ----------
    counts : (T, L) array
        Readings in order, evenly spaced; NaN where a taxel did not answer.
    pressure_pa : (T,) array, Pa
        Positive in compression.

    Returns
    -------
    PressureCalibration
        With memory if parts of the recording are foretold better by it.

    Raises
    ------
    InputError
        If the arrays do not go together, the pressure does not change, is in other units than Pa,
        or no taxel follows it, as on a solid silicone, which a uniform pressure does not thin.
    """
    reference = as_floats("pressure_pa", pressure_pa)
    check_shape("pressure_pa", reference, (None,), "one per reading")
    table = _table(counts, None)
    _check_together(table, reference)
    lag = min(LAG, len(table) // 4)
    walk = float(np.sqrt(np.mean(np.square(reference[lag:] - reference[:-lag])) / lag))
    table, shift, shift_std = _without_shifts(table, reference)
    rest, span = _range_of(table, reference)
    broken = _broken(table, reference, span)
    _check_any(broken)
    use = np.flatnonzero([not why for why in broken])
    constants, widths, own, by_line = _choose(table[:, use] - rest[use], span[use], reference)
    whole = _features(table[:, use] - rest[use], span[use], constants, widths)
    fitted = _fit(*_moments(whole, reference), float(np.abs(reference).max()))
    far = own > FAR * reference.std()
    for row in np.flatnonzero(far):
        broken[use[row]] = f"{own[row] * 1e-3:.3g} kPa off, over half as far as a constant"
    _check_any(broken)
    fitted[far] = np.nan
    taxels, rests = table.shape[1], reference <= reference.min() + RESTS * reference.max()
    filled: Floats = np.full((taxels, fitted.shape[1] + 4), np.nan)
    rested = np.full(len(use), np.nan)
    if reference.min() < RESTS * reference.max() and np.count_nonzero(rests) >= LEAST:
        resting = np.nan_to_num(whole[:, rests])
        rested = np.median(np.einsum("ktl,lk->tl", resting, fitted), axis=0)
    one = _one_line(table[:, use], reference)
    filled[use[~far]] = np.column_stack((fitted, rested, own, by_line, one))[~far]
    rested, own, by_line, one = filled[:, -4:].T
    step = STEPS * np.quantile(np.abs(_shifts(table)), 0.999, axis=0) + LEAST_STEP * span
    low, high = float(np.quantile(reference, 0.05)), float(reference.max())
    return PressureCalibration(
        filled[:, :-4], np.array(constants), np.array(widths), rest, span, step, shift, shift_std,
        walk, low, high, rested, own, by_line, one, tuple(broken),
    )  # fmt: skip


def _choose(
    change: Floats, span: Floats, reference: Floats
) -> tuple[tuple[float, ...], tuple[float, ...], Floats, Floats]:
    """Memory that foretells parts of a recording best, its errors (L,), and those of lines, Pa."""
    found = {
        (constants, widths): _foretold(_features(change, span, constants, widths), reference)
        for constants in MEMORIES
        for widths in WIDTHS
    }
    best = min(found, key=lambda each: float(np.median(found[each])))
    return *best, found[best], found[(), ()]


def _table(counts: ArrayLike, taxels: int | None) -> Floats:
    table = as_floats("counts", counts)
    check_shape("counts", table, (None, taxels), "readings and taxels; one reading is counts[None]")
    endless = np.argwhere(np.isinf(table))
    if len(endless):
        row, taxel = endless[0]
        raise InputError(
            f"counts[{row}, {taxel}] is {table[row, taxel]}, expected a number, or NaN where a "
            "taxel did not answer"
        )
    return table


def _check_together(table: Floats, reference: Floats) -> None:
    if len(table) != len(reference):
        raise InputError(
            f"counts has {len(table)} readings and pressure_pa {len(reference)}, expected as many: "
            "cut both to what they share, from the common beginning"
        )
    if len(table) < LEAST:
        raise InputError(f"counts has {len(table)} readings, expected {LEAST} or more, in order")
    check_pressure(reference)


def check_pressure(reference: Floats) -> None:
    """Raise InputError for what is no changing pressure of a bag or a plenum, in Pa."""
    bad = np.flatnonzero(~np.isfinite(reference))
    if len(bad):
        raise InputError(f"pressure_pa[{bad[0]}] is {reference[bad[0]]}, expected a number, in Pa")
    span = float(np.ptp(reference))
    check_positive("the span of pressure_pa", span, "Pa: a pressure that changes")
    if span < LEAST_SPAN:
        raise InputError(
            f"pressure_pa spans {span:.3g} Pa, expected {LEAST_SPAN:g} or more: it is in "
            f"{'bar' if span < 20.0 else 'kPa'}, most likely; give Pa (1 bar is 1e5 Pa)"
        )
    if span > MOST_SPAN:
        raise InputError(
            f"pressure_pa spans {span:.3g} Pa, expected {MOST_SPAN:g} at most: no bag or plenum "
            "presses harder; its unit is a smaller one, most likely"
        )


def _range_of(table: Floats, reference: Floats) -> tuple[Floats, Floats]:
    """Rest (L,), and how far a taxel reads from there at the highest pressure, at least a count."""
    low = table[reference <= np.quantile(reference, 0.05)]
    high = table[reference >= np.quantile(reference, 0.95)]
    with np.errstate(all="ignore"):
        gone = np.isnan(low).all(axis=0) | np.isnan(high).all(axis=0)
        low, high = np.where(gone, 0.0, low), np.where(gone, 0.0, high)
        rest, top = np.nanmedian(low, axis=0), np.nanmedian(high, axis=0)
    return np.asarray(rest), np.asarray(np.maximum(np.abs(top - rest), 1.0))


def _broken(table: Floats, reference: Floats, span: Floats) -> list[str]:
    """Why each taxel is broken, in words; empty of one that follows the pressure."""
    broken = []
    for taxel in range(table.shape[1]):
        readings, why = table[:, taxel], ""
        there = np.isfinite(readings)
        if there.mean() < 0.9:
            why = f"answers in {there.mean():.0%} of the readings"
        elif not np.ptp(readings[there]) > 0.0:
            why = f"frozen at {readings[there][0]:g}"
        else:
            step = np.diff(readings[there])
            noise = float(np.median(np.abs(step)))
            follows = abs(float(np.corrcoef(readings[there], reference[there])[0, 1]))
            if span[taxel] < SPAN * noise:
                why = f"spans {span[taxel]:.3g} counts, its noise is {noise:.3g}"
            elif follows < FOLLOWS:
                why = f"follows the pressure by a correlation of {follows:.2f} only"
        broken.append(why)
    return broken


def _check_any(broken: Sequence[str]) -> None:
    if all(broken):
        raise InputError(
            f"none of {len(broken)} taxels follows the pressure (the first: {broken[0]}), expected "
            "some: a solid silicone is not thinned by a uniform pressure, only a foam or air is; "
            "or counts and pressure_pa do not begin together"
        )


def _shifts(table: Floats) -> Floats:
    """Change (T, L) of the median of five readings since five readings before, counts."""
    from scipy.ndimage import median_filter

    middle = median_filter(np.nan_to_num(table), size=(STEADY, 1), origin=(STEADY // 2, 0))
    change = np.zeros_like(middle)
    change[STEADY:] = middle[STEADY:] - middle[:-STEADY]
    return np.where(np.isnan(table), 0.0, change)


def _without_shifts(table: Floats, reference: Floats) -> tuple[Floats, Floats, Floats]:
    """Readings without the shifts of boards; these (L,), and their uncertainty.

    Twice, so that the second time what was learnt of them holds from the beginning.
    """
    from scipy.signal import medfilt

    lag = min(LAG, len(table) // 4)
    apart = reference[lag:] - reference[:-lag]
    wide = np.abs(apart) >= np.quantile(np.abs(apart), 0.5)
    with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
        slopes = (table[lag:] - table[:-lag])[wide] / apart[wide, None]
        slope = np.nan_to_num(np.nanmedian(slopes, axis=0))
        felt = slope * medfilt(reference, STEADY)[:, None]
        left = table - felt
        low = reference <= np.quantile(reference, 0.05)
        level = np.nan_to_num(np.nanmedian(left[low], axis=0))
    span = slope * np.ptp(reference)
    span = np.where(np.abs(span) < 1.0, 1.0, span)
    drive = np.square(ERROR * span) / CORRELATED
    none: Floats = np.full(len(slope), np.nan)
    limits = level, span, LEAST_STEP * np.abs(span), drive
    tracker, shifted = LevelTracker(*limits, none, none, False), np.zeros(table.shape, np.bool_)
    for reading, row in enumerate(left):
        tracker.update(row)
        shifted[reading] = tracker.shifted
    sizes = _sizes(left, shifted)
    with np.errstate(invalid="ignore"):
        shifted &= np.abs(sizes[0]) > LEAST_STEP * np.abs(span)
    sizes = np.where(shifted.any(axis=0), sizes, np.nan)
    for reading, taxel in np.argwhere(np.diff(shifted, axis=0)):
        left[max(reading + 1 - BEFORE, 0) : reading + 1, taxel] = np.nan  # it was found late
    again = LevelTracker(*limits, sizes[0], 0.0 * sizes[0], False)
    levels = [again.update(*each) for each in zip(left, shifted, strict=True)]
    return np.array(levels) + felt, sizes[0], sizes[1]


def _sizes(left: Floats, shifted: NDArray[np.bool_]) -> Floats:
    """Sizes of shifts and their errors (2, L), counts, by what goes before and after them."""
    found: Floats = np.full((2, left.shape[1]), np.nan)
    for taxel in np.flatnonzero(shifted.any(axis=0)):
        edges, sizes = np.flatnonzero(np.diff(shifted[:, taxel])) + 1, []
        for edge in edges:
            before, after = (
                left[max(part.start, 0) : max(part.stop, 0), taxel]
                for part in (
                    slice(edge - EDGE - BEFORE, edge - BEFORE),
                    slice(edge + BEFORE, edge + EDGE + BEFORE),
                )
            )
            if np.isfinite(before).sum() > BEFORE < np.isfinite(after).sum():
                step = np.nanmean(after) - np.nanmean(before)
                sizes.append(step if shifted[edge, taxel] else -step)
        if sizes:
            noise = np.nanstd(np.diff(left[shifted[:, taxel], taxel]))
            found[:, taxel] = np.mean(sizes), noise * np.sqrt(REPEATS / (EDGE * len(sizes)))
    return found


def _drift(pressures: Floats, high: float) -> Floats:
    """Drift (T, L), Pa, of pressures (T, L) above those of the calibration's rest, causally.

    What reads as rest does is at rest as likely as not, and anything up to `high` else; by the
    posterior of rest a reading counts (Kalman 1960, with a mixture for what is seen).
    """
    drift, spread = np.zeros(pressures.shape), np.square(DRIFT * high)
    variance, grown = np.full(pressures.shape[1], spread), spread / DRIFT_TIME
    now, noise = np.zeros(pressures.shape[1]), np.square(REST_NOISE * high)
    there = np.isfinite(pressures)
    for reading, row in enumerate(pressures):
        off, total = np.where(there[reading], row - now, 0.0), noise + variance
        at_rest = np.exp(-0.5 * np.square(off) / total) / np.sqrt(2.0 * np.pi * total)
        pressed = np.where(off > 0.0, 1.0 / high, 0.0)
        weight = there[reading] * at_rest / np.maximum(at_rest + pressed, 1e-300)
        gain = variance * weight / (variance * weight + CORRELATED * noise)
        bound = 2.0 * np.sqrt(total)
        now = now + gain * np.clip(off, -bound, bound)
        variance = variance * (1.0 - gain) + grown
        drift[reading] = now
    return drift


def _features(change: Floats, span: Floats, constants: Numbers, widths: Numbers) -> Floats:
    """One, change from rest, its exponentials and its plays, (2 + K + J, T, L).

    A reading that is missing is as the one before, but NaN itself.
    """
    from scipy.signal import lfilter

    gone = np.isnan(change)
    if gone.any():
        last = np.maximum.accumulate(np.where(gone, 0, np.arange(len(change))[:, None]), axis=0)
        change = np.nan_to_num(np.take_along_axis(change, last, axis=0))
    features = [np.where(gone, np.nan, 1.0), change]
    for constant in constants:
        stays = float(np.exp(-1.0 / constant))
        begin = stays * change[:1]
        features.append(lfilter([1.0 - stays], [1.0, -stays], change, axis=0, zi=begin)[0])
    for width in widths:
        held, reach = np.array(change), width * span / 2.0
        for reading in range(1, len(held)):
            low, high = change[reading] - reach, change[reading] + reach
            held[reading] = np.clip(held[reading - 1], low, high)
        features.append(held)
    return np.stack(features)


def _foretold(features: Floats, reference: Floats) -> Floats:
    """Error (L,), Pa rms, of contiguous parts foretold from the others."""
    squares, answers = np.zeros((2, features.shape[2]))
    parts = np.array_split(np.arange(len(reference)), PARTS)
    moments = [_moments(features[:, part], reference[part]) for part in parts]
    gram, along = (sum(each) for each in zip(*moments, strict=True))
    highest = float(np.abs(reference).max())
    for part, own in zip(parts, moments, strict=True):
        weights = _fit(gram - own[0], along - own[1], highest)
        guess = np.einsum("ktl,lk->tl", features[:, part], weights)
        squares += np.nansum((guess - reference[part, None]) ** 2, axis=0)
        answers += np.isfinite(guess).sum(axis=0)
    return np.asarray(np.sqrt(squares / answers))


def _moments(features: Floats, reference: Floats) -> tuple[Floats, Floats]:
    """Products of each taxel's features, (L, K, K), and with the reference, (L, K)."""
    known = np.ascontiguousarray(np.nan_to_num(features).transpose(2, 0, 1))
    return known @ known.transpose(0, 2, 1), known @ reference


def _fit(gram: Floats, along: Floats, highest: float) -> Floats:
    """Weights (L, 2 + K + J) of taxels, each drawn towards those of all, by `_moments`.

    The highest pressure, Pa, says what an error may be.
    """
    terms = gram.shape[1]
    lines = np.linalg.solve(gram[:, :2, :2] + 1e-9 * np.eye(2), along[:, :2, None])[..., 0]
    unit = np.ones((len(lines), terms))
    unit[:, 0] = ERROR * highest
    unit[:, 1:] = lines[:, 1:]  # the slope
    variance = unit[:, 0] ** 2 * CORRELATED
    gram = gram * unit[:, :, None] * unit[:, None, :] / variance[:, None, None]
    along = along * unit / variance[:, None]
    weights = np.linalg.solve(gram + 1e-6 * np.eye(terms), along[..., None])[..., 0]
    for _ in range(5):
        middle = np.median(weights, axis=0)
        spread = np.maximum(1.4826 * np.median(np.abs(weights - middle), axis=0), 1e-3)
        prior = np.diag(1.0 / np.square(spread))
        weights = np.linalg.solve(gram + prior, (along + prior @ middle)[..., None])[..., 0]
    return np.asarray(weights * unit)


def _one_line(table: Floats, reference: Floats) -> Floats:
    """Error (L,), Pa rms, of one line for all taxels."""
    there = np.isfinite(table)
    wanted = np.broadcast_to(reference[:, None], table.shape)
    slope, constant = np.polyfit(table[there], wanted[there], 1)
    return np.asarray(np.sqrt(np.nanmean((slope * table + constant - wanted) ** 2, axis=0)))
