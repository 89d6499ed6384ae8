"""Means of live readings: as long as nothing moves, and no longer."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ndtr

from skinfield.loop.stationary_mean import BASELINE, GAP_NS, MOST, StationaryMeans, rounding_of

TAXELS, NOISE, PERIOD_NS = 20, 0.01, 10_000_000
PRESSED, FAINT = np.zeros(TAXELS), np.zeros(TAXELS)
PRESSED[3:7], FAINT[3:7] = 0.3, 0.02


class Patches:
    """Two patches of which the second one is fed and touched."""

    def __init__(self) -> None:
        self.means = StationaryMeans(np.array([0, 5, 5 + TAXELS]))
        self.means.calibrate(np.full(5 + TAXELS, NOISE), np.zeros(5 + TAXELS))
        self.now, self.touched = 0, np.array([False, True])

    def feed(self, rows: np.ndarray, valid: np.ndarray | None = None) -> None:
        for place, row in enumerate(rows):
            self.now += PERIOD_NS
            good = np.ones(5 + TAXELS, np.bool_)
            if valid is not None:
                good[5:] = valid[place]
            stamps = np.array([0, self.now])
            values = np.concatenate([np.zeros(5), row])
            self.means.take(values, good, np.array([0, TAXELS]), stamps, self.touched)

    @property
    def readings(self) -> int:
        assert self.means.readings[0] == 1  # nothing came on the other patch
        return int(self.means.readings[1])

    @property
    def values(self) -> np.ndarray:
        return self.means.values[5:]


def readings(touch: np.ndarray, count: int, seed: int) -> np.ndarray:
    return touch + np.random.default_rng(seed).normal(0.0, NOISE, (count, TAXELS))


@pytest.mark.parametrize("count", [1, 2, 3, 7, 32, 100, 500, 2000])
def test_what_rests_is_averaged(count: int) -> None:
    patches, rows = Patches(), readings(PRESSED, count, 1)
    patches.feed(rows)
    used = patches.readings
    assert used == count if count <= MOST else MOST / 2 < used <= MOST
    assert_allclose(patches.values, rows[-used:].mean(axis=0), atol=1e-12)
    each = NOISE if count == 1 else NOISE * np.sqrt(1 / used + 1 / BASELINE)
    assert_allclose(patches.means.noise_std[5:], each)


@pytest.mark.parametrize(
    ("touch", "after"), [*((PRESSED, after) for after in (1, 2, 3, 5, 11, 40)), (FAINT, 32)]
)
def test_an_average_ends_where_the_touch_began(touch: np.ndarray, after: int) -> None:
    patches = Patches()
    patches.feed(readings(np.zeros(TAXELS), 64, 3))
    patches.feed(readings(touch, after, 4))
    assert patches.readings <= after
    assert_allclose(patches.values, touch, atol=5 * NOISE / np.sqrt(patches.readings))


def test_readings_before_a_gap_or_a_time_without_touch_do_not_count() -> None:
    patches = Patches()
    patches.feed(readings(PRESSED, 20, 5))
    patches.now += GAP_NS
    patches.feed(readings(PRESSED, 1, 6))
    assert patches.readings == 1
    patches.feed(readings(PRESSED, 4, 7))
    assert patches.readings == 5
    patches.touched[1] = False
    patches.feed(readings(PRESSED, 1, 8))
    assert patches.readings == 1
    assert_allclose(patches.means.noise_std, NOISE)


def test_a_taxel_that_is_left_out_now_and_then_is_the_mean_of_its_own() -> None:
    patches, rows = Patches(), readings(PRESSED, 8, 6)
    valid = np.ones((8, TAXELS), np.bool_)
    valid[::2, 4], valid[:, 5] = False, False
    patches.feed(np.where(valid, rows, 0.0), valid)
    assert patches.readings == 8
    assert patches.values[4] == pytest.approx(rows[1::2, 4].mean())
    assert patches.means.noise_std[9] == pytest.approx(NOISE * np.sqrt(1 / 4 + 1 / BASELINE))
    assert patches.values[5] == 0.0


@pytest.mark.parametrize("noise", [0.0, 0.2, 0.35, 0.5, 1.0])
def test_rounding_of_averages_against_the_expected_value_of_a_rounded_count(noise: float) -> None:
    places, counts = np.linspace(-0.5, 0.5, 201), np.arange(-8, 9)
    if noise:
        edges = ndtr((counts + 0.5 - places[:, None]) / noise)
        chance = np.diff(edges, axis=1, prepend=0.0)
    else:
        chance = (np.rint(places)[:, None] == counts).astype(float)
    off = chance @ counts - places
    total = np.full((1, 4), np.hypot(noise, 12**-0.5))
    found = rounding_of(total, np.array([total[0, 2]]))[0]
    worst = np.sqrt((off**2).mean())
    assert found == pytest.approx(worst, abs=0.02 * worst + 1e-6)
