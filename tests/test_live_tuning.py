"""A running skin is changed in every way, and its recording shows it as it was."""

import json
import os
import signal
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke
from live_skins import REST, Ticking, TickingStream, pressed_counts, settings, wait_for
from numpy.testing import assert_array_equal

import skinfield as sf
from skinfield.errors import InputError
from skinfield.loop.client import Live, Snapshot, connect
from skinfield.loop.control import order
from skinfield.loop.runtime_parameters import Focus, Tuning
from skinfield.loop.settings import LIVE_TOLERANCE
from skinfield.loop.status import Observer
from skinfield.loop.supervisor import EngineFailed, Supervisor
from skinfield.record.recorder import Recorder, RecorderSettings, forget_state
from skinfield.record.replay import Replay
from skinfield.ring import State
from skinfield.signal import Blocks, Kind
from skinfield.solve import GaussianField, NonNegative, Solver

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
ENOUGH = 20  # cycles
LONG = 600.0  # s: on a busy machine, kernels are compiled first
CHANGE = pressed_counts(1.5) - REST
WINDOW = Focus(patch="hexagon72", low=(-0.01, -0.002), high=(0.01, 0.015))


@dataclass(frozen=True)
class Pressing(Ticking):
    """Source of a skin that is pressed, now harder and now weaker, once a file is there."""

    pressed: Path = Path()

    def open(self) -> "PressingStream":
        return PressingStream(self)


class PressingStream(TickingStream):
    """See `Stream`."""

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        assert isinstance(self.source, Pressing)
        if now_ns - self._last < self.source.period * 1e9:
            return 0
        self._last = now_ns
        force = 0.75 + 0.25 * np.sin(now_ns * 3e-9) if self.source.pressed.exists() else 0.0
        counts = np.rint(REST + force * CHANGE + self._rng.normal(0.0, 0.6, len(CHANGE)))
        blocks.put(now_ns, channel, np.clip(counts, 0, 255), Kind.BYTES)
        self.counters[:2] += 1
        return 1


class Session:
    """A running skin and its recorder, which is stepped here."""

    def __init__(self, supervisor: Supervisor, live: Live, recorder: Recorder) -> None:
        self.supervisor, self.live, self.recorder = supervisor, live, recorder
        self.snapshots: list[Snapshot] = []

    def goes_on(self, cycles: int = ENOUGH) -> None:
        end = self.recorder._live.cycles + cycles
        wait_for(lambda: self.recorder.step() or self.recorder._live.cycles >= end, LONG)
        self.snapshots.append(self.live.latest(timeout=20.0))

    def tare(self) -> np.ndarray:
        """Take another baseline; the one before."""
        status = self.live.reader.status_view
        before, tares = status["calibration"].copy(), int(status["tares"][0])
        self.live.tare()
        wait_for(lambda: self.recorder.step() or status["tares"][0] > tares, LONG)
        return before

    def reconfigure(self, solver: Solver) -> None:
        """In another thread, as the recorder must be stepped meanwhile."""
        failed: list[BaseException] = []

        def change() -> None:
            try:
                self.supervisor.reconfigure(solver=solver, timeout=LONG)
            except BaseException as error:
                failed.append(error)

        thread = threading.Thread(target=change)
        thread.start()
        wait_for(lambda: self.recorder.step() or not thread.is_alive(), LONG)
        if failed:
            raise failed[0]


CHANGES: tuple[dict[str, Any], ...] = (
    {"smoothing": 0.02},
    {"threshold": 0.7},
    {"resolution": 10, "deadline": 1e-3},
    {"focus": WINDOW},
    {"smoothing": 0.0},
    {"smoothing": 0.05, "focus": None, "resolution": "auto"},
)


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What was seen while all was changed, and the recording."""
    folder = tmp_path_factory.mktemp("tuning")
    made = settings(sources=(Pressing(pressed=folder / "pressed"),))
    seen: dict[str, Any] = {"path": folder / "a.mcap", "tunings": []}
    with Supervisor(made) as supervisor:
        supervisor.wait(LONG).close()
        recorder = Recorder(RecorderSettings(name=made.name, path=seen["path"]))
        with connect(made.name) as live:
            session = Session(supervisor, live, recorder)
            seen["first"], seen["snapshots"] = live.tuning, session.snapshots
            session.goes_on()
            seen["before"] = session.tare()
            seen["calibration"] = live.reader.status_view["calibration"].copy()
            (folder / "pressed").touch()
            for changes in CHANGES:
                seen["tunings"].append((changes, live.tune(**changes)))
                session.goes_on()
            observe(session, seen)
            seen["solvers"] = [live.model_config.solver]
            session.reconfigure(GaussianField())
            session.goes_on()
            seen["solvers"].append(live.latest(timeout=20.0).model_config.solver)
            seen["after"], seen["restarts"] = live.tuning, supervisor.restarts
            seen["tares"] = int(live.reader.status_view["tares"][0])
            os.kill(live.reader.pid, signal.SIGKILL)
            again = live.reader.generation + 1
            wait_for(lambda: recorder.step() or live.reader.generation == again, LONG)
            wait_for(lambda: recorder.step() or live.state == State.RUNNING, LONG)
            session.goes_on(2 * ENOUGH)
            seen["killed"] = live.tuning
            seen["solvers"].append(live.latest(timeout=20.0).model_config.solver)
            last = session.snapshots[-1].number
            wait_for(lambda: recorder.step() or recorder._drain._number >= last, LONG)
        recorder.close()
    forget_state(made.name)
    return seen


def observe(session: Session, seen: dict[str, Any]) -> None:
    """What is refused, and what the status and the command tell."""
    live, name = session.live, session.live.name
    with pytest.raises(InputError, match="resolution is 11"):
        live.tune(resolution=11)
    order(name, "set", {"set": {"threshold": "much"}})  # of a program that does not ask first
    wait_for(
        lambda: "threshold is 'much'" in str(notes := Observer(live.reader).look().notes) and notes
    )
    with pytest.raises(EngineFailed, match="the engine stays as it was: solver is ContactFit"):
        session.reconfigure(sf.ContactFit())
    seen["status"] = Observer(live.reader).look().as_dict()["tuning"]
    done = invoke(["tune", name, "--smoothing-ms", "40", "--json"])
    assert done.exit_code == 0, done.output
    seen["command"] = json.loads(done.stdout)
    done = invoke(["tune", name, "--focus", "1,2"])
    assert done.exit_code == 2
    assert "expected PATCH:X0,Y0,X1,Y1 in mm" in done.stderr
    seen["said"] = invoke(["tune", name]).stdout


def test_changes_are_in_force_and_told(told: dict[str, Any]) -> None:
    expected = told["first"]
    for changes, found in told["tunings"]:
        expected = expected.changed(changes)
        assert found == expected
    assert told["status"]["threshold"] == {"value": 0.7, "range": [0.0, 5.0]}
    assert told["status"]["solver"]["value"] == "NonNegative"
    assert told["command"]["smoothing"]["value"] == pytest.approx(0.04)
    assert "threshold   0.7 N" in told["said"]
    assert (
        told["after"]
        == told["killed"]
        == Tuning(deadline=1e-3, threshold=0.7, smoothing=told["command"]["smoothing"]["value"])
    )


def test_another_solver_answers_and_stays_after_a_crash(told: dict[str, Any]) -> None:
    first = NonNegative(tolerance=LIVE_TOLERANCE)
    assert told["solvers"] == [first, GaussianField(), GaussianField()]
    assert (told["restarts"], told["tares"]) == (0, 2)


def test_the_recording_says_what_was_in_force_when(told: dict[str, Any]) -> None:
    source = Replay(told["path"])
    tunings = [each.configuration.tuning for each in source.settings[1:]]
    wanted = [told["first"], *(each for _, each in told["tunings"])]
    assert tunings[: len(wanted)] == wanted
    solvers = [each.configuration.solver for each in source.settings]
    assert solvers[-1] == GaussianField()
    generations = [each.configuration.generation for each in source.settings]
    assert generations == sorted(generations)


def test_all_is_shown_as_it_was(told: dict[str, Any]) -> None:
    source = Replay(told["path"])
    cycles = {each.cycle.number: each.cycle for each in source}
    assert list(cycles) == list(range(min(cycles), max(cycles) + 1))
    assert sum(len(each.contacts) > 0 for each in cycles.values()) > ENOUGH
    for time_ns, name in ((source.index.first_ns, "before"), (source.index.last_ns, "calibration")):
        tare = source.tare(time_ns)
        assert tare is not None
        assert_array_equal(tare.calibration, told[name])
    assert (told["before"] != told["calibration"]).any()
    for snapshot in told["snapshots"]:
        cycle = cycles[snapshot.number]
        assert cycle.patches.tobytes() == snapshot.patches.tobytes()
        assert cycle.contacts.tobytes() == snapshot.contacts.tobytes()
    fields = {each.number for each in source.recording.fields()}
    assert len(fields) > 1
    assert fields <= set(cycles)


def test_what_is_left_of_a_file_is_shown(told: dict[str, Any], tmp_path: Path) -> None:
    data, cut = told["path"].read_bytes(), tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 6 // 10])
    assert len(list(Replay(cut))) > 10
