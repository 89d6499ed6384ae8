"""Baselines: accuracy, honesty of the stated errors, and what is not quiet."""

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.signal import CySkinCount, ICubByte, estimate_baseline, quiet_stretch

RATE = 50.0


def noise(readings, taxels, seed=0):
    return np.random.default_rng(seed).standard_normal((readings, taxels))


def test_noise_drift_and_level_are_found_and_the_errors_are_honest():
    true_level, true_noise, true_drift = 240.0, 3.0, 0.4
    time = (np.arange(400) - 199.5) / RATE
    counts = true_level + true_noise * noise(400, 500) + true_drift * time[:, None]
    b = estimate_baseline(counts, RATE, quiet=slice(None), convention=ICubByte())
    assert b.quiet
    assert b.notes == ()
    assert np.median(b.noise_std) == pytest.approx(true_noise, rel=0.02)
    assert np.median(b.drift) == pytest.approx(true_drift, abs=0.05)
    error = (b.baseline - true_level) / b.uncertainty
    assert np.std(error) == pytest.approx(1.0, abs=0.12)


def test_touches_do_not_move_a_robust_baseline():
    counts = 240 + 2 * noise(400, 50)
    counts[150:170, :3] -= 100
    b = estimate_baseline(counts, RATE, quiet=slice(None))
    assert np.abs(b.baseline - 240).max() < 0.6
    assert b.noise_std.max() < 2.4
    assert b.stretch.moving.nonzero()[0].tolist() == [0, 1, 2]


def test_repeated_values_are_seen_and_counted_once():
    fresh = 240 + 3 * noise(400, 100)
    held = np.repeat(fresh, 3, axis=0)
    b = estimate_baseline(held, RATE, quiet=slice(None))
    assert b.stretch.hold == pytest.approx(3.0, abs=0.1)
    assert b.correlation == pytest.approx(3.0, abs=0.3)
    assert any("one independent one" in note for note in b.notes)
    error = (b.baseline - 240) / b.uncertainty
    assert np.std(error) == pytest.approx(1.0, abs=0.2)
    assert b.stretch.still


def test_whole_counts_never_claim_less_noise_than_quantisation():
    b = estimate_baseline(np.full((100, 4), 240.0), RATE, convention=ICubByte())
    assert b.noise_std == pytest.approx([12**-0.5] * 4)
    coarse = np.rint(240.3 + 1.0 * noise(2000, 50))
    wanted = np.sqrt(1.0 + 1 / 12)
    assert np.median(estimate_baseline(coarse, RATE, quiet=slice(None)).noise_std) == pytest.approx(
        wanted, rel=0.03
    )


def test_bytes_that_rarely_change_keep_their_noise():
    counts = np.rint(240 + 0.34 * noise(400, 72))  # most readings are 240 exactly
    wanted = np.std(counts)
    found = estimate_baseline(counts, RATE, quiet=slice(None), convention=ICubByte()).noise_std
    assert np.median(found) == pytest.approx(wanted, rel=0.05)
    assert found.min() > 0.7 * wanted


@pytest.mark.parametrize("pressed_from", [20, 50, 80])
def test_a_press_is_no_noise_and_no_rest(pressed_from):
    counts = 240 + 2 * noise(100, 72)
    counts[pressed_from:, 5] -= 100  # all the while, in a recording too short to be quiet
    b = estimate_baseline(counts, RATE, quiet=slice(None), convention=ICubByte())
    assert b.stretch.moving.nonzero()[0].tolist() == [5]
    assert b.noise_std[5] == pytest.approx(2.0, rel=0.5)
    assert b.baseline[5] == pytest.approx(240.0, abs=4.0)
    assert b.drift[5] == 0.0


def test_a_short_recording_is_quiet_where_nobody_touches():
    counts = 240 + 2 * noise(60, 72)
    counts[32:] -= 50
    q = quiet_stretch(counts, RATE, convention=ICubByte())
    assert q.still
    assert (q.start, q.stop) == (0, 30)


def press(readings, start, stop, taxels, depth=120.0):
    pushed = np.zeros((readings, taxels))
    ramp = np.sin(np.linspace(0, np.pi, stop - start)) ** 2
    pushed[start:stop] = depth * ramp[:, None]
    return pushed


def test_the_quietest_stretch_avoids_presses():
    counts = 240 + 2 * noise(600, 72) - press(600, 0, 250, 72) - press(600, 400, 600, 72)
    q = quiet_stretch(counts, RATE, convention=ICubByte())
    assert q.still
    assert q.start >= 240
    assert q.stop <= 410
    assert q.ratio < 1.6


def test_of_two_still_stretches_the_unloaded_one_is_taken():
    counts = 240 + 2 * noise(600, 72)
    counts[:300] -= 40  # someone leans on it, without moving
    assert quiet_stretch(counts, RATE, convention=ICubByte()).start >= 300
    raised = 2 * noise(600, 72) + 100
    raised[:300] += 400
    assert quiet_stretch(raised, RATE, convention=CySkinCount()).start >= 300


def test_a_recording_that_is_never_still_says_so():
    time = np.arange(500) / RATE
    counts = 200 - 40 * np.sin(2 * np.pi * time)[:, None] + 2 * noise(500, 72)
    b = estimate_baseline(counts, RATE, convention=ICubByte())
    assert not b.quiet
    assert not b.stretch.still
    assert any("not still" in note for note in b.notes)


def test_standing_still_is_not_unloaded():
    b = estimate_baseline(200 + 2 * noise(300, 72), RATE, convention=ICubByte())
    assert b.stretch.still
    assert not b.quiet
    assert b.loaded.all()
    unknown = estimate_baseline(200 + 2 * noise(300, 72), RATE)
    assert any("taken to be unloaded" in note for note in unknown.notes)


def test_a_clipped_scale_gives_its_noise_from_above():
    counts = CySkinCount().counts_from_difference(90 * noise(4000, 60))
    b = estimate_baseline(counts, 10.0, quiet=slice(None), convention=CySkinCount())
    assert b.quiet
    assert np.median(b.noise_std) == pytest.approx(90, rel=0.05)
    assert any("floor of the scale" in note for note in b.notes)


def test_taxels_below_the_floor_of_the_scale_rest_too_until_they_are_pressed():
    """At -0.7 deviations three readings in four are 0, and so is the median step."""
    counts = CySkinCount().counts_from_difference(90 * noise(400, 40) - 63)
    assert (counts == 0).mean() > 0.7
    assert quiet_stretch(counts, RATE, seconds=4).still
    swell = np.sin(np.linspace(0, np.pi, 400))[:, None] * 3000
    pressed = CySkinCount().counts_from_difference(90 * noise(400, 40) - 63 + swell)
    assert quiet_stretch(pressed, RATE, seconds=8).moving.sum() > 20


def test_absent_taxels_have_no_baseline_and_are_named():
    counts = 240 + 2 * noise(200, 6)
    counts[:, 2] = np.nan
    counts[::3, 4] = np.nan
    b = estimate_baseline(counts, RATE, convention=ICubByte())
    assert b.measured.tolist() == [True, True, False, True, True, True]
    assert any("1 of 6 taxels answer too rarely" in note for note in b.notes)
    assert b.quiet


def test_unusable_recordings_are_refused():
    bad = noise(100, 3)
    bad[4, 1] = np.inf
    for wrong, text in [
        (lambda: estimate_baseline(np.full((100, 3), np.nan), RATE), "hold no number"),
        (lambda: estimate_baseline(bad, RATE), r"counts\[4, 1\] is inf"),
        (lambda: quiet_stretch(noise(10, 3), RATE), "10 readings, expected at least 16"),
        (lambda: estimate_baseline(noise(100, 3), RATE, quiet=slice(0, 5)), "readings in a row"),
        (lambda: estimate_baseline(noise(100, 3), float("nan")), "rate is nan"),
        (lambda: estimate_baseline(np.zeros(100), RATE), r"shape \(100,\), expected"),
    ]:
        with pytest.raises(InputError, match=text):
            wrong()
