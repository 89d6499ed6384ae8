"""Virtual skin without a process: its parts, their times, its control socket."""

import json
import math
import re
import subprocess
import sys
import tomllib
import tracemalloc
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from virtual_host import QUIET

from skinfield.elastic import Layer
from skinfield.emulator import (
    Fault,
    TemperatureSettings,
    VirtualSettings,
    VirtualSkin,
    Wires,
    fault_from_text,
    press_tables,
    temperature_from_text,
    truth_log,
    world,
)
from skinfield.emulator.hardware import NEVER, Schedule, Wire
from skinfield.emulator.packet import Ear
from skinfield.emulator.press_tables import FORCES, PressTable, cache_path, table_for
from skinfield.emulator.scenes import (
    SCENES,
    BodyPath,
    CurrentPress,
    Point,
    SceneTool,
    scene_by_name,
    scene_from_text,
)
from skinfield.emulator.settings import numbers_of
from skinfield.emulator.transports import ANSWER, Request, answer_to, encoded
from skinfield.emulator.truth_log import TruthLog
from skinfield.emulator.world import World
from skinfield.errors import FileError, InputError
from skinfield.settings import json_from_value, value_from_json
from skinfield.simulate import press
from skinfield.skin import Skin
from skinfield.skin.generators import by_name
from skinfield.wire.packet import PacketKind, encode_command

SKIN = Skin((by_name("hexagon72"),))


@pytest.mark.parametrize(
    ("tool", "share"),
    [(SceneTool(), 0.1), (SceneTool(3e-3, "flat"), 0.02), (SceneTool(6e-3, "L"), 0.09)],
)
def test_tables_hold_what_a_press_reads(tool, share):
    table = table_for(tool, Layer(), 4e-3)
    force = share * table.highest_force
    made = press(Layer(), [tool.body(force=force)], extent=30e-3, cell=0.5e-3)
    away = np.random.default_rng(0).uniform(-12e-3, 12e-3, (40, 2))
    exact = made.capacitance(away, 4e-3)
    assert np.abs(table.readings(away, force) - exact).max() < 0.004 * exact.max()
    assert table.radius_at(force) == pytest.approx(math.sqrt(made.contact_area / math.pi), rel=0.02)


@pytest.mark.parametrize(("tool", "share"), [(SceneTool(), 0.06), (SceneTool(6e-3, "flat"), 0.04)])
def test_a_push_adds_what_the_pushed_press_reads(tool, share):
    table = table_for(replace(tool, pushed=True), Layer(), 4e-3)
    force, push = share * table.highest_force, np.array([0.3, -0.2])
    away = np.random.default_rng(1).uniform(-12e-3, 12e-3, (40, 2))
    plain, pushed = (
        press(Layer(), [replace(tool.body(force=force), shear=shear)], extent=30e-3, cell=0.5e-3)
        for shear in ((0.0, 0.0), tuple(force * push))
    )
    exact = pushed.capacitance(away, 4e-3) - plain.capacitance(away, 4e-3)
    assert np.abs(exact).max() > 3e-3
    off = np.abs(table.added(away, force, force * push) - exact).max()
    assert off < 0.1 * np.abs(exact).max()  # what is of second order


@pytest.mark.parametrize(
    ("shape", "shear", "said"),
    [("L", (0.1, 0.0), "shear is .* of a L, expected none"), ("ball", (0.4, 0.4), "it slides"),
     ("ball", (math.nan, 0.0), "it slides")],
)  # fmt: skip
def test_a_push_that_cannot_be_is_refused(shape, shear, said):
    with pytest.raises(InputError, match=said):
        CurrentPress("a", 0, SceneTool(8e-3, shape), 0.0, 0.0, 1.0, shear=shear).check_shear()


def small_table():
    return PressTable(1.0, np.linspace(0.0, 1e-3, FORCES), np.ones((FORCES, 5)))


def test_tables_are_kept_between_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tool, table, solved = SceneTool(30e-3), small_table(), []
    monkeypatch.setattr(press_tables, "solve_table", lambda *key: solved.append(key) or table)
    for _ in range(2):
        assert np.array_equal(table_for(tool, Layer(), 4e-3).change, table.change)
    assert len(solved) == 1
    cache_path(tool, Layer(), 4e-3).write_bytes(b"cut")
    table_for(tool, Layer(), 4e-3)
    assert len(solved) == 2
    table_for(tool, Layer(thickness=3e-3), 4e-3)
    assert len(solved) == 3


def test_a_table_says_what_it_holds():
    table = small_table()
    with pytest.raises(InputError, match=r"force is 2 N, expected above 0 and at most 1 N"):
        table.check_force(2.0, SceneTool())
    assert table.radius_at(0.25) == pytest.approx(0.5e-3)
    places = np.array([[0.0, 0.0], [6e-5, 8e-5], [1.0, 0.0]])
    assert table.readings(places, 1.0).tolist() == [1.0, 1.0, 0.0]


def test_a_track_goes_straight_from_point_to_point():
    points = (Point(1.0, 0.0, 0.0, 0.0), Point(2.0, 4e-3, 2e-3, 1.0), Point(3.0, 4e-3, 2e-3, 0.0))
    track = BodyPath(0, SceneTool(), points)
    assert [track.at(time) for time in (0.9, 1.0, 3.1)] == [None] * 3  # without a force no touch
    assert track.at(1.25) == pytest.approx((1e-3, 0.5e-3, 0.25))
    assert track.at(2.5) == pytest.approx((4e-3, 2e-3, 0.5))


@pytest.mark.parametrize("name", SCENES)
def test_scenes_press_within_the_skin(name):
    scene = scene_from_text(name, SKIN, 3)
    low, high = SKIN.patches[0].plane.min(axis=0), SKIN.patches[0].plane.max(axis=0)
    points = np.array([point for track in scene.tracks for point in track.points]).reshape(-1, 4)
    times, places, forces = points[:, 0], points[:, 1:3], points[:, 3]
    assert ((low - 5e-3 <= places) & (places <= high + 5e-3)).all()
    assert ((times >= 0.0) & (times <= scene.period)).all()
    assert (name == "idle") == (not len(points))
    if name == "random":
        assert forces[forces > 0.0].min() >= 0.2
        assert forces.max() <= 3.0
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
    scene = scene_from_text(str(path), SKIN, 0)
    assert (scene.name, scene.period) == ("mine", 10.0)
    held, moved = scene.tracks
    x, y = SKIN.patches[0].plane[5]
    assert held.at(2.0) == pytest.approx((x, y, 0.5))
    assert moved.tool == SceneTool(3e-3, "flat")
    assert moved.at(2.5) == pytest.approx((0.0, 2e-3, 1.0))
    again = tmp_path / "mine.json"
    again.write_text(json.dumps(tomllib.loads(TOML)))
    assert scene_from_text(str(again), SKIN, 0).tracks == scene.tracks


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("press = 3", "press is 3"),
        ("[[press]]\nforce = 1", "'force' is not known"),
        ("[[press]]\ntaxel = 99", "press[0]: taxel is 99"),
        ("[[press]]\ntaxel = 1\npatch = 'palm'", "patch 'palm' is not in"),
        ("[[press]]\npath = [{time_s = 0, x_mm = 1, y_mm = 1}]", "points has 1"),
        ("[[press]", "is not TOML"),
    ],
)
def test_what_is_wrong_with_a_scene_is_said(tmp_path, text, said):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(FileError, match=f"{path}.*{re.escape(said)}"):
        scene_from_text(str(path), SKIN, 0)


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


@pytest.mark.parametrize(
    ("text", "read"),
    [
        *((text, fault_from_text)
          for text in ("", "explode 3", "unplug 3@10", "dead 1+-2s", "reboot 0@soon")),
        ("warm", temperature_from_text),
        *((text, lambda text: numbers_of(text, 6, "it"))
          for text in ("6", "-1", "4-2", "2-6", "x", "1-", "9" * 30)),
    ],
)  # fmt: skip
def test_texts_that_make_no_sense_are_refused(text, read):
    with pytest.raises(InputError, match=r" is .*, expected "):
        read(text)


def test_numbers_and_runs():
    assert [numbers_of(text, 6, "it") for text in ("3", "2-4")] == [[3], [2, 3, 4]]
    assert numbers_of("*", 3, "it") == [0, 1, 2]


def test_temperatures():
    assert temperature_from_text("25") == TemperatureSettings(25.0)
    rise = temperature_from_text("20..30@100s")
    assert [rise.warmth(t) for t in (0.0, 50.0, 100.0, 900.0)] == pytest.approx([-5, 0, 5, 5])
    wave = temperature_from_text("25~3@40s")
    assert [wave.warmth(t) for t in (0.0, 10.0, 30.0)] == pytest.approx([0, 3, -3])


def test_settings_go_through_json():
    settings = VirtualSettings(
        hardware="cyskin", channels=("127.0.0.1:0",), layer=Layer(thickness=3e-3),
        wires=Wires(lose=0.1), temperature="20..25@60s",
        fault=("unplug 3@1s", "dead 4"),
    )  # fmt: skip
    assert value_from_json(VirtualSettings, json_from_value(settings)) == settings


def test_the_newest_tools_are_solved_first_and_only_what_is_wanted(monkeypatch) -> None:
    begun: list[SimpleNamespace] = []

    def start(words: list[str], **_: object) -> SimpleNamespace:
        ends = dict.fromkeys(("kill", "wait"), lambda: None)
        begun.append(SimpleNamespace(script=words[2], poll=lambda: None, stdout=None, **ends))
        return begun[-1]

    monkeypatch.setattr(press_tables.subprocess, "Popen", start)
    monkeypatch.setattr(press_tables, "cache_path", lambda *_: Path("nowhere"))
    monkeypatch.setattr(press_tables, "table_for", lambda tool, *_: tool)
    mine = press_tables.PressTables(Layer())
    keys = [(SceneTool(1e-3 * radius), 4e-3) for radius in range(1, 6)]
    assert not mine.poll(keys)
    begun[0].poll = lambda: 0
    assert mine.poll(keys[:1])
    wanted = [keys[-1], keys[-2], keys[0]]
    assert all(repr(key[0]) in each.script for key, each in zip(wanted, begun, strict=True))
    assert mine.get(keys[-1]) == keys[-1][0]
    assert mine.get(keys[0]) is None


def test_tools_are_prepared_before_they_press(monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[tuple[SceneTool, int]] = []

    class Fake(press_tables.PressTables):
        def _solve(self, key: press_tables.Key, nice: int) -> None:
            begun.append((key[0], nice))
            process = subprocess.Popen(["sleep", "60"], stdout=subprocess.PIPE)
            self._running[key] = press_tables.Solving(process)

    monkeypatch.setattr(world, "PressTables", Fake)
    made = World(SKIN, Layer(), scene_by_name("idle", SKIN, 0))
    monkeypatch.setattr(press_tables, "cache_path", lambda *_: Path("nowhere"))
    try:
        for radius in (21e-3, 22e-3):
            assert made.prepare(Request(radius=radius)) == {"solving": True}
        made.poll()
        made.poll()
        assert begun == [(SceneTool(22e-3), press_tables.BESIDE)]  # one at a time, the newest first
        made.press(Request(x=0.0, y=0.0, radius=23e-3))
        assert begun[1:] == [(SceneTool(23e-3), 0)]  # a press comes at once, beside it
        told = made.tools(Request())
        assert told["ready"] == [{"shape": "ball", "radius": 10e-3}]
        assert [each["radius"] for each in told["preparing"]] == [22e-3, 23e-3]
        assert made.prepare(Request()) == {"solving": False}
    finally:
        made.close()


def test_a_process_that_solves_says_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(press_tables, "SHARES", (0.1, 0.4, 0.7, 1.0))
    monkeypatch.setattr(press_tables, "CELL", 1e-3)  # coarse: this is not about the numbers
    shares: list[float] = []
    press_tables.solve_table(SceneTool(6e-3), Layer(), 4e-3, shares.append)
    assert shares == pytest.approx([0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0])
    script = "print(0.25, flush=True); print(0.5, flush=True)"
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    solving = press_tables.Solving(process)
    process.wait()
    assert solving.ended()
    assert solving.share == 0.5
    solving.close()


def test_a_body_that_is_stored_is_pressed_through_no_layer(monkeypatch) -> None:
    world = World(SKIN, Layer(), scene_by_name("idle", SKIN, 0))
    hard = table_for(SceneTool(), Layer(), 4e-3)  # what is stored for any tool
    monkeypatch.setattr(press_tables, "cache_path", lambda *_: Path(__file__))
    monkeypatch.setattr(press_tables, "table_for", lambda *_: hard)
    with pytest.raises(InputError, match="press lighter"):
        world.press(Request(x=0.0, y=0.0, radius=2e-3, force=1e3))
    assert world.waits == []


MS = 1_000_000


@pytest.mark.parametrize("seed", range(3))
def test_fates_of_messages_can_be_counted_from_what_arrives(seed):
    """Numbers that are missing, doubled, or behind a later one: a second count, in plain Python."""
    wire = Wire(VirtualSettings(wires=Wires(lose=0.1, duplicate=0.1, swap=0.1), seed=seed), 0)
    out, first = [], 0
    for burst in np.random.default_rng(seed).integers(0, 50, 200).tolist():
        out += wire.draw(range(first, first + burst))
        first += burst
    numbers = np.array(out)
    missing = first - len(set(out)) - len(wire.waiting)
    behind = (numbers < np.maximum.accumulate(numbers)).sum()
    doubled = len(out) - len(set(out))
    assert wire.counts == {"lost": missing, "duplicated": doubled, "swapped": behind}
    assert min(wire.counts.values()) > 0.05 * first


def test_a_schedule_keeps_to_absolute_times():
    schedule = Schedule(False, 0.0, np.random.default_rng(0))
    assert schedule.next_ns == NEVER
    schedule.set({0: MS, 1: MS}, 2, 10 * MS + 5)
    assert schedule.next_ns == 11 * MS
    assert schedule.due(11 * MS - 1) == []
    (group,) = schedule.due(11 * MS + 400_000)  # late, but the next one is not
    assert group.members == (0, 1)
    assert schedule.next_ns == 12 * MS
    # 12 is sent late; 13, 14, 15 are not, of two boards; 16 is late by less than a period
    for now_ns, following in ((16 * MS + 1, 16 * MS), (16 * MS + 2, 17 * MS)):
        schedule.due(now_ns)
        assert (schedule.skipped, schedule.next_ns) == (2 * 3, following)
    schedule.begin(40 * MS - 1)  # nothing was due before
    assert (schedule.next_ns, schedule.skipped) == (40 * MS, 2 * 3)


def test_jitter_never_moves_a_reading_behind_the_next():
    schedule = Schedule(False, 10e-3, np.random.default_rng(0))
    schedule.set({0: MS}, 1, 0)
    times = []
    for _ in range(1000):
        times.append(schedule.next_ns)
        schedule.due(schedule.next_ns)
    assert (np.diff(times) > 0).all()
    late = np.array(times) % MS
    assert late.max() > 0.8 * MS
    assert schedule.skipped == 0


def test_commands_are_found_in_a_stream_cut_anywhere():
    whole = b"SFx" + b"".join(
        encode_command(kind, sequence=n)
        for n, kind in enumerate([PacketKind.START, PacketKind.STOP, PacketKind.ASK])
    )
    for cut in range(len(whole)):
        ear = Ear()
        found = [*ear.packets(whole[:cut]), *ear.packets(whole[cut:]), *ear.packets(b"")]
        assert [packet.sequence for packet in found] == [0, 1, 2]


def test_the_truth_has_the_end_of_every_movement(tmp_path, monkeypatch):
    monkeypatch.setattr(truth_log, "LINES", 4)  # in memory: it does not grow
    truth = TruthLog(SKIN, str(tmp_path / "truth.jsonl"))
    at = lambda x: [CurrentPress("a", 0, SceneTool(), x, 0.0, 1.0, 2e-3)]
    truth.note([], 0)
    truth.note(at(1e-3), 1 * MS)
    for step in range(2, 30):  # every millisecond: a line each 10 ms
        truth.note(at(step * 1e-3), step * MS)
    truth.note(None, 30 * MS)
    assert truth.made == 4
    truth.note(None, 31 * MS)
    truth.note(None, 90 * MS)
    truth.note([], 100 * MS)
    truth.close()
    lines = [json.loads(line) for line in (tmp_path / "truth.jsonl").read_text().splitlines()]
    found = [(line["stamp_ns"] // MS, [p["x"] for p in line["presses"]]) for line in lines]
    assert found == [(0, []), (1, [1e-3]), (11, [11e-3]), (21, [21e-3]), (29, [29e-3]), (100, [])]
    assert truth.after(3, 2) == lines[3:5]
    assert truth.after(0, 100) == lines[2:]


def test_the_truth_of_a_press_that_moves_takes_no_more_memory_with_time():
    """Lines once took 0.4 kB each: 2.3 MB a minute, until there were 10,000."""
    truth, tool = TruthLog(SKIN), SceneTool()
    at = lambda step: [
        CurrentPress(f"press-{each}", 0, SceneTool(), 1e-6 * step, 0.0, 1.0, 2e-3)
        for each in range(2)
    ]
    for step in range(100):
        truth.note(at(step), step * 10 * MS)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for step in range(100, 5000):
            truth.note(at(step), step * 10 * MS)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert truth.made == 5000
    assert grown < 5_000  # bytes: one for each line
    newest = truth.after(4999, 9)[0]
    assert [each["x"] for each in newest["presses"]] == [4.999e-3] * 2
    assert newest["presses"][1]["radius"] == tool.radius


def test_the_truth_of_many_presses_goes_back_less_far(monkeypatch):
    monkeypatch.setattr(truth_log, "LINES", 8)
    monkeypatch.setattr(truth_log, "PRESSES", 9)
    truth = TruthLog(SKIN)
    for number in range(12):
        presses = [
            CurrentPress(f"{number}-{k}", 0, SceneTool(), 1e-3 * k, 0.0, 1.0) for k in range(4)
        ]
        truth.note(presses, number * 10 * MS)
    lines = truth.after(0, 100)
    assert [line["number"] for line in lines] == [10, 11]
    assert [press["id"] for press in lines[0]["presses"]] == ["10-0", "10-1", "10-2", "10-3"]


PLAIN = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=12)
KEYS = "id patch x y taxel face weights force radius shape fault kind after lose swap scene tag"
WORDS = "press move release fault clear wires scene truth nothing"
COMMAND = st.fixed_dictionaries({"do": st.sampled_from(WORDS.split())}).flatmap(
    lambda do: st.dictionaries(
        st.sampled_from(KEYS.split()), PLAIN | st.lists(PLAIN, max_size=4), max_size=7
    ).map(lambda fields: json.dumps(fields | do).encode())
)


@pytest.fixture(scope="module")
def skin():
    made = VirtualSkin(VirtualSettings(**QUIET, control="", at_once=True))
    made.world._solving._solve = lambda *_: None  # nothing is solved beside
    yield made
    made.close()


@settings(max_examples=150)
@given(data=COMMAND | st.binary(max_size=200))
def test_any_command_is_answered_and_the_skin_goes_on(skin, data):
    answer = json.loads(encoded(answer_to(data, skin.commands())))
    assert answer["ok"] or "expected" in answer["error"] or len(answer["error"]) == 2000
    skin.step(skin.started_ns + 10**9 * (1 + len(data)))
    counts = skin.hardware.converters.counts
    assert ((counts >= 0) & (counts <= 65535)).all()


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"x" * 5000, "command has 5000 bytes, expected at most 4096"),
        (b"[" * 4000, "command is no"),
        (b"[1]", "command is no plain object"),
        (b'{"do": 1}', "do is 1, expected one of clear, counts"),
        (b'{"do": "press"}', "x is None, expected a number"),
        (b'{"do": "press", "x": 0, "y": 1e999}', "y is inf"),
        (b'{"do": "press", "taxel": 0, "shape": "star"}', "shape is 'star'"),
        (b'{"do": "press", "taxel": 0, "radius": 4}', "radius is 4"),
        (b'{"do": "press", "face": 0, "weights": [0, 0, 0]}', "weights is (0.0, 0.0, 0.0)"),
        (b'{"do": "press", "taxel": 0, "patch": "palm"}', "patch 'palm' is not in"),
        (b'{"do": "wires", "lose": 2}', "lose is 2"),
    ],
)
def test_what_is_wrong_is_said(skin, data, said):
    answer = answer_to(data, skin.commands())
    assert answer["ok"] is False
    assert said in answer["error"]


def test_a_face_is_a_place(skin):
    commands = skin.commands()
    patch = skin.skin.patches[0]
    said = answer_to(b'{"do": "press", "face": 5, "weights": [1, 1, 2], "tag": 9}', commands)
    corners = patch.plane[patch.triangles[5]]
    assert (said["ok"], said["tag"]) == (True, 9)
    assert (said["x"], said["y"]) == pytest.approx(tuple([0.25, 0.25, 0.5] @ corners))
    answer_to(b'{"do": "release"}', commands)


def test_an_answer_is_one_datagram(skin):
    long = encoded({"ok": True, "lines": "x" * 70_000, "tag": 3})
    assert len(long) < ANSWER
    assert json.loads(long) == {
        "ok": False, "error": "the answer has 70035 bytes: ask for less at once", "tag": 3,
    }  # fmt: skip
    for number in range(64):
        skin.world.press(Request(taxel=number, id=f"{number:064d}"))
    for step in range(300):
        for number in range(64):
            skin.world.move(Request(id=f"{number:064d}", x=1e-4 * step, y=0.0))
        skin.truth.note(skin.world.touches(-1.0), 10**9 * step)
    said = answer_to(b'{"do": "truth", "after": 0}', skin.commands())
    assert len(encoded(said)) < ANSWER
    assert said["lines"][0]["number"] == 0
    skin.world.release(Request())


def test_the_process_that_solves_a_table_is_asked_for_that_table(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list = []
    monkeypatch.setattr(press_tables, "table_for", lambda *what: asked.append(what))
    tool, layer = SceneTool(6e-3, "flat"), Layer()
    begun: list = []
    start = lambda command, **_: begun.append(command) or SimpleNamespace(stdout=None)
    monkeypatch.setattr(press_tables.subprocess, "Popen", start)
    press_tables.PressTables(layer)._solve((tool, 4e-3), 0)
    exec(begun[0][-1], {})
    assert [what[:3] for what in asked] == [(tool, layer, 4e-3)]
