"""Filters: stated delay and noise against measured ones, invalid taxels, no allocation."""

import tracemalloc

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.signal import Exponential, NoFilter, filtered

RATE = 50.0
FILTERS = {
    "none": NoFilter(),
    "exponential": Exponential(time_constant=0.08),
    "exponential, slow": Exponential(time_constant=0.6),
}
every_filter = pytest.mark.parametrize("settings", FILTERS.values(), ids=FILTERS.keys())


@every_filter
@pytest.mark.parametrize("rate", [20.0, 100.0])
def test_the_stated_delay_is_the_lag_behind_a_ramp(settings, rate):
    slope = 30.0
    ramp = slope * np.arange(4000)[:, None] / rate
    lag = (ramp - filtered(settings, ramp, rate))[-1, 0] / slope
    assert lag == pytest.approx(settings.delay(rate), abs=1e-6 + 1e-6 * lag)


@every_filter
def test_the_stated_noise_is_what_is_left_of_white_noise(settings):
    noise = 2.0 * np.random.default_rng(3).standard_normal((6000, 200))
    left = filtered(settings, noise, RATE)[1000:].std()
    assert left / 2.0 == pytest.approx(settings.noise_factor(RATE), rel=0.015)
    assert settings.noise_factor(RATE) <= 1.0


@every_filter
def test_an_invalid_taxel_poisons_neither_itself_nor_others(settings):
    clean = 240 + np.random.default_rng(4).standard_normal((400, 5))
    dirty = clean.copy()
    dirty[0, 3] = np.nan
    dirty[100:103, 1] = np.nan
    dirty[:, 4] = np.nan
    got, wanted = filtered(settings, dirty, RATE), filtered(settings, clean, RATE)
    np.testing.assert_array_equal(np.isnan(got), np.isnan(dirty))
    np.testing.assert_array_equal(got[:, [0, 2]], wanted[:, [0, 2]])
    assert np.abs(got[103:, 1] - 240).max() < 5
    assert np.abs(got[-1, [1, 3]] - wanted[-1, [1, 3]]).max() < 0.05


@every_filter
def test_the_first_reading_passes_and_reset_forgets(settings):
    state, out = settings.prepare(2, RATE), np.empty(2)
    state.apply(np.array([240.0, 100.0]), out)
    assert out.tolist() == [240.0, 100.0]
    state.apply(np.array([200.0, 180.0]), out)
    state.reset()
    state.apply(np.array([10.0, 20.0]), out)
    assert out.tolist() == [10.0, 20.0]


@every_filter
def test_output_may_be_the_input(settings):
    counts = 240 + np.random.default_rng(5).standard_normal((50, 4))
    counts[20, 2] = np.nan
    state, wanted = settings.prepare(4, RATE), filtered(settings, counts, RATE)
    for reading, row in zip(counts.copy(), wanted, strict=True):
        state.apply(reading, reading)
        np.testing.assert_array_equal(reading, row)


@every_filter
def test_apply_allocates_nothing(settings):
    taxels = 20_000
    state, out = settings.prepare(taxels, RATE), np.empty(taxels)
    reading = np.random.default_rng(6).standard_normal(taxels)
    reading[7] = np.nan
    for _ in range(3):
        state.apply(reading, out)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    state.apply(reading, out)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak - before < taxels  # one byte per taxel, a bool mask, would already show


def test_unusable_settings_are_refused():
    for wrong, text in [
        (lambda: Exponential(time_constant=0.0), "time_constant is 0.0"),
        (lambda: Exponential().prepare(3, 0.0), "rate is 0.0"),
        (lambda: filtered(NoFilter(), np.zeros(3), RATE), "counts has shape"),
    ]:
        with pytest.raises(InputError, match=text):
            wrong()
