"""Noise of the emulated electronics, by their statistics."""

import numpy as np
import pytest

from skinfield.simulate.electronics import Delivery, Electronics, Noise
from skinfield.simulate.electronics.delivery import wiring
from skinfield.skin import Patch, generators

HEXAGON = generators.icub_hexagon()
MANY = Patch(np.random.default_rng(0).uniform(0, 1, (2400, 2)))


def rng(seed=0):
    return np.random.default_rng(seed)


def untouched(electronics, readings, patch=HEXAGON, seed=0):
    array = electronics.manufacture(patch, rng(seed))
    return array, array.counts(np.zeros((readings, len(patch))), None, rng(seed + 1))


def allan_deviation(series, group):
    """Of (T, L) readings in groups of `group`, (L,): half the mean square step of their means."""
    groups = len(series) // group
    means = series[: groups * group].reshape(groups, group, -1).mean(axis=1)
    return np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2, axis=0))


def levels(noise, readings, rate=20.0):
    made = Electronics(quantised=False, noise=noise, delivery=Delivery(rate=rate))
    array, counts = untouched(made, readings)
    return array, counts - array.baseline


def test_white_noise_has_its_deviation_per_taxel_and_no_memory():
    array, noise = levels(Noise(white=3.0, spread=0.5), 20000)
    assert noise.std(axis=0) == pytest.approx(array.white_noise, rel=0.03)
    assert array.calibration.noise_std == pytest.approx(array.white_noise)
    assert np.log(array.white_noise / 3.0).std() == pytest.approx(0.5, rel=0.25)
    assert abs(np.mean(noise[1:] * noise[:-1]) / np.mean(noise**2)) < 0.005
    for group in (1, 10, 100):
        expected = array.white_noise / np.sqrt(group)
        assert np.mean(allan_deviation(noise, group) / expected) == pytest.approx(1.0, abs=0.03)


def test_common_noise_is_shared_within_a_converter_only():
    _, noise = levels(Noise(white=1.0, common=2.0), 20000)
    ties = np.corrcoef(noise.T)
    same = wiring(HEXAGON).converter
    same = (same[:, None] == same) & ~np.eye(72, dtype=bool)
    assert ties[same] == pytest.approx(0.8, abs=0.02)
    assert abs(ties[~same & ~np.eye(72, dtype=bool)]).max() < 0.04


@pytest.mark.parametrize("rate", [5.0, 50.0])
def test_flicker_has_one_allan_deviation_at_all_averaging_times(rate):
    _, noise = levels(Noise(flicker=2.0), 20000, rate)
    expected = 2.0 * np.sqrt(2.0 * np.log(2.0) / np.pi)
    for group in (8, 32, 128, 512):
        assert np.mean(allan_deviation(noise, group)) == pytest.approx(expected, rel=0.06)


def test_a_walk_goes_with_the_square_root_of_time():
    made = Electronics(quantised=False, noise=Noise(walk=0.5), delivery=Delivery(rate=20.0))
    array, counts = untouched(made, 2001, MANY)
    away = counts - array.baseline
    assert (away[0] == 0).all()
    for seconds in (4.0, 25.0, 100.0):
        spread = away[int(20 * seconds)].std()
        assert spread == pytest.approx(0.5 * np.sqrt(seconds), rel=0.06)
    expected = 0.5 * np.sqrt(5.0 / 3.0)
    assert np.mean(allan_deviation(away, 100)) == pytest.approx(expected, rel=0.03)
