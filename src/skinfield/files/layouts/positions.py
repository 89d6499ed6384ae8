"""Positions of taxels from a table of any column names, in mm, m, cm or inches, or from a picture.

    name,px_mm,py_mm              id;x;y;z;nx;ny;nz              12.0 4.0
    ch0,-14.0,-14.0               0;0,0;0,0;1,5;0;0;1            16.0 4.0

Names say which columns are x, y and z; else the columns of numbers are taken in their order. The
unit is that of the names (`x_mm`, `x [m]`), else what makes the taxels' distance that of a skin.

A picture, scan or drawing, has equal dots on a plain ground: a plane of colour through its border,
so that the light may fade. What differs from it, by the threshold of Otsu (IEEE Trans. SMC 9(1),
62-66, 1979), are marks; taxels are at their centroids.
"""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from skinfield.errors import FileError, Floats, InputError, check_positive, needs
from skinfield.files.layouts.text import listed, read_bytes
from skinfield.files.numbers import delimiter_of
from skinfield.plot import plural
from skinfield.signal.boards import Bools

LengthUnit = Literal["m", "cm", "mm", "inch"]
METRES = {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "inch": 0.0254}
WORDS = {"mm": "mm", "millimetres": "mm", "millimeters": "mm", "cm": "cm", "m": "m",
         "metres": "m", "meters": "m", "in": "inch", "inch": "inch", "inches": "inch"}  # fmt: skip
AXES, NORMALS = ("x", "y", "z"), ("nx", "ny", "nz")
IDS = ("id", "name", "taxel", "channel", "ch", "label", "uid", "column", "sensor", "index",
       "number", "no", "#", "")  # fmt: skip
METRE_PITCH = 0.1  # m between taxels at most; from here on numbers are millimetres
MOST = 1 << 20  # taxels

HEADS = (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"BM", b"II*\0", b"MM\0*")
DRAWINGS = (b"%PDF", b"%!PS", b"<svg", b"PK\x03\x04")
LARGEST = 50_000_000  # pixels
CONTRAST = 24.0  # of 255, between marks and ground
SPECK, SMALL, LARGE = 0.1, 0.5, 1.7  # of the median area of the marks
LEAST = 6  # pixels of a mark
LINE = 0.3  # of its box, that a line or a frame fills at most
ROW = 0.5  # distances of neighbours, between two rows at least
TILT = 20.0  # degrees, of the rows of a picture at most


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


def is_picture(head: bytes) -> bool:
    """Whether a file that begins so is a picture, or a drawing that can become one."""
    return head.startswith(HEADS + DRAWINGS) or b"<svg" in head[:400]


def positions_in_picture(
    path: Path, pitch: float | None = None, width: float | None = None
) -> Positions:
    """Positions of the dots of a picture, by rows from top to bottom, each from left to right.

    Parameters
    ----------
    path : Path
        PNG, JPEG, BMP, GIF or TIFF.
    pitch : float, m, optional
        Distance of neighbours: the median of the distances to the nearest one.
    width : float, m, optional
        From the centre of the leftmost to that of the rightmost taxel; one of the two.

    Returns
    -------
    Positions
        About the middle of their box; x to the right, y upwards in the picture.

    Raises
    ------
    FileError
        If it is no picture, or no equal dots are found in it.
    InputError
        If its scale is not given, or twice; or Pillow is missing.
    """
    image = _pixels(path)
    centres, size, notes = _dots(path, image)
    metres = _scale(path, centres, pitch, width)
    centres = centres[_order(centres)]
    middle = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    places = np.zeros((len(centres), 3))
    places[:, :2] = (centres - middle) * [metres, -metres]
    notes = (
        f"{plural(len(centres), 'dot')} of {size * metres * 1e3:.3g} mm in {path.name}, by rows "
        "from top to bottom, each from left to right: check the numbers in the picture", *notes,
    )  # fmt: skip
    return Positions(places, None, (), "mm", False, notes)


def _pixels(path: Path) -> Floats:
    """Colours (H, W, 3) of a picture on white, as it is to be seen, 0 to 255."""
    data = read_bytes(path)
    if data.startswith(DRAWINGS) or b"<svg" in data[:400]:
        raise FileError(f"{path} is a drawing, expected a picture: export it as PNG")
    with needs("PIL", "skinfield[plot]", "pictures of arrays"):
        from PIL import Image, ImageOps
    try:
        with Image.open(io.BytesIO(data)) as opened:
            if opened.width * opened.height > LARGEST or min(opened.size) < 8:
                raise FileError(
                    f"{path} has {opened.width} x {opened.height} pixels, expected 8 x 8 or more, "
                    f"{LARGEST // 10**6} million at most"
                )
            seen = ImageOps.exif_transpose(opened).convert("RGBA")
            ground = Image.new("RGBA", seen.size, "white")
            return np.asarray(Image.alpha_composite(ground, seen).convert("RGB"), float)
    except FileError:
        raise
    except Exception as error:  # whatever a decoder of damaged bytes raises
        raise FileError(f"{path} is no picture that can be read ({error}), expected PNG") from error


def _dots(path: Path, image: Floats) -> tuple[Floats, float, tuple[str, ...]]:
    """Centres (L, 2) of equal dots, and their median diameter, in pixels; and what was left out."""
    from scipy import ndimage

    labels, count = ndimage.label(ndimage.binary_fill_holes(_marks(path, image)), np.ones((3, 3)))
    areas = np.bincount(labels.ravel(), minlength=count + 1)[1:].astype(float)
    known = np.flatnonzero(areas >= LEAST)
    if not len(known):
        raise FileError(f"{path} holds no dot of {LEAST} pixels, expected one for each taxel")
    usual = float(np.median(areas[known]))
    specks = areas < max(SPECK * usual, LEAST)
    centres = np.array(ndimage.center_of_mass(labels > 0, labels, np.arange(1, count + 1)))[:, ::-1]
    odd = ~specks & ((areas < SMALL * usual) | (areas > LARGE * usual))
    if odd.any():
        x, y = centres[np.argmax(odd)]
        raise FileError(
            f"{path}: {odd.sum()} of {plural(int((~specks).sum()), 'mark')} differ in size from "
            f"the others ({usual:.0f} pixels), the first at pixel {x:.0f}, {y:.0f}; expected equal "
            "dots that do not touch, on a plain ground, without words"
        )
    left = int(specks.sum())
    notes = (f"left out, as too small for dots: {plural(left, 'speck')}",) if left else ()
    return centres[~specks], float(np.sqrt(4.0 * usual / np.pi)), notes


def _marks(path: Path, image: Floats) -> Bools:
    """Pixels (H, W) that are no ground, without lines and frames."""
    from scipy import ndimage

    rows, columns = np.indices(image.shape[:2])
    edge = np.zeros(image.shape[:2], bool)
    edge[[0, -1]] = edge[:, [0, -1]] = True
    plane = np.column_stack([np.ones(rows.size), rows.ravel(), columns.ravel()])
    of_edge, colours = plane[edge.ravel()], image[edge]
    off = np.abs(colours - np.median(colours, axis=0)).max(axis=1)
    near = off <= np.median(off) + CONTRAST  # a mark may reach the border
    ground = plane @ np.linalg.lstsq(of_edge[near], colours[near], rcond=None)[0]
    differs = np.abs(image - ground.reshape(image.shape)).max(axis=2)
    level = _otsu(differs)
    if not differs[differs > level].size or differs[differs > level].mean() < CONTRAST:
        raise FileError(f"{path} is all of one colour, expected dots on a plain ground")
    marks: Bools = differs > level
    labels, count = ndimage.label(marks, np.ones((3, 3)))
    for number, box in enumerate(ndimage.find_objects(labels), 1):
        tall, wide = (each.stop - each.start for each in box)
        long = tall > 0.5 * image.shape[0] or wide > 0.5 * image.shape[1]
        if count > 1 and long and (labels[box] == number).mean() < LINE:
            marks[box][labels[box] == number] = False
    return marks


def _otsu(values: Floats) -> float:
    """Threshold that parts values in two classes, farthest apart beside their spread."""
    counts, edges = np.histogram(values, 256, (0.0, 256.0))
    middles = 0.5 * (edges[1:] + edges[:-1])
    below, sums = np.cumsum(counts), np.cumsum(counts * middles)
    above = below[-1] - below
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = below * above * (sums / below - (sums[-1] - sums) / above) ** 2
    return float(edges[1:][np.nanargmax(np.nan_to_num(apart))])


def _scale(path: Path, centres: Floats, pitch: float | None, width: float | None) -> float:
    """Metres per pixel."""
    if len(centres) == 1:
        return 1e-3
    if (pitch is None) == (width is None):
        raise InputError(
            f"the scale of {path} is {'unknown' if pitch is None else 'given twice'}, expected "
            "--pitch-mm, the distance of neighbours, or --width-mm, from the leftmost to the "
            "rightmost taxel"
        )
    if pitch is not None:
        from skinfield.skin.geometry import nearest_distance

        check_positive("pitch", pitch, "distance of neighbours")
        return pitch / float(np.median(nearest_distance(np.column_stack([centres, 0 * centres]))))
    assert width is not None
    check_positive("width", width, "of the array")
    across = float(np.ptp(centres[:, 0]))
    if across < 1.0:
        raise InputError(f"dots of {path} stand above each other, expected --pitch-mm")
    return width / across


def _order(centres: Floats) -> list[int]:
    """Centres (L, 2) by rows, which may be tilted, and in these from left to right."""
    from scipy.spatial import KDTree

    if len(centres) == 1:
        return [0]
    near, which = map(np.asarray, KDTree(centres).query(centres, min(7, len(centres))))
    step = float(np.median(near[:, 1]))
    along = centres[which[:, 1:]] - centres[:, None]
    angles = np.degrees(np.arctan2(along[..., 1], along[..., 0]))
    angles = angles[(near[:, 1:] < 1.4 * step) & (np.abs(angles) < TILT)]
    tilt = np.radians(np.median(angles)) if len(angles) else 0.0
    x, y = (centres @ [[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]]).T
    down = np.argsort(y)
    row = np.empty(len(centres), int)
    row[down] = np.cumsum(np.r_[False, np.diff(y[down]) > ROW * step])
    return [int(each) for each in np.lexsort((x, row))]
