"""When readings are taken, how they arrive, and that nothing downstream can tell them from real."""

from dataclasses import replace

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.signal import Verdict, estimate_baseline, find_faults
from skinfield.simulate.electronics import (
    CySkinBoard,
    Defect,
    Defects,
    Delivery,
    Electronics,
    Noise,
    ThermalDrift,
    cyskin_electronics,
    icub_electronics,
    ideal_electronics,
    recording,
)
from skinfield.skin import generators

HEXAGON = generators.icub_hexagon()


def rng(seed=0):
    return np.random.default_rng(seed)


def recorded(electronics, seconds, *, press=None, patch=HEXAGON, seed=0, defects=None):
    """Array, sampling and recording of a skin that `press`, of time in s, changes by ΔC/C₀."""
    array = electronics.manufacture(patch, rng(seed))
    if defects:
        planted = array.defect.copy()
        for kind, rows in defects.items():
            planted[rows] = kind
        array = replace(array, defect=planted)
    sampling = array.sample_times(seconds, rng(seed + 1), start_ns=1_700_000_000_000_000_000)
    instants = sampling.instants
    change = np.zeros(instants.shape) if press is None else press(instants)
    return array, sampling, recording(array, sampling, change, None, rng(seed + 2))


# ---- clock and transport -------------------------------------------------------------------------


def test_taxels_of_a_module_are_converted_one_after_another():
    made = replace(ideal_electronics(), delivery=Delivery(rate=20.0, conversion_time=2e-3))
    array, sampling, read = recorded(made, 5.0, press=lambda t: 3.0 * t)
    assert sampling.skew == pytest.approx(np.tile(np.arange(12) * 2e-3, 6))
    lead = (read.counts - read.counts[:, :1]) / 3.0  # on a ramp, lateness is a lead in value
    assert lead == pytest.approx(np.tile(sampling.skew, (100, 1)), abs=1e-12)
    assert len(array) == 72


def test_cycles_are_regular_and_begin_anywhere_in_a_period_if_free_running():
    made = Electronics(delivery=Delivery(rate=40.0, free_running=True))
    array = made.manufacture(HEXAGON, rng())
    firsts = []
    for seed in range(300):
        time = array.sample_times(1.0, rng(seed)).time
        assert np.diff(time) == pytest.approx(1 / 40, rel=1e-9)
        assert len(time) == 40
        firsts.append(time[0])
    assert np.percentile(firsts, [5, 50, 95]) * 40.0 == pytest.approx([0.05, 0.5, 0.95], abs=0.06)


def test_stamps_are_late_by_the_delay_and_an_exponential_jitter():
    made = Electronics(delivery=Delivery(rate=20.0, delay=10e-3, jitter=1e-3))
    sampling = made.manufacture(HEXAGON, rng()).sample_times(500.0, rng(1), start_ns=10**18)
    late = (sampling.stamp_ns - 10**18) * 1e-9 - sampling.time
    quantiles = np.array([0.1, 0.25, 0.5, 0.75, 0.9, 0.99])
    expected = 10e-3 - 1e-3 * np.log1p(-quantiles)
    assert np.quantile(late, quantiles) == pytest.approx(expected, rel=0.02)
    exact = Electronics(delivery=Delivery(rate=20.0)).manufacture(HEXAGON, rng())
    stamps = exact.sample_times(2.0, rng(1)).stamp_ns
    assert (np.diff(stamps) == 50_000_000).all()


def test_stamps_never_fall_however_large_the_jitter():
    made = Electronics(delivery=Delivery(rate=100.0, jitter=50e-3))
    stamps = made.manufacture(HEXAGON, rng()).sample_times(20.0, rng(1)).stamp_ns
    assert (np.diff(stamps) >= 0).all()
    assert (np.diff(stamps) == 0).any()


def test_lost_readings_are_missing_rows():
    made = replace(ideal_electronics(), delivery=Delivery(rate=100.0, lost_readings=0.1))
    _, sampling, read = recorded(made, 200.0, press=lambda t: t)
    assert len(read) / len(sampling) == pytest.approx(0.9, abs=0.01)
    gaps = np.diff(read.stamp_ns) // 10_000_000
    assert np.mean(gaps == 2) == pytest.approx(0.1 * 0.9, abs=0.01)
    assert read.counts[:, 0] == pytest.approx(read.time + read.counts[0, 0], abs=1e-9)


@pytest.mark.parametrize("holds", [True, False])
def test_lost_messages_take_the_taxels_of_one_converter(holds):
    delivery = Delivery(rate=100.0, lost_messages=0.2, holds=holds)
    made = replace(ideal_electronics(), delivery=delivery)
    _, sampling, read = recorded(made, 100.0, press=lambda t: t)
    fresh = read.counts == sampling.time[:, None]
    by_module = fresh.reshape(-1, 6, 12)
    assert (by_module.all(axis=2) == by_module.any(axis=2)).all()
    assert by_module[:, :, 0].mean() == pytest.approx(0.8, abs=0.01)
    stale = ~fresh
    if holds:
        before = np.vstack([read.counts[:1], read.counts[:-1]])
        assert (read.counts[stale] == before[stale]).all()
    else:
        assert np.isnan(read.counts[stale]).all()


def test_a_logger_that_is_faster_than_the_board_repeats_its_readings():
    made = icub_electronics()
    made = replace(made, delivery=replace(made.delivery, logged_at=50.0))
    _, _, read = recorded(made, 60.0)
    assert read.rate == pytest.approx(50.0, rel=1e-3)
    assert np.diff(read.stamp_ns).std() == pytest.approx(43e3, rel=0.1)  # ns, as there
    quiet = estimate_baseline(read.counts, read.rate, quiet=slice(0, 1000))
    assert quiet.correlation == pytest.approx(2.5, abs=0.2)  # as on a real iCub's foot
    assert quiet.stretch.hold == pytest.approx(2.5, rel=0.15)


def test_a_recording_of_which_nothing_arrives_is_refused():
    with pytest.raises(InputError, match="delivered is False for all 20 readings"):
        recorded(Electronics(delivery=Delivery(lost_readings=1.0)), 1.0)


# ---- defects, as the fault finder sees them ------------------------------------------------------

PLANTED = {Defect.ABSENT: [3], Defect.DEAD: [10, 11], Defect.STUCK: [20], Defect.SATURATED: [30]}
FOUND = {
    Defect.NONE: Verdict.OK,
    Defect.ABSENT: Verdict.ABSENT,
    Defect.DEAD: Verdict.DEAD,
    Defect.STUCK: Verdict.STUCK,
    Defect.SATURATED: Verdict.SATURATED,
}


@pytest.mark.parametrize("make", [icub_electronics, cyskin_electronics])
def test_planted_defects_are_found_and_nothing_else(make):
    array, _, read = recorded(make(), 30.0, defects=PLANTED)
    faults = find_faults(read.counts, None, array.electronics.board.convention)
    expected = [FOUND[Defect(kind)] for kind in array.defect]
    assert faults.verdict.tolist() == expected, faults.sentences
    stop = array.stops_after[20] * 20.0
    assert faults.since[20] == pytest.approx(stop, abs=12)  # may hold its count by chance before
    assert (array.calibration.alive == (array.defect == Defect.NONE)).all()


def test_a_loose_joint_loses_all_capacitance_for_moments():
    defects = Defects(flickering=1.0, open_time=0.3, closed_time=1.2)
    made = Electronics(defects=defects, delivery=Delivery(rate=50.0))
    _, _, read = recorded(made, 200.0)
    open_ = read.counts == 255
    assert (read.counts[~open_] == 240).all()
    assert open_.mean() == pytest.approx(0.2, abs=0.01)
    openings = (np.diff(open_.astype(int), axis=0) == 1).sum(axis=0).mean()
    # Seen at 50 Hz, a chain of two states opens so often: P(closed) · P(open | closed before).
    expected = 0.8 * 0.2 * (1 - np.exp(-(1 / 0.3 + 1 / 1.2) / 50.0)) * len(read)
    assert openings == pytest.approx(expected, rel=0.05)


# ---- baseline and noise, as conditioning finds them ----------------------------------------------


def test_the_planted_baseline_and_noise_are_found():
    made = icub_electronics()
    made = replace(made, noise=replace(made.noise, flicker=0.0, walk=0.0))
    array, _, read = recorded(made, 60.0)
    board = made.board.convention
    found = estimate_baseline(read.counts, read.rate, seconds=50.0, convention=board)
    assert found.quiet, found.notes
    pull = (found.baseline - array.baseline) / np.hypot(found.uncertainty, 0.29)
    assert np.abs(pull).max() < 4.0
    assert 0.3 < pull.std() < 1.2
    truth = array.calibration.noise_std
    assert np.median(found.noise_std / truth) == pytest.approx(1.0, abs=0.03)
    assert np.abs(found.noise_std / truth - 1.0).max() < 0.15


def test_the_planted_drift_is_found():
    drift = ThermalDrift(per_kelvin=-1.0, taxel_spread=0.5)
    made = Electronics(drift=drift, noise=Noise(white=2.0))
    array = made.manufacture(HEXAGON, rng())
    temperature = 298.15 + np.linspace(0, 5, 1000)  # 5 K in 50 s, slow enough to pass for still
    counts = array.counts(np.zeros((1000, 72)), temperature, rng(1))
    found = estimate_baseline(counts, 20.0, quiet=slice(0, 1000))
    one_count = 1.0 / 33.3  # medians of thirds are whole counts, with some noise
    assert found.drift == pytest.approx(0.1 * array.drift, abs=1.3 * one_count)
    assert found.drift.mean() == pytest.approx(0.1 * array.drift.mean(), rel=0.05)


def test_the_noise_of_the_icub_board_is_the_paper_s():
    array, _, _ = recorded(icub_electronics(), 1.0, patch=generators.hexagon72())
    assert np.median(array.calibration.quantity_std()) == pytest.approx(0.020, abs=0.003)


def test_untouched_cyskin_rests_on_its_floor_as_recordings_do():
    made = replace(cyskin_electronics(), board=CySkinBoard())
    array, _, read = recorded(made, 100.0)
    assert 0.35 < (read.counts == 0).mean() < 0.65
    board = made.board.convention
    found = estimate_baseline(read.counts, read.rate, seconds=50.0, convention=board)
    assert np.median(found.noise_std) == pytest.approx(np.median(array.white_noise), rel=0.15)
