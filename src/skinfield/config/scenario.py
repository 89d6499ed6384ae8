"""Scenarios of the virtual rig as TOML files, both ways."""

import tomllib
from decimal import Decimal
from pathlib import Path
from typing import Any

from skinfield.conditioning import CySkinCount, ICubByte
from skinfield.config.indenters import indenter_from_mapping
from skinfield.config.scenario_keys import (
    CYSKIN,
    ELECTRONICS,
    ICUB,
    ICUB_BYTE,
    LAYER,
    LOAD_CELL,
    PARTS,
    PLACES,
    PROFILE,
    SOLID,
    SOLVING,
    TEMPERATURE,
    Keys,
    values_of,
)
from skinfield.config.table import Table
from skinfield.errors import FileError, InputError
from skinfield.layout import Patch, load_layout
from skinfield.layout.generators import by_name
from skinfield.layout.generators.names import GENERATORS
from skinfield.mechanics import Layer, PronySeries, StandardLinearSolid, Viscoelastic
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
from skinfield.simulate.rig import (
    LoadCell,
    Loads,
    Places,
    Profile,
    Scenario,
    Solving,
    Temperature,
    Tool,
)

VERSION = 1
PRESETS = {"icub": icub_electronics, "cyskin": cyskin_electronics, "ideal": ideal_electronics}
BOARDS = {"icub": ICubBoard, "cyskin": CySkinBoard, "linear": LinearBoard}
LOADS = "no load here: those of all indenters are in [loads]"
SHEAR = "no shear here: the rig's actuator only goes up and down"
NOT_HERE = {"force_n": LOADS, "depth_mm": LOADS, "shear_x_n": SHEAR, "shear_y_n": SHEAR}


def load_scenario(path: str | Path) -> Scenario:
    """Read a scenario's file; files that it names are looked for beside it.

    Raises
    ------
    FileError
        If it cannot be read, or holds what is not known or cannot be used; the message says where.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # no UTF-8, or a zero byte in the name
        raise FileError(f"{path} is not text in UTF-8: {error}") from error
    return scenario_from_toml(text, path.parent, str(path))


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
    try:
        content = tomllib.loads(text, parse_float=Decimal)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError, ArithmeticError) as error:
        raise FileError(f"{path} is not TOML: {error}") from error
    table = Table(content, "", path, text)
    version = table.integer("skinfield_rig", 0)
    if version != VERSION:
        raise table.wrong("skinfield_rig", f"{VERSION}: the first line of a rig's scenario")
    usual = Scenario()
    values: dict[str, Any] = {
        "name": table.word("name", usual.name),
        "seed": table.integer("seed", usual.seed),
        "repeats": table.integer("repeats", usual.repeats),
        "first_repeat": table.integer("first_repeat", usual.first_repeat),
    }
    values |= _patch(table.table("patch"), folder)
    values["layer"], values["cover"] = _layer(table.table("layer"))
    values["elastomer"] = _elastomer(table.table("elastomer"))
    tools = table.tables("indenter")
    values["tools"] = tuple(_tool(one, row, folder) for row, one in enumerate(tools)) or usual.tools
    values["places"] = tuple(map(_places, table.tables("places"))) or usual.places
    values["loads"] = _loads(table.table("loads")) if "loads" in content else usual.loads
    values["profile"] = _simple(table.table("profile"), PROFILE, Profile)
    values["load_cell"] = _simple(table.table("load_cell"), LOAD_CELL, LoadCell)
    values["electronics"] = _electronics(table.table("electronics"))
    values["temperature"] = _simple(table.table("temperature"), TEMPERATURE, Temperature)
    values["solving"] = _simple(table.table("solving"), SOLVING, Solving)
    table.taken.add("loads")
    table.known.append("loads")
    return table.made(Scenario, **values)


def _simple(table: Table, keys: Keys, make: Any) -> Any:
    return table.made(make, **values_of(table, keys, make()))


def _patch(table: Table, folder: Path) -> dict[str, Any]:
    layout, name = table.word("layout", Scenario().layout), table.word("name", "")
    table.finish()
    try:
        patch, found = _patch_from(layout, name, folder)
    except InputError as error:
        raise FileError(f"{table.place('layout')}: {error}") from error
    return {"patch": patch, "layout": found, "patch_name": name}


def _patch_from(layout: str, name: str, folder: Path) -> tuple[Patch, str]:
    """Patch of a layout's file or a generator, and the layout's text without the folder."""
    file = folder / layout
    if layout.partition(":")[0].strip() in GENERATORS and not file.is_file():
        return by_name(layout), layout
    skin = load_layout(file)
    if name:
        return skin[name], str(file.resolve())
    if len(skin) > 1:
        names = ", ".join(patch.name for patch in skin)
        raise InputError(f"it has {len(skin)} patches, expected a name of one: {names}")
    return skin[0], str(file.resolve())


def _layer(table: Table) -> tuple[Layer, bool]:
    cover = table.flag("inextensible_cover", False)
    return _simple(table, LAYER, Layer), cover


def _elastomer(table: Table) -> Viscoelastic:
    terms = table.rows("prony_terms", 2)
    if terms:
        return table.made(PronySeries, terms=terms)
    solid: Viscoelastic = _simple(table, SOLID, StandardLinearSolid)
    return solid


def _tool(table: Table, row: int, folder: Path) -> Tool:
    settings = table.plain()
    name = settings.pop("name", None) or f"{settings.get('shape', 'indenter')}-{row + 1}"
    for key, expected in NOT_HERE.items():
        if key in settings:
            raise table.wrong(key, expected)
    try:
        indenter = indenter_from_mapping(settings, table.where, folder)
    except FileError:
        raise
    except (InputError, ArithmeticError, OSError, ValueError) as error:
        raise FileError(f"{table.place(None)}: {error}") from error
    words: tuple[tuple[str, object], ...] = ()
    if "file" in settings:
        settings["file"] = str((folder / settings["file"]).resolve())
        words = tuple((k, tuple(v) if isinstance(v, list) else v) for k, v in settings.items())
    return table.made(Tool, name=name, indenter=indenter, words=words)


def _places(table: Table) -> Places:
    make, keys = table.choice("kind", PLACES)
    usual: Any = make(positions=((0.0, 0.0),)) if "positions_mm" in keys else make()
    return table.made(make, **values_of(table, keys, usual))


def _loads(table: Table) -> Loads:
    return table.made(Loads, forces=table.numbers("forces_n"), depths=table.numbers("depths_mm"))


def _electronics(table: Table) -> Electronics:
    usual = table.choice("preset", PRESETS, "icub")()
    values = values_of(table, ELECTRONICS, usual)
    for name, keys in PARTS.items():
        part = table.table(name)
        values[name] = part.made(
            type(getattr(usual, name)), **values_of(part, keys, getattr(usual, name))
        )
    values["board"] = _board(table.table("board"), usual.board)
    return table.made(Electronics, **values)


def _board(table: Table, usual: Board) -> Board:
    kinds = {made: kind for kind, made in BOARDS.items()}
    kind = table.choice("kind", BOARDS, kinds[type(usual)])
    if kind is ICubBoard:
        values = values_of(table, ICUB, ICubBoard())
        byte = values_of(table, ICUB_BYTE, ICubByte())
        return table.made(ICubBoard, convention=table.made(ICubByte, **byte), **values)
    if kind is CySkinBoard:
        values = values_of(table, CYSKIN, CySkinBoard())
        return table.made(CySkinBoard, convention=CySkinCount(), **values)
    return table.made(LinearBoard)
