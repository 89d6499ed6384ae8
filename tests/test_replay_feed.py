"""Recordings as a feed of the page: any time of them, at any pace, exactly as it was."""

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from live_skins import wait_for
from numpy.testing import assert_allclose
from replay_sample import KEYS, PERIOD, STALE, START, Known, write

from skinfield.errors import FileError, InputError
from skinfield.live.answered import Answered, Passed
from skinfield.live.replay import Replay
from skinfield.live.slots import Head
from skinfield.live.snapshot import Snapshot
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_moments import Moments
from skinfield.viewer.replay_clock import LATE, Clock
from skinfield.viewer.replay_feed import ReplayFeed

CYCLES, TARED = 320, 170
WHOLE = 1e9 / PERIOD  # cycles in a second


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Known]]:
    path = tmp_path_factory.mktemp("feed") / "touch.mcap"
    return path, write(path, CYCLES, tared_at=TARED)


@pytest.fixture(scope="module")
def opened(made: tuple[Path, list[Known]]) -> Iterator[ReplayFeed]:
    feed = ReplayFeed(made[0], playing=False)
    assert not feed.playing
    yield feed
    feed.close()


@pytest.fixture
def feed(opened: ReplayFeed) -> ReplayFeed:
    """A feed that stands still."""
    opened.pause()
    opened.set_speed(1.0)
    wait_for(lambda: opened.sought)
    return opened


def went(feed: ReplayFeed, t_s: float) -> Snapshot:
    """What is shown after a seek."""
    feed.seek(t_s)
    wait_for(lambda: feed.sought)
    found = feed.latest()
    assert found is not None
    return found


def assert_is(found: Snapshot, known: Known) -> None:
    """Everything as it was live, to the last bit."""
    slot = found.slot
    assert found.number == known.number
    assert slot.patches.tobytes() == known.patches
    assert found.contacts.tobytes() == known.contacts
    assert slot.values.tobytes() == known.values
    nodes = len(known.pressure) // 4
    assert slot.pressure[0, :nodes].tobytes() == known.pressure


# where things are in a file


def test_moments_know_keys_breaks_and_what_lasts(made: tuple[Path, list[Known]]) -> None:
    found = Moments.of(LiveRecording.open(made[0]))
    assert found.cycles == CYCLES
    assert (found.first_ns, found.last_ns) == (START, START + (CYCLES - 1) * PERIOD)
    assert found.keys == [START + key * PERIOD for key in range(0, CYCLES, KEYS)]
    assert found.breaks == [START]
    assert list(found.holes(STALE)) == [(START, START + KEYS * PERIOD)]
    ((record, data),) = found.lasting
    assert found.lasting_before(record) == b""
    assert found.lasting_before(record + 1) == data
    assert [event["kind"] for event in found.events] == ["calibrated"]
    assert found.key_before(START - 1) is None
    assert found.key_before(START + 60 * PERIOD) == START + 50 * PERIOD


def test_a_gap_is_a_hole_until_a_key_cycle_knows_all(tmp_path: Path) -> None:
    path = tmp_path / "gap.mcap"
    write(path, 200, without=range(70, 80))
    found = Moments.of(LiveRecording.open(path))
    assert found.breaks == [START, START + 80 * PERIOD]
    holes = [((a - START) // PERIOD, (b - START) // PERIOD) for a, b in found.holes(STALE)]
    assert holes == [(0, 50), (80, 100)]


# any time of it


@pytest.mark.parametrize("place", [51, 63, 149, 150, 163, TARED - 1, TARED, TARED + 1, 299, 319])
def test_from_any_time_the_cycles_are_the_same(
    made: tuple[Path, list[Known]], place: int, replay: Replay
) -> None:
    known = made[1]
    for each in replay.from_time(START + place * PERIOD):
        if each.recorded.number >= place:
            break
    assert isinstance(each, Answered)
    assert each.same
    assert each.whole
    assert each.recorded.number == place
    assert each.slot.patches.tobytes() == known[place].patches
    assert each.slot.values.tobytes() == known[place].values


@pytest.fixture(scope="module")
def replay(made: tuple[Path, list[Known]]) -> Replay:
    return Replay(made[0])


def test_a_time_that_cannot_be_answered_is_passed(replay: Replay) -> None:
    found = list(zip(range(40), replay.from_time(START), strict=False))
    assert all(isinstance(each, Passed) for _, each in found)


# as a feed


def test_a_seek_while_paused_shows_exactly_that_cycle(
    made: tuple[Path, list[Known]], feed: ReplayFeed
) -> None:
    known = made[1]
    for place in (118, 60, 250, TARED + 2, TARED - 2, 319):
        assert_is(went(feed, place / WHOLE), known[place])
        assert feed.time_s == pytest.approx(place / WHOLE)
    between = went(feed, 117.4 / WHOLE)
    assert_is(between, known[118])  # the first one from then on
    assert between.age == pytest.approx(1e-6)  # by the time of the replay
    assert between.slot.head[Head.WALL_NS] == known[118].wall_ns
    assert between["hexagon72"].pressure.max() > 1e3


def test_snapshots_keep_what_they_were(made: tuple[Path, list[Known]], feed: ReplayFeed) -> None:
    first = went(feed, 118 / WHOLE)
    assert feed.latest() is first  # nothing is new
    second = went(feed, 200 / WHOLE)
    assert_is(first, made[1][118])
    assert_is(second, made[1][200])


def test_it_says_what_happened_and_where_nothing_can_be_answered(feed: ReplayFeed) -> None:
    assert feed.start_s == 0.0
    assert feed.end_s == pytest.approx((CYCLES - 1) / WHOLE)
    assert feed.events == [(pytest.approx(TARED / WHOLE), "the baseline was taken anew")]
    assert_allclose(feed.holes, [(0.0, KEYS / WHOLE)])
    assert went(feed, 0.9).number == 90
    assert "without answers from 0.00 s to 0.50 s" in feed.status()["notes"]["replay"]
    missing = went(feed, 0.2)
    assert len(missing) == 0
    assert len(missing.contacts) == 0
    assert "from 0.00 s to 0.50 s nothing can" in feed.status()["notes"]["replay"]


def test_it_begins_to_play_where_it_can(made: tuple[Path, list[Known]]) -> None:
    opened = ReplayFeed(made[0])
    try:
        wait_for(lambda: opened.sought)
        assert opened.time_s >= KEYS / WHOLE
        assert opened.playing
        assert opened.speed == 1.0
    finally:
        opened.close()
    assert not opened._thread.is_alive()


def test_it_plays_faster_and_stops_at_the_end(feed: ReplayFeed) -> None:
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


def test_pause_and_play_go_on_from_where_it_is(feed: ReplayFeed) -> None:
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


def test_the_newest_of_many_seeks_wins(made: tuple[Path, list[Known]], feed: ReplayFeed) -> None:
    for place in range(60, 300, 3):
        feed.seek(place / WHOLE)
    assert_is(went(feed, 222 / WHOLE), made[1][222])


def test_what_makes_no_sense_is_refused(feed: ReplayFeed) -> None:
    for wrong in (0.0, 11.0, float("nan")):
        with pytest.raises(InputError, match="speed"):
            feed.set_speed(wrong)
    with pytest.raises(InputError, match="t_s is nan"):
        feed.seek(float("nan"))
    feed.seek(-5.0)
    feed.seek(1e9)  # there are no times beyond the ends
    wait_for(lambda: feed.sought)
    assert feed.time_s == pytest.approx(feed.end_s)


def test_closing_ends_the_thread_at_once(made: tuple[Path, list[Known]]) -> None:
    opened = ReplayFeed(made[0])
    before = threading.active_count()
    opened.close()
    assert threading.active_count() < before
    opened.close()


# files that are not whole


def test_a_cut_file_is_shown_as_far_as_it_goes(
    made: tuple[Path, list[Known]], tmp_path: Path
) -> None:
    data = made[0].read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    opened = ReplayFeed(cut, playing=False)
    try:
        assert 1.0 < opened.end_s < CYCLES / WHOLE
        assert_is(went(opened, 1.1), made[1][110])
        assert "cut" in opened.status()["notes"]["damage"][0]
        assert opened.end_s == pytest.approx(went(opened, 1e9).number / WHOLE)
    finally:
        opened.close()


def test_a_file_from_the_middle_and_with_a_gap_says_where_not(tmp_path: Path) -> None:
    path = tmp_path / "parts.mcap"
    known = write(path, 260, first=33, without=range(130, 138))
    opened = ReplayFeed(path, playing=False)
    try:
        assert_allclose(opened.holes, [(0.0, 0.17), (1.05, 1.17)])
        assert_is(went(opened, 0.9), known[123])
        assert len(went(opened, 1.1)) == 0
        assert_is(went(opened, 1.5), known[183])
        opened.seek(1.0)
        opened.play()  # across the gap
        wait_for(lambda: opened.time_s > 1.25)
        assert opened.latest()["hexagon72"] is not None  # type: ignore[index]
    finally:
        opened.close()


def test_a_file_without_a_key_cycle_that_can_be_used_says_so(tmp_path: Path) -> None:
    path = tmp_path / "short.mcap"
    write(path, 45)
    with pytest.raises(FileError, match="skinfield export"):
        ReplayFeed(path)


def test_other_recordings_are_for_reconstruct(tmp_path: Path) -> None:
    table = tmp_path / "counts.csv"
    rows = "\n".join(f"{0.01 * k:.2f},{k % 7},{k % 5}" for k in range(50))
    table.write_text("time_s,taxel_0,taxel_1\n" + rows + "\n")
    with pytest.raises(FileError, match="skinfield reconstruct"):
        ReplayFeed(table)
    nothing = tmp_path / "nothing.txt"
    nothing.write_text("hello")
    for wrong in (nothing, tmp_path / "absent.mcap"):
        with pytest.raises(FileError, match=wrong.name):
            ReplayFeed(wrong)


def test_what_goes_wrong_later_is_told(feed: ReplayFeed, monkeypatch: pytest.MonkeyPatch) -> None:
    wait_for(lambda: feed.sought)

    def broken(time_ns: int) -> Iterator[Answered]:
        raise FileError("the disk is gone")

    monkeypatch.setattr(feed.replay, "from_time", broken)
    feed.seek(1.0)
    status = wait_for(lambda: feed.status()["state"] == "failed" and feed.status())
    assert status["notes"]["failed"] == "the disk is gone"
    assert not feed.playing


# pace


def test_a_clock_does_not_make_up_for_what_takes_longer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [100.0]
    monkeypatch.setattr("skinfield.viewer.replay_clock.time.monotonic", lambda: now[0])
    clock = Clock(playing=True)
    clock.set_speed(2.0)
    clock.begin(START)
    left: Callable[[float], float] = lambda seconds: clock.left(START + round(seconds * 1e9))
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
