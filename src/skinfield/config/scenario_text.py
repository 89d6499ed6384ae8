"""Scenarios written as TOML: whole ones, and a commented one to start from."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from skinfield.config.indenters import COMMON, FACTORS, SHAPES
from skinfield.config.scenario import BOARDS, NOT_HERE, VERSION
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
    lines_of,
    text_of,
)
from skinfield.config.table import before_factor
from skinfield.errors import InputError
from skinfield.mechanics import PronySeries, StandardLinearSolid, Viscoelastic
from skinfield.simulate.electronics import CySkinBoard, Electronics, ICubBoard
from skinfield.simulate.rig import Scenario, Tool

PAIRS = {"x": ("position", 0), "y": ("position", 1), "tilt_x": ("tilt", 0), "tilt_y": ("tilt", 1)}


def toml_from_scenario(scenario: Scenario) -> str:
    """Text that `scenario_from_toml` makes the same scenario of.

    Raises
    ------
    InputError
        For what a file cannot hold: a patch without a layout's name, a matrix of cross-talk,
        thermal pads, or classes of one's own.
    """
    if not scenario.layout:
        raise InputError(
            f"layout of scenario {scenario.name!r} is '', expected where its patch is from: save "
            "it with save_layout and give the file's name"
        )
    heads = {
        "patch": [
            f"layout = {text_of('', scenario.layout)}",
            f"name = {text_of('', scenario.patch_name)}",
        ],
        "layer": [
            *lines_of(LAYER, scenario.layer),
            f"inextensible_cover = {text_of('', scenario.cover)}",
        ],
        "elastomer": _elastomer(scenario.elastomer),
    }
    text = [
        f"skinfield_rig = {VERSION}",
        f"name = {text_of('', scenario.name)}",
        f"seed = {int(scenario.seed)}",
        f"repeats = {int(scenario.repeats)}",
        f"first_repeat = {int(scenario.first_repeat)}",
        *_tables(heads),
    ]
    for tool in scenario.tools:
        text += ["", "[[indenter]]", *_tool(tool)]
    for places in scenario.places:
        text += ["", "[[places]]", *_places(places)]
    loads = scenario.loads
    rest = {
        "loads": [
            f"forces_n = {text_of('forces_n', loads.forces)}"
            if loads.forces
            else f"depths_mm = {text_of('depths_mm', loads.depths)}"
        ],
        "profile": lines_of(PROFILE, scenario.profile),
        "load_cell": lines_of(LOAD_CELL, scenario.load_cell),
        "temperature": lines_of(TEMPERATURE, scenario.temperature),
        "solving": lines_of(SOLVING, scenario.solving),
        **_electronics(scenario.electronics),
    }
    return "\n".join([*text, *_tables(rest)]) + "\n"


def _tables(tables: Mapping[str, list[str]]) -> list[str]:
    return [line for name, lines in tables.items() for line in ["", f"[{name}]", *lines]]


def _elastomer(elastomer: Viscoelastic) -> list[str]:
    if isinstance(elastomer, StandardLinearSolid):
        return lines_of(SOLID, elastomer)
    if isinstance(elastomer, PronySeries):
        return [f"prony_terms = {text_of('', elastomer.terms)}"]
    raise _cannot("elastomer", elastomer)


def _tool(tool: Tool) -> list[str]:
    lines = [f"name = {text_of('', tool.name)}"]
    if tool.words:
        return lines + [f"{key} = {_plain(value)}" for key, value in tool.words]
    body: Any = tool.indenter
    shape = next((name for name, shape in SHAPES.items() if shape.make is type(body)), None)
    if shape is None:
        raise _cannot(f"indenter {tool.name!r}", body)
    lines.append(f"shape = {text_of('', shape)}")
    keys = [*SHAPES[shape].required, *SHAPES[shape].optional, *COMMON]
    for key in (key for key in keys if key not in NOT_HERE):
        ending = next(end for end in FACTORS if key.endswith(end))
        pair, part = PAIRS.get(key.removesuffix(ending), (key.removesuffix(ending), None))
        value = getattr(body, pair) if part is None else getattr(body, pair)[part]
        lines.append(f"{key} = {before_factor(float(value), FACTORS[ending])!r}")
    return lines


def _plain(value: object) -> str:
    """Settings as they were given, numbers in the unit that they were given in."""
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_plain, value)) + "]"
    return repr(value) if isinstance(value, float) else text_of("", value)


def _places(places: Any) -> list[str]:
    for kind, (made, keys) in PLACES.items():
        if made is type(places):
            return [f"kind = {text_of('', kind)}", *lines_of(keys, places)]
    raise _cannot("places", places)


def _electronics(electronics: Electronics) -> dict[str, list[str]]:
    if electronics.thermal_pads is not None or electronics.cross_talk.matrix is not None:
        raise _cannot("electronics with thermal pads or a matrix of cross-talk", electronics)
    board: Any = electronics.board
    kind = next((kind for kind, made in BOARDS.items() if made is type(board)), None)
    if kind is None:
        raise _cannot("board", board)
    lines = [f"kind = {text_of('', kind)}"]
    if isinstance(board, ICubBoard):
        lines += lines_of(ICUB, board) + lines_of(ICUB_BYTE, board.convention)
    elif isinstance(board, CySkinBoard):
        lines += lines_of(CYSKIN, board)
    parts = {f"electronics.{name}": lines_of(keys, getattr(electronics, name))
             for name, keys in PARTS.items()}  # fmt: skip
    return {
        "electronics": lines_of(ELECTRONICS, electronics),
        "electronics.board": lines,
        **parts,
    }


def _cannot(what: str, value: object) -> InputError:
    return InputError(
        f"{what} is {value!r:.120}, expected one that a scenario's file can hold: see "
        "'skinfield rig --new'"
    )


def in_folder(scenario: Scenario, layout: str) -> tuple[Scenario, list[tuple[Path, str]]]:
    """Scenario whose files lie beside it under plain names, and (source, name) of what to copy.

    Parameters
    ----------
    scenario : Scenario
    layout : str
        Name of its layout's file there.
    """
    copies, tools = [], []
    for row, tool in enumerate(scenario.tools):
        words = dict(tool.words)
        if "file" in words:
            source = Path(str(words["file"]))
            name = f"shape-{row + 1}{source.suffix}"
            words["file"] = name
            copies.append((source, name))
        tools.append(replace(tool, words=tuple(words.items())))
    return replace(scenario, layout=layout, patch_name="", tools=tuple(tools)), copies


TEMPLATE = """\
# A virtual rig: who presses where, how, and what the skin's electronics make of it.
# Every key can be left out; the values shown are the defaults, unless it says "for example".
# Endings are units: _mm, _s, _ms, _n, _mn (millinewtons), _kpa, _deg, _c (Celsius), _hz, _counts.
skinfield_rig = 1
name = "rig"
seed = 0                  # of all that is random: the same seed makes the same files
repeats = 1               # recordings per indenter

[patch]
layout = "icub_hexagon"   # a layout's file beside this one, or a generator by name
name = ""                 # which patch, where the layout has several

[layer]
thickness_mm = 2.0
young_modulus_kpa = 150.0 # relaxed: after a load has stood for long
poisson_ratio = 0.5       # 0.5 is incompressible, as solid silicone is
relative_permittivity = 3.0
inextensible_cover = false

[elastomer]               # how it creeps
relaxed_fraction = 0.85   # relaxed modulus over the instantaneous one; 1 is elastic
time_constant_s = 1.0

# Each indenter presses in a recording of its own. Shapes: sphere, cylinder, cone, bar, rod, wedge,
# ring, mesh (file), heightmap (file, pixel_mm); with tilt_x_deg, tilt_y_deg, rotation_deg.
[[indenter]]
name = "sphere6"
shape = "sphere"
radius_mm = 6.0

[[indenter]]              # for example
name = "cylinder3"
shape = "cylinder"
radius_mm = 3.0
edge_radius_mm = 0.2

# Where to press, each with every load. Kinds: over_taxel, between_two, between_three, at, random,
# raster. Without taxels, pairs or triples it is the place nearest to the patch's middle.
[[places]]
kind = "over_taxel"
taxels = []               # rows of the layout, from 0
angle_deg = 0.0           # of the indenter on the patch

[[places]]                # for example
kind = "random"
count = 3
within_mm = 3.0           # of the centre of some taxel
turned = false            # at random angles too

[loads]                   # forces_n, or else depths_mm
forces_n = [0.2, 0.5, 1.0]

[profile]
rest_s = 2.5              # untouched, at the start and at the end
approach_s = 0.5
ramp_s = 0.5
hold_s = 2.0
release_s = 0.5
pause_s = 0.5             # up, and on to the next place
smooth = true             # false: straight ramps
clearance_mm = 5.0        # height of the indenter between presses

[load_cell]
full_scale_n = 3.0
rate_hz = 100.0
noise_mn = 3.0
offset_mn = 0.0
gain_error = 0.0
resolution_mn = 0.0
delay_ms = 0.0

[temperature]             # of the room, by a straight line
start_c = 25.0
end_c = 25.0

[solving]
extent_mm = 24.0          # square of skin in which the indenter may touch
cell_mm = 0.5             # of the truth's fields
rungs = 12                # loads at which contact is solved; between them is interpolated

[electronics]
preset = "icub"           # icub, cyskin or ideal; every key below changes it
quantised = true

[electronics.noise]
white_counts = 3.1

[electronics.delivery]
rate_hz = 20.0
"""
