"""A running skin is changed in every way, and its recording shows it as it was."""

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke
from live_skins import Ticking, settings, wait_for
from numpy.testing import assert_array_equal

import skinfield as sf
from skinfield.errors import InputError
from skinfield.loop.client import Live, Snapshot, connect
from skinfield.loop.control import order
from skinfield.loop.runtime_parameters import Focus, Tuning
from skinfield.loop.status import Observer
from skinfield.loop.supervisor import EngineFailed, Supervisor
from skinfield.record.recorder import Recorder, forget_state
from skinfield.record.replay import Replay
from skinfield.ring import State
from skinfield.solve import GaussianField, Tikhonov

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
ENOUGH = 20  # cycles
LONG = 600.0  # s: on a busy machine, kernels are compiled first
WINDOW = Focus(patch="hexagon72", low=(-0.01, -0.002), high=(0.01, 0.015))


@dataclass
class Session:
    """A running skin that is recorded beside the test; and what was seen of it."""

    supervisor: Supervisor
    live: Live
    recorder: Recorder
    end: Callable[[], None]
    snapshots: list[Snapshot] = field(default_factory=list)
    seen: dict[str, Any] = field(default_factory=dict)

    def goes_on(self, cycles: int = ENOUGH) -> None:
        end = self.recorder._live.cycles + cycles
        wait_for(lambda: self.recorder._live.cycles >= end, LONG)
        self.snapshots.append(self.live.latest(timeout=20.0))

    def tare(self) -> np.ndarray:
        """Take another baseline; the one before."""
        status = self.live.reader.status_view
        before, tares = status["calibration"].copy(), int(status["tares"][0])
        self.live.tare()
        wait_for(lambda: status["tares"][0] > tares, LONG)
        return before


CHANGES: tuple[dict[str, Any], ...] = (
    {"smoothing": 0.02},
    {"threshold": 0.7},
    {"resolution": 10, "deadline": 1e-3},
    {"focus": WINDOW},
    {"smoothing": 0.0},
    {"smoothing": 0.05, "focus": None, "resolution": "auto"},
)


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    """A skin whose engine answers, by a solver that is quick to compile."""
    folder = tmp_path_factory.mktemp("tuning")
    sources = (Ticking(pressed=folder / "pressed"),)
    made = settings(sources=sources, rungs=(10, 12), solver=GaussianField())
    with Supervisor(made) as supervisor:
        supervisor.wait(LONG).close()
        recorder = Recorder(made.name, folder / "a.mcap")
        stop = threading.Event()
        with connect(made.name) as live, ThreadPoolExecutor(1) as beside:
            recording = beside.submit(recorder.run, stop)

            def end() -> None:
                stop.set()
                recording.result()

            yield Session(supervisor, live, recorder, end)
            stop.set()
    forget_state(made.name)


@pytest.fixture(scope="module")
def tuned(running: Session) -> Session:
    """The same after all changes of its tuning, one after the other."""
    live, seen = running.live, running.seen
    running.goes_on()
    seen["first"], seen["before"] = live.tuning, running.tare()
    seen["calibration"] = live.reader.status_view["calibration"].copy()
    running.supervisor.settings.sources[0].pressed.touch()  # type: ignore[attr-defined]
    seen["tunings"] = []
    for changes in CHANGES:
        seen["tunings"].append((changes, live.tune(**changes)))
        running.goes_on()
    return running


@pytest.fixture(scope="module")
def changed(tuned: Session) -> Session:
    """The same with another solver."""
    live, seen = tuned.live, tuned.seen
    seen["after"], seen["solvers"] = live.tuning, [live.model_config.solver]
    tuned.supervisor.reconfigure(solver=Tikhonov(), timeout=LONG)
    tuned.goes_on()
    seen["solvers"].append(live.latest(timeout=20.0).model_config.solver)
    seen["restarts"] = tuned.supervisor.restarts
    seen["tares"] = int(live.reader.status_view["tares"][0])
    return tuned


@pytest.fixture(scope="module")
def recorded(changed: Session) -> Session:
    """The same after a crash, when its recording has ended."""
    live, seen = changed.live, changed.seen
    os.kill(live.reader.pid, signal.SIGKILL)
    again = live.reader.generation + 1
    wait_for(lambda: live.reader.generation == again and live.state == State.RUNNING, LONG)
    changed.goes_on(2 * ENOUGH)
    seen["killed"] = live.tuning
    seen["solvers"].append(live.latest(timeout=20.0).model_config.solver)
    changed.end()
    return changed


def test_changes_are_in_force_and_told(tuned: Session) -> None:
    expected, live, name = tuned.seen["first"], tuned.live, tuned.live.name
    for changes, found in tuned.seen["tunings"]:
        expected = expected.changed(changes)
        assert found == expected
    with pytest.raises(InputError, match="resolution is 11"):
        live.tune(resolution=11)
    order(name, "set", {"set": {"threshold": "much"}})  # of a program that does not ask first
    wait_for(lambda: "threshold is 'much'" in str(Observer(live.reader).look().notes))
    status = Observer(live.reader).look().as_dict()["tuning"]
    assert status["threshold"] == {"value": 0.7, "range": [0.0, 5.0]}
    assert status["solver"]["value"] == "GaussianField"


def test_the_command_changes_it_too(tuned: Session) -> None:
    live, name = tuned.live, tuned.live.name
    before = live.tuning.smoothing
    done = invoke(["tune", name, "--smoothing-ms", "40", "--json"])
    assert done.exit_code == 0, done.output
    smoothing = json.loads(done.stdout)["smoothing"]["value"]
    assert smoothing == pytest.approx(0.04)
    assert live.tuning == Tuning(deadline=1e-3, threshold=0.7, smoothing=smoothing)
    done = invoke(["tune", name, "--focus", "1,2"])
    assert done.exit_code == 2
    assert "expected PATCH:X0,Y0,X1,Y1 in mm" in done.stderr
    assert "threshold   0.7 N" in invoke(["tune", name]).stdout
    live.tune(smoothing=before)


def test_an_engine_that_cannot_be_made_leaves_all_as_it_was(
    tuned: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    supervisor = tuned.supervisor
    beyond = sf.Skin((sf.Patch(np.eye(3)[:, :2] * 1e-2, channel=[1, 2, 300]),))
    with monkeypatch.context() as patch:
        patch.setattr(supervisor, "settings", replace(supervisor.settings, skin=beyond))
        with pytest.raises(EngineFailed, match=r"the engine stays as it was: .*channel 300"):
            supervisor.reconfigure(solver=Tikhonov(), timeout=LONG)
    assert tuned.live.latest(timeout=20.0).model_config.solver == GaussianField()


def test_another_solver_answers(changed: Session) -> None:
    seen = changed.seen
    assert seen["solvers"][:2] == [GaussianField(), Tikhonov()]
    assert (seen["restarts"], seen["tares"]) == (0, 2)


def test_all_stays_after_a_crash(recorded: Session) -> None:
    seen = recorded.seen
    assert seen["solvers"][1:] == [Tikhonov(), Tikhonov()]
    assert seen["after"] == seen["killed"] == Tuning(deadline=1e-3, threshold=0.7, smoothing=0.05)


def test_the_recording_says_what_was_in_force_when(recorded: Session) -> None:
    source = Replay(recorded.recorder.state.path)
    tunings = [each.configuration.tuning for each in source.settings[1:]]
    wanted = [recorded.seen["first"], *(each for _, each in recorded.seen["tunings"])]
    assert tunings[: len(wanted)] == wanted
    solvers = [each.configuration.solver for each in source.settings]
    assert solvers[-1] == Tikhonov()
    generations = [each.configuration.generation for each in source.settings]
    assert generations == sorted(generations)


def test_all_is_shown_as_it_was(recorded: Session) -> None:
    source = Replay(recorded.recorder.state.path)
    cycles = {each.cycle.number: each.cycle for each in source}
    assert list(cycles) == list(range(min(cycles), max(cycles) + 1))
    assert sum(len(each.contacts) > 0 for each in cycles.values()) > ENOUGH
    for time_ns, name in ((source.index.first_ns, "before"), (source.index.last_ns, "calibration")):
        tare = source.tare(time_ns)
        assert_array_equal(tare.calibration, recorded.seen[name])
    assert (recorded.seen["before"] != recorded.seen["calibration"]).any()
    for snapshot in recorded.snapshots:
        cycle = cycles[snapshot.number]
        assert cycle.patches.tobytes() == snapshot.patches.tobytes()
        assert cycle.contacts.tobytes() == snapshot.contacts.tobytes()
    fields = {each.number for each in source.recording.fields()}
    assert len(fields) > 1
    assert fields <= set(cycles)


def test_what_is_left_of_a_file_is_shown(recorded: Session, tmp_path: Path) -> None:
    data, cut = Path(recorded.recorder.state.path).read_bytes(), tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    assert len(list(Replay(cut))) > 10
