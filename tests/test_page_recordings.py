"""Recordings from the page, whose recorder may be killed: the control stays of use."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from live_skins import unique_name, wait_for
from websockets.sync.client import connect

from skinfield.errors import InputError
from skinfield.page import serve_page
from skinfield.page.live_controller import LiveController
from skinfield.page.recordings import SILENT, Recordings
from skinfield.page.source import DataSource, LiveSource
from skinfield.record.recorder import RecorderState, forget_state
from skinfield.settings import PageSettings


class Recorder:
    """Like that of the command, but of a process that sleeps."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.child: subprocess.Popen[bytes] | None = None
        self.asked: list[str] = []
        self.said: list[str] = []

    def prepare(self) -> None:
        self.asked.append("prepare")

    def tend(self) -> None:
        self.asked.append("tend")

    def close(self) -> None:
        self.asked.append("close")

    @contextmanager
    def __call__(self, path: Path) -> Iterator[None]:
        self.child = child = subprocess.Popen(
            [sys.executable, "-c", "import time; time.sleep(1000)"]
        )
        try:
            path.write_bytes(b"half")
            RecorderState(pid=child.pid, path=str(path), told_ns=time.time_ns()).write(self.name)
            yield
        finally:
            child.terminate()
            if child.wait() == -9:
                raise InputError(f"the recorder failed: `skinfield recover {path}`")
            forget_state(self.name)


@pytest.fixture
def recorder() -> Iterator[Recorder]:
    made = Recorder(unique_name())
    yield made
    if made.child is not None:
        made.child.kill()
        made.child.wait()
    forget_state(made.name)


@pytest.fixture
def recordings(recorder: Recorder, tmp_path: Path) -> Recordings:
    def replay(path: Path) -> DataSource:
        raise AssertionError("no file is opened here")

    return Recordings(recorder.name, recorder, replay, tmp_path, recorder.said.append)


def killed(recorder: Recorder) -> None:
    """Kill it, and leave it to be asked for how it ended."""
    assert recorder.child is not None
    recorder.child.kill()
    os.waitid(os.P_PID, recorder.child.pid, os.WEXITED | os.WNOWAIT)


def test_one_is_begun_and_ended(recordings: Recordings, recorder: Recorder) -> None:
    assert recordings.state() is None
    file = recordings.begin()["file"]
    told = recordings.state()
    assert told is not None
    assert (told["file"], told["mine"]) == (file, True)
    with pytest.raises(InputError, match="a recording is going on"):
        recordings.begin()
    assert recordings.end() == {"file": file}
    assert recordings.state() is None
    assert (recordings.names, recorder.said) == ([file], [])
    with pytest.raises(InputError, match="no recording was begun"):
        recordings.end()


def test_a_killed_recorder_is_told_and_another_may_begin(
    recordings: Recordings, recorder: Recorder
) -> None:
    file = recordings.begin()["file"]
    killed(recorder)
    assert recordings.state() is None
    (said,) = recorder.said
    assert "skinfield recover" in said
    assert recordings.names == [file]
    assert recordings.state() is None  # what it left behind counts no more
    again = recordings.begin()["file"]
    assert again != file
    recordings.close()
    assert recordings.names == [file, again]


def test_the_end_of_a_killed_recorder_says_how_to_save_the_file(
    recordings: Recordings, recorder: Recorder
) -> None:
    file = recordings.begin()["file"]
    killed(recorder)
    with pytest.raises(InputError, match="skinfield recover"):
        recordings.end()
    assert recordings.names == [file]
    assert recordings.state() is None
    recordings.begin()
    recordings.end()


def test_what_others_record_counts_as_long_as_they_say_so(
    recordings: Recordings, recorder: Recorder
) -> None:
    other = RecorderState(pid=os.getppid(), path="x.mcap", told_ns=time.time_ns())
    other.write(recorder.name)
    found = recordings.state()
    assert found is not None
    assert (found["file"], found["mine"]) == ("x.mcap", False)
    with pytest.raises(InputError, match="a recording is going on"):
        recordings.begin()
    replace(other, told_ns=other.told_ns - int(2 * SILENT * 1e9)).write(recorder.name)
    assert recordings.state() is None
    replace(other, pid=2**22 + 1).write(recorder.name)  # more than there can be
    assert recordings.state() is None


def test_one_stands_ready_from_the_first_browser_on(
    recordings: Recordings, recorder: Recorder
) -> None:
    controller = LiveController(lambda: LiveSource("nonesuch"), recordings=recordings)
    controller.controls()
    assert recorder.asked == ["tend"]  # which does nothing until one is wanted
    with serve_page(PageSettings(port=0), lambda: (), controller) as page:
        assert "prepare" not in recorder.asked
        with connect(f"ws://127.0.0.1:{page.port}/socket"):
            wait_for(lambda: "prepare" in recorder.asked)
    controller.close()
    assert recorder.asked[-1] == "close"
