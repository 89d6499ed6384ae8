"""Faces between taxels, as CySkin files state them: checked, never used."""

import numpy as np

from skinfield.errors import Floats
from skinfield.layout.finding import Finding
from skinfield.layout.formats.text import listed
from skinfield.layout.normals import nearest_distance

BRIDGE = 4.0  # pitches: a longer side joins taxels that are no neighbours
LEFT_OUT = "; faces are left out: skinfield triangulates by itself"


def check_faces(name: str, faces: object, positions: Floats) -> list[Finding]:
    """Faces that name no taxel, a taxel twice, or taxels that are far apart."""
    if not faces:
        return []
    if not isinstance(faces, list):
        text = f"{name}: faces are {str(faces)[:40]!r}, expected a list of [i, j, k]"
        return [Finding("mixed-up-faces", "warning", text + LEFT_OUT)]
    good = [index for index, face in enumerate(faces) if _is_face(face, len(positions))]
    findings, bad = [], sorted(set(range(len(faces))) - set(good))
    if bad:
        text = (
            f"{name}: {len(bad)} of {len(faces)} faces (faces {listed(bad)}) do not name three "
            f"different taxels of {len(positions)}: they belong to another list of taxels"
        )
        findings.append(Finding("mixed-up-faces", "warning", text + LEFT_OUT))
    corners = positions[np.array([faces[index] for index in good], np.int64).reshape(-1, 3)]
    far = np.flatnonzero(longest_sides(corners) > reach(positions))
    if len(far):
        text = (
            f"{name}: {len(far)} of {len(faces)} faces (faces {listed(far.tolist())}) join taxels "
            f"more than {BRIDGE:g} pitches apart: they bridge gaps, or are mixed up"
        )
        findings.append(Finding("mixed-up-faces", "warning", text + LEFT_OUT))
    return findings


def _is_face(face: object, taxels: int) -> bool:
    if not isinstance(face, list) or len(face) != 3:
        return False
    return len(set(map(str, face))) == 3 and all(type(i) is int and 0 <= i < taxels for i in face)


def longest_sides(corners: Floats) -> Floats:
    """Longest side of each of (T, 3, 3) triangles, (T,) m."""
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1))


def reach(positions: Floats) -> float:
    """Distance, m, beyond which two of the taxels (N, 3) are no neighbours."""
    return BRIDGE * float(np.median(nearest_distance(positions)))
