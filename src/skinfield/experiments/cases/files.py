"""Cases in NPZ files: docs/cases.md says every key, with its shape and its unit."""

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.experiments.cases.case import Case, TrueContact, Truth
from skinfield.experiments.cases.stored import Stored
from skinfield.layout import Patch
from skinfield.mechanics import BondedLayer, Layer
from skinfield.sinks.pending import write_bytes

VERSION = 1
ENDING = ".npz"
LARGEST = 2**30  # bytes that a file may unpack to


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
    stored = Stored(path, _arrays(path))
    version = stored.integer("skinfield_case")
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


def load_cases(folder: str | Path) -> Iterator[tuple[Path, Case]]:
    """Read the cases of a folder one after another, by the order of their files' names.

    Raises
    ------
    FileError
        When there is no such folder, it holds no NPZ file, or one of them is no case.
    """
    for path in case_paths(folder):
        yield path, load_case(path)


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


def _patch_from(stored: Stored) -> Patch:
    positions = stored.floats("patch/positions_m", (None, None))
    count = len(positions)
    return Patch(
        positions,
        stored.number("patch/pad_diameter_m"),
        normals=stored.optional("patch/normals", (count, 3)),
        module=stored.optional_integers("patch/module", count),
        uid=stored.optional_integers("patch/uid", count),
        channel=stored.optional_integers("patch/channel", count),
        n_channels=stored.integer("patch/n_channels") if "patch/n_channels" in stored else 0,
        name=stored.text("patch/name", default="patch"),
        link=stored.text("patch/link", default=""),
        link_from_patch=stored.optional("patch/link_from_patch", (4, 4)),
    )


def _case_from(stored: Stored, patch: Patch, truth: Truth) -> Case:
    layer = Layer(
        stored.number("layer/thickness_m"),
        stored.number("layer/young_modulus_Pa"),
        stored.number("layer/poisson_ratio"),
        stored.number("layer/relative_permittivity", default=3.0),
    )
    return Case(
        name=stored.text("name", default=stored.path.stem),
        patch=patch,
        layer=layer,
        quantity=stored.text("quantity"),
        readings=stored.floats("readings", None),
        noise_std=stored.floats("noise_std", None),
        truth=truth,
        noisy=stored.flag("noisy"),
        mechanics=BondedLayer(
            inextensible_cover=stored.flag("layer/inextensible_cover", default=False)
        ),
    )


def _truth_from(stored: Stored) -> Truth:
    places = stored.floats("truth/contact_position_m", (None, 2))
    forces = stored.floats("truth/contact_force_N", (len(places),))
    areas = stored.optional("truth/contact_area_m2", (len(places),))
    areas = np.full(len(places), np.nan) if areas is None else areas
    kinds = stored.words("truth/contact_kind", len(places), default="body")
    contacts = tuple(
        TrueContact((float(x), float(y)), float(force), float(area), kind)
        for (x, y), force, area, kind in zip(places, forces, areas, kinds, strict=True)
    )
    plane = stored.optional("truth/plane_m", (None, 2))
    if plane is None:
        plane, cell, pressure = np.empty((0, 2)), 1e-3, np.empty(0)
    else:
        cell = stored.number("truth/cell_m")
        pressure = stored.floats("truth/pressure_Pa", (len(plane),))
    displacement = stored.optional("truth/displacement_m", (len(plane), 3))
    if displacement is None:
        displacement = np.full((len(plane), 3), np.nan)
    return Truth(
        cell=cell,
        plane=plane,
        pressure=pressure,
        displacement=displacement,
        contacts=contacts,
        source=stored.text("truth/source", default=""),
    )
