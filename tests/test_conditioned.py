"""From the counts of a recording to what a reconstruction takes."""

from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import Quantity
from skinfield.errors import Floats, InputError
from skinfield.reconstruct.diagnostics import Conditioning, Survey, condition
from skinfield.signal import Calibration, CySkinCount, Exponential, ICubByte
from skinfield.skin.reading import Recording

PATCH = sf.layouts.icub_triangle()
LAYER = sf.Layer()
COUNT = len(PATCH)
CHANGE = sf.Capacitance()


def conditioned(
    counts: Floats, unit: str = "count", quantity: Quantity = CHANGE, **how: Any
) -> tuple[Floats, Survey]:
    stamps = np.arange(len(counts)) * 20_000_000
    recording = Recording(stamps, counts.astype(float), unit=unit, source="test.log")
    return condition(recording, PATCH, LAYER, quantity, Conditioning(**how))


def noted(found: Survey, text: str) -> bool:
    return any(text in note for note in found.notes)


def bytes_of_a_press(readings: int = 300) -> Floats:
    """Rest at 240 with noise for 4 s, then taxel 3 pressed by 40."""
    rng = np.random.default_rng(0)
    counts = 240 + rng.normal(scale=1.5, size=(readings, COUNT)).round()
    counts[220:, 3] -= 40
    return counts


def test_bytes_of_an_icub_become_relative_capacitance() -> None:
    values, found = conditioned(bytes_of_a_press(), gain=-200.0)
    assert values[:200].mean() == pytest.approx(0, abs=2e-3)
    assert values[230:, 3].mean() == pytest.approx(0.2, abs=5e-3)
    assert found.noise_std == pytest.approx(1.5 / 200, rel=0.35)
    assert noted(found, "taken as iCub bytes")


def test_a_guessed_gain_is_said_and_a_given_one_is_not() -> None:
    values, guessed = conditioned(bytes_of_a_press())
    same, given = conditioned(bytes_of_a_press(), gain=-171.0)
    assert noted(guessed, "is a guess")
    assert not noted(given, "is a guess")
    assert values == pytest.approx(same)


def test_clamped_bytes_are_invalid_and_a_dead_taxel_is_left_out() -> None:
    counts = bytes_of_a_press()
    counts[250, 5] = 0  # the clamp of a high load
    counts[:, 7] = 240  # never moves while the others do
    values, found = conditioned(counts)
    assert np.isnan(values[250, 5])
    assert np.isfinite(values[249, 5])
    assert np.isnan(values[:, 7]).all()
    assert noted(found, "never change")


def test_gap_and_stress_follow_from_capacitance() -> None:
    change, strain, stress = (
        conditioned(bytes_of_a_press(), quantity=quantity, gain=-200.0)[0]
        for quantity in (CHANGE, sf.Gap(), sf.BaseStress())
    )
    assert strain == pytest.approx(change / (1 + change))
    assert stress == pytest.approx(strain * 150e3)


def test_a_filter_lowers_the_noise_that_is_stated() -> None:
    plain, _ = conditioned(bytes_of_a_press(), gain=-200.0)
    smooth, found = conditioned(
        bytes_of_a_press(), gain=-200.0, filter=Exponential(time_constant=0.2)
    )
    assert smooth[50:200].std() < 0.5 * plain[50:200].std()
    assert found.noise_std == pytest.approx(smooth[50:200].std(axis=0), rel=0.5)
    assert noted(found, "ms behind")


def test_a_calibration_takes_the_place_of_convention_and_gain() -> None:
    calibration = Calibration.from_convention(
        PATCH, ICubByte(no_load=230), gain=-100.0, noise_std=np.full(COUNT, 2.0)
    )
    values, found = conditioned(bytes_of_a_press(), calibration=calibration)
    assert values[:200].mean() == pytest.approx(-0.1, abs=5e-3)
    assert found.noise_std == pytest.approx(0.02)


def test_cyskin_counts_rise_from_zero() -> None:
    rng = np.random.default_rng(1)
    counts = np.maximum(rng.normal(scale=60, size=(200, COUNT)), 0).round()
    counts[150:, 2] += 5000
    values, _ = conditioned(counts, board=CySkinCount(), gain=20_000.0)
    assert values[160:, 2].mean() == pytest.approx(0.25, rel=0.02)


def test_a_few_readings_take_a_typical_noise_and_say_so() -> None:
    _, found = conditioned(np.full((3, COUNT), 0.1), "dC/C0")
    assert found.noise_std == pytest.approx(0.002)
    assert noted(found, "too few")
    _, found = conditioned(np.full((3, COUNT), 0.1), "dC/C0", noise_std=0.01)
    assert found.noise_std == pytest.approx(0.01)


def test_unit_and_quantity_must_agree() -> None:
    with pytest.raises(InputError, match=r"test.log is in 'Pa', expected a quantity of BaseStress"):
        conditioned(np.ones((3, COUNT)), "Pa")


def test_counts_of_no_known_board_are_refused() -> None:
    with pytest.raises(InputError, match=r"counts range from -5 to 3, expected 0 to 255"):
        conditioned(np.tile([-5.0, 3.0], (20, COUNT // 2)))


def test_a_recording_without_noise_keeps_its_contact_and_says_so() -> None:
    change = np.zeros((200, COUNT))
    change[120:, 3] = 0.3  # the quiet stretch holds zeros alone: they are no counts
    values, found = conditioned(change, "dC/C0")
    assert found.noise_std == pytest.approx(CHANGE.typical_noise)
    assert noted(found, "hold no noise")
    reconstruct = sf.Reconstructor(PATCH, LAYER, noise_std=found.noise_std)
    assert len(reconstruct(values[150]).contacts) == 1
    assert not reconstruct(values[50]).contacts
