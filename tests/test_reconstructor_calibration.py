"""A reconstructor with a calibration: counts in, the contacts of what they stand for out."""

from copy import copy
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.calibrate import PressureCalibration, TouchCalibration
from skinfield.errors import InputError
from skinfield.reconstruct.diagnostics import Conditioning, condition
from skinfield.signal import Calibration
from skinfield.simulate import Sphere, press
from skinfield.skin.reading import Recording

PATCH = sf.layouts.hexagon72()


@pytest.fixture(scope="module")
def pressed() -> tuple[np.ndarray, np.ndarray, Calibration]:
    """Readings of a ball, counts of them, and what turns one into the other."""
    rng = np.random.default_rng(1)
    ball = press(sf.Layer(), [Sphere(radius=8e-3, force=1.5)], 20e-3, 0.4e-3)
    change = ball.readings(PATCH.plane - PATCH.plane[30], PATCH.pad_diameter, "capacitance")
    rest, gain = rng.uniform(100, 200, 72), -300.0 * np.exp(0.1 * rng.standard_normal(72))
    alive = np.arange(72) != 5
    calibration = Calibration(rest, gain, np.full(72, 0.6), alive, PATCH.uid)
    return change, rest + gain * change, calibration


def test_counts_become_the_contacts_of_their_readings(
    pressed: tuple[np.ndarray, np.ndarray, Calibration],
) -> None:
    change, counts, calibration = pressed
    by_counts = sf.Reconstructor(PATCH, calibration=calibration)
    noise = calibration.quantity_std()
    noise[5] = sf.Capacitance().typical_noise
    by_readings = sf.Reconstructor(PATCH, noise_std=noise)
    gap = np.where(calibration.alive, change, np.nan)
    for rec in (by_counts, copy(by_counts)):
        one, other = rec(counts), by_readings(gap)
        assert one.normal_force == pytest.approx(other.normal_force, rel=1e-6)
        assert not one.valid[5]
        by_readings.reset()
    assert one.normal_force == pytest.approx(1.5, rel=0.1)
    rows, others = by_counts.rows(), by_readings.rows()
    by_counts.reset()
    whole = calibration.counts_from_relative_capacitance(change)
    whole[5] = 0.0
    assert by_counts.into(np.nan_to_num(whole), rows) == by_readings.into(
        np.where(calibration.alive, change, 0.0), others
    )
    assert rows["normal_force"][0] == pytest.approx(others["normal_force"][0], rel=1e-3)


def test_a_calibration_of_another_patch_is_refused(
    pressed: tuple[np.ndarray, np.ndarray, Calibration],
) -> None:
    with pytest.raises(InputError, match="expected 12"):
        sf.Reconstructor(sf.layouts.icub_triangle(), calibration=pressed[2])


def test_one_by_pressure_answers_by_itself() -> None:
    names = [each.name for each in fields(PressureCalibration)]
    some = PressureCalibration(
        **{name: np.zeros(3) for name in names}
        | {"weights": np.zeros((3, 2)), "time_constants": np.zeros(0), "widths": np.zeros(0)}
        | {"change_std": 1.0, "low": 0.0, "high": 1.0, "reasons": 3 * ("",)}
    )
    with pytest.raises(InputError, match=r"calibration\.pressure\(counts\)"):
        sf.Reconstructor(PATCH, calibration=some)


def touched(counts: Calibration | None, young: float = 150e3, **changes: Any) -> TouchCalibration:
    """What touches say of hexagon72, with gains of its own."""
    gain = np.exp(0.1 * np.random.default_rng(2).standard_normal(72))
    known = {"thickness": 1.8e-3, "poisson_ratio": 0.48, "young_modulus": young, "covered": True}
    known |= {"gain": gain, "gain_std": 0.02 * gain, "noise_std": np.full(72, 0.002)}
    known |= {"thickness_std": 1e-5, "poisson_std": 1e-3, "model_error": 0.0, "presses": 99}
    made = TouchCalibration(**known | {"left_out": 0, "force_ratio": float("nan")} | changes)
    return made if counts is None else made.with_counts(counts)


def test_an_engine_takes_counts_as_a_reconstructor_does(
    pressed: tuple[np.ndarray, np.ndarray, Calibration],
) -> None:
    change, counts, calibration = pressed
    whole = replace(calibration, alive=np.ones(72, bool))
    skin = sf.Skin((PATCH, sf.layouts.icub_triangle()))
    known, solver = touched(whole), sf.NonNegative()
    usual = {"budget": 60.0, "grid": (10, 20), "solver": solver, "mechanics": known.mechanics}
    rec = sf.Reconstructor(skin, calibration={"hexagon72": known}, **usual)
    layers = {"hexagon72": known.layer, skin[1].name: sf.Layer()}
    noise = {"hexagon72": known.noise_std}
    by_readings = sf.Reconstructor(skin, layers, noise_std=noise, **usual)
    counts = whole.counts_from_relative_capacitance(change)
    readings = [change / known.gain, np.zeros(12)]
    for recorded, read in (
        ([counts, np.zeros(12)], readings),
        ({"hexagon72": counts}, {"hexagon72": readings[0]}),
    ):
        found, truth = rec(recorded)["hexagon72"], by_readings(read)["hexagon72"]
        assert found.normal_force == pytest.approx(truth.normal_force, rel=1e-6)
        assert found.normal_force > 0.2
        assert (found.relative, truth.relative) == (True, False)
    rec.run(np.r_[counts, np.zeros(12)], budget=60.0)
    by_readings.run(np.concatenate(readings), budget=60.0)
    np.testing.assert_allclose(rec.results.pressure_of(0), by_readings.results.pressure_of(0))
    assert not sf.Reconstructor(PATCH, calibration=known, relative=False).relative


def test_an_engine_says_which_calibrations_it_cannot_take() -> None:
    skin = sf.Skin((PATCH, sf.layouts.icub_triangle()))
    for calibration, said in (
        (touched(None), r"expected .*by the names of 2 patches"),
        ({"hexagon_72": touched(None)}, "names 'hexagon_72', expected patches of the skin"),
        ({"hexagon72": touched(None)}, "mechanics of .* differ by their calibrations"),
        ({skin[1].name: touched(None)}, "has 72 taxels, expected 12"),
    ):
        with pytest.raises(InputError, match=said):
            sf.Reconstructor(skin, calibration=calibration)


def test_touches_of_readings_need_no_counts() -> None:
    known = touched(None)
    per_taxel = known.of_taxels(PATCH)
    readings = 0.1 * np.random.default_rng(3).random((4, 72))
    np.testing.assert_allclose(
        per_taxel.relative_capacitance_from_counts(readings), known.readings(readings)
    )
    np.testing.assert_allclose(per_taxel.quantity_std(), known.noise_std)
    recording = Recording(20_000_000 * np.arange(4), readings, unit="dC/C0")
    how = Conditioning(calibration=per_taxel, without=(7,))
    values, found = condition(recording, PATCH, sf.Layer(), sf.Capacitance(), how)
    expected = known.readings(readings)
    expected[:, 7] = np.nan
    np.testing.assert_allclose(values, expected)
    np.testing.assert_allclose(np.delete(found.noise_std, 7), np.delete(known.noise_std, 7))
    counts = Recording(20_000_000 * np.arange(4), np.full((4, 72), 200.0))
    with pytest.raises(InputError, match=r"is of readings .* the recording is of counts"):
        condition(counts, PATCH, sf.Layer(), sf.Capacitance(), how)
