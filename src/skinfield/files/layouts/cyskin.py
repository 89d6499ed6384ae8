"""CySkin calibration files of robotskinlib: JSON, version 2."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError, Ints
from skinfield.files.layouts.repair import Content, Draft, Finding, finding_of_rows
from skinfield.files.layouts.text import read_bytes
from skinfield.files.pending import write_bytes
from skinfield.skin.geometry import nearest_distance
from skinfield.skin.patch import Patch, Skin

ROUNDED = 1e-2  # of a rotation's columns: further off, it is no rotation that was rounded


def pose_from_tf(path: Path, where: str, values: list[float]) -> tuple[Floats, list[Finding]]:
    """Homogeneous pose from 16 column-major numbers, with what had to be repaired.

    Raises
    ------
    FileError
        When they are no rigid motion.
    """
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


BRIDGE = 4.0  # pitches: a longer side joins taxels that are no neighbours
NAME = "cyskin"
EXTENSIONS = (".json",)
EXPECTED = "CySkin JSON (file_version 2) with 'skin' or 'tactile_maps'"

SENSORS = 15  # of a module, besides its temperature: four bits of the uid
HUGE = 1e12  # of a coordinate


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return data.lstrip()[:1] == b"{" and (b'"skin"' in data or b'"tactile_maps"' in data)


def parse(path: Path) -> Content:
    """Contents of a file: its skins in 3D or, without one, its maps.

    Raises
    ------
    FileError
        When it is not JSON, or a taxel has no id or place.
    """
    try:
        tree = json.loads(read_bytes(path).decode("utf-8", "replace"))
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path}: no JSON: {str(error)[:200]}, expected {EXPECTED}") from error
    tree = _object(path, "the file", tree)
    info = _object(path, "info", tree.get("info", {}))
    findings = []
    version = str(info.get("file_version", "2"))
    if version != "2":
        text = f"file_version is {version}: read as version 2"
        findings.append(Finding("file-version", "warning", text))
    kind = "skin" if tree.get("skin") else "tactile_maps"
    bodies = _bodies(path, kind, tree.get(kind))
    if kind == "skin" and tree.get("tactile_maps"):
        text = "the flat tactile_maps are left out: skinfield lays curved skin flat by itself"
        findings.append(Finding("maps-left-out", "info", text))
    name = str(info.get("name") or path.stem)
    drafts = []
    for index, body in enumerate(bodies):
        own = str(body.get("name") or "") if len(bodies) > 1 or kind != "skin" else ""
        draft, found = _draft(path, f"{kind}[{index}]", body, own or name)
        drafts.append(draft)
        findings += found
    return Content(path, name, tuple(_distinct_names(drafts)), tuple(findings))


def write(skin: Skin, path: Path) -> tuple[str, ...]:
    """Write the one patch of a skin; return what the format cannot hold, in sentences.

    Raises
    ------
    InputError
        When the skin has several patches.
    """
    if len(skin) != 1:
        raise InputError(
            f"skin has {len(skin)} patches, expected 1: a CySkin file holds one rigid body; "
            "write each patch to a file of its own"
        )
    patch = skin[0]
    lost = ["a CySkin file holds no pad diameters and no channels"]
    uids = patch.uid
    if (uids & np.uint64(15) == 0).any():
        uids = _new_uids(patch)
        lost.append(
            "uids are replaced by module << 4 | sensor: some end in hexadecimal 0, which is the "
            "temperature of a module"
        )
    if not np.array_equal(np.unique(patch.module, return_inverse=True)[1], _modules(uids)):
        lost.append("modules are read from the uids (uid >> 4), and the patch has others")
    body = _body(patch, uids)
    if not body["faces"]:
        lost.append("the patch could not be triangulated: the file has no faces")
    info = {"file_version": "2", "type": "rigid_body", "name": patch.name}
    info |= {"application": "", "description": ""}
    write_bytes(path, json.dumps({"info": info, "skin": body}, indent=1).encode())
    return tuple(lost)


def _body(patch: Patch, uids: NDArray[np.uint64]) -> dict[str, Any]:
    columns = zip(uids.tolist(), patch.positions.tolist(), patch.normals.tolist(), strict=True)
    pose, faces = patch.link_from_patch.T.reshape(-1).tolist(), _faces(patch).tolist()
    return {
        "n_taxels": len(patch),
        "n_faces": len(faces),
        "parent_frames": [
            {"key": 0, "id": 0, "type": "", "name": patch.link, "tf_matrix": pose},
        ],
        "taxels": [{"id": i, "x": x, "n": n, "type": "pressure", "cut": 0} for i, x, n in columns],
        "faces": faces,
    }


def _new_uids(patch: Patch) -> NDArray[np.uint64]:
    """Uids of sensors 1 to 15 of the patch's modules, or of new ones where these have more."""
    row = np.unique(patch.module, return_inverse=True)[1]
    if np.bincount(row).max() > SENSORS:
        row = np.arange(len(patch)) // SENSORS
    order = np.argsort(row, kind="stable")
    sensor = np.empty(len(patch), np.int64)
    sensor[order] = np.arange(len(patch)) - np.searchsorted(row[order], row[order])
    return (row << 4 | sensor + 1).astype(np.uint64)


def _faces(patch: Patch) -> Ints:
    """Triangles between neighbours, wound so that their normals point as the taxels' do."""
    try:
        faces: Ints = patch.triangles
    except InputError:  # a curved patch that cannot be laid flat
        return np.empty((0, 3), np.int64)
    corners = patch.positions[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    faces = faces[longest <= BRIDGE * np.median(nearest_distance(patch.positions))]
    sides = patch.positions[faces[:, 1:]] - patch.positions[faces[:, :1]]
    normal = np.cross(sides[:, 0], sides[:, 1])
    wrong = np.einsum("ti,ti->t", normal, patch.normals[faces].sum(axis=1)) < 0
    faces[wrong] = faces[wrong][:, ::-1]
    return faces


def _modules(uid: NDArray[np.uint64]) -> Ints:
    return np.asarray(np.unique(uid >> np.uint64(4), return_inverse=True)[1], np.int64)


def _object(path: Path, where: str, value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise FileError(f"{path}: {where} is {str(value)[:40]!r}, expected a JSON object")
    return value


def _bodies(path: Path, kind: str, value: object) -> list[dict[str, Any]]:
    items = value if isinstance(value, list) else [value]
    if not items or not value:
        raise FileError(f"{path}: neither 'skin' nor 'tactile_maps' holds taxels, expected one")
    return [_object(path, f"{kind}[{i}]", item) for i, item in enumerate(items)]


def _list(path: Path, where: str, value: object) -> list[Any]:
    if not isinstance(value, list):
        raise FileError(f"{path}: {where} is {str(value)[:40]!r}, expected a list")
    return value


def _vector(path: Path, where: str, value: object, lengths: tuple[int, ...]) -> list[float]:
    """Numbers of a taxel's place or normal."""
    numbers = value if isinstance(value, list) else []
    if len(numbers) in lengths and all(_is_number(v) for v in numbers):
        return [float(v) for v in numbers]
    raise FileError(
        f"{path}: {where} is {str(value)[:40]!r}, expected "
        f"{' or '.join(map(str, lengths))} finite numbers"
    )


def _is_number(value: object) -> bool:
    return type(value) in (int, float) and abs(value) < HUGE  # type: ignore[arg-type]  # no NaN


def _draft(path: Path, where: str, body: dict[str, Any], name: str) -> tuple[Draft, list[Finding]]:
    uid, positions, normals, cut = _columns(path, where, body)
    pose, link, found_pose = _pose(path, where, body)
    findings = _counts(name, body, len(uid)) + found_pose
    rows, dropped = _pressure_rows(path, name, uid, cut)
    numbered = not uid[rows].any()
    draft = Draft(
        positions[rows],
        rows,
        None if normals is None else normals[rows],
        module=None if numbered else _modules(uid[rows]),
        uid=None if numbered else uid[rows],
        name=name,
        link=link,
        link_from_patch=pose,
    )
    return draft, findings + dropped


def _columns(
    path: Path, where: str, body: dict[str, Any]
) -> tuple[NDArray[np.uint64], Floats, Floats | None, NDArray[np.bool_]]:
    """Uids, positions, normals (None if there is no single one) and cuts of the taxels."""
    taxels = _list(path, f"{where}.taxels", body.get("taxels"))
    uid, x, n, cut = [], [], [], []
    for row, item in enumerate(taxels):
        spot = f"{where}.taxels[{row}]"
        taxel = _object(path, spot, item)
        number = taxel.get("id")
        if type(number) is not int or not 0 <= number < 2**64:
            raise FileError(f"{path}: {spot}.id is {str(number)[:40]!r}, expected a uid")
        uid.append(number)
        x.append([*_vector(path, f"{spot}.x", taxel.get("x"), (2, 3)), 0.0][:3])
        n.append(_vector(path, f"{spot}.n", taxel["n"], (3,)) if "n" in taxel else [0.0] * 3)
        cut.append(bool(taxel.get("cut")) or taxel.get("type", "pressure") != "pressure")
    if not taxels:
        raise FileError(f"{path}: {where}.taxels is empty, expected one or more")
    normals = np.array(n)
    return np.array(uid, np.uint64), np.array(x), normals if normals.any() else None, np.array(cut)


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


def _counts(name: str, body: dict[str, Any], taxels: int) -> list[Finding]:
    stated = body.get("n_taxels", taxels)
    if stated == taxels:
        return []
    text = f"{name}: n_taxels is {str(stated)[:20]}, but {taxels} taxels follow; all are read"
    return [Finding("count-mismatch", "warning", text)]


def _pose(path: Path, where: str, body: dict[str, Any]) -> tuple[Floats | None, str, list[Finding]]:
    frames = body.get("parent_frames") or []
    if not isinstance(frames, list) or not frames:
        return None, "", []
    frame = _object(path, f"{where}.parent_frames[0]", frames[0])
    spot = f"{where}.parent_frames[0].tf_matrix"
    pose, findings = pose_from_tf(path, spot, _vector(path, spot, frame.get("tf_matrix"), (16,)))
    if len(frames) > 1:
        text = f"{len(frames)} parent frames: the first is taken, the others are left out"
        findings.append(Finding("parent-frames", "warning", text))
    return pose, str(frame.get("name") or ""), findings


def _distinct_names(drafts: list[Draft]) -> list[Draft]:
    names = [draft.name for draft in drafts]
    return [
        replace(draft, name=f"{draft.name}_{i}") if names.count(draft.name) > 1 else draft
        for i, draft in enumerate(drafts)
    ]
