"""Poses as CySkin files state them: 16 numbers, column by column, often of few digits."""

from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.layout.finding import Finding

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
