"""Replays of recordings: any time of them, at any pace, exactly as it was."""

import json
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from command_line import invoke, run
from live_skins import settings, unique_name, wait_for
from mcap_sample import write as write_other
from numpy.testing import assert_array_equal
from recorder_ring import FakeFit, contact
from replay_sample import NOISE, PERIOD, ROWS, START, Known, level, write

import skinfield as sf
from skinfield.errors import FileError, InputError
from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.live import LiveRecording
from skinfield.loop import fit_ring
from skinfield.loop.client import connect
from skinfield.loop.fit_ring import LAYOUT, FitReader, Fitted
from skinfield.loop.model_config import Configuration, ModelConfig, Models
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import Observer
from skinfield.page.replay import LATE, Clock, RecordingSource
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.source import EngineView, merged_view
from skinfield.page.updates import Updates
from skinfield.record import drain as recorder_drain
from skinfield.record.drain import FitDrain
from skinfield.record.queue import Queue
from skinfield.record.recover import recover
from skinfield.record.replay import Published, RecordedCycle, Replay, ReplayFit, is_sound, slot_of
from skinfield.record.state import RecorderState
from skinfield.signal import Port

Made = tuple[Path, list[Known]]
CYCLES, TARED = 320, 170
COUNT = 340  # cycles, with a fit beside them
WHOLE = 1e9 / PERIOD  # cycles in a second
PATCH = sf.layouts.hexagon72()
NODES, LATER = 400, PERIOD // 2  # ns from a cycle to what the fit publishes after it


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    path = tmp_path_factory.mktemp("feed") / "touch.mcap"
    return path, write(path, CYCLES, tared_at=TARED)


@pytest.fixture(scope="module")
def replay(made: Made) -> Replay:
    return Replay(made[0])


@pytest.fixture(scope="module")
def opened(made: Made) -> Iterator[RecordingSource]:
    with closing(RecordingSource(made[0], playing=False)) as feed:
        assert not feed.playing
        yield feed


@pytest.fixture
def feed(opened: RecordingSource) -> RecordingSource:
    """A feed that stands still."""
    opened.pause()
    opened.set_speed(1.0)
    wait_for(lambda: opened.sought)
    return opened


def went(feed: RecordingSource, t_s: float) -> Snapshot:
    """What is shown after a seek."""
    feed.seek(t_s)
    wait_for(lambda: feed.sought)
    found = feed.latest()
    assert found is not None
    return found


def assert_slot_is(slot: CycleSlot, known: Known) -> None:
    """Everything as it was live, to the last bit."""
    assert slot.patches.tobytes() == known.patches
    assert slot.used_contacts().tobytes() == known.contacts
    assert slot.values.tobytes() == known.values
    nodes = len(known.pressure) // 4
    assert slot.pressure[0, :nodes].tobytes() == known.pressure


def assert_is(found: Snapshot, known: Known) -> None:
    """The same, of what a page is shown."""
    assert found.number == known.number
    assert_slot_is(found.slot, known)


# cycle by cycle


def test_every_cycle_is_as_it_was(made: Made, replay: Replay) -> None:
    count = 0
    for each, known in zip(replay, made[1], strict=True):
        assert each.cycle.number == known.number
        assert each.fresh
        assert_slot_is(each.slot, known)
        count += 1
    assert count == replay.index.cycles == CYCLES
    assert replay.recording.damage == []


def test_between_fields_the_newest_holds(tmp_path: Path) -> None:
    path = tmp_path / "seldom.mcap"
    known = write(path, 60, every=7)
    for each in Replay(path):
        its, shown = known[each.cycle.number], known[each.cycle.number // 7 * 7]
        assert each.cycle.patches.tobytes() == its.patches
        assert each.slot.used_contacts().tobytes() == its.contacts
        assert each.slot.values.tobytes() == shown.values
        side = int(each.slot.patches["rung"][0])
        if each.slot.patches["answer"][0] > 1 and shown.pressure:
            assert each.slot.pressure[0, : side * side].tobytes() == shown.pressure


def test_without_fields_contacts_are_shown_alone(tmp_path: Path) -> None:
    path = tmp_path / "none.mcap"
    known = write(path, 30, every=1000, first=5)
    found = [(each.slot.used_contacts().tobytes(), each.slot.valid.any()) for each in Replay(path)]
    assert found == [(each.contacts, False) for each in known[5:]]


def test_calibration_and_settings_are_those_of_the_time(replay: Replay, tmp_path: Path) -> None:
    before, after = (replay.tare(START + place * PERIOD) for place in (TARED - 1, TARED))
    assert_array_equal(after.calibration[:, 0], before.calibration[:, 0] + 0.25)
    assert_array_equal(replay.models(START).noise_std, NOISE)
    path, solver = tmp_path / "tuned.mcap", sf.NonNegative(tolerance=0.5)

    def beside(writer: RecordingWriter, slot: CycleSlot, number: int) -> None:
        wall = START + number * PERIOD
        known = Configuration(number // 10, solver, Tuning(threshold=0.01 * number)).as_dict()
        if number in (10, 20):
            writer.event(wall, "settings", "", **known)
        if number == 25:
            writer.event(wall, "settings", "")
            writer.event(wall, "settings", "", **(known | {"solver": {"a": 1}}))

    write(path, 30, beside=beside)
    found = Replay(path)
    told = [found.config_at(START + place * PERIOD) for place in (9, 10, 19, 20, 29)]
    assert [each.configuration.tuning.threshold for each in told] == [0.0, 0.1, 0.1, 0.2, 0.2]
    assert [each.configuration.generation for each in told] == [1, 1, 1, 2, 2]
    assert told[-1].configuration.solver == solver
    assert found.models(START + 29 * PERIOD).model_config.solver == solver
    assert found.models(START).model_config.solver == found.model_config.solver
    assert len(found.recording.damage) == 2  # without a tuning, or a solver
    assert all("make no sense" in each.why for each in found.recording.damage)


def test_rows_of_another_skin_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "wrong.mcap"

    def beside(writer: RecordingWriter, slot: CycleSlot, number: int) -> None:
        if number == 10:
            told = slot.recorded(1000)
            many, other = told.patches.copy(), told.patches.copy()
            many["contacts"], other["rung"] = 9, 11_000
            for wrong in (told.patches[:0], many, other):
                changed = replace(told, patches=wrong, contacts=told.contacts[:0])
                writer.write("/skin/cycles", told.wall_ns, ROWS.encode(changed))

    write(path, 20, beside=beside)
    found = Replay(path)
    assert [each.cycle.number for each in found] == list(range(20))
    assert "cycle 1000 has" in str(found.recording.damage)


def test_what_is_no_recording_of_a_skin_says_so(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    RecordingWriter(path, (), layout=ROWS).close()
    with pytest.raises(FileError, match="encloses no configuration"):
        Replay(path)
    write_other(tmp_path / "plain.mcap")
    with pytest.raises(FileError, match="cannot be used"):
        Replay(tmp_path / "plain.mcap")
    write(path, 0)
    with pytest.raises(FileError, match=r"has no cycle.*skinfield export"):
        Replay(path)


# for other programs


def test_it_can_be_looked_at_as_a_running_skin(made: Made, replay: Replay) -> None:
    with closing(Published(unique_name(), replay)) as published:
        for each in replay.from_time(START + (TARED + 10) * PERIOD):
            published.put(each)
            if each.cycle.number >= 200:
                break
        with connect(published._ring.name) as live:
            found = live.latest()
            assert found.contacts.tobytes() == made[1][200].contacts
            assert found.age < 60.0
            assert live.reader.status_view["tares"][0] == 2  # at the beginning, and then
            said = Observer(live.reader).look().as_dict()
            assert said["state"] == "running"
            assert "nothing can be changed" in str(said) or "replay" in str(said["tuning"]["off"])
            with pytest.raises(InputError, match="nothing can be changed here"):
                live.tune(threshold=0.1)


def test_lines_of_json_say_what_each_cycle_said(made: Made) -> None:
    done = invoke(["replay", made[0], "--headless", "--json"])
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert [each["cycle"] for each in lines] == list(range(CYCLES))
    assert [each["time_s"] for each in lines] == [round(k / WHOLE, 6) for k in range(CYCLES)]
    assert [each["force"] for each in lines] == [each.force for each in made[1]]
    contacts = np.frombuffer(made[1][118].contacts, ROWS.contact)
    forces = [each["normal_force"] for each in lines[118]["contacts"]]
    assert forces == contacts["normal_force"].tolist()
    assert lines[118]["contacts"][0]["patch"] == "hexagon72"
    assert f"{CYCLES} cycles, {CYCLES} with new readings" in run("replay", made[0], "--headless")


def test_a_pace_is_kept(made: Made) -> None:
    began = time.monotonic()
    run("replay", made[0], "--headless", "--speed", "10", "--duration", "100")
    assert time.monotonic() - began > (CYCLES - 1) / WHOLE / 10


# as a feed of the page


def test_a_seek_while_paused_shows_exactly_that_cycle(made: Made, feed: RecordingSource) -> None:
    known = made[1]
    for place in (118, 0, 51, 60, 149, 250, TARED, TARED - 1, 299, 319):
        assert_is(went(feed, place / WHOLE), known[place])
        assert feed.time_s == pytest.approx(place / WHOLE)
    last = went(feed, 250 / WHOLE)
    between = went(feed, 117.4 / WHOLE)
    assert feed.latest() is between  # nothing is new
    assert_is(last, known[250])  # still
    assert_is(between, known[118])  # the first one from then on
    assert between.age == pytest.approx(1e-6)  # by the time of the replay
    assert between.slot.head[CycleHead.WALL_NS] == known[118].wall_ns
    assert between["hexagon72"].pressure.max() > 1e3


def test_it_says_what_happened(feed: RecordingSource) -> None:
    assert feed.start_s == 0.0
    assert feed.end_s == pytest.approx((CYCLES - 1) / WHOLE)
    assert feed.events == [(pytest.approx(TARED / WHOLE), "the baseline was taken anew")]
    assert feed.gaps == []
    assert went(feed, 0.9).number == 90
    assert feed.status()["notes"] == {"replay": "0.90 s of 3.19 s"}


def test_it_begins_to_play_at_once_and_closing_ends_its_thread(made: Made) -> None:
    opened = RecordingSource(made[0])
    wait_for(lambda: opened.sought)
    assert opened.playing
    assert opened.speed == 1.0
    for _ in range(2):
        opened.close()
        assert not opened._thread.is_alive()


def test_it_plays_faster_and_stops_at_the_end(feed: RecordingSource) -> None:
    seen: list[Snapshot] = []
    went(feed, 1.0)
    feed.set_speed(10.0)
    feed.play()

    def plays() -> bool:
        found = feed.latest()
        if found is not None and (not seen or found.number != seen[-1].number):
            seen.append(found)
        return not feed.playing

    wait_for(plays)
    numbers = [each.number for each in seen]
    assert numbers == sorted(numbers)
    assert len(numbers) > 3
    assert feed.time_s == pytest.approx(feed.end_s)
    status = feed.status()
    assert status["state"] == "paused"
    assert status["since_start"]["cycles"] > 200
    assert status["rate"] == pytest.approx(WHOLE, rel=0.2)
    feed.play()  # from the beginning
    wait_for(lambda: feed.playing and feed.sought)
    assert feed.time_s < feed.end_s


def test_pause_and_play_go_on_from_where_it_is(feed: RecordingSource) -> None:
    went(feed, 1.0)
    feed.play()
    wait_for(lambda: feed.time_s > 1.05)
    feed.pause()
    stands = feed.time_s
    number = feed.latest().number  # type: ignore[union-attr]
    time.sleep(0.05)
    assert feed.time_s == pytest.approx(stands, abs=2 / WHOLE)
    feed.play()
    wait_for(lambda: feed.latest().number > number)  # type: ignore[union-attr]


def test_the_newest_of_many_seeks_wins(made: Made, feed: RecordingSource) -> None:
    for place in range(60, 300, 3):
        feed.seek(place / WHOLE)
    assert_is(went(feed, 222 / WHOLE), made[1][222])


def test_what_makes_no_sense_is_refused(feed: RecordingSource) -> None:
    for wrong in (0.0, 11.0, float("nan")):
        with pytest.raises(InputError, match="speed"):
            feed.set_speed(wrong)
    with pytest.raises(InputError, match="t_s is nan"):
        feed.seek(float("nan"))
    feed.seek(-5.0)
    feed.seek(1e9)  # there are no times beyond the ends
    wait_for(lambda: feed.sought)
    assert feed.time_s == pytest.approx(feed.end_s)


# files that are not whole


def test_a_cut_file_is_shown_as_far_as_it_goes(made: Made, tmp_path: Path) -> None:
    data = made[0].read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    with closing(RecordingSource(cut, playing=False)) as opened:
        assert 1.0 < opened.end_s < CYCLES / WHOLE
        assert_is(went(opened, 1.1), made[1][110])
        assert "cut" in opened.status()["notes"]["damage"][0]
        assert opened.end_s == pytest.approx(went(opened, 1e9).number / WHOLE)


def test_a_gap_is_told(tmp_path: Path) -> None:
    path = tmp_path / "parts.mcap"
    known = write(path, 160, first=33, without=range(130, 138))
    with closing(RecordingSource(path, playing=False)) as opened:
        assert opened.gaps == [pytest.approx((0.96, 1.05))]
        assert_is(went(opened, 0.9), known[123])
        assert "missing from 0.96 s to 1.05 s" in opened.status()["notes"]["replay"]
        assert_is(went(opened, 1.0), known[138])  # the first one from then on


def test_other_recordings_are_for_reconstruct(tmp_path: Path) -> None:
    table = tmp_path / "counts.csv"
    rows = "\n".join(f"{0.01 * k:.2f},{k % 7},{k % 5}" for k in range(50))
    table.write_text("time_s,taxel_0,taxel_1\n" + rows + "\n")
    with pytest.raises(FileError, match="skinfield reconstruct"):
        RecordingSource(table)
    (tmp_path / "nothing.txt").write_text("hello")
    for wrong in (tmp_path / "nothing.txt", tmp_path / "absent.mcap"):
        with pytest.raises(FileError, match=wrong.name):
            RecordingSource(wrong)


def test_what_goes_wrong_later_is_told(
    feed: RecordingSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(time_ns: int) -> Iterator[RecordedCycle]:
        raise FileError("the disk is gone")

    monkeypatch.setattr(feed.replay, "from_time", broken)
    feed.seek(1.0)
    status = wait_for(lambda: feed.status()["state"] == "failed" and feed.status())
    assert status["notes"]["failed"] == "the disk is gone"
    assert not feed.playing


def test_a_clock_does_not_make_up_for_what_takes_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr("skinfield.page.replay.time.monotonic", lambda: now[0])
    clock = Clock(playing=True)
    clock.set_speed(2.0)
    clock.begin(START)
    left = lambda seconds: clock.left(START + round(seconds * 1e9))
    assert left(1.0) == pytest.approx(0.5)
    now[0] += 0.5 + LATE / 2
    assert left(1.0) == pytest.approx(-LATE / 2)
    assert not clock.behind
    now[0] += LATE
    assert left(1.0) < 0.0
    assert clock.behind
    assert left(2.0) == pytest.approx(0.5)  # from here on
    clock.pause()
    assert left(1.0) == np.inf
    now[0] += 50.0
    clock.play()
    assert left(3.0) == 0.0


# with a fit beside the engine


class Page:
    """A live page, a fit and a recorder's reader of it, beside the cycles of a recording."""

    def __init__(self) -> None:
        made = settings()
        self.models = Models(ModelConfig.of(made, (Port("port", 72),)), np.full(len(PATCH), NOISE))
        self.name, self.now_ns = unique_name(), 0
        self.clock = SimpleNamespace(time_ns=lambda: self.now_ns)
        self.reader, self.queue = FitReader(self.name), Queue(1 << 24, RecorderState())
        self.drain = FitDrain(self.name, self.queue, (PATCH.name,), NODES)
        self.fit: FakeFit | None = None
        self.seen: list[EngineView] = []

    def __call__(self, writer: RecordingWriter, slot: CycleSlot, number: int) -> None:
        """Look as the page does; then the fit goes on, and what it says is recorded."""
        own = replace(slot, **{f.name: getattr(slot, f.name).copy() for f in fields(CycleSlot)})
        told = own.recorded(number)
        snapshot = Snapshot(own, number, self.models, told.wall_ns)
        found = self.reader.latest()
        self.seen.append(kept(merged_view(snapshot, found)))
        self.now_ns = told.wall_ns + LATER
        self._go_on(number, snapshot)
        self.drain.take()
        for each in self.queue.take(0.0):
            each.write(writer)

    def _go_on(self, number: int, snapshot: Snapshot) -> None:
        if number in (60, 230):
            self.fit = FakeFit(self.name, (PATCH.name,), NODES)
        if number == 200 and self.fit is not None:
            self.fit.close()
            self.fit = None
        silent = 251 < number < 318  # so that it is too far behind
        if self.fit is None or (number % 7 and number != 251) or silent:
            return
        engine, stamp = snapshot.contacts, int(snapshot.patches["stamp_ns"][0])
        field = np.zeros(NODES, np.float32)
        field[number : number + 30] = np.linspace(10.0, 1e4, 30)
        how: dict[str, Any] = {"stamp_ns": stamp, "told_ns": self.now_ns, "engine": engine}
        if number in (126, 182, 336):
            self.fit.tell(state=Fitted.UNHELPFUL, **how)
        elif number in (91, 161):
            self.fit.tell(state=Fitted.NOTHING, **how)
        else:
            better = engine.copy()
            better["normal_force"] *= 0.7
            weak = contact(-12e-3, -3e-3, 0.2, track=1_000_001)  # the engine does not see it
            touched = int(len(engine) > 0)
            self.fit.tell(better, weak, pressure=field, touched=touched, **how)


def kept(seen: EngineView) -> EngineView:
    """The same in memory of its own: rows of a reader last until it reads again."""
    return seen._replace(contacts=np.array(seen.contacts))


class Fit(NamedTuple):
    path: Path
    seen: list[EngineView]


@pytest.fixture(scope="module", name="fit")
def _fit(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fit]:
    path, page = tmp_path_factory.mktemp("fit") / "touch.mcap", Page()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit_ring, "AGAIN", 0.0)  # s between looks for a ring
        patch.setattr(recorder_drain, "time", page.clock)
        write(path, COUNT, beside=page)
    yield Fit(path, page.seen)
    page.reader.close()
    page.drain.close()
    page.fit.close()


@pytest.fixture(scope="module", name="fitted")
def _fitted(fit: Fit) -> Iterator[RecordingSource]:
    with closing(RecordingSource(fit.path, playing=False)) as opened:
        wait_for(lambda: opened.sought)
        yield opened


def assert_same(found: EngineView, live: EngineView) -> None:
    """Contacts, who says them, and the fit's field, to the last bit."""
    assert found.contacts.tobytes() == live.contacts.tobytes()
    assert list(found.by) == list(live.by)
    first, second = (
        None if each.fit is None else each.fit.get(PATCH.name) for each in (found, live)
    )
    assert first is second is None or first.tobytes() == second.tobytes()


def saw(feed: RecordingSource, number: int) -> EngineView:
    """What is seen after a seek."""
    assert went(feed, number / WHOLE).number == number
    return feed.view()


def test_the_page_saw_what_is_to_be_shown_again(fit: Fit) -> None:
    counts = Counter(tuple(sorted(each.by)) for each in fit.seen)
    assert counts["fit", "fit"] > 50
    assert counts["engine",] > 50
    assert counts[("fit",)] > 0  # where the engine sees nothing
    assert sum(each.fit is not None for each in fit.seen) > 60


def test_every_cycle_is_seen_as_it_was_live(fit: Fit) -> None:
    replay = Replay(fit.path)
    its = ReplayFit(replay)
    for each, live in zip(replay, fit.seen, strict=True):
        wall_ns, number = each.cycle.wall_ns, each.cycle.number
        snapshot = Snapshot(each.slot, number, replay.models(wall_ns), wall_ns)
        assert_same(merged_view(snapshot, its.at(wall_ns)), live)
    assert replay.recording.damage == []


@pytest.mark.parametrize("order", [1, -1], ids=["forwards", "backwards"])
def test_from_any_time_on_the_same_is_seen(fit: Fit, fitted: RecordingSource, order: int) -> None:
    places = (52, 61, 64, 71, 78, 100, 127, 199, 202, 231, 239, 260, 299, 330, 339)
    for number in places[::order]:
        assert_same(saw(fitted, number), fit.seen[number])


def test_while_it_plays_ten_times_as_fast_the_same_is_seen(
    fit: Fit, fitted: RecordingSource
) -> None:
    saw(fitted, 60)
    fitted.set_speed(10.0)
    fitted.play()
    seen: dict[int, EngineView] = {}

    def plays() -> bool:
        found = fitted.view()
        seen[found.snapshot.number] = found
        return not fitted.playing

    wait_for(plays)
    fitted.set_speed(1.0)
    assert len(seen) > 5
    for number, found in seen.items():
        assert_same(found, fit.seen[number])


def test_the_page_is_sent_the_same(fit: Fit, fitted: RecordingSource) -> None:
    for number in (100, 127):
        found = saw(fitted, number)
        live, again = (
            Updates(SceneLayout((fitted,))).make(1, [each], ())
            for each in (fit.seen[number], found)
        )
        assert live == again


def test_a_recovered_file_has_the_answers_that_were_whole(fit: Fit, tmp_path: Path) -> None:
    data, cut, good = fit.path.read_bytes(), tmp_path / "cut.mcap", tmp_path / "good.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    report = recover(cut, good)
    assert report.messages["/skin/fit"] == len(list(LiveRecording.open(good).fits())) > 5
    with closing(RecordingSource(good, playing=False)) as opened:
        assert_same(saw(opened, 100), fit.seen[100])


def test_numbers_that_cannot_be_shown_are_told_from_those_that_can() -> None:
    fake = FakeFit(unique_name(), (PATCH.name, "leg"), NODES)
    fake.tell(contact(patch=1), contact(force=2.0, patch=1), patch=1, pressure=[1.0])
    good = recorder_drain.record_of(fake.master, 1)
    fake.close()
    assert is_sound(good)
    assert slot_of(good).contacts[1][:2].tobytes() == good.contacts.tobytes()
    for name, value in [("x", np.nan), ("normal_force", np.inf), ("position", 1e300), ("patch", 0)]:
        rows = good.contacts.copy()
        rows[name][1] = value
        assert not is_sound(replace(good, contacts=rows))
    assert not is_sound(replace(good, pressure=np.full(1, np.nan, np.float32)))


@pytest.mark.parametrize("what", ["another skin", "damaged"])
def test_what_cannot_be_read_of_the_fit_leaves_the_engine(tmp_path: Path, what: str) -> None:
    def beside(writer: RecordingWriter, slot: CycleSlot, number: int) -> None:
        if what == "damaged":
            writer.write("/skin/fit", slot.recorded(number).wall_ns, bytes(56))
        elif number == 55:
            fake.tell(contact(), told_ns=0)
            data = LAYOUT.encode(replace(recorder_drain.record_of(fake.master, 1), time_ns=0))
            writer.write("/skin/fit", 1, data)

    fake = FakeFit(unique_name(), (PATCH.name, "leg"), NODES)
    path = tmp_path / "bad.mcap"
    known = write(path, 80, beside=beside)
    fake.close()
    with closing(RecordingSource(path, playing=False)) as opened:
        found = saw(opened, 70)
        said = str(opened.status()["notes"]["damage"])
    assert found.contacts.tobytes() == known[70].contacts
    assert set(found.by) == {"engine"}
    assert ("fit of 2 patches" if what == "another skin" else "record is of version 0") in said
    assert level(70) > 0
    assert ROWS.contact == found.contacts.dtype
