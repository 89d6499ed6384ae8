"""A replay shows the contacts that the live page showed, those of the fit among them."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from fit_rings import FakeFit, contact
from live_skins import settings, unique_name, wait_for
from replay_sample import NOISE, PERIOD, ROWS, Known, level, write

import skinfield as sf
from skinfield.acquisition import Port
from skinfield.acquisition.recorded import BLOCKS, CYCLES, Enclosed
from skinfield.live import fit_reader, recorder_fit
from skinfield.live.answered import Answered
from skinfield.live.estimates import Models
from skinfield.live.fit_reader import FitReader
from skinfield.live.fit_ring import LAYOUT, Fitted
from skinfield.live.recipe import Recipe
from skinfield.live.recorder_fit import FitDrain
from skinfield.live.recorder_queue import Queue
from skinfield.live.recorder_recover import recover
from skinfield.live.replay import Replay
from skinfield.live.replay_fit import ReplayFit, is_sound, slot_of
from skinfield.live.slots import Slot
from skinfield.live.snapshot import Snapshot
from skinfield.sinks.mcap import RecordingWriter
from skinfield.sources.recordings.mcap_fits import fits_of
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.viewer.replay_feed import ReplayFeed
from skinfield.viewer.replay_shown import Shown
from skinfield.viewer.seen_best import seen_best
from skinfield.viewer.stage import Stage
from skinfield.viewer.updates import Seen, Updates

COUNT, BEGIN = 340, 50  # cycles; the first that can be answered again
PATCH = sf.layouts.hexagon72()
NODES, LATER = 400, PERIOD // 2  # ns from a cycle to what the fit publishes after it
WHOLE = 1e9 / PERIOD


class Page:
    """A live page, a fit and a recorder's reader of it, beside the cycles of a recording."""

    def __init__(self) -> None:
        made = settings()
        self.models = Models(Recipe.of(made, (Port("port", 72),)), np.full(len(PATCH), NOISE))
        self.name, self.now_ns = unique_name(), 0
        self.clock = SimpleNamespace(time_ns=lambda: self.now_ns)
        self.reader, self.queue = FitReader(self.name), Queue(1 << 24)
        self.drain = FitDrain(self.name, self.queue, (PATCH.name,), NODES)
        self.fit: FakeFit | None = None
        self.seen: list[Seen] = []

    def __call__(self, writer: RecordingWriter, slot: Slot, number: int) -> None:
        """Look as the page does; then the fit goes on, and what it says is recorded."""
        own = replace(slot, **{f.name: getattr(slot, f.name).copy() for f in fields(Slot)})
        told = own.recorded(number)
        snapshot = Snapshot(own, number, self.models, told.wall_ns)
        found = self.reader.latest()
        self.seen.append(kept(seen_best(snapshot, found)))
        self.now_ns = told.wall_ns + LATER
        self._go_on(number, snapshot)
        self.drain.take()
        for each in self.queue.take(0.0):
            each.put(writer)

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


def kept(seen: Seen) -> Seen:
    """The same in memory of its own: rows of a reader last until it reads again."""
    return seen._replace(contacts=np.array(seen.contacts))


@dataclass(frozen=True)
class Made:
    path: Path
    known: list[Known]
    seen: list[Seen]


@pytest.fixture(scope="module", name="made")
def _made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Made]:
    path, page = tmp_path_factory.mktemp("fit") / "touch.mcap", Page()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit_reader, "AGAIN", 0.0)  # s between looks for a ring
        patch.setattr(recorder_fit, "time", page.clock)
        known = write(path, COUNT, beside=page)
    yield Made(path, known, page.seen)
    page.reader.close()
    page.drain.close()
    if page.fit is not None:
        page.fit.close()


@pytest.fixture(scope="module", name="feed")
def _feed(made: Made) -> Iterator[ReplayFeed]:
    opened = ReplayFeed(made.path, playing=False)
    wait_for(lambda: opened.sought)
    yield opened
    opened.close()


def assert_same(found: Seen, live: Seen) -> None:
    """Contacts, who says them, and the fit's field, to the last bit."""
    assert found.contacts.tobytes() == live.contacts.tobytes()
    assert list(found.by) == list(live.by)
    assert field_of(found) == field_of(live)


def field_of(seen: Seen) -> bytes | None:
    """Of the fit, on the patch."""
    field = None if seen.fit is None else seen.fit.pressure(PATCH.name)
    return None if field is None else field.tobytes()


def went(feed: ReplayFeed, number: int) -> Seen:
    feed.seek(number / WHOLE)
    wait_for(lambda: feed.sought)
    found = feed.seen()
    assert found.snapshot is not None
    assert found.snapshot.number == number
    return found


def test_the_page_saw_what_is_to_be_shown_again(made: Made) -> None:
    counts = Counter(tuple(sorted(each.by)) for each in made.seen[BEGIN:])
    assert counts["fit", "fit"] > 50
    assert counts["engine",] > 50
    assert counts[("fit",)] > 0  # where the engine sees nothing
    assert sum(each.fit is not None for each in made.seen) > 60


def test_every_cycle_is_seen_as_it_was_live(made: Made) -> None:
    replay = Replay(made.path)
    shown, fit, count = Shown(replay), ReplayFit(replay), 0
    for each in replay.walk():
        shown.put(each, at_once=True)
        if not isinstance(each, Answered):
            continue
        assert each.same
        snapshot, time_ns = shown.now()
        assert_same(seen_best(snapshot, fit.at(time_ns)), made.seen[each.recorded.number])
        count += 1
    assert count == COUNT - BEGIN
    assert replay.recording.damage == []


@pytest.mark.parametrize("order", [1, -1], ids=["forwards", "backwards"])
def test_from_any_time_on_the_same_is_seen(made: Made, feed: ReplayFeed, order: int) -> None:
    places = (52, 61, 64, 71, 78, 100, 127, 199, 202, 231, 239, 260, 299, 330, 339)
    for number in places[::order]:
        assert_same(went(feed, number), made.seen[number])


def test_while_it_plays_ten_times_as_fast_the_same_is_seen(made: Made, feed: ReplayFeed) -> None:
    went(feed, 60)
    feed.set_speed(10.0)
    feed.play()
    seen: dict[int, Seen] = {}

    def plays() -> bool:
        found = feed.seen()
        assert found.snapshot is not None
        seen[found.snapshot.number] = found
        return not feed.playing

    wait_for(plays)
    feed.set_speed(1.0)
    assert len(seen) > 5
    for number, found in seen.items():
        assert_same(found, made.seen[number])


def test_the_page_is_sent_the_same(made: Made, feed: ReplayFeed) -> None:
    for number in (100, 127):
        found = went(feed, number)
        live, again = (
            Updates(Stage((feed,))).make(1, [each], ()) for each in (made.seen[number], found)
        )
        assert live == again


def without_fit(path: Path, plain: Path) -> None:
    """The same recording as one that knows of no fit."""
    found = LiveRecording.open(path)
    enclosed = [Enclosed(*each) for each in found.attached.values()]
    writer = RecordingWriter(plain, enclosed, layout=ROWS)
    for topic, at, message in found.messages((BLOCKS, CYCLES)):
        if topic == CYCLES:
            writer.write_cycle(message.time_ns, message.data)
        elif (logged := found.logged_of(at, message)) is not None:
            writer.write_blocks(message.time_ns, logged.position, logged.data)
    writer.close()


def test_the_engine_is_answered_without_the_fit(made: Made, tmp_path: Path) -> None:
    plain = tmp_path / "plain.mcap"
    without_fit(made.path, plain)
    assert list(fits_of(LiveRecording.open(plain))) == []
    answered = [(each.slot.patches.tobytes(), each.same) for each in Replay(plain)]
    assert answered == [(each.patches, True) for each in made.known[BEGIN:]]
    opened = ReplayFeed(plain, playing=False)
    found = went(opened, 100)
    opened.close()
    assert list(found.by) == ["engine"] * len(found.contacts)
    assert found.contacts.tobytes() == made.known[100].contacts
    assert field_of(found) is None


def test_a_recovered_file_has_the_answers_that_were_whole(made: Made, tmp_path: Path) -> None:
    data, cut, good = made.path.read_bytes(), tmp_path / "cut.mcap", tmp_path / "good.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    report = recover(cut, good)
    assert report.messages["/skin/fit"] == len(list(fits_of(LiveRecording.open(good)))) > 5
    opened = ReplayFeed(good, playing=False)
    assert_same(went(opened, 100), made.seen[100])
    opened.close()


def test_numbers_that_cannot_be_shown_are_told_from_those_that_can() -> None:
    fit = FakeFit(unique_name(), (PATCH.name, "leg"), NODES)
    fit.tell(contact(patch=1), contact(force=2.0, patch=1), patch=1, pressure=[1.0])
    good = recorder_fit.record_of(fit.master, 1)
    fit.close()
    assert is_sound(good)
    assert slot_of(good).contacts[1][:2].tobytes() == good.contacts.tobytes()
    for name, value in [("x", np.nan), ("normal_force", np.inf), ("position", 1e300), ("patch", 0)]:
        rows = good.contacts.copy()
        rows[name][1] = value
        assert not is_sound(replace(good, contacts=rows))
    assert not is_sound(replace(good, pressure=np.full(1, np.nan, np.float32)))


@pytest.mark.parametrize("what", ["another skin", "damaged"])
def test_what_cannot_be_read_of_the_fit_leaves_the_engine(tmp_path: Path, what: str) -> None:
    def beside(writer: RecordingWriter, slot: Slot, number: int) -> None:
        if what == "damaged":
            writer.write_fit(slot.recorded(number).wall_ns, bytes(56))
        elif number == 55:
            fit.tell(contact(), told_ns=0)
            data = LAYOUT.encode(replace(recorder_fit.record_of(fit.master, 1), time_ns=0))
            writer.write_fit(1, data)

    fit = FakeFit(unique_name(), (PATCH.name, "leg"), NODES)
    path = tmp_path / "bad.mcap"
    known = write(path, 80, beside=beside)
    fit.close()
    opened = ReplayFeed(path, playing=False)
    found = went(opened, 70)
    assert found.contacts.tobytes() == known[70].contacts
    assert set(found.by) == {"engine"}
    said = str(opened.status()["notes"]["damage"])
    opened.close()
    assert ("fit of 2 patches" if what == "another skin" else "record is of version 0") in said
    assert level(70) > 0
    assert ROWS.contact == found.contacts.dtype
