"""A recorder that stands by, and a recording that begins before it was asked for."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from live_skins import unique_name
from recorder_ring import FakeEngine, recorder_of

from skinfield.files.mcap.live import LiveRecording
from skinfield.record import launch
from skinfield.record.launch import ReadyRecorders
from skinfield.record.recorder import read_state

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
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


def test_what_the_ring_still_has_is_recorded_with_its_readings(
    engine: FakeEngine, tmp_path: Path
) -> None:
    cycles(engine, 30)
    path, since_ns = tmp_path / "a.mcap", time.time_ns()
    cycles(engine, 10)
    recorded(engine, path, since_ns)
    found = LiveRecording.open(path)
    first, second, *_ = found.cycles()
    assert numbers(path) == list(range(first.number, 42))
    data = b"".join(each.data for each in found.blocks())
    assert data == b"".join(engine.written[first.number - 1 :])
    assert first.wall_ns <= since_ns < second.wall_ns


def test_no_further_back_than_the_ring_goes(engine: FakeEngine, tmp_path: Path) -> None:
    for _ in range(200):
        engine.cycle()
    recorded(engine, path := tmp_path / "a.mcap", 1)
    found = numbers(path)
    assert found == list(range(200 - engine.layout[2] * 3 // 4 + 2, 202))


def test_not_before_readings_that_are_gone(tmp_path: Path) -> None:
    with FakeEngine(taxels=200, log_bytes=1 << 12) as engine:
        cycles(engine, 30)
        recorded(engine, path := tmp_path / "a.mcap", 1)
        assert numbers(path) == [31]


# one that waits


@pytest.fixture
def recorders(engine: FakeEngine, monkeypatch: pytest.MonkeyPatch) -> Iterator[ReadyRecorders]:
    monkeypatch.setattr(launch, "PAUSE", 600.0)  # s: however busy the machine is
    made = ReadyRecorders(engine.ring.name)
    yield made
    made.close()


def test_one_that_stands_by_records_from_the_click_on(
    recorders: ReadyRecorders, engine: FakeEngine, tmp_path: Path
) -> None:
    recorders.tend()
    assert recorders._child is None  # nobody wants one yet
    recorders.prepare()
    pid, path = recorders._child.pid, tmp_path / "a.mcap"
    engine.close()
    engine.__init__(engine.ring.name)  # another ring of the name  # type: ignore[misc]
    cycles(engine, 5)
    with recorders(path):
        state = read_state(engine.ring.name)
        assert state is not None
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


def test_one_that_dies_is_replaced_and_a_click_before_begins_afresh(
    recorders: ReadyRecorders, tmp_path: Path
) -> None:
    recorders.prepare()
    killed(recorders)
    recorders.tend()
    assert recorders._child is None  # not at once: it may die again
    recorders._next = 0.0
    recorders.tend()
    killed(recorders)
    with recorders(path := tmp_path / "a.mcap"):
        assert path.exists()
    assert LiveRecording.open(path).finished


def test_one_that_waits_ends_with_whoever_would_tell_it() -> None:
    """On a skin that is not there yet."""
    command = [sys.executable, "-m", "skinfield.record.recorder", unique_name()]
    found = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    assert (found.returncode, found.stdout, found.stderr) == (0, b"", b"")
