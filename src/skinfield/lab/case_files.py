"""NPZ files of cases: docs/how-to/judge-a-solver.md has every key, with its shape and its unit."""

from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.elastic import BondedLayer, Layer
from skinfield.errors import FileError, InputError, check_shape
from skinfield.files.pending import write_npz
from skinfield.lab.cases import Case, TrueContact, Truth
from skinfield.skin import Patch

VERSION = 1
ENDING = ".npz"
NEEDED = object()
PAGE = "see docs/how-to/judge-a-solver.md"
PARTS = ("", "layer", "mechanics", "patch", "truth")
KINDS = {"numbers": "fiu", "whole numbers": "iu", "true or false": "b", "texts": "U"}  # dtypes
# Keys with the kind, the shape of taxels L, nodes K and contacts C (None: any), the default, and
# the attribute of a case.
FORMAT: dict[str, tuple[str, tuple[str | int, ...] | None, Any, str]] = {
    "skinfield_case": ("whole numbers", (), NEEDED, ""),
    "name": ("texts", (), None, "name"),
    "quantity": ("texts", (), NEEDED, "quantity"),
    "readings": ("numbers", None, NEEDED, "readings"),
    "noise_std": ("numbers", None, NEEDED, "noise_std"),
    "noisy": ("true or false", (), NEEDED, "noisy"),
    "layer/thickness_m": ("numbers", (), NEEDED, "layer.thickness"),
    "layer/young_modulus_Pa": ("numbers", (), NEEDED, "layer.young_modulus"),
    "layer/poisson_ratio": ("numbers", (), NEEDED, "layer.poisson_ratio"),
    "layer/relative_permittivity": ("numbers", (), 3.0, "layer.relative_permittivity"),
    "layer/inextensible_cover": ("true or false", (), False, "mechanics.inextensible_cover"),
    "patch/positions_m": ("numbers", ("L", "D"), NEEDED, "patch.positions"),
    "patch/pad_diameter_m": ("numbers", (), NEEDED, "patch.pad_diameter"),
    "patch/normals": ("numbers", ("L", 3), None, "patch.normals"),
    "patch/module": ("whole numbers", ("L",), None, "patch.module"),
    "patch/uid": ("whole numbers", ("L",), None, "patch.uid"),
    "patch/channel": ("whole numbers", ("L",), None, "patch.channel"),
    "patch/n_channels": ("whole numbers", (), 0, "patch.n_channels"),
    "patch/name": ("texts", (), "patch", "patch.name"),
    "patch/link": ("texts", (), "", "patch.link"),
    "patch/link_from_patch": ("numbers", (4, 4), None, "patch.link_from_patch"),
    "truth/plane_m": ("numbers", ("K", 2), None, "truth.plane"),
    "truth/cell_m": ("numbers", (), 1e-3, "truth.cell"),
    "truth/pressure_Pa": ("numbers", ("K",), None, "truth.pressure"),
    "truth/displacement_m": ("numbers", ("K", 3), None, "truth.displacement"),
    "truth/contact_position_m": ("numbers", ("C", 2), NEEDED, "truth.contact_position"),
    "truth/contact_force_N": ("numbers", ("C",), NEEDED, "truth.contact_force"),
    "truth/contact_area_m2": ("numbers", ("C",), None, "truth.contact_area"),
    "truth/contact_kind": ("texts", ("C",), None, "truth.contact_kind"),
    "truth/source": ("texts", (), "", "truth.source"),
}


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
    if len(case.history) or case.layer.relaxation is not None:
        raise FileError(
            f"{path}: case {case.name!r} has readings before, or a layer that creeps, which a file "
            "does not hold, expected readings of one instant on an elastic layer"
        )
    path = path / f"{case.name}{ENDING}" if path.is_dir() else path
    if path.suffix != ENDING:
        raise FileError(f"{path}: a case is an NPZ file, expected a name that ends in {ENDING}")
    write_npz(path, _plain(case))
    return path


def _plain(case: Case) -> dict[str, Any]:
    """Values of a case by key; those of the contacts are arrays with one row for each."""
    plain: dict[str, Any] = {"skinfield_case": VERSION}
    for key, (kind, shape, _, attribute) in FORMAT.items():
        name = attribute.partition("truth.contact_")[2]
        if name and shape:
            rows = [getattr(contact, name) for contact in case.truth.contacts]
            plain[key] = np.array(rows, str if kind == "texts" else float)
            plain[key] = plain[key].reshape(-1, *shape[1:])
        elif attribute:
            plain[key] = attrgetter(attribute)(case)
    return plain


def load_case(path: str | Path) -> Case:
    """Read a case.

    Raises
    ------
    FileError
        When it is no such file: the message names the key, what it holds and what was expected.
    """
    path = Path(path)
    found = _checked(path, _arrays(path))
    if found["skinfield_case"] != VERSION:
        raise FileError(f"{path}: skinfield_case is {found['skinfield_case']}, expected {VERSION}")
    try:
        return _case_from(found, path.stem)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


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
        with np.load(path, allow_pickle=False) as arrays:
            return {key: arrays[key] for key in arrays.files}
    except Exception as error:  # zip, zlib and the array headers each fail in ways of their own
        reason = str(error)[:200] or type(error).__name__
        raise FileError(f"{path}: no case: {reason}, expected an NPZ file of arrays") from error


def _checked(path: Path, arrays: dict[str, Any]) -> dict[str, Any]:
    """Values of all keys; every error names file, key, what is there and what was expected."""
    left = sorted(set(arrays) - set(FORMAT))
    if left:
        raise FileError(
            f"{path}: the key {left[0]!r} is not known ({len(left)} are not), expected "
            f"only those of the format: {PAGE}"
        )
    sizes: dict[str, int] = {}
    values = {}
    for key, (kind, shape, default, _) in FORMAT.items():
        if key not in arrays:
            if default is NEEDED or (key == "truth/pressure_Pa" and "K" in sizes):
                raise FileError(f"{path}: no array {key!r}, expected it: {PAGE}")
            values[key] = default
            continue
        found = arrays[key]
        if found.dtype.kind not in KINDS[kind]:
            raise FileError(f"{path}: {key} is of type {found.dtype}, expected {kind}: {PAGE}")
        if shape is not None:
            wanted = tuple(sizes.get(n) if isinstance(n, str) else n for n in shape)
            try:
                check_shape(key, found, wanted, PAGE)
            except ValueError as error:
                raise FileError(f"{path}: {error}") from error
            named = zip(shape, found.shape, strict=True)
            sizes |= {name: size for name, size in named if isinstance(name, str)}
        found = found.astype(np.float64) if kind == "numbers" else found
        values[key] = found.item() if shape == () else found
    return values


def _case_from(found: dict[str, Any], stem: str) -> Case:
    parts: dict[str, dict[str, Any]] = {name: {} for name in PARTS}
    for key, (*_, attribute) in FORMAT.items():
        part, _, name = attribute.rpartition(".")
        if attribute:
            parts[part][name] = found[key]
    whole, truth = parts[""], parts["truth"]
    whole["name"] = stem if whole["name"] is None else whole["name"]
    places = truth.pop("contact_position")
    columns = []
    for name, default in (("force", None), ("area", np.nan), ("kind", "body")):
        values = truth.pop(f"contact_{name}")
        columns.append([default] * len(places) if values is None else values.tolist())
    contacts = zip(map(tuple, places.tolist()), *columns, strict=True)
    nodes = 0 if truth["plane"] is None else len(truth["plane"])
    unknown = np.full((nodes, 3), np.nan)
    usual = {"plane": unknown[:, :2], "pressure": np.empty(0), "displacement": unknown}
    truth |= {name: value for name, value in usual.items() if truth[name] is None}
    return Case(
        patch=Patch(**parts["patch"]),
        layer=Layer(**parts["layer"]),
        mechanics=BondedLayer(**parts["mechanics"]),
        truth=Truth(contacts=tuple(TrueContact(*each) for each in contacts), **truth),
        **whole,
    )
