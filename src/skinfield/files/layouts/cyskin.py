"""CySkin calibration files of robotskinlib: JSON, version 2."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.layouts.repair import Content, Draft, Finding, finding_of_rows
from skinfield.files.layouts.text import read_bytes

ROUNDED = 1e-2  # of a rotation's columns: further off, it is no rotation that was rounded


NAME = "cyskin"
EXTENSIONS = (".json",)
EXPECTED = "CySkin JSON (file_version 2) with 'skin' or 'tactile_maps'"
HUGE = 1e12  # of a coordinate


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return data.lstrip()[:1] == b"{" and (b'"skin"' in data or b'"tactile_maps"' in data)


Numbers = list[Annotated[float, msgspec.Meta(ge=-HUGE, le=HUGE)]]
Place = Annotated[Numbers, msgspec.Meta(min_length=2, max_length=3)]


class _Taxel(msgspec.Struct):
    id: int
    x: Place
    n: Annotated[Numbers, msgspec.Meta(min_length=3, max_length=3)] = msgspec.field(
        default_factory=lambda: [0.0] * 3
    )
    cut: Any = 0
    type: Any = "pressure"


class _Frame(msgspec.Struct):
    tf_matrix: Annotated[Numbers, msgspec.Meta(min_length=16, max_length=16)]
    name: Any = ""


class _Body(msgspec.Struct):
    taxels: Annotated[list[_Taxel], msgspec.Meta(min_length=1)]
    name: Any = ""
    n_taxels: Any = None
    parent_frames: list[_Frame] | None = None


class _File(msgspec.Struct):
    info: dict[str, Any] = {}
    skin: _Body | list[_Body] | None = None
    tactile_maps: _Body | list[_Body] | None = None


def parse(path: Path) -> Content:
    """Contents of a file: its skins in 3D or, without one, its maps."""
    try:
        tree = msgspec.json.decode(read_bytes(path), type=_File)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        why = str(error)[:200].replace("$.", "")
        raise FileError(f"{path}: {why}, expected {EXPECTED}") from error
    findings = []
    version = str(tree.info.get("file_version", "2"))
    if version != "2":
        text = f"file_version is {version}: read as version 2"
        findings.append(Finding("file-version", "warning", text))
    found = tree.skin or tree.tactile_maps
    if not found:
        raise FileError(f"{path}: neither 'skin' nor 'tactile_maps' holds taxels, expected one")
    bodies = found if isinstance(found, list) else [found]
    if tree.skin and tree.tactile_maps:
        text = "the flat tactile_maps are left out: skinfield lays curved skin flat by itself"
        findings.append(Finding("maps-left-out", "info", text))
    name = str(tree.info.get("name") or path.stem)
    drafts = []
    for body in bodies:
        own = str(body.name or "") if len(bodies) > 1 or not tree.skin else ""
        draft, its = _draft(path, body, own or name)
        drafts.append(draft)
        findings += its
    return Content(path, name, tuple(_distinct_names(drafts)), tuple(findings))


def _draft(path: Path, body: _Body, name: str) -> tuple[Draft, list[Finding]]:
    taxels = body.taxels
    wrong = next((row for row, taxel in enumerate(taxels) if not 0 <= taxel.id < 2**64), None)
    if wrong is not None:
        shown = str(taxels[wrong].id)[:40]
        raise FileError(f"{path}: {name}: id of taxel {wrong} is {shown}, expected a uid")
    uid = np.array([taxel.id for taxel in taxels], np.uint64)
    positions = np.array([[*taxel.x, 0.0][:3] for taxel in taxels])
    normals = np.array([taxel.n for taxel in taxels])
    cut = np.array([bool(taxel.cut) or taxel.type != "pressure" for taxel in taxels])
    frames, pose = body.parent_frames or [], None
    findings: list[Finding] = []
    if frames:
        pose, findings = _pose(path, name, frames[0])
    if len(frames) > 1:
        text = f"{len(frames)} parent frames: the first is taken, the others are left out"
        findings.append(Finding("parent-frames", "warning", text))
    rows, dropped = _pressure_rows(path, name, uid, cut)
    numbered = not uid[rows].any()
    if body.n_taxels not in (None, len(taxels)):
        text = f"{name}: n_taxels is {str(body.n_taxels)[:20]}, but {len(taxels)} taxels follow; "
        findings.insert(0, Finding("count-mismatch", "warning", text + "all are read"))
    draft = Draft(
        positions[rows],
        rows,
        normals[rows] if normals.any() else None,
        module=None if numbered else np.unique(uid[rows] >> np.uint64(4), return_inverse=True)[1],
        uid=None if numbered else uid[rows],
        name=name,
        link=str(frames[0].name or "") if frames else "",
        link_from_patch=pose,
    )
    return draft, findings + dropped


def _pressure_rows(
    path: Path, name: str, uid: NDArray[np.uint64], cut: NDArray[np.bool_]
) -> tuple[Ints, list[Finding]]:
    """Rows that are taxels, and what the others are."""
    nameless, thermal = np.zeros((2, len(uid)), np.bool_)
    if uid.any():
        nameless = (uid == 0) & ~cut
        thermal = (uid & np.uint64(15) == 0) & (uid != 0) & ~cut
        findings = []
    else:
        text = f"{name}: all uids are 0; the taxels are numbered by their rows"
        findings = [Finding("zero-uids", "error", text, tuple(range(len(uid))))]
    findings += finding_of_rows(
        "zero-uids", "error", nameless, name, "taxel",
        "with uid 0, so that no column of a recording is theirs; left out",
    )  # fmt: skip
    findings += finding_of_rows(
        "thermal", "info", thermal, name, "taxel",
        "that are sensor 0 of their module, a temperature; left out",
    )  # fmt: skip
    findings += finding_of_rows(
        "cut", "info", cut, name, "taxel", "cut off, or of another type than pressure; left out"
    )
    keep = ~(nameless | thermal | cut)
    if not keep.any():
        raise FileError(f"{path}: {name}: no taxel is left, expected one that is a pressure sensor")
    return np.flatnonzero(keep), findings


def _distinct_names(drafts: list[Draft]) -> list[Draft]:
    names = [draft.name for draft in drafts]
    return [
        replace(draft, name=f"{draft.name}_{i}") if names.count(draft.name) > 1 else draft
        for i, draft in enumerate(drafts)
    ]


def _pose(path: Path, name: str, frame: _Frame) -> tuple[Floats, list[Finding]]:
    """Homogeneous pose from 16 column-major numbers, with what had to be repaired.

    Raises
    ------
    FileError
        When they are no rigid motion.
    """
    where, values = f"tf_matrix of {name}", frame.tf_matrix
    pose, findings = np.array(values).reshape(4, 4).T, []
    if np.abs(pose[3, :3]).max() > 1e-9 and np.abs(pose[:3, 3]).max() <= 1e-9:
        text = f"{where} is stored row by row, expected column by column; it is transposed"
        findings.append(Finding("transposed-pose", "error", text))
        pose = pose.T.copy()
    rotation = pose[:3, :3]
    skew = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    rigid = skew <= ROUNDED and np.linalg.det(rotation) > 0
    if not rigid or np.abs(pose[3] - [0, 0, 0, 1]).max() > 1e-9:
        raise FileError(
            f"{path}: {where} is {values}, expected a rigid motion, column by column: "
            "a rotation of orthonormal columns, then the translation"
        )
    if skew > 1e-9:
        left, _, right = np.linalg.svd(rotation)
        pose = pose.copy()
        pose[:3, :3] = left @ right
        text = (
            f"{where} has columns that are {skew:.1e} off orthonormal (few digits), which would "
            "stretch the skin; the nearest rotation is taken"
        )
        findings.append(Finding("skewed-pose", "warning", text))
    return pose, findings
