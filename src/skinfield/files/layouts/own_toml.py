"""skinfield's own layout as text: TOML, to be read and edited by people."""

import tomllib
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.files.layouts.repair import Content, Draft
from skinfield.files.layouts.text import read_bytes
from skinfield.files.pending import write_bytes
from skinfield.skin.patch import Patch, Skin

NAME = "skinfield-toml"
EXTENSIONS = (".toml",)
EXPECTED = "a TOML file with skinfield_layout = 1"
VERSION = 1
HEADER = "# Layout of a robot skin. Lengths in millimetres, one row per taxel.\n"
LARGEST_TOML = 2**63  # above it a uid is written as a string, as TOML's integers end there


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return b"skinfield_layout" in data and not data.startswith(b"PK")


def parse(path: Path) -> Content:
    """Contents of a file.

    Raises
    ------
    FileError
        When it is not TOML, of another version, or a key cannot be used.
    """
    try:
        # exact decimals: 4.75 mm is 0.00475 m, not its neighbour
        table = tomllib.loads(read_bytes(path).decode("utf-8"), parse_float=Decimal)
    except (ValueError, RecursionError, ArithmeticError) as error:
        raise FileError(f"{path}: no TOML: {str(error)[:200]}, expected {EXPECTED}") from error
    version = table.pop("skinfield_layout", None)
    if version != VERSION:
        raise FileError(
            f"{path}: skinfield_layout is {version!r}, expected {VERSION}: this program reads "
            "that version only"
        )
    fields = _Fields(path, "the file", table)
    name = fields.text("name", path.stem)
    notes = fields.texts("notes")
    patches = fields.tables("patch")
    fields.finish()
    drafts = tuple(_draft(_Fields(path, f"patch {i}", row)) for i, row in enumerate(patches))
    return Content(path, name, drafts, notes=notes)


def write(skin: Skin, path: Path) -> tuple[str, ...]:
    """Write a skin; nothing is lost."""
    head = [HEADER, f"skinfield_layout = {VERSION}\n", f"name = {_quoted(skin.name)}\n"]
    if skin.notes:
        head += ["notes = [\n", *(f"  {_quoted(note)},\n" for note in skin.notes), "]\n"]
    text = "".join(head + [_patch_text(patch) for patch in skin])
    write_bytes(path, text.encode("utf-8"))
    return ()


class _Fields:
    """Keys of one table, taken one by one; what is left at the end is a typing error."""

    def __init__(self, path: Path, where: str, table: dict[str, Any]) -> None:
        self.path, self.where, self.table = path, where, dict(table)

    def wrong(self, key: str, value: object, expected: str) -> FileError:
        shown = repr(value) if len(repr(value)) < 60 else f"{repr(value)[:57]}..."
        return FileError(f"{self.path}: {self.where}: {key} is {shown}, expected {expected}")

    def text(self, key: str, default: str) -> str:
        value = self.table.pop(key, default)
        if not isinstance(value, str):
            raise self.wrong(key, value, "text in quotes")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        value = self.table.pop(key, [])
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.wrong(key, value, "a list of sentences")
        return tuple(value)

    def tables(self, key: str) -> list[dict[str, Any]]:
        value = self.table.pop(key, None)
        if not isinstance(value, list) or not value or not isinstance(value[0], dict):
            raise self.wrong(key, value, f"one or more tables [[{key}]]")
        return value

    def numbers(self, key: str, shape: str, columns: Sequence[int], shift: int) -> Floats | None:
        """Rows of numbers, times 10**shift; a single number where `columns` is empty."""
        value = self.table.pop(key, None)
        if value is None:
            return None
        try:
            rows = [[_scaled(cell, shift) for cell in row] for row in value]
            array = np.asarray(rows, dtype=np.float64)
        except (TypeError, ValueError, ArithmeticError) as error:
            raise self.wrong(key, value, f"{shape}, numbers only") from error
        if array.ndim != 2 or array.shape[1] not in columns or not np.isfinite(array).all():
            raise self.wrong(key, value, f"{shape}, finite numbers only")
        return array

    def number(self, key: str, shift: int) -> float | None:
        if key not in self.table:
            return None
        value = self.table.pop(key)
        try:
            return _scaled(value, shift)
        except (TypeError, ValueError, ArithmeticError) as error:
            raise self.wrong(key, value, "a number") from error

    def integers(self, key: str, length: int, highest: int) -> list[int] | None:
        value = self.table.pop(key, None)
        if value is None:
            return None
        try:
            row = [int(item, 0) if isinstance(item, str) else item for item in value]
        except (TypeError, ValueError) as error:
            raise self.wrong(key, value, "a list of whole numbers") from error
        if len(row) != length or not all(type(i) is int and 0 <= i < highest for i in row):
            raise self.wrong(key, value, f"{length} whole numbers from 0, one per taxel")
        return row

    def finish(self) -> None:
        if self.table:
            unknown = ", ".join(sorted(self.table))
            raise FileError(f"{self.path}: {self.where}: unknown keys {unknown}: see the docs")


def _draft(fields: _Fields) -> Draft:
    positions = fields.numbers("positions_mm", "rows of [x, y, z] or [x, y]", (2, 3), -3)
    if positions is None:
        raise fields.wrong("positions_mm", None, "rows of [x, y, z] or [x, y]")
    count = len(positions)
    flat = np.zeros((count, 3 - positions.shape[1]))
    normals = fields.numbers("normals", "rows of [x, y, z]", (3,), 0)
    if normals is not None and len(normals) != count:
        raise fields.wrong("normals", f"{len(normals)} rows", f"{count}, one per taxel")
    uid, module = fields.integers("uid", count, 2**64), fields.integers("module", count, 2**31)
    channel = fields.integers("channel", count, 2**31)
    n_channels = fields.integers("n_channels", 1, 2**31) if _box(fields, "n_channels") else None
    draft = Draft(
        np.hstack([positions, flat]),
        np.arange(count),
        normals,
        module=None if module is None else np.array(module, np.int64),
        uid=None if uid is None else np.array(uid, np.uint64),
        channel=None if channel is None else np.array(channel, np.int64),
        n_channels=0 if n_channels is None else n_channels[0],
        pad_diameter=fields.number("pad_diameter_mm", -3),
        name=fields.text("name", fields.where),
        link=fields.text("link", ""),
        link_from_patch=_pose(fields),
        stated=True,
    )
    fields.finish()
    return draft


def _box(fields: _Fields, key: str) -> bool:
    """Make a single value a list of one, to be checked as such; whether it is there."""
    if key in fields.table:
        fields.table[key] = [fields.table[key]]
    return key in fields.table


def _pose(fields: _Fields) -> Floats | None:
    pose = np.eye(4)
    rotation = fields.numbers("link_from_patch_rotation", "3 rows of 3", (3,), 0)
    given = [rotation is not None, _box(fields, "link_from_patch_translation_mm")]
    translation = fields.numbers("link_from_patch_translation_mm", "[x, y, z]", (3,), -3)
    if rotation is not None:
        if len(rotation) != 3:
            raise fields.wrong("link_from_patch_rotation", rotation, "3 rows of 3 numbers")
        pose[:3, :3] = rotation
    if translation is not None:
        pose[:3, 3] = translation[0]
    return pose if any(given) else None


def _scaled(cell: object, shift: int) -> float:
    if isinstance(cell, bool) or not isinstance(cell, int | Decimal):
        raise TypeError(f"{cell!r} is no number")
    return float(Decimal(cell).scaleb(shift))


def _decimal(value: float, shift: int) -> str:
    """Shortest decimal of value times 10**shift that is read back as the same float."""
    text = format(Decimal(repr(float(value))).scaleb(shift), "f")
    text = text.rstrip("0") if "." in text else text
    return text + "0" if text.endswith(".") else text if "." in text else text + ".0"


def _quoted(text: str) -> str:
    escapes = {ord("\\"): "\\\\", ord('"'): '\\"'}
    escapes |= {c: f"\\u{c:04X}" for c in (*range(32), 127)}
    return '"' + text.encode("utf-8", "replace").decode().translate(escapes) + '"'


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
