"""What the page lets one do: presses, settings and recordings, also where that goes wrong."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from live_skins import unique_name, wait_for
from websockets.sync.client import connect

from skinfield.errors import InputError
from skinfield.page.live_controller import LiveController, tune
from skinfield.page.presser import MOST, Presser, PressRequest
from skinfield.page.recordings import SILENT, Recordings
from skinfield.page.server import serve_page
from skinfield.page.settings import PageSettings
from skinfield.page.source import DataSource, LiveSource
from skinfield.record.recorder import RecorderState, forget_state


class Skin:
    """A virtual skin that refuses presses beyond 2 N, and keeps what presses."""

    def __init__(self) -> None:
        self.there: dict[str, float] = {}
        self.scenes: list[str] = []
        self.notes: list[str] = []
        self.waits: list[str] = []
        self.tools: list[tuple[str, float]] = []

    def ask(self, command):
        do, id = command["do"], command.get("id")
        if do == "prepare":
            self.tools.append((command["shape"], command["radius"]))
        if do == "press":
            if command["force"] > 2.0:
                raise InputError(f"force is {command['force']:g} N, expected 2 N at most")
            self.there[id] = command["force"]
        elif do == "release" and id is None:
            self.there.clear()
        elif do == "release" and self.there.pop(id, None) is None:
            raise InputError(f"id is {id!r}, expected that of a press by hand")
        elif do == "scene":
            self.scenes.append(command["scene"])
        presses = [{"id": id, "force": force} for id, force in self.there.items()]
        return {"lines": [{"presses": presses}], "waits": self.waits, "notes": list(self.notes)}


class Case:
    def __init__(self) -> None:
        self.skin, self.why, self.said = Skin(), "", []
        self.presser = Presser(self.skin, lambda: self.why, self.said.append)


@pytest.fixture
def case() -> Case:
    return Case()


def press(id: str, force: float | None = 1.0, radius: float | None = 5e-3) -> PressRequest:
    return PressRequest(id, "hexagon72", 0.0, 0.0, force, radius, "ball")


def test_a_refused_press_is_none(case) -> None:
    with pytest.raises(InputError, match="2 N at most"):
        case.presser.press(press("1-a", 3.0))
    with pytest.raises(InputError, match="expected its force and radius"):
        case.presser.press(press("1-a", None))
    assert case.presser.placed == 0
    case.presser.lift("1-a")
    assert case.presser.let_off(0.0)


def test_presses_wait_for_the_baseline(case) -> None:
    case.why = "the engine starts"
    case.presser.begin("press")
    assert case.presser.press(press("1-a"))["waits"] == "the engine starts"
    case.presser.press(press("1-b", 3.0))
    case.presser.press(press("1-c"))
    case.presser.lift("1-c")
    case.presser.do_waiting()
    assert case.skin.there == {}
    case.why = ""
    case.presser.do_waiting()
    assert case.skin.there == {"1-a": 1.0}
    assert case.skin.scenes == ["press", "idle"]
    assert "2 N at most" in case.said[0]
    assert case.presser.placed == 1
    case.presser.do_waiting()
    assert len(case.said) == 1


def test_what_the_skin_let_go_is_told_and_gone(case) -> None:
    case.presser.press(press("1-a"))
    case.skin.waits = ["1-a"]
    case.presser.truth()
    assert case.presser.preparing
    del case.skin.there["1-a"]
    case.skin.waits, case.skin.notes = [], ["press 1-a was let go: too hard"]
    assert case.presser.truth() == []
    case.presser.truth()
    assert case.said == ["a press was let go: too hard"]
    assert case.presser.placed == 0
    assert not case.presser.preparing


def test_common_tools_are_prepared_and_others_when_they_are_asked_for(case) -> None:
    case.presser.prepare_common()
    offered = case.presser.offer()["common"]
    assert sorted(case.skin.tools) == sorted((s, r) for s in offered for r in offered[s])
    assert {("ball", 5e-3), ("ball", 10e-3), ("ball", 20e-3), ("flat", 3e-3)} < {*case.skin.tools}
    case.presser.prepare("flat", 4.4e-3)
    assert case.skin.tools[-1] == ("flat", 4.4e-3)
    for shape, radius in (("cone", 5e-3), ("ball", 0.0), ("ball", 0.5)):
        with pytest.raises(InputError, match=r"shape|radius"):
            case.presser.prepare(shape, radius)
    assert case.presser.tools() == {"ready": [], "preparing": []}


def test_presses_go_with_their_browser(case) -> None:
    for id in ("1-a", "1-b", "11-a"):
        case.presser.press(press(id))
    del case.skin.there["1-b"]  # let go, and not noted yet
    case.presser.leave("1-")
    assert case.skin.there == {"11-a": 1.0}
    assert case.presser.placed == 1
    case.presser.lift(None)
    assert case.skin.there == {}


def test_a_browser_cannot_press_without_end(case) -> None:
    for number in range(MOST):
        case.presser.press(press(f"1-{number}"))
    with pytest.raises(InputError, match="lift some"):
        case.presser.press(press("1-more"))
    case.presser.press(press("1-0", 0.5))  # but change what stands
    assert case.skin.there["1-0"] == 0.5


def test_a_scene_waits_and_lets_off(case) -> None:
    case.why = "a baseline is being taken"
    with pytest.raises(InputError, match="a baseline is being taken"):
        case.presser.scene("slide")
    case.presser.scene("idle")
    case.why = ""
    case.presser.scene("slide")
    case.skin.there["slide-0"] = 1.0
    assert not case.presser.let_off(0.1)
    case.skin.there.clear()
    assert case.presser.let_off(0.1)
    assert case.presser.playing == "idle"


RANGES = {
    "deadline": (2e-5, 9.000000000000001e-4),
    "smoothing": (0.0, 1.0),
    "threshold": (0.0, 5.0),
}


class Tuned:
    """Stands for a live skin; refuses what is outside of its ranges by one bit."""

    tuning = None
    limits = SimpleNamespace(
        as_dict=lambda _: {name: {"range": list(ends)} for name, ends in RANGES.items()}
    )

    def tune(self, **changes: Any) -> None:
        for name, value in changes.items():
            low, high = RANGES[name]
            assert low <= value <= high, (name, value)
        self.took = changes


@pytest.mark.parametrize(
    ("what", "value", "took"),
    [
        ("deadline_us", 20, {"deadline": 2e-5}),
        ("deadline_us", 900, {"deadline": 9.000000000000001e-4}),
        ("deadline_us", 400, {"deadline": pytest.approx(4e-4)}),
        ("smoothing_ms", 1000, {"smoothing": 1.0}),
        ("threshold_N", 0, {"threshold": 0.0}),
    ],
)
def test_the_ends_of_a_range_are_in_it(what: str, value: float, took: dict[str, Any]) -> None:
    live = Tuned()
    tune(live, what, value)  # type: ignore[arg-type]
    assert live.took == took


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


def kill_recorder(recorder: Recorder) -> None:
    """Kill it, and leave it to be asked for how it ended."""
    recorder.child.kill()
    os.waitid(os.P_PID, recorder.child.pid, os.WEXITED | os.WNOWAIT)


def test_one_is_begun_and_ended(recordings, recorder) -> None:
    assert recordings.state() is None
    file = recordings.begin()["file"]
    told = recordings.state()
    assert (told["file"], told["mine"]) == (file, True)
    with pytest.raises(InputError, match="a recording is going on"):
        recordings.begin()
    assert recordings.end() == {"file": file}
    assert recordings.state() is None
    assert (recordings.names, recorder.said) == ([file], [])
    with pytest.raises(InputError, match="no recording was begun"):
        recordings.end()


def test_a_killed_recorder_is_told_and_another_may_begin(recordings, recorder) -> None:
    file = recordings.begin()["file"]
    kill_recorder(recorder)
    assert recordings.state() is None
    (said,) = recorder.said
    assert "skinfield recover" in said
    assert recordings.names == [file]
    assert recordings.state() is None  # what it left behind counts no more
    again = recordings.begin()["file"]
    assert again != file
    recordings.close()
    assert recordings.names == [file, again]


def test_the_end_of_a_killed_recorder_says_how_to_save_the_file(recordings, recorder) -> None:
    file = recordings.begin()["file"]
    kill_recorder(recorder)
    with pytest.raises(InputError, match="skinfield recover"):
        recordings.end()
    assert recordings.names == [file]
    assert recordings.state() is None
    recordings.begin()
    recordings.end()


def test_what_others_record_counts_as_long_as_they_say_so(recordings, recorder) -> None:
    other = RecorderState(pid=os.getppid(), path="x.mcap", told_ns=time.time_ns())
    other.write(recorder.name)
    found = recordings.state()
    assert (found["file"], found["mine"]) == ("x.mcap", False)
    with pytest.raises(InputError, match="a recording is going on"):
        recordings.begin()
    replace(other, told_ns=other.told_ns - int(2 * SILENT * 1e9)).write(recorder.name)
    assert recordings.state() is None
    replace(other, pid=2**22 + 1).write(recorder.name)  # more than there can be
    assert recordings.state() is None


def test_one_stands_ready_from_the_first_browser_on(recordings, recorder) -> None:
    controller = LiveController(lambda: LiveSource("nonesuch"), recordings=recordings)
    controller.controls()
    assert recorder.asked == ["tend"]  # which does nothing until one is wanted
    with serve_page(PageSettings(port=0), lambda: (), controller) as page:
        assert "prepare" not in recorder.asked
        with connect(f"ws://127.0.0.1:{page.port}/socket"):
            wait_for(lambda: "prepare" in recorder.asked)
    controller.close()
    assert recorder.asked[-1] == "close"
