"""Emulated electronics: the chain read backwards, and each effect by its statistics."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.signal import CySkinCount, ICubByte
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
    assert back == pytest.approx(change, abs=1e-9)


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
def test_steps_do_not_shift_the_mean(board):
    array = Electronics(board=board, noise=Noise(white=5.0 * max(board.step, 0.1))).manufacture(
        HEXAGON, rng()
    )
    counts = array.counts(np.full((20000, 72), 0.2), None, rng(1))
    expected = board.rest + 0.2 * board.gain
    assert counts.mean() == pytest.approx(expected, abs=0.02 * max(board.step, 0.1))


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


def test_conventions_are_those_of_the_boards():
    assert isinstance(icub_electronics().board.convention, ICubByte)
    assert isinstance(cyskin_electronics().board.convention, CySkinCount)
    assert icub_electronics().board.gain == pytest.approx(-171.0, abs=0.5)


def test_the_page_s_example_runs_and_gives_back_the_press():
    page = (Path(__file__).parents[1] / "docs" / "electronics.md").read_text(encoding="utf-8")
    names = {}
    (code,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    exec(compile(code, "electronics.md", "exec"), names)
    change, back, kept = names["change"], names["back"], names["sampling"].delivered
    held = (names["rec"].time > 3.0) & (names["rec"].time < 3.9)
    assert change.max() > 0.1
    assert back[held, 3].mean() == pytest.approx(change[kept][held, 3].mean(), abs=0.02)
