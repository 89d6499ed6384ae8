"""Calibration: the way there and back, its files, and whose it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.errors import FileError, InputError
from skinfield.signal import (
    Calibration,
    ICubByte,
    estimate_baseline,
    load_calibration,
    save_calibration,
)
from skinfield.skin import Patch

finite = st.floats(-1e6, 1e6)
positive = st.floats(1e-6, 1e6)


@st.composite
def calibrations(draw):
    taxels = draw(st.integers(1, 7))
    column = lambda values: np.array(draw(st.lists(values, min_size=taxels, max_size=taxels)))
    uid = draw(st.lists(st.integers(0, 2**64 - 1), min_size=taxels, max_size=taxels))
    return Calibration(
        column(finite),
        column(positive) * column(st.sampled_from([-1.0, 1.0])),
        column(positive),
        column(st.booleans()),
        np.array(uid, dtype=np.uint64),
        patch_name=draw(st.text(max_size=9)),
        basis=draw(st.text()),
    )


@given(calibrations(), st.floats(-0.9, 9.0))
def test_counts_and_quantity_undo_each_other(calibration, change):
    wanted = np.where(calibration.alive, change, np.nan)
    counts = calibration.counts_from_relative_capacitance(np.full((2, len(calibration)), change))
    got = calibration.relative_capacitance_from_counts(counts)
    tolerance = 1e-15 * np.abs(calibration.baseline / calibration.gain).max() + 1e-12
    np.testing.assert_allclose(got, np.tile(wanted, (2, 1)), rtol=1e-9, atol=tolerance)


@pytest.mark.parametrize("ending", [".npz", ".toml"])
@settings(max_examples=40)
@given(calibration=calibrations())
def test_files_bring_back_every_bit(tmp_path_factory, ending, calibration):
    file = tmp_path_factory.getbasetemp() / f"c{ending}"
    save_calibration(calibration, file)
    back = load_calibration(file)
    for name in ("baseline", "gain", "noise_std", "alive", "uid"):
        np.testing.assert_array_equal(getattr(back, name), getattr(calibration, name))
    assert (back.patch_name, back.unit, back.basis) == (
        calibration.patch_name,
        calibration.unit,
        calibration.basis,
    )


@pytest.mark.parametrize("ending", [".npz", ".toml"])
@settings(max_examples=150)
@given(data=st.data())
def test_garbage_is_a_file_error_and_nothing_else(tmp_path_factory, ending, data):
    file = tmp_path_factory.getbasetemp() / f"g{ending}"
    save_calibration(Calibration.identity(Patch(1e-2 * np.eye(3)), noise_std=0.01), file)
    content = bytearray(data.draw(st.one_of(st.just(file.read_bytes()), st.binary(max_size=200))))
    for _ in range(data.draw(st.integers(1, 4))):
        if content:
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    file.write_bytes(bytes(content[: data.draw(st.integers(0, len(content)))]))
    try:
        back = load_calibration(file)
    except FileError:
        return
    assert len(back.uid) == len(back.gain) >= 1


def test_another_patch_version_or_ending_is_refused(tmp_path):
    patch = Patch(1e-2 * np.eye(3), uid=np.array([16, 17, 18]), name="palm")
    file = tmp_path / "c.toml"
    save_calibration(Calibration.identity(patch, noise_std=0.01), file)
    assert load_calibration(file, patch).unit == "1"
    other = Patch(1e-2 * np.eye(3), uid=np.array([16, 18, 17]), name="sole")
    with pytest.raises(FileError, match=r"uid\[1\].* is 17, expected 18 as in patch 'sole'"):
        load_calibration(file, other)
    with pytest.raises(FileError, match="3 taxels, expected 2"):
        load_calibration(file, patch.subset(np.array([0, 1])))
    file.write_text(file.read_text().replace("version = 1", "version = 2"))
    with pytest.raises(FileError, match="version 2, expected 1"):
        load_calibration(file)
    with pytest.raises(FileError, match=r"expected \.npz or \.toml"):
        load_calibration(tmp_path / "c.json")
    with pytest.raises(FileError, match="cannot be read"):
        load_calibration(tmp_path / "none.npz")
    with pytest.raises(FileError, match="cannot be written"):
        save_calibration(Calibration.identity(patch, noise_std=0.01), tmp_path / "no" / "c.npz")


def test_the_dead_tell_nothing_and_stay_invalid():
    patch = Patch(1e-2 * np.eye(3))
    alive = np.array([True, False, True])
    c = Calibration([240, np.nan, 240], [-100, np.nan, -50], [2, np.nan, 2], alive, patch.uid)
    assert c.quantity_std().tolist() == [0.02, np.inf, 0.04]
    got = c.relative_capacitance_from_counts([190, 190, 190])
    assert got[[0, 2]].tolist() == [0.5, 1.0]
    assert np.isnan(got[1])
    assert c.without(np.array([True, False, False])).alive.tolist() == [False, False, True]
    out = np.empty(3)
    assert c.relative_capacitance_from_counts(np.array([190.0, 0, 0]), out) is out


def test_wrong_figures_are_refused():
    patch = Patch(1e-2 * np.eye(3))
    with pytest.raises(InputError, match=r"noise_std\[0\] is 0.0, expected a finite number above"):
        Calibration.identity(patch, noise_std=0.0)
    with pytest.raises(InputError, match="expected the sign -1"):
        Calibration.from_convention(patch, ICubByte(), gain=100.0, noise_std=2.0)
    with pytest.raises(InputError, match=r"gain\[0\] is 0.0"):
        Calibration.from_convention(patch, ICubByte(), gain=0.0, noise_std=2.0)
    with pytest.raises(InputError, match=r"shape \(4,\), expected"):
        Calibration.identity(patch, noise_std=0.1).relative_capacitance_from_counts(np.zeros(4))
    with pytest.raises(InputError, match="gain has shape"):
        Calibration.from_convention(patch, ICubByte(), gain=[-1.0, -1.0], noise_std=2.0)


def test_a_loaded_baseline_is_not_taken_unawares():
    patch, rng = Patch(1e-2 * np.eye(3)), np.random.default_rng(1)
    standing = np.rint(200 + 2 * rng.standard_normal((300, 3)))
    baseline = estimate_baseline(standing, 50.0, convention=ICubByte())
    assert not baseline.quiet
    with pytest.raises(InputError, match="something lies on the skin"):
        Calibration.from_baseline(patch, baseline, gain=-171.0)
    tared = Calibration.from_baseline(patch, baseline, gain=-171.0, even_if_loaded=True)
    assert tared.baseline == pytest.approx([200] * 3, abs=0.6)
    assert "median of readings" in tared.basis
    with pytest.raises(InputError, match=r"alive has shape \(4,\), expected \(3\)"):
        Calibration.from_baseline(
            patch, baseline, gain=-171.0, alive=np.ones(4, bool), even_if_loaded=True
        )
