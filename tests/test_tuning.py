"""What can be changed of a running engine: settings, their limits, and what each of them does."""

import json

import numpy as np
import pytest
from engine_clock import engine_of, readings_of
from hypothesis import given
from hypothesis import strategies as st
from live_skins import cycle_of, pressed_counts, settings
from numpy.testing import assert_allclose, assert_array_equal
from scipy.signal import lfilter

from skinfield.errors import InputError
from skinfield.loop.control import order_of
from skinfield.loop.model_config import Configuration
from skinfield.loop.runtime_parameters import AUTO, Focus, Limits, Tuning
from skinfield.loop.slots import Slot
from skinfield.loop.update import Updater
from skinfield.reconstruct.engine.engine import prefer
from skinfield.signal import Blocks, Channels, Kind
from skinfield.solve import GaussianField, NonNegative

NOW, STEP = 10**18, 10_000_000  # ns
LIMITS = Limits(rungs=(10, 20), longest=9e-4, patches=("palm", "thumb"))
WINDOW = Focus(patch="thumb", low=(0.0, -1e-3), high=(2e-3, 1e-3))
PRESS_AT = (0.0, 7.5e-3)


@pytest.fixture(scope="module")
def made() -> Updater:
    return cycle_of(settings(), noise=0.004)


@pytest.fixture
def updater(made: Updater) -> Updater:
    made.forget()
    made.filters.tune(Tuning())
    return made


def answered(updater: Updater, readings: np.ndarray, first: int = 0) -> list[Slot]:
    """One cycle for each reading (N, 72) of bytes, `STEP` apart."""
    channels, blocks, slots = Channels(72), Blocks(1 << 12), []
    for place, counts in enumerate(readings):
        now = NOW + (first + place) * STEP
        blocks.clear()
        blocks.put(now, 0, counts, Kind.BYTES)
        channels.apply(blocks)
        slots.append(Slot.empty(updater.sizes))
        updater.answer(channels, now, slots[-1], reset=place == 0, budget=5.0)
    return slots


numbers = st.floats(0, 5, allow_subnormal=False)
tunings = st.builds(
    Tuning,
    resolution=st.sampled_from([AUTO, 10, 20]),
    deadline=st.floats(20e-6, 9e-4),
    threshold=numbers,
    smoothing=st.floats(0, 1),
    focus=st.none() | st.just(WINDOW),
)


@given(tuning=tunings)
def test_what_is_in_force_is_told_by_json(tuning: Tuning) -> None:
    assert LIMITS.check(tuning) == tuning
    plain = LIMITS.as_dict(tuning)
    values = {name: plain[name]["value"] for name in vars(tuning)}
    assert Tuning().changed(values) == tuning
    assert plain["off"] == {}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"resolution": 15}, "resolution is 15, expected 'auto' or one of 10, 20"),
        ({"resolution": True}, "resolution is True"),
        ({"deadline": 1e-3}, "deadline is 0.001, expected a number from 2e-05 to 0.0009"),
        ({"threshold": -1}, "threshold is -1"),
        ({"smoothing": float("nan")}, "smoothing is nan"),
        ({"smoothing": True}, "smoothing is nan"),
        ({"speed": 1}, "'speed' is no setting, expected one of resolution"),
        ({"focus": {"patch": "toe", "low": [0, 0], "high": [1, 1]}}, "focus.patch is 'toe'"),
        ({"focus": {"patch": "palm", "low": [0, 0], "high": [0, 1]}}, "expected more than low"),
        ({"focus": {"patch": "palm", "low": [0], "high": [0, 1]}}, "low is .0., expected a pair"),
        ({"focus": "palm"}, "expected patch, low and high"),
    ],
)
def test_what_no_engine_can_do_is_refused(changes: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        LIMITS.check(Tuning().changed(changes))


def test_what_cannot_be_changed_says_why() -> None:
    fixed = Limits(rungs=(10,), longest=1e-3, patches=("palm",), fixed="it is a replay")
    assert set(fixed.as_dict(Tuning())["off"].values()) == {"it is a replay"}
    with pytest.raises(InputError, match="nothing can be changed here: it is a replay"):
        fixed.check(Tuning())


@given(data=st.binary(max_size=80) | st.text(max_size=80).map(str.encode))
def test_any_bytes_are_no_order_or_one(data: bytes) -> None:
    what, values = order_of(data)
    assert isinstance(values, dict)
    assert what == "" or data.lstrip().startswith(b"{")


@given(tuning=tunings)
def test_a_configuration_survives_json(tuning: Tuning) -> None:
    for solver in (GaussianField(snr=7.0), NonNegative(tolerance=1e-3)):
        known = Configuration(3, solver, tuning)
        assert Configuration.from_dict(json.loads(json.dumps(known.as_dict()))) == known
    with pytest.raises(InputError, match="solver"):
        Configuration(1, object(), tuning).as_dict()  # type: ignore[arg-type]


def test_smoothing_is_a_low_pass_of_first_order(updater: Updater) -> None:
    readings = np.random.default_rng(4).integers(200, 241, (30, 72)).astype(float)
    plain = np.array([slot.values for slot in answered(updater, readings)])
    updater.forget()
    updater.filters.tune(Tuning(smoothing=0.03))
    smooth = np.array([slot.values for slot in answered(updater, readings)])
    part = 0.01 / (0.03 + 0.01)
    start = (1 - part) * plain[:1]
    expected, _ = lfilter([part], [1, part - 1], plain, axis=0, zi=start)
    assert_allclose(smooth, expected, rtol=1e-5, atol=1e-7)


def test_a_low_pass_begins_anew_after_a_pause_and_a_baseline(updater: Updater) -> None:
    readings = np.full((2, 72), 230.0)
    readings[1] = 210.0
    (raw,) = answered(updater, readings[1:])
    updater.filters.tune(Tuning(smoothing=0.5))
    assert abs(answered(updater, readings)[1].values - raw.values).min() > 0.05
    later = answered(updater, readings[1:], first=1000)[0]  # 10 s; readings count for 0.1 s
    assert_array_equal(later.values, raw.values)
    answered(updater, readings[:1], first=2000)
    updater.calibrate(np.tile([240.0, -171.0, 0.6, 1.0], (72, 1)))
    assert_array_equal(answered(updater, readings[1:], first=2001)[0].values, raw.values)


def test_weak_contacts_are_not_told(updater: Updater) -> None:
    strong, weak = pressed_counts(2.0, PRESS_AT), pressed_counts(0.5, (0.0, -9e-3))
    both = np.minimum(strong, weak)[None]
    slot = answered(updater, both)[0]
    rows = slot.used_contacts()
    assert len(rows) >= 2
    forces = rows["normal_force"]
    for threshold in (0.5 * (forces.min() + forces.max()), 2 * forces.max()):
        updater.forget()
        updater.filters.tune(Tuning(threshold=threshold))
        told = answered(updater, both)[0]
        names = ["x", "y", "normal_force", "area", "peak_pressure"]
        assert_array_equal(told.used_contacts()[names], rows[names][forces >= threshold])
        assert told.patches["force"][0] == pytest.approx(forces[forces >= threshold].sum())
        assert told.patches["answer"][0] == slot.patches["answer"][0]


def test_a_resolution_is_the_finest_there_is_and_a_focus_goes_beyond(updater: Updater) -> None:
    pressed = np.tile(pressed_counts(2.0, PRESS_AT), (3, 1))
    assert answered(updater, pressed)[-1].patches["rung"][0] == 20
    here = Focus(patch="hexagon72", low=(-5e-3, 3e-3), high=(5e-3, 12e-3))
    there = Focus(patch="hexagon72", low=(-5e-3, -12e-3), high=(5e-3, -3e-3))
    for focus, expected in ((None, 10), (there, 10), (here, 20)):
        updater.forget()
        updater.filters.tune(Tuning(resolution=10, focus=focus))
        rungs = [slot.patches["rung"][0] for slot in answered(updater, pressed)]
        assert rungs == [10, expected, expected]


def test_what_is_preferred_is_served_first_where_time_is_short() -> None:
    hot = {0, 1, 2, 3, 4}
    engine = engine_of(6, 500e-6)
    readings = readings_of(engine, hot)
    for first in (None, 3):
        prefer(engine, None, first)
        rungs = np.array(
            [[engine(readings).report[n].rung for n in engine.names] for _ in range(9)]
        )
        always = {p for p in hot if (rungs[:, p] == 16).all()}
        assert (3 in always) == (first == 3)
        assert (rungs[:, sorted(hot)] > 4).any(axis=0).all()  # nobody starves
    prefer(engine, 0, 3)
    rungs = [engine(readings).report[name].rung for name in engine.names]
    assert rungs[3] == 16
    assert {rungs[p] for p in hot - {3}} == {4}
    with pytest.raises(InputError, match="finest is 3"):
        prefer(engine, 3)
    with pytest.raises(InputError, match="first is 6"):
        prefer(engine, None, 6)


def test_an_engine_that_takes_over_knows_the_contacts_of_the_one_before(updater: Updater) -> None:
    pressed = np.tile(pressed_counts(2.0, PRESS_AT), (3, 1))
    before = answered(updater, pressed)[-1]
    (track,) = before.used_contacts()["track"]
    for resumed in (True, False):
        updater.forget()
        counted = np.array([100])
        updater.count_in(counted)
        if resumed:
            updater.resume(before)
        after = answered(updater, pressed[:1], first=3)[0]
        assert after.used_contacts()["track"].tolist() == [track if resumed else 101]
    assert counted[0] == 101
