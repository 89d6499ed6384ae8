"""skinfield's own layout as arrays: the content of the TOML, in an NPZ file."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError
from skinfield.files.layouts.repair import Content, Draft
from skinfield.files.layouts.text import read_bytes
from skinfield.files.pending import write_npz
from skinfield.skin.patch import Skin

NAME = "skinfield-npz"
EXTENSIONS = (".npz",)
EXPECTED = "an NPZ archive with skinfield_layout = 1"
VERSION = 1
NUMBERS = {"module": np.int64, "uid": np.uint64, "channel": np.int64}


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return data.startswith(b"PK\x03\x04") and b"skinfield_layout" in data


def parse(path: Path) -> Content:
    """Contents of a file."""
    try:
        with np.load(io.BytesIO(read_bytes(path)), allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
        version = arrays["skinfield_layout"].item()
        if version == VERSION:
            drafts = tuple(_draft(arrays, f"patch{i}/") for i in range(arrays["patches"].item()))
            notes = tuple(map(str, arrays["notes"].tolist()))
            return Content(path, str(arrays["name"]), drafts, notes=notes)
    except FileError:
        raise
    except Exception as error:  # zip, zlib, headers and what misses each fail in ways of their own
        reason = str(error)[:200] or type(error).__name__
        raise FileError(f"{path}: no NPZ of a layout: {reason}, expected {EXPECTED}") from error
    raise FileError(
        f"{path}: skinfield_layout is {version!r:.40}, expected {VERSION}: this program reads that "
        "version only"
    )


def write(skin: Skin, path: Path) -> None:
    """Write a skin; nothing is lost."""
    arrays: dict[str, Any] = {
        "skinfield_layout": VERSION,
        "name": skin.name,
        "notes": np.array(skin.notes, dtype=np.str_),
        "patches": len(skin),
    }
    names = ("name", "link", "n_channels", "link_from_patch", "normals", "module", "uid", "channel")
    for index, patch in enumerate(skin):
        arrays |= {f"patch{index}/{name}": getattr(patch, name) for name in names}
        arrays[f"patch{index}/pad_diameter_m"] = patch.pad_diameter
        arrays[f"patch{index}/positions_m"] = patch.positions
    write_npz(path, arrays)


def _draft(arrays: dict[str, NDArray[Any]], start: str) -> Draft:
    def plain(name: str, kind: Any = np.float64) -> NDArray[Any]:
        return arrays[start + name].astype(kind, casting="same_kind")

    return Draft(
        plain("positions_m"),
        np.arange(len(arrays[start + "positions_m"])),
        plain("normals"),
        n_channels=int(plain("n_channels", np.int64)),
        pad_diameter=float(plain("pad_diameter_m")),
        name=str(arrays[start + "name"]),
        link=str(arrays[start + "link"]),
        link_from_patch=plain("link_from_patch"),
        stated=True,
        **{name: plain(name, kind) for name, kind in NUMBERS.items()},
    )
