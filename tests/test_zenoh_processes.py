"""Engines in processes of their own: one skin, of which a part dies and comes back."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from live_skins import fill, skin_ring, unique_name, wait_for

from skinfield.bridges.launch import bridge_settings, bridges
from skinfield.errors import InputError
from skinfield.ring import Ring
from skinfield.settings import BridgeSettings

pytest.importorskip("zenoh")
from zenoh_peers import listening

from skinfield.bridges.zenoh.discovery import ZenohSources

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
TESTS = Path(__file__).resolve().parent
LONG = 600.0  # s: on a busy machine
ROS2 = {"ros2": True}


@contextmanager
def engine(name: str, address: str) -> Iterator["subprocess.Popen[bytes]"]:
    command = [sys.executable, str(TESTS / "zenoh_peers.py"), name, "robot", address]
    child = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, env=os.environ | {"OMP_NUM_THREADS": "1"}
    )
    try:
        yield child
    finally:
        child.terminate()
        child.wait()
        with suppress(InputError):  # it is there only after a SIGKILL
            Ring.remove(name)


def states(sources: ZenohSources) -> list[str]:
    return [source.status()["state"] for source in sources.sources()]


def test_three_engines_are_one_skin_and_one_may_die() -> None:
    names = sorted(unique_name() for _ in range(3))
    with ExitStack() as ends:
        session, address = ends.enter_context(listening())
        sources = ZenohSources(session)
        ends.callback(sources.close)
        children = [ends.enter_context(engine(name, address)) for name in names]
        wait_for(lambda: states(sources) == ["running"] * 3, LONG)
        wait_for(
            lambda: [f.latest() and f.latest().force for f in sources.sources()] == [1.5] * 3, LONG
        )
        one = sources.sources()[1]
        assert one.name == f"robot/{names[1]}"
        children[1].kill()
        killed = time.monotonic()
        wait_for(lambda: one.status()["state"] == "failed", LONG)
        took = time.monotonic() - killed
        assert [*one.latest()] == []  # none of its patches has an answer
        assert one.latest().force == 0.0
        before = [source.latest().number for source in sources.sources()]
        others = [0, 2]
        wait_for(lambda: all(
            sources.sources()[k].latest().number > before[k] + 3 for k in others
        ), LONG)  # fmt: skip
        children[1].wait()
        Ring.remove(names[1])
        ends.enter_context(engine(names[1], address))
        wait_for(lambda: one.status()["state"] == "running" and one.latest().force == 1.5, LONG)
        assert took < LONG  # usually at once, as the system says that the connection ended
        assert sources.sources()[1] is one
        assert sources.notes == {}


def test_a_bridge_that_dies_is_started_again() -> None:
    rng = np.random.default_rng(2)
    with (
        skin_ring() as ring,
        listening() as (session, address),
        closing(ZenohSources(session)) as sources,
    ):
        given = BridgeSettings(zenoh=True, zenoh_connect=(address,))
        with bridges(given, ring.name) as made:
            (bridge,) = made
            assert bridge.facts["key"] == f"skinfield/robot/{ring.name}/**"
            (source,) = wait_for(sources.sources, LONG)

            def comes() -> bool:
                fill(ring, rng, time.time_ns(), 2.0)
                found = source.latest()
                return found is not None and found.force == 2.0

            wait_for(comes, LONG)
            assert bridge.child is not None
            bridge.child.kill()
            wait_for(lambda: source.status()["state"] == "failed", LONG)
            wait_for(lambda: bridge.restarts == 1 and not bridge.failure, LONG)
            said = "the bridge to zenoh ended with signal SIGKILL; it is started again"
            assert bridge.notices() == [said]
            assert bridge.notices() == []
            wait_for(lambda: source.status()["state"] == "running", LONG)
            wait_for(comes, LONG)
        wait_for(lambda: source.status()["state"] == "failed", LONG)


def test_a_bridge_that_cannot_start_says_why() -> None:
    with skin_ring() as ring, listening() as (_, address):
        given = BridgeSettings(zenoh=True, zenoh_listen=(address,))
        match = "bridge to zenoh did not start: zenoh cannot start"
        with pytest.raises(InputError, match=match), bridges(given, ring.name):
            pass


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"zenoh_listen": ("tcp/0.0.0.0:1",)}, "expected zenoh or ros2"),
        ({"ros_domain": 3}, "expected ros2"),
        ({"robot": "a/b"}, "robot is 'a/b'"),
        ({"zenoh": True, "zenoh_connect": ("robot",)}, "expected an address such as"),
        (ROS2 | {"ros_rate": ("wrench",)}, "such as wrench=500"),
        (ROS2 | {"ros_rate": ("force=5",)}, "expected one of contact_wrench, contacts"),
        (ROS2 | {"ros_rate": ("wrench=nan",)}, "messages a second"),
        ({"ros_rate": ("wrench=5",)}, "expected ros2 with it"),
        (ROS2 | {"robot": 80 * "a" + "b", "ros_domain": 3}, "robot is"),
    ],
)
def test_options_that_cannot_be_are_refused_before_anything_starts(given, match) -> None:
    bridge_settings(BridgeSettings(ros2=True, ros_rate=("wrench=500", "taxels=0"), ros_domain=3))
    with pytest.raises(InputError, match=match):
        bridge_settings(BridgeSettings(**given))


def test_a_missing_package_is_named(monkeypatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'skinfield\[zenoh\]'"):
        bridge_settings(BridgeSettings(zenoh=True))


def test_no_bridge_is_no_process() -> None:
    with bridges(BridgeSettings(), "nobody") as made:
        assert made == []
