"""A reconstructor with a calibration: counts in, the contacts of what they stand for out."""

from copy import copy
from dataclasses import fields

import numpy as np
import pytest

import skinfield as sf
from skinfield.calibrate import PressureCalibration
from skinfield.errors import InputError
from skinfield.signal import Calibration
from skinfield.simulate import Sphere, press

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
        assert one.normal_force == pytest.approx(other.normal_force, rel=1e-9)
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
