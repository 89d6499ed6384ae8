"""Averages of readings that show the same: how far back they go, and what ends them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinfield.loop.stationary_mean import GAP_NS, MOST, Mean, StationaryMean

TAXELS, PERIOD_NS = 20, 10_000_000
NOISES = np.full(TAXELS, 0.002)
ALL = np.ones(TAXELS)
PRESSED = np.zeros(TAXELS)
PRESSED[:3] = 0.03, 0.02, 0.01
FAINT = np.where(np.arange(TAXELS) < 8, 3.0 * NOISES, 0.0)  # no taxel stands out of one reading


def readings(level: np.ndarray, count: int, seed: int) -> np.ndarray:
    return level + np.random.default_rng(seed).normal(0.0, 0.002, (count, TAXELS))


def fed(stationary: StationaryMean, rows: np.ndarray, start: int = 0) -> int:
    for number, row in enumerate(rows, start):
        stationary.take(row, ALL, (number + 1) * PERIOD_NS)
    return start + len(rows)


def mean_of(stationary: StationaryMean) -> Mean:
    found = stationary.mean(NOISES)
    assert found is not None
    return found


@pytest.mark.parametrize("count", [1, 2, 7, 32, 100, 500])
def test_what_rests_is_averaged(count: int) -> None:
    stationary, rows = StationaryMean(TAXELS), readings(PRESSED, count, 1)
    assert stationary.mean(NOISES) is None  # before the first reading
    fed(stationary, rows)
    found = mean_of(stationary)
    assert found.readings == min(count, MOST)
    assert found.stamp_ns == count * PERIOD_NS
    assert_allclose(found.values, rows[-MOST:].mean(axis=0), atol=1e-12)


@pytest.mark.parametrize(
    ("touch", "after"), [*((PRESSED, after) for after in (1, 2, 3, 5, 11, 40)), (FAINT, 24)]
)
def test_an_average_ends_where_the_touch_began(touch: np.ndarray, after: int) -> None:
    stationary = StationaryMean(TAXELS)
    start = fed(stationary, readings(np.zeros(TAXELS), 64, 3))
    fed(stationary, readings(touch, after, 4), start)
    assert mean_of(stationary).readings == after


def test_readings_before_a_gap_do_not_count() -> None:
    stationary = StationaryMean(TAXELS)
    start = fed(stationary, readings(PRESSED, 20, 5))
    stationary.take(PRESSED, ALL, start * PERIOD_NS + GAP_NS + PERIOD_NS)
    assert mean_of(stationary).readings == 1


def test_a_taxel_that_is_left_out_now_and_then_is_the_mean_of_its_own() -> None:
    stationary, rows = StationaryMean(TAXELS), readings(PRESSED, 8, 6)
    for number, row in enumerate(rows):
        valid = ALL.copy()
        valid[4] = number % 2
        valid[5] = 0.0
        stationary.take(np.where(valid > 0, row, np.nan), valid, (number + 1) * PERIOD_NS)
    found = mean_of(stationary)
    assert found.readings == 8
    assert found.values[4] == pytest.approx(rows[1::2, 4].mean())
    assert found.valid[4]
    assert not found.valid[5]
    assert found.values[5] == 0.0
