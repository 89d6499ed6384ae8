"""skinfield's own layout as arrays: the content of the TOML, in an NPZ file."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError
from skinfield.files.layouts.repair import Content, Draft
from skinfield.files.layouts.text import read_bytes
from skinfield.files.pending import write_bytes
from skinfield.skin.patch import Skin

NAME = "skinfield-npz"
EXTENSIONS = (".npz",)
EXPECTED = "an NPZ archive with skinfield_layout = 1"
VERSION = 1
KINDS = {"f": "floats", "i": "integers", "u": "unsigned integers", "U": "text"}


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
    arrays = _Arrays(path)
    version = arrays.item("skinfield_layout", "iu")
    if version != VERSION:
        raise FileError(
            f"{path}: skinfield_layout is {version!r}, expected {VERSION}: this program reads "
            "that version only"
        )
    count = arrays.item("patches", "iu")
    if not 1 <= count <= 10_000:
        raise FileError(f"{path}: patches is {count}, expected 1 to 10000")
    drafts = tuple(_draft(arrays, f"patch{i}/") for i in range(count))
    notes = tuple(map(str, arrays.get("notes", (None,), "Uf").tolist()))
    return Content(path, str(arrays.item("name", "U")), drafts, notes=notes)


def write(skin: Skin, path: Path) -> tuple[str, ...]:
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
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_bytes(path, buffer.getvalue())
    return ()


class _Arrays:
    """Arrays of an archive, each checked as it is taken; raises FileError."""

    def __init__(self, path: Path) -> None:
        self.path = path
        data = read_bytes(path)
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as archive:
                self._arrays = {key: archive[key] for key in archive.files}
        except Exception as error:  # zip, zlib and the array headers each fail in ways of their own
            reason = str(error)[:200] or type(error).__name__
            raise FileError(f"{path}: no NPZ archive: {reason}, expected {EXPECTED}") from error

    def get(self, key: str, shape: tuple[int | None, ...], kinds: str) -> NDArray[Any]:
        """Array of such a shape, None for any length, and of such kinds of numbers."""
        if key not in self._arrays:
            raise FileError(f"{self.path}: no array {key!r}, expected it in {EXPECTED}")
        found: NDArray[Any] = self._arrays[key]
        wrong = len(shape) != found.ndim or any(
            wanted not in (None, size) for wanted, size in zip(shape, found.shape, strict=True)
        )
        if wrong or found.dtype.kind not in kinds:
            raise FileError(
                f"{self.path}: {key} has shape {found.shape} of {found.dtype}, expected {shape} of "
                f"{' or '.join(KINDS[kind] for kind in kinds)}"
            )
        return found

    def item(self, key: str, kinds: str) -> Any:
        """A single value."""
        return self.get(key, (), kinds).item()


def _draft(arrays: _Arrays, start: str) -> Draft:
    positions = arrays.get(start + "positions_m", (None, 3), "f")
    count = len(positions)
    pose = arrays.get(start + "link_from_patch", (4, 4), "f")
    channel = arrays.get(start + "channel", (count,), "iu").astype(np.int64)
    channels = arrays.item(start + "n_channels", "iu")
    if not np.isfinite(pose).all() or (channel < 0).any() or not 0 <= channels < 2**31:
        raise FileError(
            f"{arrays.path}: {start} has {channels} channels, the first {channel[:4]}, and the "
            f"pose {pose.tolist()}, expected columns from 0 and finite numbers"
        )
    return Draft(
        positions.astype(np.float64),
        np.arange(count),
        arrays.get(start + "normals", (count, 3), "f").astype(np.float64),
        module=arrays.get(start + "module", (count,), "iu").astype(np.int64),
        uid=arrays.get(start + "uid", (count,), "u").astype(np.uint64),
        channel=channel,
        n_channels=channels,
        pad_diameter=float(arrays.item(start + "pad_diameter_m", "fiu")),
        name=arrays.item(start + "name", "U"),
        link=arrays.item(start + "link", "U"),
        link_from_patch=pose.astype(np.float64),
        stated=True,
    )
