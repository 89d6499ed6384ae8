"""The recorder against rings that are written here."""

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from live_skins import unique_name, wait_for
from mcap.reader import make_reader
from recorder_ring import FakeEngine, missing_bytes, record, recorder_of, whole

import skinfield as sf
from skinfield.files import open_recording
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop.model_config import Configuration, write_configuration
from skinfield.loop.runtime_parameters import Tuning
from skinfield.reconstruct.serialisation import value_from_plain
from skinfield.record import launch
from skinfield.record.launch import ReadyRecorders
from skinfield.record.queue import Item, Queue
from skinfield.record.recorder import read_state
from skinfield.record.state import RecorderState
from skinfield.signal import Kind


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def recorder(engine, path):
    return recorder_of(engine, path)


def step(engine, recorder):
    engine.cycle()
    recorder.step()


def test_everything_that_the_ring_had_is_in_the_file(engine, path):
    recorder = record(engine, path, 100)
    assert recorder.state.finished
    assert recorder.state.lost == recorder.state.overrun_cycles == 0
    found = whole(engine, path)
    assert found.damage == []
    cycles = list(found.cycles())
    assert [each.number for each in cycles] == list(range(1, 101))
    assert [int(each.patches["force"][0]) for each in cycles] == list(range(100))
    assert [len(each.contacts) for each in cycles] == [i % 3 for i in range(100)]
    assert [bool(each.flags & CycleFlag.LATE) for each in cycles] == [
        i % 10 == 0 for i in range(100)
    ]
    assert found.skin.name == "test"
    np.testing.assert_array_equal(found.skin[0].positions, engine.skin[0].positions)
    assert found.calibrations["arm"].baseline.tolist() == [200.0] * 24
    assert found.configuration["ports"] == [["arm", 24, "count"]]
    kinds = [each["kind"] for each in found.events()]
    assert kinds == ["recording_started", "settings", "recording_ended"]
    assert len(list(found.timing())) >= 1
    written = b"".join(engine.written)
    before = np.cumsum([len(each) for each in engine.written]).tolist()
    assert [each.log_position for each in cycles] == before  # of each cycle's readings
    assert before[-1] == len(written)


def test_fields_are_there_so_many_times_a_second(engine, path):
    record(engine, path, 40, view_rate=1000.0)
    found = list(LiveRecording.open(path).fields())
    assert len(found) > 1
    for each in found:
        number, pressure = each.number - 1, np.ones((1, 16), np.float32)
        each.pressure_into(pressure)
        assert pressure[0, number % 16] == number
        assert np.count_nonzero(pressure) == (number > 0)
        assert each.sides.tolist() == [4]
        np.testing.assert_array_equal(each.counts, engine.counts[number])
        np.testing.assert_array_equal(each.values, np.float32(1e-3 * number))
        assert each.valid.all()
    seldom = path.with_name("b.mcap")
    record(engine, seldom, 40, view_rate=1e-3)
    assert len(list(LiveRecording.open(seldom).fields())) == 1


def test_settings_and_their_changes_are_events(engine, path):
    status = engine.ring.status
    first, second = sf.NonNegative(), sf.NonNegative(tolerance=0.25)
    tuned = Tuning(threshold=0.5, resolution=4)
    write_configuration(status["configuration"], Configuration(1, first, Tuning()))
    recorder = recorder_of(engine, path)
    for number in range(6):
        engine.cycle()
        if number == 2:
            known = Configuration(1, first, tuned)
            write_configuration(status["configuration"], known)
        if number == 4:
            write_configuration(status["configuration"], Configuration(2, second, tuned))
        recorder.step()
    recorder.close()
    told = [each for each in LiveRecording.open(path).events() if each["kind"] == "settings"]
    assert [each["cycle"] for each in told] == [2, 4, 6]
    assert [each["tuning"]["threshold"] for each in told] == [0.0, 0.5, 0.5]
    assert [each["tuning"]["resolution"] for each in told] == ["auto", 4, 4]
    assert [each["generation"] for each in told] == [1, 1, 2]
    solvers = [value_from_plain("solver", each["solver"]) for each in told]
    assert solvers == [first, first, second]


def test_counts_over_time(engine, path):
    record(engine, path, 50)
    found = open_recording(path)
    np.testing.assert_array_equal(found.counts, engine.counts)
    assert found.notes == ()
    assert (np.diff(found.stamp_ns) > 0).all()


def test_mcap_reads_it_alone(engine, path):
    record(engine, path, 30)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        topics = {channel.topic for channel in summary.channels.values()}
        own = ("blocks", "cycles", "fields", "timing", "events")
        assert topics == {f"/skin/{each}" for each in own}
        assert len(list(reader.iter_messages(topics=["/skin/cycles"]))) == 30
        data = b"".join(m.data[8:] for _, _, m in reader.iter_messages(topics=["/skin/blocks"]))
        assert data == b"".join(engine.written)
        names = {each.name for each in reader.iter_attachments()}
    assert names == {
        "layout.npz", "configuration.json", "ring.json", "calibration/arm.npz", "tare-1.npz"
    }  # fmt: skip


def test_a_recording_may_begin_late(engine, path):
    for _ in range(30):
        engine.cycle()
    record(engine, path, 20)
    found = LiveRecording.open(path)
    assert [each.number for each in found.cycles()] == list(range(31, 51))
    assert b"".join(each.data for each in found.blocks()) == b"".join(engine.written[30:])


def test_sources_that_come_and_go_are_told(engine, path):
    def each(blocks, now):
        blocks.put_number(now, 0, Kind.SOURCE, 0)
        blocks.put_number(now, 0, Kind.LOST, 7)
        blocks.put_number(now, 0, Kind.SOURCE, 1)

    recorder = recorder_of(engine, path)
    engine.cycle(extra=each)
    recorder.close()
    events = list(LiveRecording.open(path).events())
    kinds = [event["kind"] for event in events[1:-1]]
    assert kinds == ["source_down", "source_up", "settings", "messages_lost"]
    assert events[4]["messages"] == 7
    assert events[4]["text"] == "NoSource: 7 messages were lost"


def test_an_engine_that_is_started_again(engine, recorder, path):
    step(engine, recorder)
    engine.reopen()
    engine.cycle()
    recorder.close()
    found = whole(engine, path)
    assert "engine_restarted" in [event["kind"] for event in found.events()]


def test_an_overrun_is_counted_to_the_byte(path):
    with FakeEngine(slots=8, log_bytes=4096) as engine:
        recorder = recorder_of(engine, path)
        engine.cycle()
        recorder.step()
        for _ in range(200):  # 64 bytes each
            engine.cycle()
        recorder.step()
        engine.cycle()
        recorder.close()
        found = LiveRecording.open(path)
        log = b"".join(engine.written)
        kept = {each.position: each.data for each in found.blocks()}
        assert all(log[at : at + len(data)] == data for at, data in kept.items())
        saved = sum(map(len, kept.values()))
        events = {event["kind"]: event for event in found.events()}
        assert events["log_overrun"]["bytes"] == len(log) - saved == recorder.state.overrun_bytes
        numbers = {cycle.number for cycle in found.cycles()}
        missing = events["cycle_overrun"]
        assert missing["cycles"] == 202 - len(numbers) == recorder.state.overrun_cycles
        assert set(range(1, 203)) - numbers == set(range(missing["first"], missing["last"] + 1))
        assert missing_bytes(found) == len(log) - saved


def test_its_state_is_told(engine, recorder):
    stop = threading.Event()
    thread = threading.Thread(target=recorder.run, args=(stop,))
    thread.start()
    engine.cycle()
    state = wait_for(lambda: (now := read_state(engine.ring.name)) and now.cycles == 1 and now)
    assert state.bytes_written > 1000
    assert not state.ended
    stop.set()
    thread.join(30)
    state = read_state(engine.ring.name)
    assert state.finished
    assert state.ended == "it was told to stop"


def test_it_ends_with_the_ring(engine, recorder, path):
    engine.cycle()
    engine.ring.unlink()
    state = recorder.run(threading.Event(), 30.0)
    assert state.ended.startswith("the ring was taken away")
    assert len(list(LiveRecording.open(path).cycles())) == 1


def test_a_new_baseline_is_enclosed(engine, recorder, path):
    step(engine, recorder)
    engine.ring.status["calibration"][:, 0] = 199.0
    engine.ring.status["tares"][0] = 2
    engine.cycle()
    recorder.close()
    found = LiveRecording.open(path)
    assert {"tare-1.npz", "tare-2.npz"} <= set(found.attached)
    assert found.calibrations["arm"].baseline.tolist() == [199.0] * 24
    assert [each["kind"] for each in found.events()][1:-1] == ["settings", "calibrated"]


def test_a_queue_keeps_half_of_its_room_for_readings():
    queue = Queue(1 << 12, RecorderState())

    def item(size: int) -> Item:
        return Item(1, size, lambda writer: None)

    assert [queue.offer(item(1000)) for _ in range(3)] == [True, True, False]
    assert queue.put(item(1500))
    assert not queue.put(item(2000))  # from here on readings are missing
    assert [each.size for each in queue.take(0.0)] == [1000, 1000, 1500]
    assert not queue.offer(item(1))


PERIOD = 0.01  # s


def cycles(engine: FakeEngine, count: int) -> None:
    for _ in range(count):
        engine.cycle()
        time.sleep(PERIOD)


def numbers(path: Path) -> list[int]:
    return [each.number for each in LiveRecording.open(path).cycles()]


def recorded(engine: FakeEngine, path: Path, since_ns: int) -> None:
    recorder = recorder_of(engine, path, since_ns=since_ns)
    recorder.step()
    engine.cycle()
    recorder.close()


# since when


def test_what_the_ring_still_has_is_recorded_with_its_readings(engine, path):
    cycles(engine, 30)
    since_ns = time.time_ns()
    cycles(engine, 10)
    recorded(engine, path, since_ns)
    found = LiveRecording.open(path)
    first, second, *_ = found.cycles()
    assert numbers(path) == list(range(first.number, 42))
    data = b"".join(each.data for each in found.blocks())
    assert data == b"".join(engine.written[first.number - 1 :])
    assert first.wall_ns <= since_ns < second.wall_ns


def test_no_further_back_than_the_ring_goes(engine, path):
    for _ in range(200):
        engine.cycle()
    recorded(engine, path, 1)
    found = numbers(path)
    assert found == list(range(200 - engine.layout[2] * 3 // 4 + 2, 202))


def test_not_before_readings_that_are_gone(path):
    with FakeEngine(taxels=200, log_bytes=1 << 12) as engine:
        cycles(engine, 30)
        recorded(engine, path, 1)
        assert numbers(path) == [31]


# one that waits


@pytest.fixture
def recorders(engine: FakeEngine, monkeypatch: pytest.MonkeyPatch) -> Iterator[ReadyRecorders]:
    monkeypatch.setattr(launch, "PAUSE", 600.0)  # s: however busy the machine is
    made = ReadyRecorders(engine.ring.name)
    yield made
    made.close()


def test_one_that_stands_by_records_from_the_click_on(recorders, engine, path):
    recorders.tend()
    assert recorders._child is None  # nobody wants one yet
    recorders.prepare()
    pid = recorders._child.pid
    engine.close()
    engine.__init__(engine.ring.name)  # another ring of the name  # type: ignore[misc]
    cycles(engine, 5)
    with recorders(path):
        state = read_state(engine.ring.name)
        assert (state.pid, Path(state.path)) == (pid, path)
        cycles(engine, 5)
        recorders.tend()
        assert recorders._child is None  # the next comes later
    assert numbers(path) == list(range(5, 11))
    recorders._next = 0.0
    recorders.tend()
    assert recorders._child.pid != pid


def killed(recorders: ReadyRecorders) -> None:
    recorders._child.kill()
    recorders._child.wait()


def test_one_that_dies_is_replaced_and_a_click_before_begins_afresh(recorders, path):
    recorders.prepare()
    killed(recorders)
    recorders.tend()
    assert recorders._child is None  # not at once: it may die again
    recorders._next = 0.0
    recorders.tend()
    killed(recorders)
    with recorders(path):
        assert path.exists()
    assert LiveRecording.open(path).finished


def test_one_that_waits_ends_with_whoever_would_tell_it():
    """On a skin that is not there yet."""
    command = [sys.executable, "-m", "skinfield.record.recorder", unique_name()]
    found = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    assert (found.returncode, found.stdout, found.stderr) == (0, b"", b"")
