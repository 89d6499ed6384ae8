"""Baseline, noise and drift of each taxel, from a stretch in which nothing moves."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.signal.boards import Bools, Convention
from skinfield.signal.noise import Neighbours, quiet_level, shared_noise
from skinfield.signal.stationary import (
    LEAST_READINGS,
    MOVING,
    QuietStretch,
    fast_noise,
    judge,
    level_and_noise,
    quiet_stretch,
    readings_per_independent,
    readings_per_value,
    recorded,
    trend,
    whole_numbers,
)

_QUANTISATION = 1.0 / math.sqrt(12.0)
_LOADED = 5.0
_FEW = 0.02


@dataclass(frozen=True, eq=False)
class Baseline:
    """What each taxel reads when nothing happens.

    Attributes
    ----------
    baseline : (L,) array, counts
        Median, in the middle of the stretch; NaN for a taxel that answered less than half of it.
        Of a taxel that moves, the least loaded readings, where a convention tells which.
    noise_std : (L,) array, counts
        Of one reading, drift removed; at least 0.29 for whole counts. Of a taxel that moves, from
        reading to reading: what presses it is no noise.
    uncertainty : (L,) array, counts
        Standard error of the baseline.
    drift : (L,) array, counts/s
    correlation : float
        Readings that carry as much as one independent one; 1 for white noise.
    stretch : QuietStretch
        Where it was taken from.
    loaded : (L,) bool array
        Taxels that rest further than 5 noise standard deviations, and 5 counts, on the pressed
        side of the convention's rest; all False where no convention was given.
    quiet : bool
        Still, and not loaded as far as can be told. Where False, this is not an unloaded skin.
    notes : tuple of str
        What the caller must know, in sentences.
    basis : str
        How it was made, for the stamp of a calibration.
    """

    baseline: Floats
    noise_std: Floats
    uncertainty: Floats
    drift: Floats
    correlation: float
    stretch: QuietStretch
    loaded: Bools
    quiet: bool
    notes: tuple[str, ...]
    basis: str

    @property
    def measured(self) -> Bools:
        """Taxels that have a baseline, (L,)."""
        return np.isfinite(self.baseline)


def estimate_baseline(
    counts: Floats,
    rate: float,
    *,
    quiet: slice | None = None,
    seconds: float = 2.0,
    convention: Convention | None = None,
    source: str = "",
    neighbours: Neighbours | None = None,
) -> Baseline:
    """Estimate the baseline and its noise, robustly.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    rate : float, 1/s
        Readings per second.
    quiet : slice, optional
        Readings in which the skin is known to be untouched; default the quietest stretch.
    seconds : float
        Length of that quietest stretch.
    convention : Convention, optional
        Lets the result say whether something lies on the skin.
    source : str
        File or port, for the stamp.
    neighbours : (P, 2) int array, optional
        Pairs of taxels, such as `Patch.neighbours`: where the board clips what is below rest, rest
        and noise are then told from touches all over the recording; see `shared_noise`.

    Raises
    ------
    InputError
        If the stretch has fewer than 16 readings, or there is no number.

    Notes
    -----
    Drift is the slope between the medians of the first and the last third; baseline the median of
    what remains; noise as in `level_and_noise`. The uncertainty of the median, 1.2533 σ/√n, takes
    for n the independent readings: a port that repeats its values does not gain by it.
    """
    counts = recorded(counts)
    check_positive("rate", rate, "readings per second")
    stretch = (
        quiet_stretch(counts, rate, seconds=seconds, convention=convention)
        if quiet is None
        else _chosen(counts, quiet)
    )
    window = counts[stretch.start : stretch.stop]
    answers = (~np.isnan(window)).sum(axis=0)
    present = answers >= len(window) / 2
    x = np.where(present, window, np.nan)
    slope = trend(x)
    x = x - (np.arange(len(x)) - (len(x) - 1) / 2.0)[:, None] * slope
    floor = present & _on_the_floor(window, convention)
    whole = whole_numbers(counts)  # of all: a stretch of zeros alone may hold any unit
    level, noise = _level_and_noise(x, window, floor, whole)
    moving = stretch.moving & present
    slope = np.where(moving, 0.0, slope)
    noise[moving] = np.minimum(noise[moving], fast_noise(window[:, moving], stretch.hold))
    if convention is not None:
        level[moving] = _unpressed(window[:, moving], noise[moving], convention.direction)
    if neighbours is not None and floor.any():
        level = np.where(present, quiet_level(counts, neighbours), np.nan)
        noise = np.fmax(shared_noise(counts - level, neighbours), _QUANTISATION if whole else 0.0)
    correlation = readings_per_independent(x)
    noise = _no_quieter(noise, present & ~moving & ~floor, len(window) / correlation)
    loaded = _loaded(level, noise, convention)
    span = f"readings {stretch.start} to {stretch.stop}"
    return Baseline(
        baseline=level,
        noise_std=noise,
        uncertainty=1.2533 * noise / np.sqrt(np.maximum(answers / correlation, 1.0)),
        drift=np.where(present, slope * rate, np.nan),
        correlation=correlation,
        stretch=stretch,
        loaded=loaded,
        quiet=stretch.still and bool(loaded.mean() <= _FEW),
        notes=tuple(_notes(stretch, span, loaded, convention, correlation, floor, present)),
        basis=f"{source}{': ' * bool(source)}median of {span} ({len(window) / rate:.1f} s), "
        "drift removed",
    )


def _level_and_noise(x: Floats, window: Floats, floor: Bools, whole: bool) -> tuple[Floats, Floats]:
    """Of the readings without drift, `x`; where they lie on the floor, from the upper side."""
    level, noise = level_and_noise(x, step=1.0 if whole else 0.0)
    if floor.any():
        upper = np.nanpercentile(window[:, floor], 84.134, axis=0)
        noise[floor] = np.maximum(upper - level[floor], _QUANTISATION)
    return level, np.maximum(noise, _QUANTISATION) if whole else noise


def _no_quieter(noise: Floats, known: Bools, readings: float) -> Floats:
    """Noise (L,) of which none is less than its readings tell, beside those of the others.

    Deviations of few readings are spread, and the stillest stretch was chosen: what is below the
    others is drawn towards them (Efron and Morris 1975), as far as chance spreads logarithms.
    """
    known = known & (noise > 0.0)
    if known.sum() < 3:
        return noise
    logs = np.log(noise[known])
    middle = float(np.median(logs))
    spread = (1.4826 * float(np.median(np.abs(logs - middle)))) ** 2
    chance = 1.0 / (2.0 * max(readings - 1.0, 1.0))
    own = max(spread - chance, 0.0) / spread if spread > 0.0 else 1.0
    least = np.exp(middle + own * np.minimum(logs - middle, 0.0))
    drawn = noise.copy()
    drawn[known] = np.maximum(noise[known], least)
    return drawn


def _unpressed(pressed: Floats, noise: Floats, direction: int) -> Floats:
    """Level (L,) of taxels that were touched for up to 90 % of their readings (T, L)."""
    lightest = np.nanpercentile(direction * pressed, 10.0, axis=0)
    return np.asarray(direction * (lightest + 1.2816 * noise))


def _chosen(counts: Floats, quiet: slice) -> QuietStretch:
    start, stop, step = quiet.indices(len(counts))
    if step != 1 or stop - start < LEAST_READINGS:
        raise InputError(
            f"quiet is {quiet!r}, expected at least {LEAST_READINGS} readings in a row of the "
            f"{len(counts)} there are: a baseline needs its noise"
        )
    recorded(counts[start:stop])
    return judge(counts, start, stop, readings_per_value(counts[start:stop]))


def _on_the_floor(window: Floats, convention: Convention | None) -> Bools:
    """Taxels at rest on the floor of a scale that starts at rest, as CySkin's does."""
    if convention is None or convention.rest != convention.lowest:
        return np.zeros(window.shape[1], bool)
    return np.asarray((window <= convention.lowest).mean(axis=0) > 0.02)


def _loaded(baseline: Floats, noise: Floats, convention: Convention | None) -> Bools:
    if convention is None or not np.isfinite(convention.rest):
        return np.zeros(len(baseline), bool)
    pressed = convention.direction * (baseline - convention.rest)
    return np.asarray(pressed > np.maximum(_LOADED * noise, 5.0))


def _notes(
    stretch: QuietStretch,
    span: str,
    loaded: Bools,
    convention: Convention | None,
    correlation: float,
    floor: Bools,
    present: Bools,
) -> Iterator[str]:
    """What the caller must know."""
    if not stretch.still:
        yield (
            f"the recording is not still: even in {span}, {int(stretch.moving.sum())} of "
            f"{len(stretch.moving)} taxels spread over more than {MOVING:g} times their noise"
        )
    elif stretch.moving.any():
        rows = [str(row) for row in np.flatnonzero(stretch.moving)]
        moving = f"taxel {rows[0]} moves" if len(rows) == 1 else f"taxels {', '.join(rows)} move"
        yield f"in {span} {moving}; all others are still"
    if convention is None or not np.isfinite(convention.rest):
        yield f"in {span} the skin is taken to be unloaded: its rest is not known otherwise"
    elif loaded.any():
        yield (
            f"in {span} {int(loaded.sum())} of {len(loaded)} taxels rest on the pressed side of "
            f"{convention.rest:g}, by more than {_LOADED:g} times their noise: something lies on "
            "the skin, or its rest is another"
        )
    if correlation > 1.5:
        yield (
            f"{correlation:.1f} readings carry as much as one independent one (the port repeats "
            "its values, or the noise is slow): averages and filters gain less than they state"
        )
    if floor.any():
        yield (
            f"{int(floor.sum())} taxels rest on the floor of the scale: their noise is taken "
            "from the readings above the median"
        )
    if not present.all():
        yield (
            f"{int((~present).sum())} of {len(present)} taxels answer too rarely "
            "and have no baseline"
        )
