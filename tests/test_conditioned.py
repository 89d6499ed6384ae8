"""From the counts of a recording to what a reconstruction takes."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.reconstruct.conditioned import condition, without_empty
from skinfield.reconstruct.diagnostics import Conditioning
from skinfield.signal import Calibration, CySkinCount, Exponential, ICubByte
from skinfield.skin.reading import Recording

PATCH = sf.layouts.icub_triangle()
LAYER = sf.Layer()
COUNT = len(PATCH)


def recording(counts: np.ndarray, unit: str = "count") -> Recording:
    stamps = np.arange(len(counts)) * 20_000_000
    return Recording(stamps, counts.astype(float), unit=unit, source="test.log")


def bytes_of_a_press(readings: int = 300) -> np.ndarray:
    """Rest at 240 with noise for 4 s, then taxel 3 pressed by 40."""
    rng = np.random.default_rng(0)
    counts = 240 + rng.normal(scale=1.5, size=(readings, COUNT)).round()
    counts[220:, 3] -= 40
    return counts


def test_bytes_of_an_icub_become_relative_capacitance() -> None:
    how = Conditioning(gain=-200.0)
    found = condition(recording(bytes_of_a_press()), PATCH, LAYER, sf.Capacitance(), how)
    assert found.values[:200].mean() == pytest.approx(0, abs=2e-3)
    assert found.values[230:, 3].mean() == pytest.approx(0.2, abs=5e-3)
    assert found.noise_std == pytest.approx(1.5 / 200, rel=0.35)
    assert any("taken as iCub bytes" in note for note in found.notes)


def test_a_guessed_gain_is_said_and_a_given_one_is_not() -> None:
    guessed = condition(
        recording(bytes_of_a_press()), PATCH, LAYER, sf.Capacitance(), Conditioning()
    )
    given = condition(
        recording(bytes_of_a_press()), PATCH, LAYER, sf.Capacitance(), Conditioning(gain=-171.0)
    )
    assert any("is a guess" in note for note in guessed.notes)
    assert not any("is a guess" in note for note in given.notes)
    assert guessed.values == pytest.approx(given.values)


def test_clamped_bytes_are_invalid_and_a_dead_taxel_is_left_out() -> None:
    counts = bytes_of_a_press()
    counts[250, 5] = 0  # the clamp of a high load
    counts[:, 7] = 240  # never moves while the others do
    found = condition(recording(counts), PATCH, LAYER, sf.Capacitance(), Conditioning())
    assert np.isnan(found.values[250, 5])
    assert np.isfinite(found.values[249, 5])
    assert np.isnan(found.values[:, 7]).all()
    assert any("never change" in note for note in found.notes)


def test_gap_and_stress_follow_from_capacitance() -> None:
    how = Conditioning(gain=-200.0)
    counts = recording(bytes_of_a_press())
    change = condition(counts, PATCH, LAYER, sf.Capacitance(), how).values
    strain = condition(counts, PATCH, LAYER, sf.Gap(), how).values
    stress = condition(counts, PATCH, LAYER, sf.BaseStress(), how).values
    assert strain == pytest.approx(change / (1 + change))
    assert stress == pytest.approx(strain * 150e3)


def test_a_filter_lowers_the_noise_that_is_stated() -> None:
    how = Conditioning(gain=-200.0, filter=Exponential(time_constant=0.2))
    counts = recording(bytes_of_a_press())
    plain = condition(counts, PATCH, LAYER, sf.Capacitance(), Conditioning(gain=-200.0))
    smooth = condition(counts, PATCH, LAYER, sf.Capacitance(), how)
    assert smooth.values[50:200].std() < 0.5 * plain.values[50:200].std()
    assert smooth.noise_std == pytest.approx(smooth.values[50:200].std(axis=0), rel=0.5)
    assert any("ms behind" in note for note in smooth.notes)


def test_a_calibration_takes_the_place_of_convention_and_gain() -> None:
    calibration = Calibration.from_convention(
        PATCH, ICubByte(no_load=230), gain=-100.0, noise_std=np.full(COUNT, 2.0)
    )
    how = Conditioning(calibration=calibration)
    found = condition(recording(bytes_of_a_press()), PATCH, LAYER, sf.Capacitance(), how)
    assert found.values[:200].mean() == pytest.approx(-0.1, abs=5e-3)
    assert found.noise_std == pytest.approx(0.02)


def test_cyskin_counts_rise_from_zero() -> None:
    rng = np.random.default_rng(1)
    counts = np.maximum(rng.normal(scale=60, size=(200, COUNT)), 0).round()
    counts[150:, 2] += 5000
    how = Conditioning(board=CySkinCount(), gain=20_000.0)
    found = condition(recording(counts), PATCH, LAYER, sf.Capacitance(), how)
    assert found.values[160:, 2].mean() == pytest.approx(0.25, rel=0.02)


def test_a_few_readings_take_a_typical_noise_and_say_so() -> None:
    values = np.full((3, COUNT), 0.1)
    found = condition(recording(values, "dC/C0"), PATCH, LAYER, sf.Capacitance(), Conditioning())
    assert found.noise_std == pytest.approx(0.002)
    assert any("too few" in note for note in found.notes)
    set_by_hand = Conditioning(noise_std=0.01)
    found = condition(recording(values, "dC/C0"), PATCH, LAYER, sf.Capacitance(), set_by_hand)
    assert found.noise_std == pytest.approx(0.01)


def test_unit_and_quantity_must_agree() -> None:
    with pytest.raises(InputError, match=r"test.log is in 'Pa', expected a quantity of BaseStress"):
        condition(
            recording(np.ones((3, COUNT)), "Pa"), PATCH, LAYER, sf.Capacitance(), Conditioning()
        )


def test_counts_of_no_known_board_are_refused() -> None:
    with pytest.raises(InputError, match=r"counts range from -5 to 3, expected 0 to 255"):
        condition(
            recording(np.tile([-5.0, 3.0], (20, COUNT // 2))),
            PATCH, LAYER, sf.Capacitance(), Conditioning(),
        )  # fmt: skip


def test_readings_without_a_valid_taxel_are_dropped_and_counted() -> None:
    values = np.full((30, COUNT), 0.1)
    values[[4, 9]] = np.nan
    found = condition(recording(values, "dC/C0"), PATCH, LAYER, sf.Capacitance(), Conditioning())
    kept = without_empty(found)
    assert len(kept.values) == len(kept.recording) == 28
    assert kept.notes[-1] == "2 of 30 readings have no valid taxel: left out"


def test_a_recording_without_noise_keeps_its_contact_and_says_so() -> None:
    change = np.zeros((200, COUNT))
    change[120:, 3] = 0.3  # the quiet stretch holds zeros alone: they are no counts
    found = condition(recording(change, "dC/C0"), PATCH, LAYER, sf.Capacitance(), Conditioning())
    assert found.noise_std == pytest.approx(sf.Capacitance().typical_noise)
    assert any("hold no noise" in note for note in found.notes)
    reconstruct = sf.Reconstructor(PATCH, LAYER, noise_std=found.noise_std)
    assert len(reconstruct(found.values[150]).contacts) == 1
    assert not reconstruct(found.values[50]).contacts
