"""Parts of the virtual skin, each against something that can be seen at a glance."""

import json
import math
import tomllib

import numpy as np
import pytest

from skinfield.errors import FileError, InputError
from skinfield.layout import Skin
from skinfield.layout.generators import by_name
from skinfield.mechanics import Layer
from skinfield.simulate import press
from skinfield.virtual import (
    Fault,
    Temperature,
    VirtualSettings,
    Wires,
    fault_from_text,
    solving,
    temperature_from_text,
)
from skinfield.virtual.faults import numbers_of
from skinfield.virtual.scene_files import load_scene, scene_from_text
from skinfield.virtual.scenes import SCENES, scene_by_name
from skinfield.virtual.settings import settings_from_json
from skinfield.virtual.tables import FORCES, SPACING, PressTable, cache_path, table_for
from skinfield.virtual.tool import Tool
from skinfield.virtual.touch import Point, Track
from skinfield.virtual.world import World
from skinfield.virtual.world_kernel import add_press

SKIN = Skin((by_name("hexagon72"),))


@pytest.mark.parametrize(("tool", "share"), [(Tool(), 0.1), (Tool(3e-3, "flat"), 0.02)])
def test_tables_hold_what_a_press_reads(tool, share):
    table = table_for(tool, Layer(), 4e-3)
    force = share * table.highest_force
    made = press(Layer(), [tool.body(force=force)], extent=30e-3, cell=0.5e-3)
    away = np.random.default_rng(0).uniform(-12e-3, 12e-3, (40, 2))
    exact = made.capacitance(away, 4e-3)
    change = np.zeros(40)
    row = math.sqrt(share) * (FORCES - 1)
    add_press(change, away, 0, 40, table.change, SPACING, row, 0.0, 0.0)
    assert np.abs(change - exact).max() < 0.004 * exact.max()
    assert table.radius_at(force) == pytest.approx(math.sqrt(made.contact_area / math.pi), rel=0.02)


def test_tables_are_kept_between_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tool = Tool(30e-3)
    solved = []

    def solve(*given):
        solved.append(given)
        return table

    table = small_table()
    monkeypatch.setattr("skinfield.virtual.tables.solve_table", solve)
    for _ in range(2):
        found = table_for(tool, Layer(), 4e-3)
        assert np.array_equal(found.change, table.change)
    assert len(solved) == 1
    cache_path(tool, Layer(), 4e-3).write_bytes(b"cut")
    table_for(tool, Layer(), 4e-3)
    assert len(solved) == 2
    table_for(tool, Layer(thickness=3e-3), 4e-3)
    assert len(solved) == 3


def small_table():
    return PressTable(1.0, np.linspace(0.0, 1e-3, FORCES), np.ones((FORCES, 5)))


def test_a_table_says_what_it_holds():
    with pytest.raises(InputError, match=r"force is 2 N, expected above 0 and at most 1 N"):
        small_table().check_force(2.0, Tool())
    assert small_table().radius_at(0.25) == pytest.approx(0.5e-3)


def test_a_track_goes_straight_from_point_to_point():
    points = (Point(1.0, 0.0, 0.0, 0.0), Point(2.0, 4e-3, 2e-3, 1.0), Point(3.0, 4e-3, 2e-3, 0.0))
    track = Track(0, Tool(), points)
    assert track.at(0.9) is None
    assert track.at(1.0) is None  # no force: no touch
    assert track.at(1.25) == pytest.approx((1e-3, 0.5e-3, 0.25))
    assert track.at(2.5) == pytest.approx((4e-3, 2e-3, 0.5))
    assert track.at(3.1) is None


@pytest.mark.parametrize("name", SCENES)
def test_scenes_press_within_the_skin(name):
    scene = scene_from_text(name, SKIN, 3)
    low, high = SKIN.patches[0].plane.min(axis=0), SKIN.patches[0].plane.max(axis=0)
    forces = []
    for track in scene.tracks:
        for point in track.points:
            assert (low - 5e-3 <= [point.x, point.y]).all()
            assert ([point.x, point.y] <= high + 5e-3).all()
            assert 0.0 <= point.time <= scene.period
            forces.append(point.force)
    assert (name == "idle") == (not forces)
    if name == "random":
        assert min(f for f in forces if f) >= 0.2
        assert max(forces) <= 3.0
        assert scene.tracks == scene_from_text(name, SKIN, 3).tracks
        assert scene.tracks != scene_from_text(name, SKIN, 4).tracks


TOML = """
repeat_s = 10
[[press]]
taxel = 5
force_n = 0.5
start_s = 1
seconds = 2
[[press]]
patch = "hexagon72"
shape = "flat"
radius_mm = 3
path = [
  { time_s = 0, x_mm = -10, y_mm = 2, force_n = 0 },
  { time_s = 1, force_n = 1 },
  { time_s = 4, x_mm = 10 },
]
"""


def test_scenes_come_from_toml_and_json(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(TOML)
    scene = load_scene(path, SKIN)
    assert (scene.name, scene.period) == ("mine", 10.0)
    held, moved = scene.tracks
    x, y = SKIN.patches[0].plane[5]
    assert held.at(2.0) == pytest.approx((x, y, 0.5))
    assert moved.tool == Tool(3e-3, "flat")
    assert moved.at(2.5) == pytest.approx((0.0, 2e-3, 1.0))
    again = tmp_path / "mine.json"
    again.write_text(json.dumps(tomllib.loads(TOML)))
    assert scene_from_text(str(again), SKIN, 0).tracks == scene.tracks


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("press = 3", "no list"),
        ("[[press]]\nforce = 1", "has 'force', expected only"),
        ("[[press]]\ntaxel = 99", "press[0]: taxel is 99"),
        ("[[press]]\ntaxel = 1\npatch = 'palm'", "patch 'palm' is not in"),
        ("[[press]]\npath = [{time_s = 0, x_mm = 1, y_mm = 1}]", "points has 1"),
        ("[[press]", "cannot be read"),
    ],
)
def test_what_is_wrong_with_a_scene_is_said(tmp_path, text, said):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(FileError) as caught:
        load_scene(path, SKIN)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("unplug 3", Fault("unplug", "3")),
        ("unplug 1.3@10s+5s", Fault("unplug", "1.3", 10.0, 5.0)),
        ("stuck palm/3-7@2min", Fault("stuck", "palm/3-7", 120.0)),
        ("dead *+250ms", Fault("dead", "*", 0.0, 0.25)),
        ("reboot 0@20s", Fault("reboot", "0", 20.0, 2.0)),
        ("bus-off @1.5s+3s", Fault("bus-off", "0", 1.5, 3.0)),
    ],
)
def test_faults_are_read_as_they_are_written(text, fault):
    assert fault_from_text(text) == fault


@pytest.mark.parametrize("text", ["", "explode 3", "unplug 3@10", "unplug 3@s", "dead 1+-2s"])
def test_faults_that_make_no_sense_are_refused(text):
    with pytest.raises(InputError):
        fault_from_text(text)


def test_numbers_and_runs():
    assert numbers_of("3", 6, "it") == [3]
    assert numbers_of("2-4", 6, "it") == [2, 3, 4]
    assert numbers_of("*", 3, "it") == [0, 1, 2]
    for bad in ("6", "-1", "4-2", "2-6", "x", "1-", "9" * 30):
        with pytest.raises(InputError, match="it is"):
            numbers_of(bad, 6, "it")


def test_temperatures():
    assert temperature_from_text("25") == Temperature(25.0)
    rise = temperature_from_text("20..30@100s")
    assert [rise.warmth(t) for t in (0.0, 50.0, 100.0, 900.0)] == pytest.approx([-5, 0, 5, 5])
    wave = temperature_from_text("25~3@40s")
    assert [wave.warmth(t) for t in (0.0, 10.0, 30.0)] == pytest.approx([0, 3, -3])
    with pytest.raises(InputError, match="temperature is 'warm'"):
        temperature_from_text("warm")


def test_settings_go_through_json():
    settings = VirtualSettings(
        hardware="cyskin",
        bus="udp",
        channels=("127.0.0.1:0",),
        layer=Layer(thickness=3e-3),
        wires=Wires(lose=0.1),
        faults=("unplug 3@1s", Fault("dead", "4")),
        temperature=Temperature(20.0, 5.0, 60.0),
    )
    assert settings_from_json(settings.to_json()) == settings
    for bad in ("{", "[]", '{"skim": "hexagon72"}', '{"wires": 3}', '{"rate": "fast"}'):
        with pytest.raises(InputError):
            settings_from_json(bad)


class Solved:
    """Stands for a process that solves a table."""

    def __init__(self, words: list[str], **_: object) -> None:
        self.radius, self.done = float(words[3]), False

    def poll(self) -> int | None:
        return 0 if self.done else None


def test_tools_wait_for_their_turn_the_newest_first(monkeypatch) -> None:
    begun: list[Solved] = []
    monkeypatch.setattr(
        solving.subprocess, "Popen", lambda *a, **k: begun.append(Solved(*a, **k)) or begun[-1]
    )
    monkeypatch.setattr(solving, "is_stored", lambda *_: False)
    monkeypatch.setattr(solving, "table_for", lambda tool, *_: tool)
    mine = solving.Solving(Layer())
    tools = [Tool(1e-3 * radius) for radius in range(1, 2 + solving.QUEUED + solving.AT_ONCE)]
    for tool in tools[:-1]:
        mine.start(tool, 4e-3)
    assert [each.radius for each in begun] == [tools[0].radius, tools[1].radius]
    with pytest.raises(InputError, match="others wait to be prepared"):
        mine.start(tools[-1], 4e-3)
    begun[0].done = True
    assert mine.poll()
    assert mine.get(tools[0], 4e-3) == tools[0]
    assert begun[-1].radius == tools[-2].radius


def test_a_body_that_is_stored_is_pressed_through_no_layer(monkeypatch) -> None:
    world = World(SKIN, Layer(), scene_by_name("idle", SKIN, 0))
    hard = table_for(Tool(), Layer(), 4e-3)  # what is stored for any tool
    monkeypatch.setattr(solving, "is_stored", lambda *_: True)
    monkeypatch.setattr(solving, "table_for", lambda *_: hard)
    with pytest.raises(InputError, match="press lighter"):
        world.press({"x": 0.0, "y": 0.0, "radius": 2e-3, "force": 1e3})
    assert world.waits == []
