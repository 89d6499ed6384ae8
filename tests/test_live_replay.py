"""A running skin is recorded and shown again as it was."""

import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from live_skins import settings, wait_for
from numpy.testing import assert_array_equal

from skinfield.loop.client import Live, connect
from skinfield.loop.supervisor import Supervisor
from skinfield.record.recorder import Recorder, RecorderSettings, forget_state
from skinfield.record.replay import Replay
from skinfield.ring import State

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
ENOUGH = 60  # cycles


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A file with a new baseline in it, and a crash of the engine; and what was in force when."""
    path = tmp_path_factory.mktemp("replay") / "a.mcap"
    made = settings()
    with Supervisor(made) as supervisor:
        supervisor.wait(120.0).close()
        recorder = Recorder(RecorderSettings(name=made.name, path=path))

        def goes_on(cycles: int) -> None:
            end = recorder._live.cycles + cycles
            wait_for(lambda: recorder.step() or recorder._live.cycles >= end)
            seen.append(live.latest())

        with connect(made.name) as live:
            status, seen = live.reader.status_view, []
            for _ in range(5):
                goes_on(ENOUGH // 5)
            before = status["calibration"].copy()
            live.tare()
            wait_for(lambda: recorder.step() or status["tares"][0] == 2)
            goes_on(ENOUGH)
            after = status["calibration"].copy()
            os.kill(live.reader.pid, signal.SIGKILL)
            wait_for(lambda: recorder.step() or answers_again(live), 120.0)
            goes_on(ENOUGH)
            wait_for(lambda: recorder.step() or recorder._drain._number >= seen[-1].number)
            recorder.close()
    forget_state(made.name)
    return {"path": path, "before": before, "after": after, "seen": seen}


def answers_again(live: Live) -> bool:
    """Whether an engine answers that was started after the first one."""
    return live.reader.generation > 1 and live.state == State.RUNNING


def test_all_is_shown_as_it_was_across_a_new_baseline_and_a_crash(
    recorded: dict[str, Any],
) -> None:
    source = Replay(recorded["path"])
    cycles = {each.cycle.number: each.cycle for each in source}
    numbers = list(cycles)
    assert numbers == list(range(numbers[0], numbers[-1] + 1))
    first, last = source.index.first_ns, source.index.last_ns
    assert_array_equal(source.tare(first).calibration, recorded["before"])  # type: ignore[union-attr]
    assert_array_equal(source.tare(last).calibration, recorded["after"])  # type: ignore[union-attr]
    assert (recorded["before"] != recorded["after"]).any()
    generations = [each.configuration.generation for each in source.settings]
    assert generations[-1] == 2
    assert len(recorded["seen"]) > 5
    for snapshot in recorded["seen"]:
        cycle = cycles[snapshot.number]
        assert cycle.patches.tobytes() == snapshot.patches.tobytes()
        assert cycle.contacts.tobytes() == snapshot.contacts.tobytes()
    fields = list(source.recording.fields())
    assert len(fields) > 1
    assert {each.number for each in fields} <= set(numbers)


def test_what_is_left_of_a_file_is_shown(recorded: dict[str, Any], tmp_path: Path) -> None:
    data = recorded["path"].read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    assert len(list(Replay(cut))) > 10
