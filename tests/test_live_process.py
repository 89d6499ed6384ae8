"""The engine in its own process, what starts processes again, and the readers of its ring."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from command_line import invoke
from live_skins import Ticking, fill, settings, skin_ring, unique_name, wait_for
from numpy.testing import assert_array_equal

import skinfield as sf
from skinfield.bridges.launch import Bridge
from skinfield.bridges.settings import BridgeSettings
from skinfield.errors import InputError
from skinfield.estimate import Tracker
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop import preparation, process_supervisor
from skinfield.loop.baseline import TareBaseline
from skinfield.loop.client import Live, NotRunning, Stale, connect
from skinfield.loop.control import order
from skinfield.loop.engine_process import EngineProcess
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.process_supervisor import Child, SupervisedProcess, exit_text
from skinfield.loop.realtime import TimingTable
from skinfield.loop.ring_fields import open_ring
from skinfield.loop.slots import CycleHead
from skinfield.loop.status import Observer
from skinfield.loop.supervisor import EngineFailed, Supervisor
from skinfield.ring import Field, Ring, State
from skinfield.ring.files import sidecar
from skinfield.signal import Count, Port

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")


@pytest.fixture(scope="module")
def finger(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """File that presses the skin while it is there."""
    return tmp_path_factory.mktemp("finger") / "presses"


@pytest.fixture(scope="module")
def running(finger):
    made = settings(sources=(Ticking(fail_after=1500, pressed=finger),))
    with Supervisor(made) as supervisor:
        supervisor.wait(120.0).close()
        yield supervisor
    assert not [each for each in Ring.names() if each.name == made.name]
    assert not sidecar(made.name, "supervisor").exists()
    assert not sidecar(made.name, "control").exists()


@pytest.fixture(scope="module")
def live(running):
    with connect(running.settings.name) as found:
        yield found


def goes_on(live: Live, cycles: int) -> None:
    number = live.latest(timeout=20.0).number
    wait_for(lambda: live.latest(timeout=20.0).number > number + cycles)


def test_estimates_arrive_and_their_age_is_true(live) -> None:
    found = live.latest(max_age=0.5, timeout=20.0)
    assert 0.0 <= found.age <= 0.5
    assert list(found) == ["hexagon72"]
    estimate = found["hexagon72"]
    assert estimate.pressure.shape == (len(estimate.grid),)
    assert estimate.stamp_ns == found.stamp_ns
    assert np.abs(found.readings - 240.0).max() <= 1.0
    with pytest.raises(InputError, match="no patch is named 'other'"):
        found["other"]
    with pytest.raises(Stale, match="expected 1e-09 s at most"):
        live.latest(max_age=1e-9, timeout=0.1)


def test_a_loop_gets_new_readings_only_and_each_once(live) -> None:
    stamps = [found.stamp_ns for found, _ in zip(live, range(10), strict=False)]
    assert (np.diff(stamps) > 0).all()


def test_the_deformation_of_an_estimate_is_made_when_it_is_asked_for(live) -> None:
    estimate = live.latest(timeout=20.0)["hexagon72"]
    assert estimate.displacement.shape == (len(estimate.grid), 3)
    assert np.isfinite(estimate.displacement).all()
    assert estimate.residual.shape == (72,)


def test_nothing_touches_a_still_skin(live) -> None:
    assert live.wait_contact(0.3, force=0.5) is None
    with pytest.raises(InputError, match="patch is 'other'"):
        live.wait_contact(0.1, patch="other")


def test_times_are_published(live) -> None:
    observer = Observer(live.reader)
    goes_on(live, 20)
    found = observer.look()
    plain = json.loads(json.dumps(found.as_dict()))
    assert plain["state"] == "running"
    assert plain["lately"]["cycles"] > 10
    for name in ("wake_us", "ready_us", "latency_us"):
        assert 0 < plain["since_start"][name]["p50"] <= plain["since_start"][name]["max"]
    assert plain["sources"]["Ticking"]["received"] > 0
    assert plain["notes"]["granted"]["priority"] == 0
    assert any("gain not given" in each for each in plain["notes"]["tare"])
    assert plain["memory"]["resident"] > 10**6


def test_a_new_baseline_is_taken_on_order(live) -> None:
    before = int(live.reader.status["tares"][0])
    done = invoke(["tare", live.name])
    assert "leave the skin untouched" in done.output
    wait_for(lambda: live.reader.status["tares"][0] == before + 1)
    assert_array_equal(live.reader.status["calibration"][:, 3], 1.0)
    assert live.state == State.RUNNING


def test_orders_that_are_none_change_nothing(live) -> None:
    address = str(sidecar(live.name, "control"))
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        for data in (b"", b"{", b"[]", b'{"do": 3}', b'{"do": "fly"}', b"\xff" * 2000):
            sender.sendto(data, address)
    with pytest.raises(InputError, match="order is 'fly'"):
        order(live.name, "fly")
    goes_on(live, 5)


def test_a_reader_that_dies_disturbs_nobody(live, running) -> None:
    loop = f"for each in sf.connect({live.name!r}): print('x', flush=True)"
    code = f"import skinfield as sf\n{loop}"
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert child.stdout.readline() == b"x\n"
    child.kill()
    child.wait()
    child.stdout.close()
    restarts = running.restarts
    goes_on(live, 5)
    assert running.restarts == restarts


def test_a_source_that_falls_over_is_opened_again(live, running) -> None:
    restarts = running.restarts
    wait_for(lambda: live.reader.status["sources"][0, Count.REOPENED] > 0)
    assert live.reader.status["sources"][0, Count.DOWN_NS] > 0
    wait_for(lambda: live.latest(timeout=20.0).age < 0.3)
    assert running.restarts == restarts


def test_the_engine_comes_back_after_a_kill_on_the_same_ring(live, running, finger) -> None:
    def contact(age: float = 0.0) -> Any:
        """The oldest one, once it is older than this, s."""

        def found() -> Any:
            rows = live.latest(timeout=60.0).contacts
            return rows[rows["age"].argmax()] if (rows["age"] >= age).any() else None

        return wait_for(found)

    finger.touch()
    held, before = contact(0.2), live.latest(timeout=20.0)
    pid, generation = live.reader.pid, live.reader.generation
    calibration = live.reader.status["calibration"]
    os.kill(pid, signal.SIGKILL)
    wait_for(lambda: live.reader.generation > generation and live.state == State.RUNNING)
    after = wait_for(lambda: (found := live.latest(timeout=60.0)).fresh and found)
    assert after.number > before.number
    assert_array_equal(live.reader.status["calibration"], calibration)  # no new baseline
    assert not live.reader.replaced()
    assert any(each.what == "failed" and "SIGKILL" in each.text for each in running.events)
    told = json.loads(sidecar(live.name, "supervisor").read_text())
    assert told["restarts"] >= 1
    found, waited = contact(), 1e-9 * (live.latest(timeout=20.0).stamp_ns - before.stamp_ns)
    if waited < Tracker().pause:
        assert found["track"] == held["track"]  # it was held meanwhile
    finger.unlink()
    wait_for(lambda: not len(live.latest(timeout=20.0).contacts))
    live.wait_contact(0.3)
    finger.touch()
    assert contact()["track"] > held["track"]
    finger.unlink()
    wait_for(lambda: not len(live.latest(timeout=20.0).contacts))


def test_an_engine_that_cannot_start_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skinfield.loop.supervisor.TRIES", 1)
    small = sf.Patch(np.eye(3)[:, :2] * 1e-2, channel=[1, 2, 300])
    made = settings(skin=small, sources=(Ticking(10),))
    with Supervisor(made) as supervisor, pytest.raises(EngineFailed, match="channel 300"):
        supervisor.wait(60.0)


def test_it_ends_with_its_parent() -> None:
    name = unique_name()
    code = (
        "import sys, time; sys.path.insert(0, sys.argv[1])\n"
        "from live_skins import settings\n"
        "from skinfield.loop.supervisor import State, Supervisor\n"
        f"supervisor = Supervisor(settings(name={name!r})).__enter__()\n"
        "supervisor.wait(120.0, State.STARTING); print(supervisor.child.pid, flush=True)\n"
        "time.sleep(600)\n"
    )
    folder = str(Path(__file__).parent)
    child = subprocess.Popen([sys.executable, "-c", code, folder], stdout=subprocess.PIPE)
    engine = int(child.stdout.readline())
    child.kill()
    child.wait()
    child.stdout.close()
    try:
        wait_for(lambda: not Path(f"/proc/{engine}").exists())
    finally:
        Ring.remove(name)
        sidecar(name, "supervisor").unlink(missing_ok=True)


def test_without_a_skin_it_is_said() -> None:
    name = unique_name()
    with pytest.raises(NotRunning, match="is not there"):
        connect(name)
    with Ring.create(name, [Field("x", "<f8", (1,))]) as ring:
        with pytest.raises(NotRunning, match="something else"):
            Live(name)
        ring.unlink()


@pytest.mark.parametrize(
    ("wrong", "why"), [({"sources": ()}, "sources is empty"), ({"rate": -1}, "rate is -1")]
)
def test_settings_that_no_engine_can_have_are_refused(wrong: dict[str, object], why: str) -> None:
    with pytest.raises(InputError, match=why):
        settings(**wrong)


SECOND = 10**9


@pytest.fixture
def ring() -> Iterator[Ring]:
    with skin_ring() as found:
        yield found


def publish(ring: Ring, *forces: float, fresh: int = 1) -> int:
    """A cycle with contacts of these forces."""
    return fill(ring, np.random.default_rng(ring.number), SECOND, *forces, fresh=fresh)


def test_the_cycle_of_the_contact_is_the_one_that_is_returned(ring: Ring) -> None:
    publish(ring)
    found = []
    with Live(ring.name) as live:
        waiting = threading.Thread(target=lambda: found.append(live.wait_contact(60.0, force=1.0)))
        waiting.start()
        publish(ring, 0.5)
        wanted = publish(ring, 0.25, 1.5)
        waiting.join()
    (snapshot,) = found
    assert snapshot.number == wanted
    assert_array_equal(snapshot.contacts["normal_force"], [0.25, 1.5])


def test_what_was_returned_does_not_change_later(ring: Ring) -> None:
    publish(ring, 2.0)
    with Live(ring.name) as live:
        first = live.wait_contact(60.0)
        readings = first.readings.copy()
        publish(ring, 3.0)
        second = live.wait_contact(60.0)
        assert second is not None
        assert_array_equal(first.readings, readings)
        assert first.patches["contacts"][0] == 1
        assert first.contacts["normal_force"][0] == 2.0
        assert second.contacts["normal_force"][0] == 3.0
        assert not np.array_equal(second.readings, readings)


def test_a_loop_passes_over_cycles_without_a_new_reading(ring: Ring) -> None:
    first = publish(ring)
    with Live(ring.name) as live:
        loop = iter(live)
        assert next(loop).number == first
        publish(ring, fresh=0)
        found = []
        waiting = threading.Thread(target=lambda: found.append(next(loop)))
        waiting.start()
        third = publish(ring)
        waiting.join()
    assert [each.number for each in found] == [third]


def test_a_log_that_one_poll_could_overfill_is_refused() -> None:
    made = settings(log_bytes=1 << 20)
    with pytest.raises(InputError, match="log_bytes is 1048576, expected at least 4194304"):
        open_ring(made, ModelConfig.of(made, ()))


def test_a_new_baseline_that_fails_leaves_the_old_one() -> None:
    def finish() -> TareBaseline:
        raise InputError("counts reach 300")

    notes: dict[str, object] = {}
    engine = SimpleNamespace(again=SimpleNamespace(finish=finish), _note=notes.update)
    EngineProcess._finish_tare(engine, SimpleNamespace())  # type: ignore[arg-type]
    assert engine.again is None
    assert notes == {"tare": ["the baseline stays as it was: counts reach 300"]}


def test_what_searches_say_of_the_readings_is_published_where_it_lasts() -> None:
    notes: dict[str, object] = {}
    engine = sf.Engine(sf.layouts.rectangular(3, 3), rungs=(8,), solver=sf.NonNegative())
    said = ("ContactFit stopped at the deadline, with 1 found", "it reads unlike its model")
    engine.groups[0].last[0] = SimpleNamespace(solution=SimpleNamespace(notes=said))
    process = SimpleNamespace(
        intake=SimpleNamespace(sentences=list),
        updater=SimpleNamespace(engine=engine, unfinished=lambda now_ns: {engine.names[0]: 3}),
        notes=notes,
        _note=notes.update,
    )
    EngineProcess._note_what_is_new(process)  # type: ignore[arg-type]
    (patch,) = engine.names
    assert notes == {"readings": {patch: ["it reads unlike its model"]}, "searching": {patch: 3}}


@pytest.mark.parametrize(("loaded", "solvers"), [(True, "Auto"), (False, "GaussianField")])
def test_a_solver_that_is_loaded_by_the_baseline_answers_first(
    monkeypatch: pytest.MonkeyPatch, loaded: bool, solvers: str
) -> None:
    made = []

    def prepared(model_config: ModelConfig, *_: object, **__: object) -> SimpleNamespace:
        made.append(type(model_config.solver).__name__)
        return SimpleNamespace(updater=model_config, has_ended=loaded)

    monkeypatch.setattr(preparation, "Preparation", prepared)
    known = settings(solver=sf.Auto())
    model_config = ModelConfig.of(known, (Port("hexagon72", 72),))
    start = preparation.Start(known, model_config, None, np.zeros(1, np.int64))
    start._tare = SimpleNamespace(skip=lambda _: None)
    monkeypatch.setattr(preparation, "BaselineCollector", Collected)
    assert start.take(None, 0) is None  # loaded: now the baseline
    assert start.take(None, 0) is None
    assert made == ["GaussianField", "Auto", solvers]
    assert start.take(None, 0).solver == start._preparation.updater.solver


class Collected:
    """A baseline that is there at once."""

    def __init__(self, *_: object) -> None: ...

    def skip(self, channels: object) -> None: ...

    def take(self, channels: object, now_ns: int) -> bool:
        return True

    def finish(self) -> TareBaseline:
        return TareBaseline(np.zeros((72, 4)), np.full(72, 0.002), 10**9)


def test_a_solver_that_cannot_be_prepared_leaves_the_one_that_answers() -> None:
    notes: dict[str, object] = {}

    class Failed:
        progress: ClassVar[dict[str, float]] = {}
        has_ended = True

        @property
        def updater(self) -> None:
            raise InputError("no mechanics")

    by = [SimpleNamespace(solver=each) for each in (sf.GaussianField(), sf.Auto())]
    before = SimpleNamespace(model_config=by[0])
    engine = SimpleNamespace(updater=before, better=1, model_config=by[1], _note=notes.update)
    EngineProcess._improve(engine, Failed())  # type: ignore[arg-type]
    assert engine.updater is before
    assert engine.better is None
    assert notes["failed"] == "Auto cannot be prepared, GaussianField goes on: no mechanics"


@pytest.mark.parametrize(
    ("due", "flags"),
    [(0, CycleFlag(0)), (6, CycleFlag.LATE), (40, CycleFlag.LATE | CycleFlag.OVERRUN)],
)
def test_cycles_say_that_they_were_late(
    monkeypatch: pytest.MonkeyPatch, due: int, flags: CycleFlag
) -> None:
    def nothing(*_: object, **__: object) -> bool:
        return False

    slot = SimpleNamespace(head=np.zeros(len(CycleHead), np.int64))
    slot.head[CycleHead.DUE_NS] = (100 - due) * SECOND
    clock = SimpleNamespace(monotonic_ns=lambda: 100 * SECOND)
    monkeypatch.setattr("skinfield.loop.engine_process.time", clock)
    engine = SimpleNamespace(
        reset=True,
        budget_ns=400_000,
        flags=0,
        intake=SimpleNamespace(channels=None),
        timing=TimingTable(20 * SECOND, 5 * SECOND),
        ring=SimpleNamespace(publish=nothing, heartbeat=nothing),
        waiter=SimpleNamespace(skipped=0),
    )
    cycle = SimpleNamespace(answer=nothing)
    EngineProcess._answer(engine, cycle, slot, int(slot.head[CycleHead.DUE_NS]), 0)  # type: ignore[arg-type]
    assert CycleFlag(int(slot.head[CycleHead.FLAGS])) == flags
    assert not engine.reset


def test_an_engine_that_cannot_be_started_now_is_started_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    supervisor, tries = Supervisor(settings()), []

    def spawn() -> subprocess.Popen[bytes]:
        tries.append(1)
        if len(tries) < 3:
            raise OSError(11, "Resource temporarily unavailable")
        supervisor.stopping.set()
        return subprocess.Popen([sys.executable, "-c", ""])

    monkeypatch.setattr(supervisor, "spawn", spawn)
    monkeypatch.setattr(supervisor, "pauses", (0.01,))
    supervisor._watch()
    supervisor.end()
    assert [each.what for each in supervisor.events] == ["failed", "failed", "started"]
    assert "temporarily unavailable" in supervisor.failure
    supervisor.status_path.unlink()


def test_the_watch_goes_on_where_its_events_cannot_be_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    supervisor = Supervisor(settings())
    monkeypatch.setattr(
        "skinfield.ring.files.sidecar", lambda name, what: tmp_path / "not there" / name
    )
    supervisor.report("failed", "text")
    assert supervisor.events[-1].text == "text"


LONG = 600.0  # s: on a busy machine
SLEEPS, FAILS = "import time; time.sleep(1000)", "raise SystemExit(3)"


class Script(SupervisedProcess):
    def __init__(self, *scripts: str) -> None:
        super().__init__("the script")
        self.scripts = list(scripts)

    def spawn(self) -> Child:
        script = self.scripts.pop(0) if len(self.scripts) > 1 else self.scripts[0]
        if not script:
            raise OSError("no process is left")
        return subprocess.Popen([sys.executable, "-c", script], process_group=0)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SupervisedProcess, "poll", 0.01)
    monkeypatch.setattr(SupervisedProcess, "pauses", (0.0, 0.01))


def test_what_ends_is_started_again_and_told_once(impatient: None) -> None:
    with Script(FAILS, "", FAILS, SLEEPS) as script:
        script.begin()
        script.watch()
        wait_for(lambda: script.restarts == 3 and not script.failure, LONG)
        assert script.child is not None
        child = script.child
        assert script.notices() == [
            "the script ended with status 3; it is started again",
            "the script could not be started: no process is left; it is tried again every 0.01 s",
        ]
        assert script.notices() == []
    assert child.returncode == -15
    assert not script._thread.is_alive()


@pytest.mark.parametrize(
    ("script", "said", "why"),
    [
        ("1 / 0", "line 1, in <module>", "status 1: ZeroDivisionError: division by zero"),
        ("import os; os.abort()", "line 1 in <module>", "signal SIGABRT: Fatal Python error: Ab"),
    ],
)
def test_why_a_process_ended_is_not_lost(impatient: None, script: str, said: str, why: str) -> None:
    class Failing(Script):
        def spawn(self) -> Child:
            words = [sys.executable, "-X", "faulthandler", "-c", self.scripts.pop(0)]
            return subprocess.Popen(words, stderr=self.new_errors())

    with Failing(script, SLEEPS) as failing:
        failing.begin()
        failing.watch()
        wait_for(lambda: failing.restarts == 1 and not failing.failure, LONG)
        assert said in failing.traceback
        assert why in failing.notices()[0]


def test_what_goes_well_for_long_is_told(impatient: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process_supervisor, "SETTLED", 0.0)
    said: list[str] = []
    with Script("", "", SLEEPS) as script:
        with pytest.raises(InputError, match="no process is left"):
            script.begin()
        script.failure = "it was not there"
        script.watch()

        def is_there() -> bool:
            said.extend(script.notices())
            return bool(said) and said[-1] == "the script is there again"

        wait_for(is_there, LONG)
        assert script.restarts == 2


@pytest.mark.parametrize(
    ("code", "said"), [(1, "status 1"), (-9, "signal SIGKILL"), (-99, "signal 99")]
)
def test_how_a_process_ended(code: int, said: str) -> None:
    assert exit_text(code) == said


def test_a_signal_sets_the_event_that_it_interrupts() -> None:
    before = signal.getsignal(signal.SIGUSR1)
    stop = process_supervisor.stop_on(signal.SIGUSR1)
    try:
        with stop._cond:  # as while somebody waits for it, or the same signal came just before
            signal.raise_signal(signal.SIGUSR1)
        assert stop.wait(60.0)
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_a_bridge_that_never_answers_does_not_hold_up_the_end() -> None:
    class Silent(Bridge):
        def spawn(self) -> Child:
            pipe = subprocess.PIPE
            return subprocess.Popen([sys.executable, "-c", SLEEPS], stdin=pipe, stdout=pipe)

    bridge = Silent("zenoh", "nobody", BridgeSettings())
    failures: list[str] = []

    def begin() -> None:
        try:
            bridge.begin()
        except InputError as error:
            failures.append(str(error))

    thread = threading.Thread(target=begin)
    with bridge:
        thread.start()
        wait_for(lambda: bridge.child is not None, LONG)
        child = bridge.child
        began = time.monotonic()
        bridge.stopping.set()
        thread.join(LONG)
        assert time.monotonic() - began < 90.0  # half of what it would be waited for
    assert child.returncode is not None
    assert failures == ["the bridge to zenoh did not start: all was told to end"]
