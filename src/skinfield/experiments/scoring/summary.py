"""Many scores in few numbers, each with how far it can be trusted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_range
from skinfield.experiments.scoring.score import Score
from skinfield.experiments.scoring.statistics import wilson

# What is summarised of a score. Signed errors by their size; those named bias keep the sign.
MEASURES: dict[str, Callable[[Score], float]] = {
    "force_error": lambda score: abs(score.force_error),
    "force_bias": lambda score: score.force_error,
    "field_force_error": lambda score: abs(score.field_force_error),
    "place_error_m": lambda score: score.place_error,
    "contact_force_error": lambda score: score.contact_force_error,
    "peak_error": lambda score: abs(score.peak_error),
    "pressure_error": lambda score: score.pressure_error,
    "blurred_pressure_error": lambda score: score.blurred_pressure_error,
    "deformation_error": lambda score: score.deformation_error,
    "area_error": lambda score: abs(score.area_error),
}
RESAMPLES = 999


@dataclass(frozen=True)
class Interval:
    """A number and its 95 % confidence interval; NaN at both ends where one value is too few."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Figures:
    """Of one measure: median, 90th percentile and mean, over `count` values that exist."""

    median: Interval
    p90: Interval
    mean: Interval
    count: int


@dataclass(frozen=True)
class Summary:
    """Of many scores.

    Attributes
    ----------
    measures : dict of str to Figures
        By the names of `MEASURES`; shares of the truth, but those in `_m`, metres.
    missed : Interval
        Share of the true contacts; Wilson's interval.
    false_share : Interval
        Share of readings with at least one contact that is not there; Wilson's interval.
    false_per_reading : float
    readings, contacts : int
        Scores, and true contacts in them.
    """

    measures: dict[str, Figures]
    missed: Interval
    false_share: Interval
    false_per_reading: float
    readings: int
    contacts: int


def summarise(
    scores: Sequence[Score], resamples: int = RESAMPLES, seed: int = 0, level: float = 0.95
) -> Summary:
    """Summarise scores.

    Medians, 90th percentiles and means have percentile bootstrap intervals over the scores; they
    speak for cases like these, not for the model that made them.

    Parameters
    ----------
    scores : sequence of Score
        At least one.
    resamples : int
        Of the bootstrap.
    seed : int
        Of its random numbers: the same scores give the same intervals.
    level : float
        Confidence of the bootstrap intervals; that of rates is 0.95.
    """
    if not scores:
        raise InputError("scores is empty, expected at least one")
    check_range("level", level, 0.5, 0.999, "of confidence")
    table = {
        name: np.array([measure(score) for score in scores]) for name, measure in MEASURES.items()
    }
    contacts = sum(score.true_contacts for score in scores)
    false = [score.false for score in scores]
    return Summary(
        measures=figures_of(table, resamples, seed, level),
        missed=rate_of(sum(score.missed for score in scores), contacts),
        false_share=rate_of(sum(count > 0 for count in false), len(scores)),
        false_per_reading=float(np.mean(false)),
        readings=len(scores),
        contacts=contacts,
    )


def rate_of(hits: int, trials: int) -> Interval:
    """Share of hits with Wilson's interval; NaN where nothing was tried."""
    return Interval(hits / trials, *wilson(hits, trials)) if trials else Interval(*[np.nan] * 3)


def figures_of(
    table: dict[str, Floats], resamples: int = RESAMPLES, seed: int = 0, level: float = 0.95
) -> dict[str, Figures]:
    """Median, 90th percentile and mean of measures, each (N,), with their intervals.

    NaN is left out. Measures that lack the same values share one bootstrap: it is the dear part.
    """
    known = {name: np.isfinite(values) for name, values in table.items()}
    groups: dict[bytes, list[str]] = {}
    for name, mask in known.items():
        groups.setdefault(mask.tobytes(), []).append(name)
    found: dict[str, Figures] = {}
    for names in groups.values():
        values = np.stack([table[name][known[names[0]]] for name in names])
        medians = _intervals(values, np.median, resamples, seed, level)
        highs = _intervals(values, _p90, resamples, seed, level)
        means = _intervals(values, np.mean, resamples, seed, level)
        for row, name in enumerate(names):
            found[name] = Figures(medians[row], highs[row], means[row], values.shape[1])
    return {name: found[name] for name in table}


def _p90(values: Floats, axis: int) -> Floats:
    return np.asarray(np.quantile(values, 0.9, axis=axis))


def _intervals(
    values: Floats,
    statistic: Callable[..., NDArray[np.float64]],
    resamples: int,
    seed: int,
    level: float,
) -> list[Interval]:
    """Statistic of each row (measures, n), with its interval."""
    from scipy.stats import bootstrap

    measures, count = values.shape
    if count == 0:
        return [Interval(*[np.nan] * 3)] * measures
    centre = np.asarray(statistic(values, axis=-1))
    if count == 1:
        return [Interval(float(value), np.nan, np.nan) for value in centre]
    result = bootstrap(
        (values,),
        statistic,
        n_resamples=resamples,
        axis=-1,
        vectorized=True,
        method="percentile",
        confidence_level=level,
        random_state=np.random.default_rng(seed),
    ).confidence_interval
    return [
        Interval(float(value), float(low), float(high))
        for value, low, high in zip(
            centre, np.atleast_1d(result.low), np.atleast_1d(result.high), strict=True
        )
    ]
