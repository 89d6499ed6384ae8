"""skinfield's own layout as text: TOML, to be read and edited by people.

The file of a skin holds beside its layout how its logs are read (`[log]`) and settings of a live
skin (`[skin]` and so on), each as a table.
"""

import json
import re
import tomllib
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.files.layouts.repair import Content, Draft
from skinfield.files.layouts.text import read_bytes
from skinfield.files.pending import write_bytes
from skinfield.settings import plain_from_toml, text_of_file, value_of_tables
from skinfield.skin.log import LogSettings
from skinfield.skin.patch import Patch, Skin

NAME = "skinfield-toml"
EXTENSIONS = (".toml",)
EXPECTED = "a TOML file with skinfield_layout = 1"
STATED = re.compile(rb"(?m)^(\xef\xbb\xbf)?[ \t]*[\"']?skinfield_layout[\"']?[ \t]*=")
VERSION = 1
HEADER = "# Layout of a robot skin. Lengths in millimetres, one row per taxel.\n"
LARGEST_TOML = 2**63  # above it a uid is written as a string, as TOML's integers end there

LAYOUT_KEYS = ("skinfield_layout", "name", "notes", "patch")
LOG = "log"
SECTIONS = (LOG, "skin", "source", "model", "loop", "page", "bridges", "record")

Number = int | Decimal  # exact: 4.75 mm is 0.00475 m, not its neighbour
Row = Annotated[list[Number], msgspec.Meta(min_length=3, max_length=3)]
Rotation = Annotated[list[Row], msgspec.Meta(min_length=3, max_length=3)]
Whole = Annotated[int, msgspec.Meta(ge=0, lt=2**31)]


class _Patch(msgspec.Struct, forbid_unknown_fields=True):
    positions_mm: list[Annotated[list[Number], msgspec.Meta(min_length=2, max_length=3)]]
    name: str | None = None
    link: str = ""
    pad_diameter_mm: Number | None = None
    n_channels: Whole = 0
    link_from_patch_rotation: Rotation | None = None
    link_from_patch_translation_mm: Row | None = None
    normals: list[Row] | None = None
    module: list[Whole] | None = None
    channel: list[Whole] | None = None
    uid: list[int | str] | None = None


class _File(msgspec.Struct, forbid_unknown_fields=True):
    skinfield_layout: Literal[1]
    patch: Annotated[list[_Patch], msgspec.Meta(min_length=1)]
    name: str | None = None
    notes: list[str] = []


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return STATED.search(data) is not None and b"\0" not in data  # recordings enclose layouts


def parse(path: Path) -> Content:
    """Contents of a file."""
    try:
        table = tomllib.loads(read_bytes(path).decode("utf-8"), parse_float=Decimal)
    except (ValueError, RecursionError, ArithmeticError) as error:
        raise FileError(f"{path}: no TOML: {str(error)[:200]}, expected {EXPECTED}") from error
    version = table.get("skinfield_layout")
    if version != VERSION:
        raise FileError(
            f"{path}: skinfield_layout is {version!r:.60}, expected {VERSION}: this program reads "
            "that version only"
        )
    try:
        layout = {key: value for key, value in table.items() if key not in SECTIONS}
        found = msgspec.convert(layout, _File)
        drafts = tuple(_draft(i, patch) for i, patch in enumerate(found.patch))
    except (msgspec.ValidationError, ValueError, ArithmeticError) as error:
        why = str(error)[:300].replace("`$.", "`")
        raise FileError(f"{path}: {why}; see the docs for all keys of a layout") from error
    return Content(path, found.name or path.stem, drafts, notes=tuple(found.notes))


def log_settings(path: Path) -> LogSettings | None:
    """How logs of the skin of a file are read; None where it does not say, or is another file.

    Raises
    ------
    FileError
        If it says so in a way that cannot be used.
    """
    if path.suffix.lower() not in EXTENSIONS or not path.is_file():
        return None
    text = text_of_file(path)
    found = plain_from_toml(text, str(path)).get(LOG)
    return None if found is None else value_of_tables(LogSettings, found, text, str(path), LOG)


def write(skin: Skin, path: Path, tables: str = "") -> None:
    """Write a skin; nothing is lost. `tables` are TOML that stands before its patches."""
    head = [HEADER, f"skinfield_layout = {VERSION}\n", f"name = {_quoted(skin.name)}\n"]
    if skin.notes:
        head += ["notes = [\n", *(f"  {_quoted(note)},\n" for note in skin.notes), "]\n"]
    head += [f"\n{tables.strip()}\n"] if tables.strip() else []
    text = "".join(head + [_patch_text(patch) for patch in skin])
    write_bytes(path, text.encode("utf-8"))


def _draft(index: int, patch: _Patch) -> Draft:
    positions = _scaled([[*row, 0][:3] for row in patch.positions_mm], -3)
    pose, shift = np.eye(4), patch.link_from_patch_translation_mm
    if patch.link_from_patch_rotation is not None:
        pose[:3, :3] = _scaled(patch.link_from_patch_rotation, 0)
    if shift is not None:
        pose[:3, 3] = _scaled([shift], -3)[0]
    uid = None
    if patch.uid is not None:
        numbers = [int(u, 0) if isinstance(u, str) else u for u in patch.uid]
        if not all(0 <= u < 2**64 for u in numbers):
            raise ValueError(f"uid of patch {index} is {numbers[:4]} ..., expected numbers from 0")
        uid = np.array(numbers, np.uint64)
    return Draft(
        positions,
        np.arange(len(positions)),
        None if patch.normals is None else _scaled(patch.normals, 0),
        module=None if patch.module is None else np.array(patch.module, np.int64),
        uid=uid,
        channel=None if patch.channel is None else np.array(patch.channel, np.int64),
        n_channels=patch.n_channels,
        pad_diameter=None if (size := patch.pad_diameter_mm) is None else _exact(size, -3),
        name=f"patch {index}" if patch.name is None else patch.name,
        link=patch.link,
        link_from_patch=pose,
        stated=True,
    )


def _scaled(rows: list[list[Number]], shift: int) -> Floats:
    """Rows of finite numbers, times 10**shift."""
    found = np.array([[_exact(cell, shift) for cell in row] for row in rows], np.float64)
    if not np.isfinite(found).all():
        raise ValueError(f"rows {rows[:2]!r:.80} hold inf or nan, expected finite numbers")
    return found.reshape(-1, 3)


def _exact(number: Number, shift: int) -> float:
    return float(Decimal(number).scaleb(shift))


def _decimal(value: float, shift: int) -> str:
    """Shortest decimal of value times 10**shift that is read back as the same float."""
    text = format(Decimal(repr(float(value))).scaleb(shift), "f")
    text = text.rstrip("0") if "." in text else text
    return text + "0" if text.endswith(".") else text if "." in text else text + ".0"


def _quoted(text: str) -> str:
    plain = text.encode("utf-8", "replace").decode()
    return json.dumps(plain, ensure_ascii=False).replace("\x7f", "\\u007F")


def _patch_text(patch: Patch) -> str:
    uids = [str(u) if u < LARGEST_TOML else f'"{u}"' for u in patch.uid.tolist()]
    pose = patch.link_from_patch
    lines = [
        "\n[[patch]]",
        f"name = {_quoted(patch.name)}",
        f"link = {_quoted(patch.link)}",
        f"pad_diameter_mm = {_decimal(patch.pad_diameter, 3)}",
        f"n_channels = {patch.n_channels}",
        f"link_from_patch_rotation = {_rows(pose[:3, :3], 0)}",
        f"link_from_patch_translation_mm = {_row(pose[:3, 3], 3)}",
        f"positions_mm = {_rows(patch.positions, 3)}",
        f"normals = {_rows(patch.normals, 0)}",
        f"module = [{', '.join(map(str, patch.module.tolist()))}]",
        f"channel = [{', '.join(map(str, patch.channel.tolist()))}]",
        f"uid = [{', '.join(uids)}]",
    ]
    return "\n".join(lines) + "\n"


def _row(values: Floats, shift: int) -> str:
    return "[" + ", ".join(_decimal(value, shift) for value in values.tolist()) + "]"


def _rows(values: Floats, shift: int) -> str:
    return "[\n" + "".join(f"  {_row(row, shift)},\n" for row in values) + "]"
