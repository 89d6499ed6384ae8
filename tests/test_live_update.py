"""One cycle: what sources send, from blocks to a slot, and what can be changed of it."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_skins import GAIN, LAYER, REST, Ticking, cycle_of, pressed_counts, settings
from numpy.testing import assert_allclose, assert_array_equal

import skinfield as sf
from skinfield.errors import InputError
from skinfield.estimate.row_contacts import CONTACT
from skinfield.loop.baseline import unrounded
from skinfield.loop.control import order_of
from skinfield.loop.intake import Intake
from skinfield.loop.model_config import Configuration, ModelConfig, bind
from skinfield.loop.runtime_parameters import AUTO, Focus, Limits, Tuning
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.status import plain_contacts
from skinfield.loop.update import Updater
from skinfield.reconstruct.diagnostics import Conditioner
from skinfield.reconstruct.engine.state import Answer
from skinfield.signal import (
    Blocks,
    Calibration,
    Channels,
    Count,
    ICubByte,
    Kind,
    Port,
    Status,
    blocks_of,
    counters,
)
from skinfield.solve import GaussianField, NonNegative

NOW = 10**18


@pytest.fixture(scope="module")
def made() -> Updater:
    return cycle_of(settings())


def fed(counts, stamp: int, status: Status = Status.OK, first: int = 0) -> Blocks:
    blocks = Blocks(1 << 12)
    blocks.put(stamp, first, counts, Kind.BYTES, status)
    return blocks


def test_values_are_those_of_the_conditioner(made) -> None:
    patch, rng = sf.layouts.hexagon72(), np.random.default_rng(3)
    counts = rng.integers(0, 256, 72).astype(float)  # clamps among them
    counts[:3] = 0, 255, 240
    known = Calibration(
        np.full(72, REST), np.full(72, -171.0), np.ones(72), np.ones(72, bool), patch.uid
    )
    expected = Conditioner(sf.Capacitance(), LAYER, known, ICubByte())(counts)
    channels, slot = Channels(72), CycleSlot.empty(made.sizes)
    channels.apply(fed(counts, NOW))
    made.answer(channels, NOW, slot, reset=True)
    assert_array_equal(slot.valid.astype(bool), np.isfinite(expected))
    assert_allclose(slot.values, np.nan_to_num(expected), rtol=1e-6)
    assert_array_equal(slot.counts, counts)


def test_a_press_is_found_where_it_is(made) -> None:
    channels, slot = Channels(72), CycleSlot.empty(made.sizes)
    channels.apply(fed(pressed_counts(1.0), NOW))
    assert made.answer(channels, NOW, slot, reset=True, budget=1.0)
    row = slot.used_contacts()[0]
    assert_allclose(row["position"][:2], (0.0, 7.5e-3), atol=2e-3)
    assert 0.5 < row["normal_force"] < 2.0
    assert slot.patches["answer"][0] == int(Answer.CONTACTS)
    assert slot.head[CycleHead.CONTACTS] == slot.patches["contacts"][0]
    nodes = int(slot.patches["rung"][0]) ** 2
    cell = sf.Grid.square(sf.layouts.hexagon72(), int(nodes**0.5)).pitch ** 2
    whole = slot.pressure[0, :nodes].sum() * cell  # a contact ends where its pressure is low
    assert 0.99 * slot.patches["force"][0] < whole < 1.6 * slot.patches["force"][0]


def test_a_press_without_time_is_found_in_cycles_without_a_reading(made) -> None:
    later = NOW + 10**12  # all before is forgotten
    channels, slot = Channels(72), CycleSlot.empty(made.sizes)
    channels.apply(fed(pressed_counts(1.0), later))
    assert made.answer(channels, later, slot, reset=True, budget=1e-6)
    assert slot.patches["answer"][0] == int(Answer.LINEAR)
    assert made.unfinished(later + 5 * 10**8) == {}  # not for long
    assert made.unfinished(later + 3 * 10**9) == {made.engine.names[0]: 3}
    channels.apply(fed(pressed_counts(1.0)[:36], later + 10**6))  # half of the next reading
    assert not made.answer(channels, later + 10**6, slot, budget=1.0)
    assert slot.patches["answer"][0] == int(Answer.CONTACTS)
    assert slot.patches["stamp_ns"][0] == later
    assert_allclose(slot.used_contacts()[0]["position"][:2], (0.0, 7.5e-3), atol=2e-3)
    assert made.unfinished(later + 3 * 10**9) == {}


def test_what_an_unfinished_search_has_not_found_is_no_drift(
    updater: Updater, monkeypatch: pytest.MonkeyPatch
) -> None:
    pressed, run, settled = pressed_counts(1.0), updater.engine.run, updater.engine.results.settled

    def unfinished(*args, **known):
        run(*args, **known)
        settled[:] = False

    before = updater._drift.known
    with monkeypatch.context() as patched:
        patched.setattr(updater.engine, "run", unfinished)
        slot = answered(updater, np.tile(pressed, (2, 1)))[-1]
        assert slot.patches["answer"][0] == int(Answer.CONTACTS)
        assert_array_equal(updater._drift.known, before)
    answered(updater, np.tile(pressed, (2, 1)), first=2)
    assert (updater._drift.known != before).any()


def test_half_a_reading_waits_for_the_other_half_but_not_for_ever(made) -> None:
    channels, slot = Channels(72), CycleSlot.empty(made.sizes)
    channels.apply(fed(np.full(72, 240), NOW))
    assert made.answer(channels, NOW, slot, reset=True)
    channels.apply(fed(np.full(36, 230), NOW + 10**6))
    assert not made.answer(channels, NOW + 10**6, slot)
    assert slot.patches["fresh"][0] == 0
    channels.apply(fed(np.full(36, 230), NOW + 2 * 10**6, first=36))
    assert made.answer(channels, NOW + 2 * 10**6, slot)
    channels.apply(fed(np.full(36, 230), NOW + 3 * 10**6))
    assert not made.answer(channels, NOW + 4 * 10**6, slot)
    assert made.answer(channels, NOW + 14 * 10**6, slot)
    assert slot.patches["fresh"][0] == 36


def test_a_patch_whose_turn_has_not_come_keeps_its_searched_answer() -> None:
    made = cycle_of(settings(solver=NonNegative()))
    channels, slot, found = Channels(72), CycleSlot.empty(made.sizes), []
    for cycle, budget in enumerate((1.0, 1e-6)):
        channels.apply(fed(pressed_counts(1.0 + cycle), NOW + cycle * 10**7))
        made.answer(channels, NOW + cycle * 10**7, slot, reset=not cycle, budget=budget)
        found.append((slot.patches["answer"][0], slot.patches["stamp_ns"][0]))
    assert found == [(Answer.FEASIBLE, NOW)] * 2
    assert made.engine.results.answer[0] == Answer.LINEAR


def test_rows_of_contacts_are_json_whatever_is_not_known() -> None:
    rows = np.zeros(2, CONTACT)
    for name in rows.dtype.names or ():
        if rows.dtype[name].base.kind == "f":
            rows[name][1] = np.nan
    first, second = json.loads(json.dumps(plain_contacts(["a"], rows), allow_nan=False))
    assert first["covariance"] == [0.0] * 6
    assert second["covariance"] == [None] * 6
    assert second["force_std"] is None


def test_an_answer_is_not_repeated_as_new_and_goes_when_it_is_too_old(made) -> None:
    channels, slot = Channels(72), CycleSlot.empty(made.sizes)
    channels.apply(fed(pressed_counts(1.0), NOW))
    made.answer(channels, NOW, slot, reset=True, budget=1.0)
    found = slot.used_contacts()
    assert not made.answer(channels, NOW + 10**6, slot)
    assert slot.head[CycleHead.FRESH] == 0
    assert slot.patches["stamp_ns"][0] == NOW
    assert slot.used_contacts().tobytes() == found.tobytes()  # also where something is not known
    assert not made.answer(channels, NOW + 2 * made.stale_ns, slot)  # a pause, as of a busy machine
    assert slot.used_contacts().tobytes() == found.tobytes()
    assert slot.patches["stamp_ns"][0] == NOW
    assert not made.answer(channels, NOW + 4 * made.stale_ns, slot)
    assert slot.patches["answer"][0] == int(Answer.MISSING)
    assert len(slot.used_contacts()) == 0


@pytest.mark.parametrize("pause", [0.02, 0.1, 0.7, 3.0])
def test_a_pause_of_readings_keeps_the_number_of_a_contact(made, pause: float) -> None:
    channels, slot, found = Channels(72), CycleSlot.empty(made.sizes), []
    stamp, step = NOW, 10**7
    for reading in range(12):
        stamp += step if reading != 6 else round(pause * 1e9)
        channels.apply(fed(pressed_counts(1.0), stamp))
        made.answer(channels, stamp, slot, reset=not reading, budget=1.0)
        found.append(slot.used_contacts()["track"].tolist())
    assert len(found[0]) == 1
    assert found == [found[0]] * 12
    channels.apply(fed(np.full(72, REST), stamp + step))  # let go: gone with the first reading
    made.answer(channels, stamp + step, slot, budget=1.0)
    assert slot.patches["answer"][0] == int(Answer.IDLE)
    assert len(slot.used_contacts()) == 0


def test_what_is_not_connected_is_left_out(made) -> None:
    channels, slot = Channels(72), CycleSlot.empty(made.sizes)
    channels.apply(fed(np.full(72, 240), NOW))
    channels.apply(fed(np.zeros(12), NOW, Status.NOT_CONNECTED))
    made.answer(channels, NOW, slot, reset=True)
    assert_array_equal(slot.valid[:12], 0)
    assert slot.patches["invalid"][0] == 12


def test_a_model_config_survives_json() -> None:
    model_config = ModelConfig.of(settings(), (Port("port", 72),))
    other = ModelConfig.from_json(model_config.to_json())
    assert (other.solver, other.layer, other.rungs) == (
        model_config.solver,
        model_config.layer,
        model_config.rungs,
    )
    assert_array_equal(other.skin[0].positions, model_config.skin[0].positions)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"skin": 1}', '{"skin": {"patches": [3]}}'])
def test_a_damaged_model_config_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"configuration|patches"):
        ModelConfig.from_json(text)


def test_a_patch_beyond_its_port_is_refused() -> None:
    skin = sf.Skin((sf.layouts.hexagon72(),))
    with pytest.raises(InputError, match="reads channel 71, expected channels below 60"):
        bind(skin, [Port("port", 60)])


def test_patches_find_the_ports_of_their_names() -> None:
    patches = [sf.Patch(np.eye(3)[:, :2] * 1e-2, name=name) for name in ("left", "right")]
    found = bind(sf.Skin(tuple(patches)), [Port("right", 5), Port("left", 3)])
    assert_array_equal(found.channel, [5, 6, 7, 0, 1, 2])
    with pytest.raises(InputError, match="'left' has no port"):
        bind(sf.Skin(tuple(patches)), [Port("right", 5), Port("other", 3)])


def test_a_baseline_is_not_rounded() -> None:
    rng, patch = np.random.default_rng(5), sf.layouts.hexagon72()
    level = 240.0 + rng.uniform(-0.5, 0.5, 72)
    counts = np.rint(level + rng.normal(0.0, 0.5, (400, 72)))
    counts[:, 7] = np.nan  # never answered
    counts[11, 9] = 100.0  # once, nobody knows why
    known = Calibration(
        np.median(counts, axis=0), np.full(72, -171.0), np.full(72, 0.3), np.arange(72) != 7,
        patch.uid,
    )  # fmt: skip
    baseline, noise = unrounded(counts, known)
    others = np.arange(72) != 7
    assert_allclose(baseline[others], level[others], atol=0.12)  # four standard errors
    assert np.abs(np.median(counts, axis=0) - level)[others].max() > 0.4
    assert_allclose(noise[others], np.hypot(0.5, 12**-0.5), rtol=0.2)


STEP = 10_000_000  # ns
LIMITS = Limits(rungs=(10, 20), longest=9e-4, patches=("palm", "thumb"))
WINDOW = Focus(patch="thumb", low=(0.0, -1e-3), high=(2e-3, 1e-3))
PRESS_AT = (0.0, 7.5e-3)


@pytest.fixture
def updater(made: Updater) -> Updater:
    made.forget()
    made.tune(Tuning())
    return made


def answered(updater: Updater, readings: np.ndarray, first: int = 0) -> list[CycleSlot]:
    """One cycle for each reading (N, 72) of bytes, `STEP` apart."""
    channels, blocks, slots = Channels(72), Blocks(1 << 12), []
    for place, counts in enumerate(readings):
        now = NOW + (first + place) * STEP
        blocks.clear()
        blocks.put(now, 0, counts, Kind.BYTES)
        channels.apply(blocks)
        slots.append(CycleSlot.empty(updater.sizes))
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
    updater.tune(Tuning(smoothing=0.03))
    from scipy.signal import lfilter

    smooth = np.array([slot.values for slot in answered(updater, readings)])
    part = 0.01 / (0.03 + 0.01)
    start = (1 - part) * plain[:1]
    expected, _ = lfilter([part], [1, part - 1], plain, axis=0, zi=start)
    assert_allclose(smooth, expected, rtol=1e-5, atol=1e-7)


def test_a_low_pass_begins_anew_after_a_pause_and_a_baseline(updater: Updater) -> None:
    readings = np.full((2, 72), 230.0)
    readings[1] = 210.0
    (raw,) = answered(updater, readings[1:])
    updater.tune(Tuning(smoothing=0.5))
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
        updater.tune(Tuning(threshold=threshold))
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
        updater.tune(Tuning(resolution=10, focus=focus))
        rungs = [slot.patches["rung"][0] for slot in answered(updater, pressed)]
        assert rungs == [10, expected, expected]


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


def test_contacts_keep_their_numbers_when_the_fit_follows_linear_answers(updater: Updater) -> None:
    places = [(-9e-3, 2e-3), (13e-3, 5e-3), (0.0, 13e-3), (4e-3, -12e-3)]
    pressed = REST + sum(pressed_counts(1.0, at) - REST for at in places)
    before = answered(updater, np.tile(pressed, (4, 1)))[-1]
    linear = cycle_of(settings(solver=GaussianField()))
    linear.count_in(np.array([4]))
    linear.resume(before)
    since = answered(linear, np.tile(pressed, (20, 1)), first=900)[-1]
    assert since.patches["answer"][0] == int(Answer.LINEAR)
    updater.take_over(linear, np.tile([REST, GAIN, 0.6, 1.0], (72, 1)))
    updater.recall(before)
    after = answered(updater, np.tile(pressed, (2, 1)), first=1100)[-1]
    assert after.patches["answer"][0] == int(Answer.CONTACTS)
    known = []
    for slot in before, since, after:
        rows = slot.used_contacts()
        x, y = rows["x"][:, None], rows["y"][:, None]
        nearest = np.hypot(x - np.array(places)[:, 0], y - np.array(places)[:, 1]).argmin(axis=1)
        known.append(dict(zip(nearest.tolist(), rows["track"].tolist(), strict=True)))
    assert known == [known[0]] * 3
    assert sorted(known[0].values()) == [1, 2, 3, 4]
    assert_allclose(after.used_contacts()["age"], (1101 * STEP) * 1e-9, atol=1e-6)


@pytest.mark.parametrize(("gone", "same"), [(0.05, True), (0.3, False)])
def test_a_touch_comes_back_under_its_number_while_the_tracker_waits(
    updater: Updater, gone: float, same: bool
) -> None:
    pressed, rest = pressed_counts(2.0, PRESS_AT), np.full(72, REST)
    idle = round(gone * 1e9 / STEP)
    slots = answered(updater, np.stack([pressed] * 3 + [rest] * idle + [pressed] * 2))
    tracks = [slot.used_contacts()["track"].tolist() for slot in slots]
    assert tracks[3 : 3 + idle] == [[]] * idle
    assert tracks[2] == tracks[0] != []
    assert (tracks[-1] == tracks[0]) == same


SECOND = 10**9


@dataclass(eq=False)
class Played:
    """A source that does at each poll what it is told: numbers of readings, or an exception."""

    script: list[object] = field(default_factory=list)
    opened: int = 0

    def open(self) -> "Played":
        self.opened += 1
        self.up, self.counters, self.index = True, counters(), 0
        self.ports: Sequence[Port] = (Port("port", 4),)
        return self

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        what = self.script.pop(0) if self.script else 0
        if isinstance(what, Exception):
            raise what
        for _ in range(int(what)):  # type: ignore[call-overload]
            blocks.put(now_ns, channel, [1, 2, 3, 4], Kind.BYTES)
            self.counters[Count.RECEIVED] += 1
        return int(what)  # type: ignore[call-overload]

    def filenos(self) -> Sequence[int]:
        return ()

    def close(self) -> None:
        self.up = False


def source_news(intake: Intake) -> list[tuple[int, int]]:
    """Sources that went (0) or came (1) in the last poll."""
    found = blocks_of(intake.blocks.data)
    return [(b.channel, int(b.payload[0])) for b in found if b.kind == Kind.SOURCE]


def test_a_driver_that_raises_costs_itself_only() -> None:
    bad, good = Played([1, ValueError("oops"), 0, 1]), Played([1, 1, 1, 1])
    intake = Intake([bad, good])
    assert intake.poll(SECOND) == 2
    assert intake.poll(SECOND + 1) == 1
    assert source_news(intake) == [(0, 0)]
    assert intake.sentences() == ["Played: ValueError: oops"]
    assert not intake.members[0].up
    assert intake.poll(SECOND + 2) == 1  # too early to try again
    intake.poll(2 * SECOND)
    assert source_news(intake) == [(0, 1)]
    assert bad.opened == 2
    counted = intake.members[0].counters
    intake.poll(2 * SECOND + 1)
    assert counted[Count.REOPENED] == 1
    assert counted[Count.DOWN_NS] == SECOND - 1
    assert intake.sentences() == []


def test_boards_that_fall_silent_are_away_until_they_speak() -> None:
    intake = Intake([Played([0, 1, 0, 0, 0, 1, 1])])
    log = []
    for now in (0.5, 1.0, 1.9, 2.1, 4.0, 4.5, 4.6):
        intake.poll(int(now * SECOND))
        log.append(source_news(intake))
    assert log == [[], [], [], [(0, 0)], [], [(0, 1)], []]
    counted = intake.members[0].counters
    assert counted[Count.DOWN_NS] == 3.5 * SECOND
    assert counted[Count.REOPENED] == 1


def test_one_that_never_spoke_is_not_said_to_have_gone() -> None:
    intake = Intake([Played()])
    for now in range(1, 20):
        intake.poll(now * SECOND)
        assert source_news(intake) == []


def test_a_broken_wire_is_told_by_its_stream_alone() -> None:
    source = Played([1])
    intake = Intake([source])
    intake.poll(SECOND)
    source.up = False
    for now in range(2, 6):
        intake.poll(now * SECOND)
        assert source_news(intake) == []
    assert intake.members[0].counters[Count.DOWN_NS] == 0


def test_counts_go_on_from_those_of_an_engine_before() -> None:
    intake = Intake([Played([1, 1])])
    intake.poll(1)
    table = np.zeros((1, len(Count)), np.int64)
    table[0, Count.RECEIVED], table[0, Count.LOST] = 100, 7
    intake.count_in(table)
    intake.poll(2)
    assert table[0, Count.RECEIVED] == 102
    assert table[0, Count.LOST] == 7


def test_channels_of_several_sources_lie_one_after_the_other() -> None:
    intake = Intake([Played([1]), Ticking(3, period=0.0)])
    intake.poll(SECOND)
    assert_array_equal(intake.channels.counts[:4], [1, 2, 3, 4])
    assert np.isfinite(intake.channels.counts[4:]).all()
    assert len(intake.channels) == 7


class Awkward(Played):
    """A driver that raises not only where it is polled."""

    awkward = ""

    def __getattribute__(self, name: str) -> object:
        if name == object.__getattribute__(self, "awkward"):
            raise RuntimeError(f"no {name}")
        return super().__getattribute__(name)


@pytest.mark.parametrize("where", ["up", "ports"])
def test_wherever_a_driver_raises_it_costs_itself_only(where: str) -> None:
    bad, good = Awkward([1, 0, 0, 1]), Played([1] * 9)
    intake = Intake([bad, good])
    intake.poll(SECOND)
    bad.awkward = where
    if where == "ports":
        bad.script = [ValueError("oops")]
    for now in range(2, 6):
        assert intake.poll(now * SECOND) >= 1
    assert bad.opened > 1


def test_all_are_closed_though_one_cannot() -> None:
    bad, good = Awkward(), Played()
    intake = Intake([bad, good])
    bad.awkward = "close"
    intake.close()
    assert not good.up
    assert intake.members[0].failure == "when it was closed, RuntimeError: no close"
    intake.close()


def test_notes_that_cannot_be_read_are_told() -> None:
    source = Awkward([1])
    intake = Intake([source])
    source.awkward = "notes"
    assert intake.sentences() == ["Awkward: RuntimeError: no notes"]


def test_damaged_blocks_end_no_cycle() -> None:
    source = Played([1])
    intake = Intake([source])
    source.poll = lambda blocks, channel, now: blocks.put(now, 3, [1, 2], Kind.BYTES) or 1  # type: ignore[method-assign]
    assert intake.poll(SECOND) == 1
    assert intake.damaged > 0
    assert np.isnan(intake.channels.counts).all()
