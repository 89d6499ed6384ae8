"""Indenters as settings: the same words in a scenario's file and on the command line."""

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.settings.text import nearest
from skinfield.simulate import Bar, Cone, Cylinder, Indenter, Ring, Rod, Sphere, Wedge

COMMON = (
    "x_mm", "y_mm", "rotation_deg", "tilt_x_deg", "tilt_y_deg",
    "force_n", "depth_mm", "shear_x_n", "shear_y_n",
)  # fmt: skip
PLAIN: dict[str, tuple[Any, str]] = {  # keys without a unit
    "file": (str, "the path of a file"),
    "invert": (bool, "true or false"),
    "down": (list | tuple, "three numbers, the direction in the file's axes into the skin"),
}
FACTORS = {"_mm": 1e-3, "_deg": np.pi / 180.0, "_n": 1.0}


@dataclass(frozen=True)
class Shape:
    """Keys of a shape beside the common ones, an example, and what makes it of SI values."""

    required: tuple[str, ...]
    optional: tuple[str, ...]
    example: str
    make: Callable[..., Indenter]

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that may be given, `shape` itself left out."""
        return (*self.required, *self.optional, *COMMON)


def _mesh(
    *, folder: Path, file: str, unit: float = 1e-3, down: Any = (0.0, 0.0, -1.0), **pose: Any
) -> Indenter:
    from skinfield.files.shapes import load_mesh

    return replace(load_mesh(folder / file, unit=unit, down=down), **{"force": None, **pose})


def _height_map(
    *, folder: Path, file: str, pixel: float, relief: float | None = None, invert: bool = False,
    **pose: Any,
) -> Indenter:  # fmt: skip
    from skinfield.files.shapes import load_height_map

    found = load_height_map(folder / file, pixel, relief, invert=invert)
    return replace(found, **{"force": None, **pose})


SHAPES = {
    "sphere": Shape(("radius_mm",), (), "sphere radius_mm=6 force_n=1", Sphere),
    "cylinder": Shape(
        ("radius_mm",), ("edge_radius_mm",), "cylinder radius_mm=3 edge_radius_mm=0.3", Cylinder
    ),
    "cone": Shape(
        ("radius_mm", "half_angle_deg"), ("edge_radius_mm",),
        "cone radius_mm=6 half_angle_deg=75", Cone,
    ),
    "bar": Shape(
        ("length_mm", "width_mm"), ("edge_radius_mm",), "bar length_mm=12 width_mm=3", Bar
    ),
    "rod": Shape(
        ("radius_mm", "length_mm"), ("edge_radius_mm",), "rod radius_mm=3 length_mm=12", Rod
    ),
    "wedge": Shape(
        ("length_mm", "width_mm", "half_angle_deg"), ("edge_radius_mm",),
        "wedge length_mm=10 width_mm=8 half_angle_deg=60", Wedge,
    ),
    "ring": Shape(
        ("inner_radius_mm", "outer_radius_mm"), ("edge_radius_mm",),
        "ring inner_radius_mm=4 outer_radius_mm=6", Ring,
    ),
    "mesh": Shape(("file",), ("unit_mm", "down"), "mesh file=part.stl", _mesh),
    "heightmap": Shape(
        ("file", "pixel_mm"), ("relief_mm", "invert"),
        "heightmap file=logo.png pixel_mm=0.1 relief_mm=1", _height_map,
    ),
}  # fmt: skip
EXAMPLE = SHAPES["sphere"].example


def indenter_from_mapping(
    mapping: Mapping[str, Any], where: str = "indenter", folder: Path = Path()
) -> Indenter:
    """Indenter that a table of settings describes.

    Parameters
    ----------
    mapping : mapping of str to number, str or bool
        ``shape``, the keys of that shape in `SHAPES`, and the common ones in `COMMON`, whose
        endings are their units: ``{"shape": "sphere", "radius_mm": 6, "x_mm": 3, "force_n": 1}``.
        Neither a force nor a depth means 1 N.
    where : str
        What errors call it.
    folder : Path
        Where the files of meshes and height maps are looked for.

    Raises
    ------
    InputError
        For a shape or key that there is not, one that is missing, or a value that cannot be used.
    FileError
        If its file cannot be used.
    """
    name = mapping.get("shape")
    if not isinstance(name, str) or name not in SHAPES:
        raise InputError(
            f"{where} has shape {name!r}, expected one of {', '.join(SHAPES)}"
            f"{nearest(name, SHAPES)}: for example '{EXAMPLE}'"
        )
    shape = SHAPES[name]
    given = [key for key in mapping if key != "shape"]
    for key in given:
        if key not in shape.keys:
            raise InputError(
                f"{where} has the key {key!r}, expected for a {name}: {', '.join(shape.keys)}"
                f"{nearest(key, shape.keys)}: for example '{shape.example}'"
            )
    missing = [key for key in shape.required if key not in mapping]
    if missing:
        raise InputError(
            f"{where} lacks {', '.join(missing)}, which a {name} needs: "
            f"for example '{shape.example}'"
        )
    values = {_field(key): _value(key, mapping[key], where) for key in given}
    if "file" in mapping:
        values["folder"] = folder
    try:
        return shape.make(**_posed(values))
    except FileError:
        raise
    except InputError as error:
        raise InputError(f"{where} ({name}): {error}") from error


def _posed(values: dict[str, Any]) -> dict[str, Any]:
    """Fields of an indenter: pairs of x and y put together."""
    pairs = {"position": ("x", "y"), "tilt": ("tilt_x", "tilt_y"), "shear": ("shear_x", "shear_y")}
    for name, (first, second) in pairs.items():
        values[name] = (values.pop(first, 0.0), values.pop(second, 0.0))
    return values


def _field(key: str) -> str:
    return next((key.removesuffix(end) for end in FACTORS if key.endswith(end)), key)


def _value(key: str, value: Any, where: str) -> Any:
    """Number in SI units, or the word, switch or direction that a key without a unit holds."""
    if key in PLAIN:
        kind, expected = PLAIN[key]
        if not isinstance(value, kind) or (key == "down" and len(value) != 3):
            raise InputError(f"{where}: {key} is {value!r}, expected {expected}")
        return tuple(_number(key, part, where) for part in value) if key == "down" else value
    factor = next(factor for end, factor in FACTORS.items() if key.endswith(end))
    return _number(key, value, where) * factor


def _number(key: str, value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(f"{where}: {key} is {value!r}, expected a number")
    if not np.isfinite(value):
        raise InputError(f"{where}: {key} is {value!r}, expected a finite number")
    return float(value)


WORDS = {"yes": True, "true": True, "no": False, "false": False}


def indenter_from_text(text: str, where: str = "--indenter") -> Indenter:
    """Indenter from its shape and `key=value` words, in mm, N and degrees.

    Keys are those of `SHAPES`; their units may be left out, so that `radius` stands for
    `radius_mm`.

    Raises
    ------
    InputError
        For words that mean nothing, with those that would.
    FileError
        If the file of a mesh or height map cannot be used.
    """
    return indenter_from_mapping(mapping_from_text(text, where), where)


def mapping_from_text(text: str, where: str = "--indenter") -> dict[str, Any]:
    """Settings that the words stand for."""
    try:
        first, *words = shlex.split(text) or [""]
    except ValueError as error:
        raise InputError(f"{where} is {text!r}: {error}; expected '{EXAMPLE}'") from error
    if not first or "=" in first:
        raise InputError(
            f"{where} is {text!r}, expected a shape first, one of {', '.join(SHAPES)}: "
            f"for example '{EXAMPLE}'"
        )
    known = SHAPES[first].keys if first in SHAPES else ()
    mapping: dict[str, Any] = {"shape": first}
    for word in words:
        key, _, value = word.partition("=")
        if not value:
            raise InputError(f"{where} holds {word!r}, expected key=value, as in '{EXAMPLE}'")
        key = next((key + unit for unit in FACTORS if key + unit in known), key)
        if key in mapping:
            raise InputError(f"{where} gives {key} twice, expected it once")
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
