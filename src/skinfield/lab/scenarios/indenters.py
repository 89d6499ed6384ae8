"""Indenters as settings: the same words in a scenario's file and on the command line."""

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from skinfield.errors import InputError
from skinfield.lab.scenarios.table import TomlTable, field_of
from skinfield.simulate import Bar, Cone, Cylinder, Finger, Indenter, Ring, Rod, Sphere, Wedge

POSE = "x_mm y_mm rotation_deg tilt_x_deg tilt_y_deg force_n depth_mm shear_x_n shear_y_n"
PAIRS = {"position": ("x", "y"), "tilt": ("tilt_x", "tilt_y"), "shear": ("shear_x", "shear_y")}
KINDS: dict[str, Any] = {"file": str, "invert": bool, "down": tuple[float, float, float]}


@dataclass(frozen=True)
class ShapeKeys:
    """What makes a shape of SI values, its keys beside those of the pose, and an example."""

    make: Callable[..., Indenter]
    required: str
    optional: str
    example: str

    @property
    def keys(self) -> list[str]:
        """All keys that there may be, `shape` itself left out."""
        return f"{self.required} {self.optional} {POSE}".split()


def _mesh(
    *, folder: Path, file: str, unit: float = 1e-3, down: Any = (0.0, 0.0, -1.0), **pose: Any
) -> Indenter:
    from skinfield.simulate.indenters.shape_files import load_mesh

    return replace(load_mesh(folder / file, unit=unit, down=down), **{"force": None, **pose})


def _height_map(
    *, folder: Path, file: str, pixel: float, relief: float | None = None, invert: bool = False,
    **pose: Any,
) -> Indenter:  # fmt: skip
    from skinfield.simulate.indenters.shape_files import load_height_map

    found = load_height_map(folder / file, pixel, relief, invert=invert)
    return replace(found, **{"force": None, **pose})


EDGE = "edge_radius_mm"
SHAPES = {
    "sphere": ShapeKeys(Sphere, "radius_mm", "", "sphere radius_mm=6 force_n=1"),
    "cylinder": ShapeKeys(Cylinder, "radius_mm", EDGE, "cylinder radius_mm=3 edge_radius_mm=0.3"),
    "cone": ShapeKeys(Cone, "radius_mm half_angle_deg", EDGE, "cone radius_mm=6 half_angle_deg=75"),
    "bar": ShapeKeys(Bar, "length_mm width_mm", EDGE, "bar length_mm=12 width_mm=3"),
    "rod": ShapeKeys(Rod, "radius_mm length_mm", EDGE, "rod radius_mm=3 length_mm=12"),
    "wedge": ShapeKeys(Wedge, "length_mm width_mm half_angle_deg", EDGE,
                   "wedge length_mm=10 width_mm=8 half_angle_deg=60"),
    "ring": ShapeKeys(Ring, "inner_radius_mm outer_radius_mm", EDGE,
                  "ring inner_radius_mm=4 outer_radius_mm=6"),
    "finger": ShapeKeys(Finger, "width_mm", "length_mm second apart_mm growth",
                        "finger width_mm=9 length_mm=14"),
    "mesh": ShapeKeys(_mesh, "file", "unit_mm down", "mesh file=part.stl"),
    "heightmap": ShapeKeys(_height_map, "file pixel_mm", "relief_mm invert",
                       "heightmap file=logo.png pixel_mm=0.1 relief_mm=1"),
}  # fmt: skip
EXAMPLE = SHAPES["sphere"].example


def indenter_from_mapping(
    mapping: Mapping[str, Any], where: str = "indenter", folder: Path = Path()
) -> Indenter:
    """Indenter that a table of settings describes.

    Parameters
    ----------
    mapping : mapping of str to number, str or bool
        ``shape``, the keys of that shape in `SHAPES`, and those of its pose in `POSE`, whose
        endings are their units: ``{"shape": "sphere", "radius_mm": 6, "x_mm": 3, "force_n": 1}``.
        Neither a force nor a depth means 1 N.
    where : str
        What errors call it.
    folder : Path
        Where the files of meshes and height maps are looked for.

    Raises
    ------
    FileError
        For a shape or key that there is not, one that is missing, a value that cannot be used, or
        a file that cannot.
    """
    return indenter_from_table(TomlTable(mapping, "", where), folder)


def indenter_from_table(table: TomlTable, folder: Path) -> Indenter:
    """Indenter of a table, of which nothing else may be left; see `indenter_from_mapping`."""
    shape = table.choice("shape", SHAPES)
    values = table.values({key: (field_of(key), KINDS.get(key, float)) for key in shape.keys})
    for key in shape.required.split():
        if key not in table.content:
            raise table.wrong(key, f"it with this shape: for example '{shape.example}'")
    for name, (first, second) in PAIRS.items():
        values[name] = (values.pop(first, 0.0), values.pop(second, 0.0))
    if "file" in values:
        values["folder"] = folder
    return table.make(shape.make, **values)


WORDS = {"yes": True, "true": True, "no": False, "false": False}


def indenter_from_text(text: str) -> Indenter:
    """Indenter from its shape and `key=value` words, in mm, N and degrees.

    Keys are those of `SHAPES`; their units may be left out, so that `radius` stands for
    `radius_mm`.

    Raises
    ------
    InputError
        For words that mean nothing, with those that would, and a file that cannot be used.
    """
    return indenter_from_mapping(mapping_from_text(text))


def mapping_from_text(text: str) -> dict[str, Any]:
    """Settings that the words stand for."""
    try:
        first, *words = shlex.split(text) or [""]
    except ValueError as error:
        raise InputError(f"{error}; expected '{EXAMPLE}'") from error
    with_unit = {field_of(key): key for key in SHAPES[first].keys} if first in SHAPES else {}
    mapping: dict[str, Any] = {"shape": first}
    for word in words:
        key, _, value = word.partition("=")
        key = with_unit.get(key, key)
        if not value or key in mapping:
            raise InputError(f"{word!r}, expected key=value, each key once, as in '{EXAMPLE}'")
        mapping[key] = value if key == "file" else _of_word(value)
    return mapping


def _of_word(text: str) -> Any:
    """Switch, number or list of numbers that a word stands for; else the word."""
    if text.lower() in WORDS:
        return WORDS[text.lower()]
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return text
    return numbers if len(numbers) > 1 else numbers[0]
