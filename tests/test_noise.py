"""Noise per taxel of skins that jump, clip and are touched."""

import numpy as np
import pytest
from scipy.stats import t

import skinfield as sf
from skinfield.signal.noise import draw_in_jumps, quiet_level, shared_noise, touched_readings

PATCH = sf.layouts.hexagon72()


def jumping(readings: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Student's t of 2.5 degrees of freedom, scale log-normal, clipped at rest; and the scale."""
    rng = np.random.default_rng(seed)
    scale = 30.0 * np.exp(0.7 * rng.standard_normal(len(PATCH)))
    noise = scale * rng.standard_t(2.5, (readings, len(PATCH)))
    return np.rint(np.maximum(noise, 0.0)), scale


def touch(counts: np.ndarray, first: int, last: int, height: float = 8000.0) -> np.ndarray:
    """The same with a finger on taxels around the middle; which they are."""
    away = np.linalg.norm(PATCH.plane - PATCH.plane.mean(axis=0), axis=1)
    its = away < 1.6 * PATCH.pitch
    counts[first:last, its] += height * np.exp(-np.square(away[its] / PATCH.pitch))
    return np.asarray(its)


@pytest.mark.parametrize("seed", range(4))
def test_gaussian_noise_is_what_it_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    noise = shared_noise(5.0 * rng.standard_normal((400, 72)), PATCH.neighbours)
    assert np.abs(noise / 5.0 - 1.0).max() < 0.2
    assert np.median(noise) == pytest.approx(5.0, rel=0.03)


@pytest.mark.parametrize("seed", range(4))
def test_jumps_lie_within_six_deviations_but_for_few_in_a_thousand(seed: int) -> None:
    counts, _ = jumping(30, seed)
    noise = shared_noise(counts, PATCH.neighbours)
    later, _ = jumping(2000, seed)
    beyond = np.mean(later > 6.0 * noise)
    assert beyond < 6e-3  # of which Gaussian noise of the same spread has none

    assert np.mean(later > noise) > 1e-2  # nor are all values taken for quiet


@pytest.mark.parametrize("freedom", [3.0, 5.0, 1e6])
def test_few_readings_in_ten_thousand_are_beyond_a_normal_distribution(freedom: float) -> None:
    rng = np.random.default_rng(int(freedom))
    noise = shared_noise(rng.standard_t(freedom, (600, 72)), PATCH.neighbours)
    later = np.abs(rng.standard_t(freedom, (40_000, 72))) > 4.83 * noise  # 1e-4 of 72 values
    assert later.any(axis=1).mean() <= 4e-4
    assert np.median(noise) < 1.4 * t.isf(0.5e-4 / 72, freedom) / 4.83


@pytest.mark.parametrize("seed", range(4))
def test_a_touch_is_no_noise(seed: int) -> None:
    counts, _ = jumping(30, seed)
    before = shared_noise(counts, PATCH.neighbours)
    its = touch(counts, 8, 24)
    level = quiet_level(counts, PATCH.neighbours)
    after = shared_noise(counts - level, PATCH.neighbours)
    assert (after[its] < 3.0 * np.maximum(before[its], np.median(before))).all()
    assert (level[its] < 400.0).all()


def test_what_lies_on_the_skin_all_the_time_is_no_rest() -> None:
    counts, _ = jumping(30, 1)
    its = touch(counts, 0, 30)
    level = quiet_level(counts, PATCH.neighbours)
    high = its & (np.percentile(counts, 20.0, axis=0) > 1000.0)
    assert high.any()
    assert not level[high].any()


def test_a_rest_that_has_drifted_is_one() -> None:
    counts, _ = jumping(30, 2)
    counts[:, 10] += 1500.0
    level = quiet_level(counts, PATCH.neighbours)
    assert level[10] == pytest.approx(1500.0, abs=200.0)


def test_touched_are_the_neighbours_of_what_stands_out() -> None:
    apart = np.zeros((1, len(PATCH)))
    apart[0, 20] = 100.0
    pairs = PATCH.neighbours
    beside = set(pairs[pairs[:, 0] == 20, 1]) | set(pairs[pairs[:, 1] == 20, 0])
    assert set(np.flatnonzero(touched_readings(apart, 1.0, pairs)[0])) == beside


def test_silence_has_no_noise_and_absence_none_to_tell() -> None:
    apart = np.zeros((20, 72))
    apart[:, 3] = np.nan
    noise = shared_noise(apart, PATCH.neighbours)
    assert np.isnan(noise[3])
    assert not np.delete(noise, 3).any()


def test_a_taxel_that_jumps_alone_for_one_reading_is_drawn_in() -> None:
    neighbours = np.array([(k, k + 1) for k in range(9)])
    noise = np.full(10, 0.01)
    values = np.zeros((6, 10))
    values[2, 4] = 0.2  # a jump
    values[4, 8:] = 0.2  # a touch of two taxels
    values[3:5, 0] = -0.2  # two readings
    values[5, 3] = np.nan
    before = values.copy()
    assert draw_in_jumps(values, noise, neighbours) == 1
    assert values[2, 4] == pytest.approx(0.03)
    values[2, 4] = 0.2
    np.testing.assert_array_equal(values, before)
