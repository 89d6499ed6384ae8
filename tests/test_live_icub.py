"""A virtual iCub skin, the engine in its own process, and a reader: from bytes to newtons."""

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from live_skins import settings, wait_for

from skinfield.cli.sources import source_from_options
from skinfield.emulator import VirtualSettings
from skinfield.emulator.process import VirtualProcess, start
from skinfield.loop.client import Live, Snapshot, Stale, connect
from skinfield.loop.status import Observer
from skinfield.loop.supervisor import Supervisor

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")

RATE = 100.0  # 1/s
NEAR, FACTOR = 3e-3, 2.5  # m; of a press, by the quick inverse on a layer of 2 mm
PATIENCE = 90.0  # s
STALE = 0.4  # s
STARTS = 600.0  # s: every kernel may have to be compiled first


class Skin:
    """All that runs: the boards, the engine, and its reader."""

    def __init__(self, boards: VirtualProcess, live: Live, supervisor: Supervisor) -> None:
        self.boards, self.live, self.supervisor = boards, live, supervisor

    def counted(self) -> dict[str, int]:
        """Of the engine's only source."""
        (source,) = Observer(self.live.reader).look().sources.values()
        return source

    def patch(self) -> dict[str, Any]:
        """What the status says of the only patch."""
        (found,) = Observer(self.live.reader).look().patches
        return found

    def quiet(self) -> bool:
        """Whether nothing is wrong, and nothing touches it."""
        found, patch = self.live.latest(timeout=PATIENCE), self.patch()
        return found.age < 0.3 and patch["invalid"] == 0 and not len(found.contacts)


def started(parts: ExitStack) -> Skin:
    """A skin whose engine answers."""
    virtual = VirtualSettings(rate=RATE, scene="idle", lead_in=0.0)
    boards = parts.enter_context(start(virtual))
    made = settings(rungs=(10, 20))
    source = source_from_options("icub", "udp", tuple(boards.channels), made.skin)
    made = settings(sources=(source,), rungs=(10, 20), tare_seconds=1.0, stale_after=STALE)
    supervisor = parts.enter_context(Supervisor(made))
    supervisor.wait(STARTS).close()
    return Skin(boards, parts.enter_context(connect(made.name)), supervisor)


@pytest.fixture(scope="module")
def everywhere() -> Iterator[Skin]:
    with ExitStack() as parts:
        yield started(parts)


@pytest.fixture
def skin(everywhere: Skin) -> Iterator[Skin]:
    """The skin with nothing wrong, at first and at last."""
    wait_for(everywhere.quiet, PATIENCE)
    yield everywhere
    everywhere.boards.release()
    everywhere.boards.clear()
    everywhere.boards.wires(lose=0.0, duplicate=0.0, swap=0.0)
    assert everywhere.supervisor.restarts == 0


def settled(skin: Skin, force: float) -> Snapshot:
    """A cycle after the contact's force has stopped growing."""

    def steady() -> Snapshot | None:
        found = skin.live.wait_contact(1.0, force=force / FACTOR)
        if found is None:
            return None
        wait_for(lambda: skin.live.latest(timeout=PATIENCE).number > found.number + 20)
        later = skin.live.latest(timeout=PATIENCE)
        grew = len(later.contacts) != 1 or abs(later.force - found.force) > 0.1 * force
        return None if grew else later

    return wait_for(steady, PATIENCE)


@pytest.mark.parametrize(("x", "y"), [(0.0, 7.5e-3), (-15e-3, 0.0)])
def test_a_press_is_where_it_is_and_about_as_strong(skin: Skin, x: float, y: float) -> None:
    patch = skin.live.skin.patches[0]
    near = int(np.argmin(np.hypot(*(patch.plane - [x, y]).T)))
    skin.boards.press(taxel=near, force=4.0, radius=10e-3)
    found = settled(skin, 4.0)
    (press,) = skin.boards.truth()[-1]["presses"]
    (contact,) = found.contacts
    assert np.linalg.norm(contact["position"] - press["position"]) < NEAR
    assert press["force"] / FACTOR < contact["normal_force"] < press["force"] * FACTOR
    assert found.force == pytest.approx(float(contact["normal_force"]))


def test_the_scene_s_press_comes_and_goes(skin: Skin) -> None:
    skin.boards.scene("press")
    found = skin.live.wait_contact(PATIENCE, force=0.5)
    assert found is not None
    skin.boards.scene("idle")
    wait_for(skin.quiet, PATIENCE)


def test_an_unplugged_triangle_is_left_out_and_told(skin: Skin) -> None:
    skin.boards.fault("unplug 2")
    wait_for(lambda: skin.patch()["invalid"] == 12, PATIENCE)
    channel = skin.live.skin.patches[0].channel

    def left_out() -> bool:
        valid = skin.live.latest(timeout=PATIENCE).slot.valid.astype(bool)
        return bool((valid == (channel // 12 != 2)).all())

    wait_for(left_out, PATIENCE)
    found = [each for each, _ in zip(skin.live, range(30), strict=False)]
    assert sum(each.force > 0.5 for each in found) < 10  # zeros are no press; noise may be one
    skin.boards.clear("unplug")
    wait_for(skin.quiet, PATIENCE)


def test_a_board_that_boots_is_configured_again(skin: Skin) -> None:
    before = skin.boards.counts()
    skin.boards.fault("reboot 0+60s")
    wait_for(lambda: missing(skin), PATIENCE)
    gone = skin.live.latest(timeout=PATIENCE)
    assert gone.age > STALE
    assert not gone.slot.valid.any()
    assert not gone.fresh
    with pytest.raises(Stale, match="no answer"):
        gone["hexagon72"]
    skin.boards.clear("reboot")  # now it is there, and sends nothing before it is told to
    wait_for(skin.quiet, PATIENCE)
    after = skin.boards.counts()
    assert after["reboots"] == before["reboots"] + 1
    assert after["commands"] > before["commands"]


def missing(skin: Skin) -> bool:
    """Whether the patch has no answer, and the status says why."""
    patch = skin.patch()
    return bool(patch["answer"] == "missing" and patch["stale"] and patch["age"] > STALE)


def test_a_bus_that_goes_away_and_returns(skin: Skin) -> None:
    skin.boards.fault("bus-off 0")
    wait_for(lambda: missing(skin), PATIENCE)
    number = skin.live.latest(timeout=PATIENCE).number
    wait_for(lambda: skin.live.latest(timeout=PATIENCE).number > number + 3)  # it goes on
    skin.boards.clear("bus-off")
    wait_for(skin.quiet, PATIENCE)


@pytest.mark.parametrize(
    ("kind", "name", "chance"), [("lose", "lost", 0.04), ("duplicate", "duplicated", 0.1)]
)
def test_what_happens_on_the_wires_is_counted(
    skin: Skin, kind: str, name: str, chance: float
) -> None:
    seen, done = skin.counted(), skin.boards.counts()
    skin.boards.wires(**{kind: chance})
    wait_for(lambda: skin.boards.counts()[name] - done[name] >= 150, PATIENCE)
    skin.boards.wires(**{kind: 0.0})
    truth = skin.boards.counts()[name] - done[name]
    received = skin.counted()["received"]
    wait_for(lambda: skin.counted()["received"] > received + 48, PATIENCE)  # a loss shows later
    after = skin.counted()
    assert after[name] - seen[name] == pytest.approx(truth, rel=0.2)
    for other in {"lost", "duplicated", "swapped"} - {name}:
        assert after[other] - seen[other] <= 0.05 * truth


def test_nothing_is_counted_where_nothing_happens(skin: Skin) -> None:
    names = ("lost", "overflowed", "malformed", "duplicated", "swapped")
    before = skin.counted()
    wait_for(lambda: skin.counted()["received"] > before["received"] + 1000, PATIENCE)
    after = skin.counted()
    assert [after[name] - before[name] for name in names] == [0] * len(names)
