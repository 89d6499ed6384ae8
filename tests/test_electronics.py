"""Emulated electronics: the chain read backwards, and each effect by its statistics."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.signal import ICubByte
from skinfield.simulate.electronics import (
    CrossTalk,
    CySkinBoard,
    Defect,
    Defects,
    Delivery,
    Electronics,
    ICubBoard,
    LinearBoard,
    Noise,
    ThermalDrift,
    cyskin_electronics,
    icub_electronics,
    ideal_electronics,
)
from skinfield.simulate.electronics.delivery import wiring
from skinfield.skin import Patch, generators

HEXAGON = generators.icub_hexagon()
MANY = Patch(np.random.default_rng(0).uniform(0, 1, (2400, 2)))
BOARDS = [
    ICubBoard(),
    ICubBoard(convention=ICubByte(no_load=245, shift=0)),
    ICubBoard(convention=ICubByte(shift=5)),
    CySkinBoard(),
    LinearBoard(),
]
boards = pytest.mark.parametrize("board", BOARDS, ids=lambda b: type(b).__name__)


def rng(seed=0):
    return np.random.default_rng(seed)


def untouched(electronics, readings, patch=HEXAGON, seed=0):
    array = electronics.manufacture(patch, rng(seed))
    return array, array.counts(np.zeros((readings, len(patch))), None, rng(seed + 1))


# ---- the chain and its inverse -------------------------------------------------------------------


@boards
@given(
    seed=st.integers(0, 2**32 - 1),
    gain=st.floats(0, 0.5),
    base=st.floats(0, 20),
    size=st.floats(-0.9, 3),
)
def test_without_steps_the_true_calibration_inverts_the_chain(board, seed, gain, base, size):
    made = Electronics(board=board, quantised=False, gain_spread=gain, baseline_spread=base)
    array = made.manufacture(HEXAGON, rng(seed))
    change = size * rng(seed + 1).random((3, 72))
    back = array.calibration.relative_capacitance_from_counts(array.counts(change, None, rng()))
    np.testing.assert_allclose(back, change, rtol=0, atol=1e-9)


@boards
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(-0.05, 0.8))
def test_with_steps_it_inverts_within_half_a_step(board, seed, size):
    made = Electronics(board=board, gain_spread=0.2, converter_gain_spread=0.1, baseline_spread=3)
    array = made.manufacture(HEXAGON, rng(seed))
    change = size * rng(seed + 1).random((3, 72))
    counts = array.counts(change, None, rng())
    back = array.calibration.relative_capacitance_from_counts(counts)
    known = np.ones(counts.shape, bool)
    if board.convention is not None:
        assert (counts == np.rint(counts)).all()
        known = ~board.convention.saturated(counts) & (counts > board.convention.lowest)
    allowed = 0.5 * board.step / np.abs(array.gain) + 1e-9
    assert (np.abs(back - change) <= allowed)[known].all()


@given(st.lists(st.floats(-0.2, 1.5), min_size=12, max_size=12))
def test_bytes_are_those_of_the_firmware_in_whole_numbers(changes):
    board = ICubBoard(rest_capacitance=1024 * 0.25e-15, farads_per_count=0.25e-15)  # 1024 per unit
    array = Electronics(board=board).manufacture(generators.icub_triangle(), rng())
    sent = array.counts([changes], None, rng())[0]
    for change, byte in zip(changes, sent, strict=True):
        v = round(1024 * change)
        up, bottom = 15 << 2, 240 << 2
        assert byte == (255 if v <= -up else 0 if v >= bottom else 240 - (v >> 2))


@boards
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(-1, 50), noise=st.floats(0, 1e3))
def test_whatever_happens_a_board_sends_what_it_can(board, seed, size, noise):
    some = Defects(absent=0.1, dead=0.1, stuck=0.1, flickering=0.1, saturated=0.1)
    made = replace(icub_electronics(), board=board, defects=some)
    made = replace(made, noise=replace(made.noise, white=noise, walk=noise))
    array = made.manufacture(HEXAGON, rng(seed))
    change = size * rng(seed + 1).random((5, 72))
    counts = array.counts(change, 250.0 + 20.0 * np.arange(5), rng(seed + 2))
    assert (np.isnan(counts) == (array.defect == Defect.ABSENT)).all()
    shorted = counts[:, array.defect == Defect.SATURATED]
    if board.convention is not None:
        assert board.convention.saturated(shorted).all()
    sent = counts[~np.isnan(counts)]
    if board.convention is not None:
        assert (sent == np.rint(sent)).all()
        assert sent.min() >= board.convention.lowest
        assert sent.max() <= board.convention.highest


def test_the_ideal_readings_are_the_change_itself():
    array = ideal_electronics(rate=100.0).manufacture(HEXAGON, rng())
    change = rng(1).normal(size=(5, 72))
    assert (array.counts(change, np.linspace(250, 350, 5), rng(2)) == change).all()
    assert array.calibration.unit == "1"


# ---- reproducible, and each effect by itself -----------------------------------------------------


def test_a_seed_gives_the_same_skin_and_the_same_recording():
    change = 0.1 * rng(3).random((50, 72))
    for made in (icub_electronics(), cyskin_electronics()):
        first, second = (made.manufacture(HEXAGON, rng(7)) for _ in range(2))
        assert (first.counts(change, None, rng(8)) == second.counts(change, None, rng(8))).all()
        assert (first.counts(change, None, rng(9)) != second.counts(change, None, rng(8))).any()
        times = [a.sample_times(2.0, rng(1)).stamp_ns for a in (first, second)]
        assert (times[0] == times[1]).all()


def test_an_effect_switched_off_leaves_the_others_as_they_were():
    full = replace(icub_electronics(), defects=Defects(dead=0.2))
    array = full.manufacture(HEXAGON, rng(7))
    other = replace(full, gain_spread=0.0, converter_gain_spread=0.0, cross_talk=CrossTalk())
    without = other.manufacture(HEXAGON, rng(7))
    assert (without.gain == full.board.gain).all()
    for name in ("baseline", "drift", "white_noise", "defect"):
        assert (getattr(without, name) == getattr(array, name)).all(), name
    quiet = np.zeros((30, 72))
    assert (without.counts(quiet, None, rng(1)) == array.counts(quiet, None, rng(1))).all()
    flicker = replace(full, noise=replace(full.noise, flicker=0.0), quantised=False)
    walk = replace(full, noise=replace(full.noise, flicker=0.0, walk=0.0), quantised=False)
    levels = [m.manufacture(HEXAGON, rng(7)).counts(quiet, None, rng(1)) for m in (flicker, walk)]
    assert levels[0][0] == pytest.approx(levels[1][0], abs=1e-12)  # the walk starts at 0


# ---- spread, cross-talk --------------------------------------------------------------------------


def test_gains_are_lognormal_from_taxel_to_taxel_and_shared_by_a_converter():
    array = Electronics(gain_spread=0.1, converter_gain_spread=0.2).manufacture(MANY, rng(1))
    ratio = np.log(array.gain / array.electronics.board.gain).reshape(-1, 12)
    assert ratio.std(axis=1, ddof=1).mean() == pytest.approx(0.1, rel=0.05)
    assert ratio.mean(axis=1).std() == pytest.approx(np.hypot(0.2, 0.1 / 12**0.5), rel=0.15)


def test_baselines_spread_around_the_rest_of_the_board():
    array = Electronics(baseline_spread=2.0).manufacture(MANY, rng(1))
    assert array.baseline.std() == pytest.approx(2.0, rel=0.05)
    assert array.baseline.mean() == pytest.approx(240.375, abs=0.15)


def test_cross_talk_shows_on_the_stages_before_and_after_and_nowhere_else():
    made = replace(ideal_electronics(), cross_talk=CrossTalk(neighbours=0.02))
    array = made.manufacture(HEXAGON, rng())
    change = np.zeros((2, 72))
    change[0, 17], change[1, 24] = 1.0, 1.0
    shown = array.counts(change, None, rng())
    assert np.flatnonzero(shown[0]).tolist() == [16, 17, 18]
    assert shown[0, [16, 17, 18]] == pytest.approx([0.02, 1.0, 0.02])
    assert np.flatnonzero(shown[1]).tolist() == [24, 25]  # the first stage of its converter


def test_wiring_follows_modules_and_channels():
    wired = wiring(HEXAGON)
    assert (wired.converter == HEXAGON.module).all()
    assert (wired.stage == np.tile(np.arange(12), 6)).all()
    ten = wiring(generators.ten_pad_triangle())
    assert ten.stage.tolist() == [0, 1, 2, 3, 4, 5, 7, 8, 9, 11]
    assert [5, 6] not in ten.neighbours.tolist()  # the thermal pad lies between
    odd = Patch(rng().random((25, 2)), module=np.repeat([4, 9], [10, 15]))
    assert wiring(odd).stage.tolist() == [*range(10), *range(12), 0, 1, 2]
    assert wiring(odd).converters == 3


# ---- errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Electronics(gain_spread=-0.1), "gain_spread is -0.1, expected"),
        (lambda: Noise(white=-1.0), "white is -1.0, expected"),
        (lambda: CrossTalk(neighbours=0.7), "neighbours is 0.7, expected"),
        (lambda: ThermalDrift(reference=-3.0), "reference is -3.0, expected"),
        (lambda: Defects(dead=0.7, stuck=0.6), "probabilities sum to 1.3, expected at most 1"),
        (lambda: Delivery(rate=50.0, conversion_time=3e-3), "conversion_time is 0.003 s, expected"),
        (lambda: Delivery(lost_readings=2.0), "lost_readings is 2.0, expected"),
        (lambda: CySkinBoard(gain=-1.0), "gain is -1.0, expected"),
        (lambda: untouched(Electronics(), 0), "at least one reading"),
        (
            lambda: untouched(Electronics(), 1)[0].counts([[np.nan] * 72], None, rng()),
            r"change\[\(0, 0\)\] is nan",
        ),
        (lambda: untouched(Electronics(), 3)[0].counts(np.zeros((3, 71)), None, rng()), "change"),
        (
            lambda: untouched(Electronics(), 3)[0].counts(np.zeros((3, 72)), [300.0], rng()),
            "temperature has shape",
        ),
        (lambda: untouched(Electronics(), 3)[0].sample_times(0.0, rng()), "duration is 0.0"),
    ],
)
def test_errors_say_what_was_expected(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_defects_are_as_frequent_as_asked():
    made = Electronics(
        defects=Defects(absent=0.05, dead=0.1, stuck=0.15, flickering=0.2, saturated=0.25)
    )
    kinds = made.manufacture(MANY, rng()).defect
    share = [np.mean(kinds == kind) for kind in Defect]
    assert share == pytest.approx([0.25, 0.05, 0.1, 0.15, 0.2, 0.25], abs=0.03)
    assert (Electronics().manufacture(MANY, rng()).defect == Defect.NONE).all()


# ---- noise ---------------------------------------------------------------------------------------


def allan_deviation(series, group):
    """Of (T, L) readings in groups of `group`, (L,): half the mean square step of their means."""
    groups = len(series) // group
    means = series[: groups * group].reshape(groups, group, -1).mean(axis=1)
    return np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2, axis=0))


def levels(noise, readings, rate=20.0):
    made = Electronics(quantised=False, noise=noise, delivery=Delivery(rate=rate))
    array, counts = untouched(made, readings)
    return array, counts - array.baseline


def test_white_noise_has_its_deviation_per_taxel_and_no_memory():
    array, noise = levels(Noise(white=3.0, spread=0.5), 20000)
    assert noise.std(axis=0) == pytest.approx(array.white_noise, rel=0.03)
    assert array.calibration.noise_std == pytest.approx(array.white_noise)
    assert np.log(array.white_noise / 3.0).std() == pytest.approx(0.5, rel=0.25)
    assert abs(np.mean(noise[1:] * noise[:-1]) / np.mean(noise**2)) < 0.005
    for group in (1, 10, 100):
        expected = array.white_noise / np.sqrt(group)
        assert np.mean(allan_deviation(noise, group) / expected) == pytest.approx(1.0, abs=0.03)


def test_common_noise_is_shared_within_a_converter_only():
    _, noise = levels(Noise(white=1.0, common=2.0), 20000)
    ties = np.corrcoef(noise.T)
    same = wiring(HEXAGON).converter
    same = (same[:, None] == same) & ~np.eye(72, dtype=bool)
    assert ties[same] == pytest.approx(0.8, abs=0.02)
    assert abs(ties[~same & ~np.eye(72, dtype=bool)]).max() < 0.04


@pytest.mark.parametrize("rate", [5.0, 50.0])
def test_flicker_has_one_allan_deviation_at_all_averaging_times(rate):
    _, noise = levels(Noise(flicker=2.0), 20000, rate)
    expected = 2.0 * np.sqrt(2.0 * np.log(2.0) / np.pi)
    for group in (8, 32, 128, 512):
        assert np.mean(allan_deviation(noise, group)) == pytest.approx(expected, rel=0.06)


def test_a_walk_goes_with_the_square_root_of_time():
    made = Electronics(quantised=False, noise=Noise(walk=0.5), delivery=Delivery(rate=20.0))
    array, counts = untouched(made, 2001, MANY)
    away = counts - array.baseline
    assert (away[0] == 0).all()
    for seconds in (4.0, 25.0, 100.0):
        spread = away[int(20 * seconds)].std()
        assert spread == pytest.approx(0.5 * np.sqrt(seconds), rel=0.06)
    expected = 0.5 * np.sqrt(5.0 / 3.0)
    assert np.mean(allan_deviation(away, 100)) == pytest.approx(expected, rel=0.03)


# ---- warmth: drift with a lag, and the firmware's correction ------------------------------


def test_warmth_drifts_each_taxel_at_its_own_rate():
    drift = ThermalDrift(per_kelvin=0.5, converter_spread=0.2, taxel_spread=0.1)
    array = Electronics(quantised=False, drift=drift).manufacture(MANY, rng())
    temperature = 298.15 + np.array([0.0, 1.0, 10.0])
    counts = array.counts(np.zeros((3, 2400)), temperature, rng())
    rates = counts[1] - counts[0]
    assert counts[2] - counts[0] == pytest.approx(10 * rates, abs=1e-9)
    together = rates.reshape(-1, 12)
    assert rates.mean() == pytest.approx(0.5, abs=0.05)
    assert together.std(axis=1, ddof=1).mean() == pytest.approx(0.1, rel=0.05)
    assert together.mean(axis=1).std() == pytest.approx(0.2, rel=0.15)
    assert array.counts(np.zeros((1, 2400)), None, rng()) == pytest.approx(counts[:1], abs=1e-9)


def test_the_skin_lags_behind_its_surroundings():
    drift = ThermalDrift(per_kelvin=1.0, time_constant=30.0)
    made = Electronics(quantised=False, drift=drift, delivery=Delivery(rate=10.0))
    array = made.manufacture(HEXAGON, rng())
    temperature = np.full(1001, 308.15)
    temperature[0] = 298.15  # in balance with it at the start
    away = array.counts(np.zeros((1001, 72)), temperature, rng()) - array.baseline
    assert away[0] == pytest.approx(0.0, abs=1e-9)
    time = np.arange(1001) / 10.0
    assert away[:, 5] == pytest.approx(10.0 * (1.0 - np.exp(-time / 30.0)), abs=0.02)
