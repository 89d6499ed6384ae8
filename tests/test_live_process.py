"""The engine in its own process: it starts, is watched, dies, and goes on."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from live_skins import LAYER, Ticking, settings, sf_board, unique_name, wait_for
from numpy.testing import assert_array_equal

import skinfield as sf
from skinfield.errors import InputError
from skinfield.loop.client import Live, NotRunning, Stale, connect
from skinfield.loop.control import order
from skinfield.loop.status import Observer
from skinfield.loop.supervisor import EngineFailed, Supervisor
from skinfield.ring import Ring, State
from skinfield.ring.files import sidecar
from skinfield.signal import Count

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")


@pytest.fixture(scope="module")
def running():
    made = settings(sources=(Ticking(fail_after=1500),))
    with Supervisor(made) as supervisor:
        supervisor.wait(120.0).close()
        yield supervisor
    assert not [each for each in Ring.names() if each.name == made.name]
    assert not sidecar(made.name, "supervisor").exists()
    assert not sidecar(made.name, "control").exists()


def name_of(supervisor: Supervisor) -> str:
    return supervisor.settings.name


def test_estimates_arrive_and_their_age_is_true(running) -> None:
    with connect(name_of(running)) as live:
        found = live.latest(max_age=0.5, timeout=20.0)
        assert 0.0 <= found.age <= 0.5
        assert list(found) == ["hexagon72"]
        estimate = found["hexagon72"]
        assert estimate.pressure.shape == (len(estimate.grid),)
        assert estimate.stamp_ns == found.stamp_ns
        assert np.abs(found.readings - 240.0).max() <= 1.0
        with pytest.raises(InputError, match="no patch is named 'other'"):
            found["other"]


def test_no_old_estimate_is_given_for_a_new_one(running) -> None:
    with connect(name_of(running)) as live, pytest.raises(Stale, match="expected 1e-09 s at most"):
        live.latest(max_age=1e-9, timeout=0.1)


def test_a_loop_gets_new_readings_only_and_each_once(running) -> None:
    with connect(name_of(running)) as live:
        stamps = [found.stamp_ns for found, _ in zip(live, range(10), strict=False)]
    assert (np.diff(stamps) > 0).all()


def test_the_deformation_of_an_estimate_is_made_when_it_is_asked_for(running) -> None:
    with connect(name_of(running)) as live:
        estimate = live.latest(timeout=20.0)["hexagon72"]
    assert estimate.displacement.shape == (len(estimate.grid), 3)
    assert np.isfinite(estimate.displacement).all()
    assert estimate.residual.shape == (72,)


def test_nothing_touches_a_still_skin(running) -> None:
    with connect(name_of(running)) as live:
        assert live.wait_contact(0.3, force=0.5) is None
        with pytest.raises(InputError, match="patch is 'other'"):
            live.wait_contact(0.1, patch="other")


def test_times_are_published(running) -> None:
    with connect(name_of(running)) as live:
        observer = Observer(live.reader)
        number = live.latest(timeout=20.0).number
        wait_for(lambda: live.latest(timeout=20.0).number > number + 20)
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


def test_a_new_baseline_is_taken_on_order(running) -> None:
    with connect(name_of(running)) as live:
        before = int(live.reader.status["tares"][0])
        done = invoke(["tare", name_of(running)])
        assert "leave the skin untouched" in done.output
        wait_for(lambda: live.reader.status["tares"][0] == before + 1)
        assert_array_equal(live.reader.status["calibration"][:, 3], 1.0)
        assert live.state == State.RUNNING


def test_orders_that_are_none_change_nothing(running) -> None:
    import socket

    address = str(sidecar(name_of(running), "control"))
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        for data in (b"", b"{", b"[]", b'{"do": 3}', b'{"do": "fly"}', b"\xff" * 2000):
            sender.sendto(data, address)
    with pytest.raises(InputError, match="order is 'fly'"):
        order(name_of(running), "fly")
    with connect(name_of(running)) as live:
        number = live.latest(timeout=20.0).number
        wait_for(lambda: live.latest(timeout=20.0).number > number + 5)


def test_a_reader_that_dies_disturbs_nobody(running) -> None:
    loop = f"for each in sf.connect({name_of(running)!r}): print('x', flush=True)"
    code = f"import skinfield as sf\n{loop}"
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert child.stdout is not None
    assert child.stdout.readline() == b"x\n"
    child.kill()
    child.wait()
    child.stdout.close()
    restarts = running.restarts
    with connect(name_of(running)) as live:
        number = live.latest(timeout=20.0).number
        wait_for(lambda: live.latest(timeout=20.0).number > number + 5)
    assert running.restarts == restarts


def test_a_source_that_falls_over_is_opened_again(running) -> None:
    restarts = running.restarts
    with connect(name_of(running)) as live:
        wait_for(lambda: live.reader.status["sources"][0, Count.REOPENED] > 0)
        assert live.reader.status["sources"][0, Count.DOWN_NS] > 0
        wait_for(lambda: live.latest(timeout=20.0).age < 0.3)
    assert running.restarts == restarts


def test_the_engine_comes_back_after_a_kill_on_the_same_ring(running) -> None:
    with connect(name_of(running)) as live:
        before = live.latest(timeout=20.0)
        pid, generation = live.reader.pid, live.reader.generation
        calibration = live.reader.status["calibration"]
        os.kill(pid, signal.SIGKILL)
        wait_for(lambda: live.reader.generation > generation and live.state == State.RUNNING)
        after = wait_for(lambda: (found := live.latest(timeout=60.0)).fresh and found)
        assert after.number > before.number
        assert_array_equal(live.reader.status["calibration"], calibration)  # no new baseline
        assert not live.reader.replaced()
    assert any(each.what == "failed" and "SIGKILL" in each.text for each in running.events)
    told = json.loads(sidecar(name_of(running), "supervisor").read_text())
    assert told["restarts"] >= 1


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
    assert child.stdout is not None
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
    with pytest.raises(NotRunning, match="is not there"):
        connect(unique_name())


def test_live_refuses_rings_of_something_else() -> None:
    from skinfield.ring import Field

    name = unique_name()
    with Ring.create(name, [Field("x", "<f8", (1,))]) as ring:
        with pytest.raises(NotRunning, match="something else"):
            Live(name)
        ring.unlink()


def test_layers_and_boards_are_those_of_the_settings() -> None:
    made = settings()
    assert made.layer == LAYER
    assert made.board == sf_board()
    with pytest.raises(InputError, match="sources is empty"):
        settings(sources=())
    with pytest.raises(InputError, match="rate is -1"):
        settings(rate=-1)
