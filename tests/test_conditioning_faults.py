"""Faults planted in a recording are found, each by its name, and nothing else is."""

import warnings

import numpy as np
import pytest

from skinfield import layouts
from skinfield.errors import InputError
from skinfield.signal import (
    Calibration,
    CySkinCount,
    ICubByte,
    Verdict,
    find_faults,
    valid_from_counts,
)
from skinfield.skin import Patch


def healthy(readings=500, taxels=60, seed=0):
    rng = np.random.default_rng(seed)
    return np.rint(230 + 3 * rng.standard_normal((readings, taxels)))


@pytest.mark.parametrize("seed", range(5))
def test_a_healthy_skin_has_no_fault(seed):
    faults = find_faults(healthy(seed=seed), convention=ICubByte())
    assert (faults.verdict == Verdict.OK).all()
    assert faults.usable.all()
    assert faults.sentences == ()


def test_each_fault_is_found_by_its_name():
    counts = healthy()
    counts[:, 3] = np.nan
    counts[:, 7:10] = 240
    counts[300:, 20] = 231
    counts[:, 30] = 0
    counts[:, 40] += 30 * np.random.default_rng(1).standard_normal(500)
    counts = np.clip(np.rint(counts), 0, 255)
    faults = find_faults(counts, convention=ICubByte())
    wanted = np.zeros(60, int)
    wanted[3], wanted[7:10], wanted[20] = Verdict.ABSENT, Verdict.DEAD, Verdict.STUCK
    wanted[30], wanted[40] = Verdict.SATURATED, Verdict.NOISY
    assert faults.verdict.tolist() == wanted.tolist()
    assert faults.verdict.dtype == np.int8
    assert faults.since[20] in (299, 300)
    assert np.flatnonzero(~faults.usable).tolist() == [3, 7, 8, 9, 20, 40]
    assert any("3 of 60 taxels never change" in s and "7-9" in s for s in faults.sentences)


def test_a_high_load_is_not_a_fault():
    counts = healthy()
    counts[200:300, 5] = 0
    faults = find_faults(counts, convention=ICubByte())
    assert faults.verdict[5] == Verdict.OK
    assert any("invalid only there: 5" in s for s in faults.sentences)
    valid = valid_from_counts(counts, ICubByte())
    assert np.flatnonzero(~valid[:, 5]).tolist() == list(range(200, 300))
    assert valid.sum() == valid.size - 100


def test_a_load_held_at_the_clamp_to_the_end_is_not_stuck():
    counts = healthy()
    counts[350:, 5] = 0
    assert find_faults(counts, convention=ICubByte()).verdict[5] == Verdict.OK


def test_a_slow_port_is_not_stuck():
    held = np.repeat(healthy(200), 5, axis=0)
    assert (find_faults(held, convention=ICubByte()).verdict == Verdict.OK).all()


def test_a_frozen_port_is_undecided_and_says_so():
    faults = find_faults(np.full((300, 20), 240.0), convention=ICubByte())
    assert not faults.decided
    assert (faults.verdict == Verdict.OK).all()
    assert any("frozen port" in s for s in faults.sentences)
    assert not find_faults(healthy(5), convention=ICubByte()).decided


@pytest.mark.parametrize("noise", [0.05, 0.15, 0.3, 0.5])
def test_a_quiet_taxel_that_rounding_keeps_still_is_neither_dead_nor_stuck(noise):
    rng = np.random.default_rng(11)
    own = noise * np.exp(0.5 * rng.standard_normal(72))  # most change now and then, some never
    for level in (np.full(72, 240.0), 240.0 + rng.uniform(-0.5, 0.5, 72)):
        counts = np.rint(level + own * rng.standard_normal((1000, 72)))
        counts[:20, 8] = np.rint(209.3 + 0.4 * rng.standard_normal(20))  # touched, then at rest
        for start in range(0, 1000, 100):
            faults = find_faults(counts[start : start + 100], convention=ICubByte())
            assert (faults.verdict == Verdict.OK).all(), (start, faults.sentences)


def test_a_dead_taxel_is_found_as_soon_as_noise_outweighs_the_rounding():
    rng = np.random.default_rng(12)
    own = 0.93 * np.exp(0.5 * rng.standard_normal(72))
    counts = np.rint(240.0 + own * rng.standard_normal((100, 72)))
    counts[:, 5] = 240.0
    faults = find_faults(counts, convention=ICubByte())
    assert faults.decided
    assert np.flatnonzero(faults.verdict == Verdict.DEAD).tolist() == [5]


def test_noise_is_measured_against_the_calibration_where_there_is_one():
    counts = healthy()
    patch = Patch(1e-3 * np.arange(180.0).reshape(60, 3))
    calm = np.full(60, 3.0)
    calm[11] = 0.4
    calibration = Calibration.from_convention(patch, ICubByte(), gain=-171, noise_std=calm)
    faults = find_faults(counts, convention=ICubByte(), calibration=calibration)
    assert np.flatnonzero(faults.verdict).tolist() == [11]
    with pytest.raises(InputError, match="59 columns, expected 60"):
        find_faults(counts[:, 1:], convention=ICubByte(), calibration=calibration)


def test_validity_of_one_reading():
    reading = np.array([240, 0, 255, 256, -1, np.nan, np.inf, 17])
    valid = valid_from_counts(reading, ICubByte())
    assert valid.tolist() == [True, False, False, False, False, False, False, True]
    alive = np.array([False] + [True] * 7)
    assert valid_from_counts(reading, ICubByte(), alive=alive).tolist() == [False] * 7 + [True]
    words = valid_from_counts([0.0, 65535.0, 70000.0], CySkinCount())
    assert words.tolist() == [True, False, False]
    assert valid_from_counts([1.0, np.nan]).tolist() == [True, False]


def test_nothing_and_wrong_lengths_are_refused():
    with pytest.raises(InputError, match="hold no number"):
        valid_from_counts(np.full(4, np.nan))
    with pytest.raises(InputError, match=r"shape \(4,\), expected \(5,\)"):
        valid_from_counts(np.zeros(4), alive=np.ones(5, bool))
    with pytest.raises(InputError, match="hold no number"):
        find_faults(np.full((9, 4), np.nan))
    with pytest.raises(InputError, match="expected numbers"):
        valid_from_counts(["a", "b"])


def test_no_patch_is_refused_and_one_reading_decides_nothing():
    counts = healthy()[:1]
    with pytest.raises(InputError, match="patch is 'hexagon72', expected a Patch"):
        find_faults(counts, "hexagon72")
    with warnings.catch_warnings(action="error"):
        assert not find_faults(counts).decided
        counts = np.full((1, 72), 240.0)
        assert not find_faults(counts, layouts.hexagon72()).decided
