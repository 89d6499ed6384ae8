"""What happens to a recording when the disk, the machine or the recorder itself does not go on."""

import contextlib
import errno
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from command_line import refused, run
from live_skins import wait_for
from mcap.reader import make_reader
from mcap_sample import write
from recorder_ring import missing_bytes, whole

from skinfield.files.mcap.container import FileOutput
from skinfield.files.mcap.live import LiveRecording
from skinfield.record.recorder import Recorder, read_state
from skinfield.record.recover import recover

PATIENCE = 180.0  # s, on a machine that is busy
MODULE, MAIN = ("-m", "skinfield.record.recorder"), "from skinfield.cli import main; main()"


def step(engine, recorder, cycles: int = 1) -> None:
    for _ in range(cycles):
        engine.cycle()
        recorder.step()


class Process:
    """A recorder in a process of its own; as the command, if asked for so."""

    def __init__(self, engine, path, command=False):
        self.name, self.path = engine.ring.name, path
        words = ["-c", MAIN, "record", self.name, "-o"] if command else [*MODULE, self.name]
        self.child = subprocess.Popen(
            [sys.executable, *words, str(path)],
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"COLUMNS": "200"},
        )
        wait_for(lambda: read_state(self.name) or self.child.poll() is not None)

    def flushed(self) -> list[int]:
        """Numbers of the cycles that are in the file."""
        return [cycle.number for cycle in LiveRecording.open(self.path).cycles()]

    def end(self, number) -> tuple[int, str]:
        self.child.send_signal(number)
        _, said = self.child.communicate(timeout=PATIENCE)
        return self.child.returncode, said


@pytest.fixture
def process(request, engine, tmp_path):
    made = Process(engine, tmp_path / "a.mcap", getattr(request, "param", False))
    yield made
    if made.child.poll() is None:
        made.child.kill()
        made.child.communicate()


def test_what_was_flushed_survives_a_kill(engine, process, tmp_path):
    for _ in range(50):
        engine.cycle()
    wait_for(lambda: process.flushed()[-1:] == [50])
    code, _ = process.end(signal.SIGKILL)
    assert code == -signal.SIGKILL
    assert "is gone" in read_state(process.name).ended
    assert not LiveRecording.open(process.path).finished
    good = tmp_path / "good.mcap"
    report = recover(process.path, good)
    assert not report.was_whole
    assert report.messages["/skin/cycles"] == 50
    with good.open("rb") as file:
        assert len(list(make_reader(file).iter_messages(topics=["/skin/cycles"]))) == 50
    whole(engine, good)


@pytest.mark.parametrize(
    ("process", "number", "says"),
    [(False, signal.SIGTERM, ""), (False, signal.SIGINT, ""), (True, signal.SIGINT, "20 cycles")],
    indirect=["process"],
)
def test_told_to_stop_it_finishes_its_file(engine, process, number, says):
    for _ in range(20):
        engine.cycle()
    code, said = process.end(number)
    assert code == 0
    assert says in said if says else not said
    assert "lost" not in said
    assert len(list(whole(engine, process.path).cycles())) == 20
    assert read_state(process.name) is None


class SlowDisk(FileOutput):
    """A file whose writes wait as long as `free` is not set."""

    def __init__(self, path):
        super().__init__(path)
        self.free, self.waiting = threading.Event(), threading.Event()
        self.free.set()

    def append(self, piece) -> None:
        if not self.free.is_set():
            self.waiting.set()
            self.free.wait(PATIENCE)
        super().append(piece)


def test_a_slow_disk_costs_what_does_not_fit_and_that_is_told(engine, tmp_path):
    path, said = tmp_path / "a.mcap", []
    disk = SlowDisk(path)
    recorder = Recorder(engine.ring.name, path, said.append, disk, queue_bytes=1 << 14)
    step(engine, recorder)
    wait_for(lambda: recorder._queue.waiting == 0)
    disk.free.clear()
    step(engine, recorder)
    assert disk.waiting.wait(PATIENCE)
    step(engine, recorder, 400)  # some 250 bytes each
    recorder._next = 0.0
    recorder.step()
    assert recorder.state.dropped_bytes > 0
    assert recorder.state.dropped_cycles > 0
    assert recorder.state.queue_bytes <= 1 << 14
    assert any("does not keep up" in text for text in said)
    disk.free.set()
    wait_for(lambda: recorder._queue.waiting == 0)
    step(engine, recorder, 5)
    state = recorder.close()
    assert state.finished
    found = LiveRecording.open(path)
    numbers = [cycle.number for cycle in found.cycles()]
    kept = sum(len(each.data) for each in found.blocks())
    dropped = [event for event in found.events() if event["kind"] == "dropped"]
    assert sum(each["cycles"] for each in dropped) == 407 - len(numbers) == state.dropped_cycles
    lost = sum(each["bytes"] for each in dropped)
    assert lost == len(b"".join(engine.written)) - kept == state.dropped_bytes
    assert numbers[-5:] == [403, 404, 405, 406, 407]
    assert missing_bytes(found) == lost


@pytest.fixture
def small_disk(tmp_path):
    """A file system with room for 400 kB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", str(folder)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"no small file system can be mounted here: {error}")
    yield folder
    subprocess.run(["umount", "-l", str(folder)], check=True)


def fill(path) -> int:
    """Write a file until nothing more fits; its size."""
    with path.open("wb", buffering=0) as file:
        with contextlib.suppress(OSError):
            while True:
                file.write(bytes(4096))
        return file.tell()


def test_a_full_disk_that_is_emptied_again(engine, small_disk):
    """Really full: nothing is lost as long as the queue holds it."""
    path, said = small_disk / "a.mcap", []
    ballast = small_disk / "ballast"
    recorder = Recorder(engine.ring.name, path, said.append)
    assert fill(ballast) > 300_000

    def write_on() -> float:
        step(engine, recorder)
        return recorder._disk.failing_since

    wait_for(write_on)
    step(engine, recorder, 100)
    recorder._next = 0.0
    recorder.step()
    assert recorder.state.failing
    assert "No space left" in said[-1]
    size = path.stat().st_size
    so_far = [cycle.number for cycle in LiveRecording.open(path).cycles()]  # it can be read
    assert so_far == list(range(1, len(so_far) + 1))
    ballast.unlink()
    wait_for(lambda: not recorder._disk.failing_since)
    assert path.stat().st_size > size
    state = recorder.close()
    assert state.finished
    assert state.lost == state.dropped_cycles == state.given_up == 0
    found = whole(engine, path)
    (event,) = [each for each in found.events() if each["kind"] == "disk_failed"]
    assert "No space left" in event["text"]
    assert event["seconds"] > 0


def test_a_disk_that_stays_full(engine, small_disk, tmp_path):
    path, said = small_disk / "a.mcap", []
    recorder = Recorder(engine.ring.name, path, said.append)
    engine.keep = False

    def write_on() -> float:
        step(engine, recorder, 200)
        return recorder._disk.failing_since

    wait_for(write_on)
    fill(small_disk / "ballast")
    state = recorder.close()
    assert not state.finished
    assert state.given_up > 0
    assert "No space left" in state.failure
    assert any("could not be written at the end" in text for text in said)
    good = tmp_path / "good.mcap"
    assert recover(path, good).messages["/skin/cycles"] > 0
    assert LiveRecording.open(good).finished


class Room(FileOutput):
    """A file that may have so many bytes."""

    room = 1 << 30

    def append(self, piece) -> None:
        if self.end + len(piece) > self.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        super().append(piece)


def test_the_last_bytes_of_a_full_disk_take_the_end(engine, tmp_path):
    path = tmp_path / "a.mcap"
    disk = Room(path)
    recorder = Recorder(engine.ring.name, path, output=disk)
    step(engine, recorder)
    wait_for(lambda: recorder._disk.last_flush and disk.end > 12_000)
    disk.room = disk.end + 20_000
    engine.keep = False
    for _ in range(500):
        step(engine, recorder)
        if recorder._disk.failing_since:
            break
        if recorder._writer.waiting < 30_000:  # all in one chunk, longer than what is left
            recorder._disk.last_flush = time.monotonic()
    wait_for(lambda: recorder._disk.failing_since)
    state = recorder.close()
    assert state.finished
    found = LiveRecording.open(path)
    last = list(found.events())[-1]
    assert (last["kind"], last["messages"]) == ("given_up", state.given_up)
    assert state.given_up > 0
    assert found.finished


def test_half_a_piece_is_taken_back(tmp_path, monkeypatch):
    """A disk that takes the first half of a write and then refuses."""
    output = FileOutput(tmp_path / "a")
    output.append(b"12345678")
    real = os.pwrite
    calls = []

    def half(file, data, at):
        calls.append(at)
        if len(calls) > 1:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(file, bytes(data)[: len(data) // 2], at)

    monkeypatch.setattr(os, "pwrite", half)
    with pytest.raises(OSError, match="No space"):
        output.append(b"abcdefgh")
    monkeypatch.undo()
    assert (tmp_path / "a").read_bytes() == b"12345678"
    output.append(b"xy")
    output.close()
    assert (tmp_path / "a").read_bytes() == b"12345678xy"


def test_record_what_cannot_be(tmp_path):
    path = tmp_path / "a.mcap"
    assert "expected a ring" in refused("record", "nonesuch-ring", "-o", path)
    assert "ends in .mcap" in refused("record", "-o", tmp_path / "a.bag")
    assert "--duration" in refused("record", "-o", path, "--duration", "0")
    assert list(tmp_path.iterdir()) == []


def test_recover(tmp_path):
    path, bad, good = (tmp_path / name for name in ("a.mcap", "bad.mcap", "good.mcap"))
    write(path, close=False)
    text = run("recover", path, "-o", good)
    assert "saved 30 messages" in text
    assert "had no end; nothing had to be left out" in text
    bad.write_bytes(path.read_bytes()[:-10])
    assert "expected a new file" in refused("recover", bad, "-o", good)
    text = run("recover", bad, "-o", good, "--force")
    assert "saved 28 messages" in text or "saved 30 messages" in text
    assert "bytes at the end" in text
    text = run("recover", good, "-o", tmp_path / "again.mcap")
    assert "is whole: nothing was wrong with it" in text
    bad.write_text("no recording")
    assert "it is no MCAP file" in refused("recover", bad, "-o", good, "--force")
