"""Positions of taxels from a table of any column names: a CSV of one's own, in mm, m, cm or inches.

    name,px_mm,py_mm              id;x;y;z;nx;ny;nz              12.0 4.0
    ch0,-14.0,-14.0               0;0,0;0,0;1,5;0;0;1            16.0 4.0

Names say which columns are x, y and z; else the columns of numbers are taken in their order. The
unit is that of the names (`x_mm`, `x [m]`), else what makes the taxels' distance that of a skin.
"""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from skinfield.errors import FileError, Floats, InputError
from skinfield.files.layouts.text import listed, read_bytes
from skinfield.files.numbers import delimiter_of

LengthUnit = Literal["m", "cm", "mm", "inch"]
METRES = {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "inch": 0.0254}
WORDS = {"mm": "mm", "millimetres": "mm", "millimeters": "mm", "cm": "cm", "m": "m",
         "metres": "m", "meters": "m", "in": "inch", "inch": "inch", "inches": "inch"}  # fmt: skip
AXES, NORMALS = ("x", "y", "z"), ("nx", "ny", "nz")
IDS = ("id", "name", "taxel", "channel", "ch", "label", "uid", "column", "sensor", "index",
       "number", "no", "#", "")  # fmt: skip
METRE_PITCH = 0.1  # m between taxels at most; from here on numbers are millimetres
MOST = 1 << 20  # taxels


@dataclass(frozen=True, eq=False)
class Positions:
    """Places of taxels as a table has them.

    Attributes
    ----------
    positions : (L, 3) array, m
    normals : (L, 3) array or None
    names : tuple of str
        Of the taxels, in the table's own words; empty without a column of them.
    unit : str
        Of the numbers in the table.
    guessed : bool
        Whether the unit is known by the taxels' distance only.
    notes : tuple of str
        Which columns and which unit were taken, and why.
    """

    positions: Floats
    normals: Floats | None
    names: tuple[str, ...]
    unit: LengthUnit
    guessed: bool
    notes: tuple[str, ...]


def read_positions(
    path: Path, axes: Sequence[str] = (), unit: LengthUnit | None = None
) -> Positions:
    """Read a table of positions.

    Parameters
    ----------
    path : Path
    axes : sequence of str
        Names of the two or three columns of the positions; by default those named so.
    unit : str, optional
        Of the numbers: mm, m, cm or inch. Default as columns are named, else by their size.

    Raises
    ------
    FileError
        If it is no table, or a place is no number.
    InputError
        If a column of `axes` is not there.
    """
    names, first, rows = _rows(path)
    places, why = _axes(path, names, rows, axes)
    values = np.zeros((len(rows), 3))
    values[:, : len(places)] = _numbers(path, first, rows, places)
    told, how = (unit, "as given") if unit else _named_unit([names[place] for place in places])
    guessed = told is None
    if told is None:
        told, how = _unit_by_distance(values)
    columns = ", ".join(names[place] or f"column {place + 1}" for place in places)
    notes = [f"positions: columns {columns} ({why}), in {told} ({how})"]
    normals = None
    lower = [_bare(name) for name in names]
    if all(name in lower for name in NORMALS):
        normals = _numbers(path, first, rows, [lower.index(name) for name in NORMALS])
    ids = next((lower.index(name) for name in IDS if name in lower), None)
    if ids is None:
        ids = next((k for k in range(len(names)) if k not in places and _texts(rows, k)), None)
    taxels = () if ids is None or ids in places else tuple(row[ids].strip() for row in rows)
    if twice := sorted({name for name in taxels if taxels.count(name) > 1})[:8]:
        notes.append(f"names of taxels repeat ({listed(twice)}): not used")
        taxels = ()
    return Positions(values * METRES[told], normals, taxels, told, guessed, tuple(notes))


def _rows(path: Path) -> tuple[list[str], int, list[list[str]]]:
    """Names of the columns, the line of the first row, and the rows of a table."""
    try:
        text = read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"{path} is not text in UTF-8, expected a CSV of positions") from error
    numbered = [(n, line.strip()) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    lines = [(n, line) for n, line in numbered if not line.startswith(("#", "%"))]
    comments = [line.lstrip("#% ") for _, line in numbered if line.startswith(("#", "%"))]
    if not lines or len(lines) > MOST or "\0" in text:
        what = "has no line of numbers" if not lines else "is no table of taxels"
        raise FileError(f"{path} {what}, expected a CSV of positions: a row of x, y for each taxel")
    delimiter, _ = delimiter_of(lines[-1][1])
    table = [(n, _cells(path, n, line, delimiter)) for n, line in lines]
    names: list[str] = [""] * len(table[0][1])
    if not any(_number(cell) is not None for cell in table[0][1]):
        names, table = [cell.strip().strip("\"'") for cell in table[0][1]], table[1:]
    elif comments:
        said = _cells(path, 0, comments[-1], delimiter)
        names = [cell.strip() for cell in said] if len(said) == len(names) else names
    if not table:
        raise FileError(f"{path} holds a line of names only, expected a row for each taxel below")
    for n, row in table:
        if len(row) != len(names):
            raise FileError(
                f"{path}:{n}: {len(row)} values, expected {len(names)} as its first line has"
            )
    return names, table[0][0], [row for _, row in table]


def _cells(path: Path, line: int, text: str, delimiter: str | None) -> list[str]:
    try:
        return next(csv.reader([text], delimiter=delimiter)) if delimiter else text.split()
    except (csv.Error, StopIteration) as error:
        raise FileError(f"{path}:{line}: no line of a table ({error})") from error


def _number(cell: str) -> float | None:
    """A finite number; a comma counts as a point."""
    try:
        value = float(cell.strip().replace(",", "."))
    except ValueError:
        return None
    return value if abs(value) < 1e9 and "_" not in cell else None


def _numbers(path: Path, first: int, rows: list[list[str]], places: Sequence[int]) -> Floats:
    values = np.empty((len(rows), len(places)))
    for at, row in enumerate(rows):
        for column, place in enumerate(places):
            value = _number(row[place])
            if value is None:
                raise FileError(
                    f"{path}: taxel {at} (from line {first} on) has {row[place][:20]!r} as a "
                    "place, expected a number"
                )
            values[at, column] = value
    return values


def _bare(name: str) -> str:
    """Name without its unit and what stands before: x of "pos_x (mm)"."""
    words = [word for word in re.split(r"[^a-z#]+", name.lower()) if word]
    words = [word for word in words if word not in WORDS] or words
    last = words[-1] if words else ""
    prefixed = re.fullmatch(r"(?:p|pos|position|c|center|centre)([xyz])", last)
    return prefixed[1] if prefixed else last


def _texts(rows: list[list[str]], place: int) -> bool:
    return all(_number(row[place]) is None and row[place].strip() for row in rows)


def _axes(
    path: Path, names: list[str], rows: list[list[str]], wanted: Sequence[str]
) -> tuple[list[int], str]:
    """Columns of the positions, and how they are known."""
    known = ", ".join(filter(None, names)) or f"{len(names)} without names"
    if wanted:
        for name in wanted:
            if name not in names:
                raise InputError(
                    f"column {name!r} is not in {path}, expected two or three of its {len(names)}: "
                    f"{known}"
                )
        return [names.index(name) for name in wanted], "as given"
    bare = [_bare(name) for name in names]
    named = [bare.index(axis) for axis in AXES if bare.count(axis) == 1]
    if len(named) >= 2 and {"x", "y"} <= {bare[place] for place in named}:
        return named, "by their names"
    numeric = [k for k in range(len(names)) if all(_number(row[k]) is not None for row in rows)]
    numeric = [k for k in numeric if bare[k] not in IDS or not names[k]]
    if len(numeric) in (2, 3):
        return numeric, "the columns of numbers, in their order"
    raise FileError(
        f"{path} has columns {known}, expected x and y (and z) among them: name them with --axes"
    )


def _named_unit(names: Sequence[str]) -> tuple[LengthUnit | None, str]:
    """Unit in the names of columns; None without one."""
    for name in names:
        words = [word for word in re.split(r"[^a-z]+", name.lower()) if word]
        if len(words) > 1 and words[-1] in WORDS:
            return WORDS[words[-1]], "by their names"  # type: ignore[return-value]
    return None, ""


def _unit_by_distance(values: Floats) -> tuple[LengthUnit, str]:
    """Unit that makes the distance of positions (L, 3) that of taxels."""
    from skinfield.skin.geometry import nearest_distance

    if len(values) == 1:
        return "mm", "of one taxel, whose place tells no unit"
    distance = nearest_distance(np.unique(values, axis=0))
    pitch = float(np.median(distance)) if np.isfinite(distance).all() else 0.0
    if pitch >= METRE_PITCH:
        return "mm", f"taxels are {pitch:.3g} apart, which in metres no skin is"
    return "m", f"taxels are {pitch:.3g} apart, which in mm no skin is"
