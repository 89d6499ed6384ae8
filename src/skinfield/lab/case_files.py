"""NPZ files of cases: docs/cases.md has every key, with its shape and its unit."""

import io
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import BondedLayer, Layer
from skinfield.errors import FileError, InputError, check_shape
from skinfield.files.pending import write_bytes
from skinfield.lab.cases import Case, TrueContact, Truth
from skinfield.skin import Patch

VERSION = 1
ENDING = ".npz"
Shape = tuple[int | None, ...]
REQUIRED = object()
KINDS = {"numbers": "fiu", "whole numbers": "iu", "true or false": "b", "texts": "U"}  # dtypes
LARGEST = 2**30  # bytes that a file may unpack to


@dataclass(frozen=True, eq=False)
class _Arrays:
    """Arrays of a file by key; every error names file, key, what is there and what was expected."""

    path: Path
    arrays: dict[str, NDArray[Any]]
    used: set[str] = field(default_factory=set)

    def check_all_used(self) -> None:
        """Raise FileError if there is a key that nobody asked for: it may be a mistyped one."""
        left = sorted(set(self.arrays) - self.used)
        if left:
            raise FileError(
                f"{self.path}: the key {left[0]!r} is not known ({len(left)} are not), expected "
                "only those of the format: see docs/cases.md"
            )

    def get(self, key: str, kind: str, shape: Shape | None = (), default: Any = REQUIRED) -> Any:
        """Array of a kind of `KINDS` and a shape (any where it is None), or the default."""
        if key not in self.arrays:
            if default is REQUIRED:
                raise FileError(f"{self.path}: no array {key!r}, expected it: see docs/cases.md")
            return default
        self.used.add(key)
        values = self.arrays[key]
        if values.dtype.kind not in KINDS[kind]:
            raise FileError(
                f"{self.path}: {key} is of type {values.dtype}, expected {kind}: see docs/cases.md"
            )
        if shape is not None:
            try:
                check_shape(key, values, shape, "see docs/cases.md")
            except ValueError as error:
                raise FileError(f"{self.path}: {error}") from error
        values = values.astype(np.float64) if kind == "numbers" else values
        return values.item() if shape == () else values


def save_case(case: Case, path: str | Path) -> Path:
    """Write a case as an NPZ file, whole or not at all; nothing is lost.

    Parameters
    ----------
    case : Case
    path : str or Path
        Ends in ".npz"; or a folder, in which the file gets the case's name.

    Raises
    ------
    FileError
        When it cannot be written.
    """
    path = Path(path)
    path = path / f"{case.name}{ENDING}" if path.is_dir() else path
    if path.suffix != ENDING:
        raise FileError(f"{path}: a case is an NPZ file, expected a name that ends in {ENDING}")
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {**_head(case), **_patch(case.patch), **_truth(case.truth)}
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    write_bytes(path, buffer.getvalue())
    return path


def _head(case: Case) -> dict[str, Any]:
    layer = case.layer
    return {
        "skinfield_case": VERSION,
        "name": case.name,
        "quantity": case.quantity,
        "readings": case.readings,
        "noise_std": case.noise_std,
        "noisy": case.noisy,
        "layer/thickness_m": layer.thickness,
        "layer/young_modulus_Pa": layer.young_modulus,
        "layer/poisson_ratio": layer.poisson_ratio,
        "layer/relative_permittivity": layer.relative_permittivity,
        "layer/inextensible_cover": case.mechanics.inextensible_cover,
    }


def _patch(patch: Patch) -> dict[str, Any]:
    return {
        "patch/positions_m": patch.positions,
        "patch/pad_diameter_m": patch.pad_diameter,
        "patch/normals": patch.normals,
        "patch/module": patch.module,
        "patch/uid": patch.uid,
        "patch/channel": patch.channel,
        "patch/n_channels": patch.n_channels,
        "patch/name": patch.name,
        "patch/link": patch.link,
        "patch/link_from_patch": patch.link_from_patch,
    }


def _truth(truth: Truth) -> dict[str, Any]:
    contacts = truth.contacts
    return {
        "truth/cell_m": truth.cell,
        "truth/plane_m": truth.plane,
        "truth/pressure_Pa": truth.pressure,
        "truth/displacement_m": truth.displacement,
        "truth/contact_position_m": np.array([c.position for c in contacts]).reshape(-1, 2),
        "truth/contact_force_N": np.array([c.force for c in contacts], dtype=np.float64),
        "truth/contact_area_m2": np.array([c.area for c in contacts], dtype=np.float64),
        "truth/contact_kind": np.array([c.kind for c in contacts], dtype=np.str_),
        "truth/source": truth.source,
    }


def load_case(path: str | Path) -> Case:
    """Read a case.

    Raises
    ------
    FileError
        When it is no such file: the message names the key, what it holds and what was expected.
    """
    path = Path(path)
    stored = _Arrays(path, _arrays(path))
    version = stored.get("skinfield_case", "whole numbers")
    if version != VERSION:
        raise FileError(f"{path}: skinfield_case is {version}, expected {VERSION}")
    try:
        patch = _patch_from(stored)
        case = _case_from(stored, patch, _truth_from(stored))
    except FileError:
        raise
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    stored.check_all_used()
    return case


def case_paths(folder: str | Path) -> list[Path]:
    """Files of cases in a folder, sorted by name; or the one file that is named.

    Raises
    ------
    FileError
        When there are none.
    """
    folder = Path(folder)
    if folder.is_file():
        return [folder]
    try:
        found = sorted(path for path in folder.iterdir() if path.suffix == ENDING)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"{folder}: {reason}, expected a folder of cases") from error
    if not found:
        raise FileError(f"{folder}: no file ends in {ENDING}, expected at least one case")
    return found


def _arrays(path: Path) -> dict[str, Any]:
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > LARGEST:
            raise FileError(f"{path}: unpacks to {size} bytes, expected at most {LARGEST}")
        with np.load(path, allow_pickle=False) as arrays:
            return {key: arrays[key] for key in arrays.files}
    except FileError:
        raise
    except Exception as error:  # zip, zlib and the array headers each fail in ways of their own
        reason = str(error)[:200] or type(error).__name__
        raise FileError(f"{path}: no case: {reason}, expected an NPZ file of arrays") from error


def _patch_from(stored: _Arrays) -> Patch:
    positions = stored.get("patch/positions_m", "numbers", (None, None))
    count = len(positions)
    whole = {
        name: stored.get(f"patch/{name}", "whole numbers", (count,), None)
        for name in ("module", "uid", "channel")
    }
    return Patch(
        positions,
        stored.get("patch/pad_diameter_m", "numbers"),
        normals=stored.get("patch/normals", "numbers", (count, 3), None),
        **whole,
        n_channels=stored.get("patch/n_channels", "whole numbers", default=0),
        name=stored.get("patch/name", "texts", default="patch"),
        link=stored.get("patch/link", "texts", default=""),
        link_from_patch=stored.get("patch/link_from_patch", "numbers", (4, 4), None),
    )


def _case_from(stored: _Arrays, patch: Patch, truth: Truth) -> Case:
    layer = Layer(
        stored.get("layer/thickness_m", "numbers"),
        stored.get("layer/young_modulus_Pa", "numbers"),
        stored.get("layer/poisson_ratio", "numbers"),
        stored.get("layer/relative_permittivity", "numbers", default=3.0),
    )
    cover = stored.get("layer/inextensible_cover", "true or false", default=False)
    return Case(
        name=stored.get("name", "texts", default=stored.path.stem),
        patch=patch,
        layer=layer,
        quantity=stored.get("quantity", "texts"),
        readings=stored.get("readings", "numbers", None),
        noise_std=stored.get("noise_std", "numbers", None),
        truth=truth,
        noisy=stored.get("noisy", "true or false"),
        mechanics=BondedLayer(inextensible_cover=cover),
    )


def _truth_from(stored: _Arrays) -> Truth:
    places = stored.get("truth/contact_position_m", "numbers", (None, 2))
    count = (len(places),)
    forces = stored.get("truth/contact_force_N", "numbers", count)
    areas = stored.get("truth/contact_area_m2", "numbers", count, np.full(count, np.nan))
    kinds = stored.get("truth/contact_kind", "texts", count, np.full(count, "body"))
    contacts = tuple(
        TrueContact((float(x), float(y)), float(force), float(area), str(kind))
        for (x, y), force, area, kind in zip(places, forces, areas, kinds, strict=True)
    )
    plane = stored.get("truth/plane_m", "numbers", (None, 2), None)
    if plane is None:
        plane, cell, pressure = np.empty((0, 2)), 1e-3, np.empty(0)
    else:
        cell = stored.get("truth/cell_m", "numbers")
        pressure = stored.get("truth/pressure_Pa", "numbers", (len(plane),))
    unknown = np.full((len(plane), 3), np.nan)
    return Truth(
        cell=cell,
        plane=plane,
        pressure=pressure,
        displacement=stored.get("truth/displacement_m", "numbers", unknown.shape, unknown),
        contacts=contacts,
        source=stored.get("truth/source", "texts", default=""),
    )
