"""skinfield's own layout as arrays: the content of the TOML, in an NPZ file."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError
from skinfield.files.layouts.repair import Content, Draft
from skinfield.files.layouts.text import read_bytes, write_bytes
from skinfield.skin.patch import Skin

NAME = "skinfield-npz"
EXTENSIONS = (".npz",)
EXPECTED = "an NPZ archive with skinfield_layout = 1"
VERSION = 1
LENGTHS = {"positions_m": 3, "normals": 3, "module": 0, "uid": 0, "channel": 0}


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return data.startswith(b"PK\x03\x04") and b"skinfield_layout" in data


def parse(path: Path) -> Content:
    """Contents of a file.

    Raises
    ------
    FileError
        When it is no archive, of another version, or an array is missing or of a wrong shape.
    """
    arrays = _arrays(path)
    version = _scalar(path, arrays, "skinfield_layout")
    if version != VERSION:
        raise FileError(
            f"{path}: skinfield_layout is {version!r}, expected {VERSION}: this program reads "
            "that version only"
        )
    count = _integer(path, arrays, "patches", 1, 10_000)
    drafts = tuple(_draft(path, arrays, f"patch{i}/") for i in range(count))
    notes = tuple(str(note) for note in np.atleast_1d(_array(path, arrays, "notes")))
    return Content(path, str(_scalar(path, arrays, "name")), drafts, notes=notes)


def write(skin: Skin, path: Path) -> tuple[str, ...]:
    """Write a skin; nothing is lost."""
    arrays: dict[str, Any] = {
        "skinfield_layout": VERSION,
        "name": skin.name,
        "notes": np.array(skin.notes, dtype=np.str_),
        "patches": len(skin),
    }
    for index, patch in enumerate(skin):
        arrays |= {
            f"patch{index}/name": patch.name,
            f"patch{index}/link": patch.link,
            f"patch{index}/pad_diameter_m": patch.pad_diameter,
            f"patch{index}/n_channels": patch.n_channels,
            f"patch{index}/link_from_patch": patch.link_from_patch,
            f"patch{index}/positions_m": patch.positions,
            f"patch{index}/normals": patch.normals,
            f"patch{index}/module": patch.module,
            f"patch{index}/uid": patch.uid,
            f"patch{index}/channel": patch.channel,
        }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_bytes(path, buffer.getvalue())
    return ()


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        with np.load(io.BytesIO(read_bytes(path)), allow_pickle=False) as archive:
            return {key: archive[key] for key in archive.files}
    except FileError:
        raise
    except Exception as error:  # zip, zlib and the array headers each fail in ways of their own
        reason = str(error)[:200] or type(error).__name__
        raise FileError(f"{path}: no NPZ archive: {reason}, expected {EXPECTED}") from error


def _array(path: Path, arrays: dict[str, NDArray[Any]], key: str) -> NDArray[Any]:
    if key not in arrays:
        raise FileError(f"{path}: no array {key!r}, expected it in {EXPECTED}")
    return arrays[key]


def _scalar(path: Path, arrays: dict[str, NDArray[Any]], key: str) -> Any:
    value = _array(path, arrays, key)
    if value.ndim != 0:
        raise FileError(f"{path}: {key} has shape {value.shape}, expected a single value")
    return value.item()


def _integer(
    path: Path, arrays: dict[str, NDArray[Any]], key: str, lowest: int, highest: int
) -> int:
    value = _scalar(path, arrays, key)
    if type(value) is not int or not lowest <= value <= highest:
        raise FileError(f"{path}: {key} is {value!r}, expected {lowest} to {highest}")
    return value


def _number(path: Path, arrays: dict[str, NDArray[Any]], key: str) -> float:
    value = _scalar(path, arrays, key)
    if not isinstance(value, int | float):
        raise FileError(f"{path}: {key} is {value!r}, expected a number")
    return float(value)


def _draft(path: Path, arrays: dict[str, NDArray[Any]], start: str) -> Draft:
    count = len(np.atleast_1d(_array(path, arrays, start + "positions_m")))
    columns = {}
    for key, width in LENGTHS.items():
        value = _array(path, arrays, start + key)
        wanted = (count, width) if width else (count,)
        kinds = "f" if width else "u" if key == "uid" else "iu"
        if value.shape != wanted or value.dtype.kind not in kinds:
            raise FileError(
                f"{path}: {start}{key} has shape {value.shape} of {value.dtype}, expected "
                f"{wanted} of {'floats' if width else 'integers'}: one row per taxel"
            )
        columns[key] = value
    pose = _array(path, arrays, start + "link_from_patch")
    if pose.shape != (4, 4) or pose.dtype.kind != "f" or not np.isfinite(pose).all():
        raise FileError(f"{path}: {start}link_from_patch is {pose}, expected 4 x 4 finite floats")
    if (columns["channel"].astype(np.int64) < 0).any():
        raise FileError(f"{path}: {start}channel holds negative numbers, expected columns from 0")
    return Draft(
        columns["positions_m"].astype(np.float64),
        np.arange(count),
        columns["normals"].astype(np.float64),
        module=columns["module"].astype(np.int64),
        uid=columns["uid"].astype(np.uint64),
        channel=columns["channel"].astype(np.int64),
        n_channels=_integer(path, arrays, start + "n_channels", 0, 2**31),
        pad_diameter=_number(path, arrays, start + "pad_diameter_m"),
        name=str(_scalar(path, arrays, start + "name")),
        link=str(_scalar(path, arrays, start + "link")),
        link_from_patch=pose.astype(np.float64),
        stated=True,
    )
