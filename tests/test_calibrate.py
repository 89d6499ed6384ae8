"""One factor between two forces, and what is said of it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.signal import column_of, fit_scale
from skinfield.skin.reading import Recording

STAMPS = np.arange(0, 10_000_000_000, 20_000_000)  # 10 s at 50 Hz
FORCE = 5 + 3 * np.sin(STAMPS * 1e-9)


@given(st.floats(0.01, 100), st.floats(0, 0.3))
def test_the_factor_is_found_under_noise(factor: float, spread: float) -> None:
    noise = np.random.default_rng(0).normal(scale=spread, size=len(FORCE))
    fit = fit_scale(STAMPS, FORCE, STAMPS, factor * (FORCE + noise))
    assert fit.factor == pytest.approx(factor, rel=0.02)
    assert fit.rms == pytest.approx(factor * spread, rel=0.2, abs=1e-9 * factor)
    assert fit.held_out_rms >= 0.7 * fit.rms - 1e-9 * factor
    scatter = factor * spread / np.linalg.norm(FORCE)  # of least squares, here known from 10 parts
    assert fit.factor_std == pytest.approx(scatter, rel=0.5, abs=1e-9 * factor)


def test_clocks_of_other_rates_are_aligned() -> None:
    other = np.arange(-500_000_000, 8_000_000_000, 10_000_000)
    fit = fit_scale(STAMPS, FORCE, other, 2 * (5 + 3 * np.sin(other * 1e-9)))
    assert fit.factor == pytest.approx(2, rel=1e-3)
    assert np.isnan(fit.reference[-1])  # beyond the reference's end
    assert fit.correlation == pytest.approx(1, abs=1e-4)


def test_a_load_that_the_skin_misses_shows_in_the_second_half() -> None:
    reference = FORCE + np.where(STAMPS > 5_000_000_000, 10.0, 0.0)
    fit = fit_scale(STAMPS, FORCE, STAMPS, reference)
    assert fit.first_half == pytest.approx(1, rel=0.01)
    assert fit.held_out_rms == pytest.approx(10, rel=0.05)
    whole, held = (100 * rms / reference.mean() for rms in (fit.rms, fit.held_out_rms))
    for part in ("second: 10", f", {whole:.0f} % of the mean", f"rms, {held:.0f} %\n"):
        assert part in fit.sentences(100.0)


def test_experiments_that_do_not_overlap_are_refused() -> None:
    with pytest.raises(InputError, match="0 of 500 readings lie within the force sensor's time"):
        fit_scale(STAMPS, FORCE, STAMPS + 10**12, FORCE)
    with pytest.raises(InputError, match="force is 0 throughout"):
        fit_scale(STAMPS, np.zeros(500), STAMPS, FORCE)


@pytest.mark.parametrize(
    ("skin", "sensor", "words"),
    [
        (FORCE, -FORCE, "the factor from .* is -1, expected one above 0: the sensor's axis points"),
        (
            FORCE,
            10 - FORCE,
            "is -1.00, expected 0.1 or more .*: the sensor's axis points the other",
        ),
        (FORCE, np.zeros(500), "the sensor's force is 0 throughout, expected some load"),
        (FORCE, np.full(500, 5.0), "is not defined, expected 0.1 .*: the sensor does not follow"),
        (5 + 0.01 * np.cos(STAMPS), FORCE, "the skin does not follow a load that varies"),
        (5 + 3 * np.sin(STAMPS * 7e-9), FORCE, "are not of one experiment or one clock"),
    ],
)
def test_forces_that_are_not_one_load_are_refused(
    skin: np.ndarray, sensor: np.ndarray, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        fit_scale(STAMPS, skin, STAMPS, sensor)


def test_a_load_that_stands_is_fitted_though_its_noise_has_no_correlation() -> None:
    rng = np.random.default_rng(1)
    skin, sensor = (5 + 0.05 * rng.normal(size=500) for _ in range(2))
    fit = fit_scale(STAMPS, skin, STAMPS, 2 * sensor)
    assert fit.factor == pytest.approx(2, rel=0.01)
    assert abs(fit.correlation) < 0.2


def test_the_axis_is_read_with_its_sign() -> None:
    sensor = Recording(STAMPS[:3], np.arange(18.0).reshape(3, 6), source="ft.log")
    assert column_of(sensor, "-z").tolist() == [-2, -8, -14]
    assert column_of(sensor, "x").tolist() == [0, 6, 12]
    with pytest.raises(InputError, match="axis is 'w', expected x, y, z"):
        column_of(sensor, "w")
    with pytest.raises(InputError, match=r"ft.log has 4 columns, expected 3 or 6"):
        column_of(Recording(STAMPS[:2], np.ones((2, 4)), source="ft.log"), "z")
