"""Scenarios of the virtual rig as TOML files, and their recordings as tasks."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.files.layouts.load import save_layout, skin_from_text
from skinfield.files.pending import write_bytes, write_npz
from skinfield.files.recordings.archive import save_recording, seconds
from skinfield.lab.runner import Task
from skinfield.lab.scenarios.indenters import indenter_from_table
from skinfield.lab.scenarios.table import TomlTable, key_of
from skinfield.plot import save
from skinfield.settings import plain_from_toml, text_of_file
from skinfield.signal import save_calibration
from skinfield.simulate.electronics import (
    Board,
    CySkinBoard,
    Electronics,
    ICubBoard,
    LinearBoard,
    cyskin_electronics,
    icub_electronics,
    ideal_electronics,
)
from skinfield.simulate.habits import HABITS, NONE, Habits
from skinfield.simulate.rig import (
    At,
    BetweenThree,
    BetweenTwo,
    Loads,
    LoadSeries,
    OverTaxels,
    Places,
    Random,
    Raster,
    Scenario,
    Temperature,
    Tool,
    run_rig,
)
from skinfield.simulate.rig.plot import draw_rig_run
from skinfield.skin import Patch

VERSION = 1
LAYOUT = "icub_hexagon"
PRESETS = {"icub": icub_electronics, "cyskin": cyskin_electronics, "ideal": ideal_electronics}
BOARDS = {"icub": ICubBoard, "cyskin": CySkinBoard, "linear": LinearBoard}
NO_LOAD = "no load here: those of all indenters are in [loads]"
NO_SHEAR = "no shear here: shear_part in [loads] is that of all indenters"
NOT_HERE = {
    "force_n": NO_LOAD, "depth_mm": NO_LOAD, "shear_x_n": NO_SHEAR, "shear_y_n": NO_SHEAR,
}  # fmt: skip
PICTURE = "run.png"
TASK_VERSION = "2"  # raise it when the same scenario makes other files

PLACES: Mapping[str, Places] = {
    "over_taxel": OverTaxels(), "between_two": BetweenTwo(), "between_three": BetweenThree(),
    "at": At(positions=((0.0, 0.0),)), "random": Random(), "raster": Raster(),
}  # fmt: skip
SIMPLE = ("tolerances", "profile", "load_cell", "temperature", "solving")
SPREADS = ("quantised", "gain_spread", "converter_gain_spread", "baseline_spread", "tared")
PARTS = ("hysteresis", "cross_talk", "drift", "noise", "defects", "delivery")  # of the electronics
HEAD = ("name", "seed", "repeats", "first_repeat")


def load_scenario(path: str | Path) -> Scenario:
    """Read a scenario's file; files that it names are looked for beside it.

    Raises
    ------
    FileError
        If it cannot be read, or holds what is not known or cannot be used; the message says where.
    """
    return scenario_from_toml(text_of_file(path), Path(path).parent, str(path))


def scenario_from_toml(text: str, folder: Path = Path(), path: str = "scenario") -> Scenario:
    """Scenario of a TOML text.

    Parameters
    ----------
    text : str
        ``skinfield rig --new FILE`` writes one with all keys.
    folder : Path
        Where the files that it names are looked for.
    path : str
        What errors call it.

    Raises
    ------
    FileError
        For a key or word that there is not, a value of another kind or out of range.
    """
    table = TomlTable(plain_from_toml(text, path), "", path, text)
    habits = table.choice("habits", HABITS, NONE)
    usual = Scenario().with_habits(habits)
    if table.value("skinfield_rig", int) != VERSION:
        raise table.wrong("skinfield_rig", f"{VERSION}: the first line of a rig's scenario")
    layer = table.table("layer")
    tools = table.tables("indenter")
    made = table.read(
        usual,
        HEAD,
        patch=_patch(table.table("patch"), folder),
        cover=layer.value("inextensible_cover", bool, False),
        layer=layer.read(usual.layer),
        elastomer=table.table("elastomer").read(usual.elastomer),
        tools=tuple(_tool(one, row, folder) for row, one in enumerate(tools)) or usual.tools,
        places=tuple(map(_places, table.tables("places"))) or usual.places,
        loads=_loads(table.table("loads"), usual.loads),
        electronics=_electronics(table.table("electronics"), habits),
        **{name: table.table(name).read(getattr(usual, name)) for name in SIMPLE},
    )
    if "temperature" in table.content or not habits.warming:
        return made
    room = replace(made, temperature=Temperature()).with_habits(habits).temperature
    return replace(made, temperature=room)


def _patch(table: TomlTable, folder: Path) -> Patch:
    layout, name = table.value("layout", str, LAYOUT), table.value("name", str, "")
    table.values({})  # nothing else is known
    file = folder / layout
    skin = table.make(partial(skin_from_text, str(file) if file.is_file() else layout), "layout")
    if not name and len(skin) > 1:
        raise table.wrong("name", f"one of {', '.join(patch.name for patch in skin)}")
    return table.make(partial(skin.__getitem__, name or 0), "name")


def _tool(table: TomlTable, row: int, folder: Path) -> Tool:
    for key, expected in NOT_HERE.items():
        if key in table.content:
            raise table.wrong(key, expected)
    name = table.value("name", str, "") or f"{table.content.get('shape', 'indenter')}-{row + 1}"
    return table.make(Tool, name=name, indenter=indenter_from_table(table, folder))


def _places(table: TomlTable) -> Places:
    usual = table.choice("kind", PLACES)
    if isinstance(usual, At) and "positions_mm" not in table.content:
        raise table.wrong("positions_mm", "rows of x and y, such as [[0, 2.5]]")
    return table.read(usual)


def _loads(table: TomlTable, usual: Loads) -> Loads:
    depths = "forces_n" not in table.content and "depths_mm" in table.content
    return table.read(Loads(depths=(1e-4,)) if depths else usual)


def _electronics(table: TomlTable, habits: Habits) -> Electronics:
    usual = habits.electronics(table.choice("preset", PRESETS, "icub")())
    parts = {name: table.table(name).read(getattr(usual, name)) for name in PARTS}
    board = _board(table.table("board"), usual.board)
    return table.read(usual, SPREADS, board=board, **parts)


def _board(table: TomlTable, usual: Board) -> Board:
    kinds = {made: kind for kind, made in BOARDS.items()}
    kind = table.choice("kind", BOARDS, kinds[type(usual)])
    if kind is not ICubBoard:
        made: Board = kind()
        return table.read(made, () if kind is LinearBoard else ("gain",))
    byte, sizes = ("no_load", "shift"), ("rest_capacitance", "farads_per_count")
    table.taken |= {key_of(name) for name in (*byte, *sizes)}
    usual = ICubBoard()
    return table.read(usual, sizes, convention=table.read(usual.convention, byte))


def template() -> str:
    """Text of a scenario with all keys explained, to start from."""
    return files("skinfield.lab.scenarios").joinpath("scenario.toml").read_text("utf-8")


def rig_tasks(scenario: Scenario) -> list[Task]:
    """A task for each recording of a scenario."""
    return [Task(name, make_run, (one,), TASK_VERSION) for name, one in scenario.runs()]


def make_run(folder: Path, scenario: Scenario) -> dict[str, Any]:
    """Run a scenario of one recording and write its files; returns what a table shows.

    Raises
    ------
    FileError
        If a file cannot be written.
    """
    done = run_rig(scenario)
    save_recording(done.recording, folder / "recording.npz")
    save_load_cell(done.load_cell, folder / "load_cell.csv")
    write_npz(folder / "truth.npz", done.truth.arrays())
    save_layout(done.scenario.patch, folder / "layout.toml")
    save_calibration(done.skin.calibration, folder / "calibration.toml")
    save(draw_rig_run(done), folder / PICTURE)
    truth = done.truth
    return {
        "indenter": scenario.tools[0].name,
        "presses": len(truth.press_load),
        "readings": len(done.recording),
        "duration_s": float(truth.time_s[-1]),
        "highest_force_N": float(truth.force_N.max()),
        "deepest_mm": float(truth.depth_m.max() * 1e3),
        "widest_area_mm2": float(truth.contact_area_m2.max() * 1e6),
        "highest_change": float(truth.reading_change.max()),
        "saturated": int(np.count_nonzero(done.load_cell.saturated)),
    }


def save_load_cell(series: LoadSeries, path: str | Path) -> None:
    """Write a load cell's series as a force sensor's CSV: ``time_s,fx,fy,fz``, pushed to -z."""
    full = int(series.saturated.sum())
    lines = [
        f"# {full} of {len(series.force)} samples are at the end of the cell's range\n",
        "time_s,fx,fy,fz\n",
    ]
    for stamp, force in zip(series.stamp_ns.tolist(), series.force.tolist(), strict=True):
        lines.append(f"{seconds(stamp)},0.0,0.0,{0.0 - force!r}\n")
    write_bytes(path, "".join(lines).encode())
