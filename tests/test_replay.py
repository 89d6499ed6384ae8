"""Replays of recordings: any time of them, at any pace, exactly as it was."""

import csv
import io
import json
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke, run
from live_skins import unique_name, wait_for
from mcap_sample import write as write_other
from numpy.testing import assert_array_equal
from replay_sample import NOISE, PERIOD, ROWS, START, Known, write

import skinfield as sf
from skinfield.errors import FileError, InputError
from skinfield.estimate.contact_table import COLUMNS
from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.schema import CycleLayout
from skinfield.loop.client import connect
from skinfield.loop.model_config import Configuration
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import Observer
from skinfield.page.replay import LATE, Clock, RecordingSource
from skinfield.record.replay import Published, RecordedCycle, Replay

Made = tuple[Path, list[Known]]
CYCLES, TARED = 320, 170
WHOLE = 1e9 / PERIOD  # cycles in a second
PATCH = sf.layouts.hexagon72()


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


# its timeline


def contacts_of(each: Known) -> np.ndarray:
    return np.frombuffer(each.contacts, ROWS.contact)


def test_the_timeline_is_force_and_touches_over_time(made: Made, feed: RecordingSource) -> None:
    told = wait_for(lambda: feed.timeline.told)
    assert feed.timeline.damage == ""
    times, force = np.array(told["times"]), np.array(told["force"])
    known = np.array([contacts_of(each)["normal_force"].sum() for each in made[1]])
    assert_array_equal(np.diff(times) > 0.0, True)
    assert len(times) == CYCLES  # each has a part of its own
    assert np.abs(force - known).max() < 1e-4
    assert np.abs(times - np.arange(CYCLES) / WHOLE).max() < 2e-3
    seen: dict[int, list[float]] = {}
    forces: dict[int, list[float]] = {}
    for number, each in enumerate(made[1]):
        for row in contacts_of(each):
            seen.setdefault(int(row["track"]), []).append(number / WHOLE)
            forces.setdefault(int(row["track"]), []).append(row["normal_force"])
    assert len(told["contacts"]) == len(seen)
    for track, when in seen.items():
        its = told["contacts"][f"{feed.name} {track}"]
        assert its[0] == pytest.approx(when, abs=2e-3)
        assert its[1] == pytest.approx(forces[track], abs=1e-4)
    ends = sorted((times[0], times[-1]) for times in seen.values())
    assert np.array(told["touches"]) == pytest.approx(np.array(ends), abs=1e-3)
    assert ends


def test_it_steps_by_readings_both_ways(made: Made, feed: RecordingSource) -> None:
    wait_for(lambda: feed.timeline.told)
    went(feed, 1.0)
    for count, place in ((1, 101), (3, 104), (-2, 102), (-1000, 0), (-1, 0), (1000, CYCLES - 1)):
        feed.step(count)
        wait_for(lambda: feed.sought)
        assert not feed.playing
        assert feed.time_s == pytest.approx(place / WHOLE, abs=1e-6)


def test_a_span_is_a_table_of_contacts(made: Made, feed: RecordingSource) -> None:
    text = feed.timeline.csv(1.0, 2.0)
    rows = list(csv.DictReader(io.StringIO(text)))
    assert tuple(rows[0]) == (*COLUMNS, "track", "patch")
    known = [(k, one) for k in range(100, 201) for one in contacts_of(made[1][k])]
    assert len(rows) == len(known) > 50
    for row, (k, one) in zip(rows, known, strict=True):
        assert int(row["stamp_ns"]) == START + k * PERIOD - 1000
        assert (int(row["track"]), row["patch"]) == (one["track"], PATCH.name)
        found = [float(row[name]) for name in ("time_s", "x_m", "y_m", "force_N", "area_m2")]
        there = (k / WHOLE, *one["position"][:2], one["normal_force"], one["area"])
        assert found == pytest.approx(there, rel=1e-5, abs=2e-6)
        assert row["scale"] == "newtons"


def test_it_begins_anew_in_a_loop(feed: RecordingSource) -> None:
    feed.set_loop(True)
    try:
        went(feed, feed.end_s - 0.05)
        feed.play()
        wait_for(lambda: feed.time_s < 1.0)
        assert feed.playing
    finally:
        feed.set_loop(False)
        feed.pause()


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


# of older rows


def without(kind: np.dtype[Any], *names: str) -> np.dtype[Any]:
    return np.dtype([field for field in kind.descr if field[0] not in names])


YOUNG = "shape", "maybe", "radius", "covariance", "area_std", "shear", "shear_covariance"
OLDER = CycleLayout(without(ROWS.contact, *YOUNG), without(ROWS.patch, "readings"))


def test_what_older_rows_lack_is_not_known(tmp_path: Path) -> None:
    path = tmp_path / "older.mcap"
    known = write(path, 60, layout=OLDER)
    replay = Replay(path)
    assert replay.recording.cycle_layout == OLDER
    for each, made in zip(replay, known, strict=True):
        rows, patches = each.slot.used_contacts(), each.slot.patches
        force = np.frombuffer(made.contacts, ROWS.contact)["normal_force"]
        assert rows["normal_force"].tolist() == force.tolist()
        assert (patches["force"][0], patches["readings"][0]) == (made.force, 1)
        assert (rows["shape"] == 0).all()
        assert np.isnan(rows["radius"]).all()
    assert replay.recording.damage == []
    with closing(RecordingSource(path, playing=False)) as opened:
        wait_for(lambda: opened.sought)
        went(opened, 40 / WHOLE)
        (shown,) = opened.status()["contacts"]
    assert (shown["shape"], shown["radius"], shown["maybe"]) == ("other", None, False)


def test_rows_that_lack_more_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    write(path, 2, layout=replace(OLDER, patch=without(OLDER.patch, "gap")))
    with pytest.raises(FileError, match="rows of contacts and patches are of another version"):
        Replay(path)
