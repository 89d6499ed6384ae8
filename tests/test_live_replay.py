"""A running skin is recorded and answered again: the same bits, or a reason why not."""

import os
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_skins import settings, wait_for
from mcap_sample import ROWS
from numpy.testing import assert_array_equal

from skinfield.acquisition.recorded import CycleFlag
from skinfield.errors import FileError
from skinfield.live.client import Live, connect
from skinfield.live.control import order
from skinfield.live.engine_process import LISTEN
from skinfield.live.recorder import Recorder
from skinfield.live.recorder_settings import RecorderSettings
from skinfield.live.recorder_state import forget_state
from skinfield.live.replay import Replay
from skinfield.live.supervisor import Supervisor
from skinfield.ring import State
from skinfield.sinks.mcap import RecordingWriter
from skinfield.sources.recordings.mcap_live import LiveRecording

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
ENOUGH = 60  # cycles


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A file with a new baseline in it, and a crash of the engine; and what was in force when."""
    path = tmp_path_factory.mktemp("replay") / "a.mcap"
    made = settings(key_seconds=0.3)
    with Supervisor(made) as supervisor:
        supervisor.wait(120.0).close()
        recorder = Recorder(RecorderSettings(name=made.name, path=path))

        def goes_on(cycles: int) -> None:
            end = recorder._drain.cycles + cycles
            wait_for(lambda: recorder.step() or recorder._drain.cycles >= end)

        with connect(made.name) as live:
            status = live.reader.status_view
            goes_on(ENOUGH)
            before = status["calibration"].copy()
            live.tare()
            wait_for(lambda: recorder.step() or status["tares"][0] == 2)
            goes_on(ENOUGH)
            after = status["calibration"].copy()
            last = live.reader.number
            os.kill(live.reader.pid, signal.SIGKILL)
            wait_for(lambda: recorder.step() or answers_again(live), 120.0)
            first = live.reader.number
            goes_on(ENOUGH)
            recorder.close()
            late = recorded_late(live, path.with_name("late.mcap"))
    forget_state(made.name)
    return {"path": path, "before": before, "after": after, "away": (last, first), "late": late}


def recorded_late(live: Live, path: Path) -> dict[str, Any]:
    """A file that is wanted from a time on at which its recorder is not there yet."""
    name, since_ns = live.reader.name, time.time_ns()
    order(name, "key")
    asked = live.reader.number
    wait_for(lambda: live.reader.number > asked + 2 * LISTEN)
    number = live.reader.number
    recorder = Recorder(RecorderSettings(name=name, path=path, since_ns=since_ns))
    wait_for(lambda: recorder.step() or live.reader.number > number + ENOUGH)
    recorder.close()
    return {"path": path, "since_ns": since_ns, "number": number}


def answers_again(live: Live) -> bool:
    """Whether an engine answers that was started after the first one."""
    return live.reader.generation > 1 and live.state == State.RUNNING


def test_all_comes_out_the_same_across_a_new_baseline_and_a_crash(
    recorded: dict[str, Any],
) -> None:
    source = Replay(recorded["path"])
    assert source.tared is not None
    assert_array_equal(source.tared.calibration, recorded["before"])
    answered = [(each.recorded.number, each.same, each.fresh) for each in source]
    assert_array_equal(source.tared.calibration, recorded["after"])
    assert (recorded["before"] != recorded["after"]).any()
    numbers, same, fresh = (np.array(each) for each in zip(*answered, strict=True))
    last, first = recorded["away"]
    assert (numbers < last).sum() > ENOUGH
    assert (numbers > first).sum() > ENOUGH // 4
    assert same.all()
    assert fresh.any()
    away = np.diff(numbers)
    assert (away > 1).sum() == 1  # while the engine was started again
    assert source.gaps == 0


def test_one_that_began_late_is_answered_from_the_time_on_that_was_wanted(
    recorded: dict[str, Any],
) -> None:
    late = recorded["late"]
    source = Replay(late["path"])
    answered = [(each.recorded, each.same, each.whole) for each in source]
    assert all(same for _, same, _ in answered)
    whole = [cycle for cycle, _, whole in answered if whole]
    assert whole[0].flags & CycleFlag.KEY
    assert whole[0].number <= late["number"]  # from before the recorder was there
    keys = [each for each in source.moments.keys if each >= late["since_ns"]]
    assert whole[0].wall_ns <= keys[0]
    assert source.gaps == 0
    assert len(whole) > ENOUGH


def test_other_decisions_are_noticed(recorded: dict[str, Any]) -> None:
    source = Replay(recorded["path"])
    found = next(each for each in source if each.fresh)
    told = found.recorded.patches.copy()
    told["stamp_ns"] += 1
    assert source._cycle is not None
    changed = replace(found.recorded, patches=told)
    again = source._answered(source._cycle, changed, key=True)
    assert not again.same


def test_what_is_left_of_a_file_is_answered(recorded: dict[str, Any], tmp_path: Path) -> None:
    data = recorded["path"].read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    answered = list(Replay(cut))
    assert len(answered) > 10
    assert all(each.same for each in answered)


def test_rows_of_another_skin_are_refused(recorded: dict[str, Any]) -> None:
    source = Replay(recorded["path"])
    good = next(LiveRecording.open(recorded["path"]).cycles())
    many = good.patches.copy()
    many["contacts"] = 9
    for wrong in (
        replace(good, patches=good.patches[:0]),
        replace(good, patches=many),
        replace(good, patches=np.zeros(1, ROWS.patch)),
        replace(good, contacts=np.zeros(2, ROWS.contact)),
    ):
        with pytest.raises(FileError, match="expected those of the skin"):
            source._begin(wrong)


def test_a_recording_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    RecordingWriter(path, (), layout=ROWS).close()
    with pytest.raises(FileError, match="encloses no configuration"):
        Replay(path)
