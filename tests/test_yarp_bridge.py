"""Contacts out to YARP: from a robot's port through the engine to skin_events, and its numbers."""

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

import numpy as np
import pytest
from live_skins import pressed_counts, settings, unique_name, wait_for
from yarp_peers import NameServer, Sender, values_of

import skinfield as sf
from skinfield.bridges.launch import Bridge
from skinfield.bridges.yarp import YarpSettings, publisher
from skinfield.errors import InputError
from skinfield.loop.client import connect
from skinfield.loop.supervisor import Supervisor
from skinfield.settings import from_plain
from skinfield.skin import Patch, Skin
from skinfield.wire import yarp
from skinfield.wire.sources import YarpPort, YarpText

FORCE, PLACE = 1.0, (0.0, 7.5e-3)
POSE = np.array([[0.0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]])
NAME = "/skinManager/skin_events:o"


class Robot:
    """A name server, and a port that sends what is told, fifty times a second."""

    def __init__(self) -> None:
        self.names, self.sender = NameServer(), Sender()
        self.names.known["/icub/skin/left_forearm"] = ("127.0.0.1", self.sender.port)
        self.counts = np.full(72, 240.0)
        self._noise = np.random.default_rng(5)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(0.02):
            noise = self._noise.integers(-1, 2, 72)
            self.sender.send(np.clip(self.counts + noise, 0, 255).tolist())

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.sender.close()
        self.names.close()


def skin() -> Skin:
    plain = sf.layouts.hexagon72()
    patch = Patch(
        plain.positions, plain.pad_diameter, normals=plain.normals, name="l_forearm",
        channel=np.arange(72), link_from_patch=POSE,
    )  # fmt: skip
    return Skin((patch,))


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    made = Robot()
    yield made
    made.close()


@pytest.fixture(scope="module")
def running(robot: Robot) -> Iterator[Supervisor]:
    port = YarpPort("l_forearm", 72, "/icub/skin/left_forearm")
    source = YarpText((port,), port=robot.names.port)
    made = settings(skin=skin(), sources=(source,), name=unique_name())
    with Supervisor(made) as supervisor:
        supervisor.wait(600.0).close()
        yield supervisor


@contextmanager
def port_reader(robot: Robot, port: str) -> Iterator[Iterator[tuple[str, list]]]:
    """Stamps and values of a port, as plain lines."""
    with socket.create_connection(robot.names.known[port], 60.0) as link:
        lines = link.makefile("r", newline="\r\n")
        link.sendall(b"CONNECT /reader\r\nr\r\n")
        assert lines.readline() == "Welcome /reader\r\n"
        yield ((lines.readline().rstrip(), values_of(lines.readline().rstrip())) for _ in count())


def test_a_press_on_the_robot_comes_out_as_a_contact(robot: Robot, running: Supervisor) -> None:
    name, server = running.settings.name, f"127.0.0.1:{robot.names.port}"
    told = {"robot": "icub", "name_server": server, "port": NAME, "taxels": True}
    with Bridge("yarp", name, from_plain(YarpSettings, told)) as bridge:
        bridge.begin()
        child, taxels = bridge.child, f"/icub/skinfield/{name}/l_forearm_comp:o"
        assert (bridge.facts["port"], bridge.facts["taxels"]) == (NAME, [taxels])
        assert {NAME, taxels} <= set(robot.names.known)
        with port_reader(robot, NAME) as events:
            follow_a_press(events, taxels, robot, name)
    assert child.returncode == 0
    assert not {NAME, taxels} & set(robot.names.known)


def follow_a_press(events: Iterator, port: str, robot: Robot, name: str) -> None:
    _, nothing = next(events)
    assert nothing == []
    robot.counts = pressed_counts(FORCE, PLACE)
    settled = time.monotonic() + 180.0
    found: list[list] = []
    while len(found) < 15:
        assert time.monotonic() < settled
        stamp, contacts = next(events)
        found = [*found, contacts[0]] if len(contacts) == 1 else []
    with connect(name) as live:
        row = live.latest(timeout=20.0).contacts[0]
    word, number, seconds = stamp.split()
    assert (word, number.isdecimal()) == ("D", True)
    assert abs(float(seconds) - time.time()) < 60.0
    force = check_contacts(found[-5:])
    assert abs(force - row["normal_force"]) < 0.3 * FORCE  # noise moves it from reading to reading
    assert abs(force - FORCE) < 2.0 * row["force_std"]
    assert found[-1][0][0] == row["track"]
    with port_reader(robot, port) as values:
        taxels = next(values)[1]
    assert len(taxels) == 72
    assert np.argmax(taxels) in found[-1][6]
    robot.counts = np.full(72, 240.0)
    wait_for(lambda: next(events)[1] == [], 180.0)


def check_contacts(contacts: list[list]) -> float:
    """In the link's frame and in newtons, as skinDynLib's types want it; their mean force."""
    forces = []
    for each in contacts:
        (number, *part), place, force, moment, centre, normal, taxels, pressure = each
        assert number > 0
        assert part == [3, 4, 2]  # left arm, its link 4, the forearm's skin
        for vector in (place, force, moment, centre, normal):
            assert [type(x) for x in vector] == [float] * 3
        assert all(type(x) is int and 0 <= x < 72 for x in taxels)
        expected = POSE[:3, :3] @ [*PLACE, 0.0] + POSE[:3, 3]
        assert np.linalg.norm(np.array(place) - expected) < 2e-3
        assert np.linalg.norm(np.array(centre) - expected) < 6e-3
        np.testing.assert_allclose(normal, POSE[:3, 2], atol=1e-9)
        np.testing.assert_allclose(force[:2], 0.0, atol=1e-9)  # into the skin, against the normal
        np.testing.assert_allclose(moment, 0.0, atol=1e-9)  # a flat skin feels none
        assert 1.0 < pressure < 1000.0
        forces.append(-force[2])
    return float(np.mean(forces))


def test_what_cannot_be_is_said() -> None:
    with pytest.raises(InputError, match="name of a port is 'no slash'"):
        from_plain(YarpSettings, {"port": "no slash"})
    for wrong in ({"rate": 0}, {"name_server": "x:y"}, {"nothing": 1}, {"parts": []}):
        with pytest.raises(InputError, match="expected"):
            from_plain(YarpSettings, wrong)


def test_a_name_server_that_began_anew_is_told_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publisher, "ASK", 0.02)
    names = NameServer()
    server = yarp.NameServer("127.0.0.1", names.port)
    port, stop = yarp.Port("/skinfield/x", "127.0.0.1", server=server), threading.Event()
    watch = threading.Thread(target=publisher.keep_registered, args=((port,), stop))
    watch.start()
    try:
        wait_for(lambda: "/skinfield/x" in names.known)
        names.close()
        names.known.clear()
        names.listen()
        wait_for(lambda: names.known.get("/skinfield/x") == ("127.0.0.1", port.socket_port))
    finally:
        stop.set()
        watch.join()
        port.close()
        names.close()
