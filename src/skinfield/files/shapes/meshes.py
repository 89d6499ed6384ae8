"""Triangle meshes: STL, OBJ and PLY, read by trimesh."""

import io
import logging
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from skinfield.errors import (
    FileError,
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)
from skinfield.files.shapes.content import read_shape
from skinfield.simulate import Mesh
from skinfield.simulate.indenters.surfaces import corners_of

ENDINGS = (".stl", ".obj", ".ply")
SMALLEST, LARGEST = 0.1e-3, 1.0
"""Metres: what an indenter can measure; beyond them the unit of the file is another one."""


def load_mesh(
    path: str | Path, *, unit: float = 1e-3, down: Sequence[float] = (0.0, 0.0, -1.0)
) -> Mesh:
    """Read a triangle mesh as an indenter; give it a pose and a load with `dataclasses.replace`.

    The middle of its bounding box comes over the reference point, and its lowest point to z = 0.
    It need not be closed: the lowest triangle over each place counts.

    Parameters
    ----------
    path : str or Path
        STL (binary or text), OBJ or PLY. Needs trimesh, the extra `skinfield[mesh]`.
    unit : float, m
        Of the numbers in the file; STL says none. Default a millimetre.
    down : (3,) floats
        Direction in the file's axes that points into the skin.

    Returns
    -------
    Mesh
        With a force of 1 N.

    Raises
    ------
    FileError
        If the file cannot be read, holds no triangles or coordinates that are not finite, or is
        smaller than 0.1 mm or larger than 1 m in that unit.
    InputError
        If `unit` or `down` cannot be used, or trimesh is missing.
    """
    check_positive("unit", unit, "metres of one unit of the file, 1e-3 for millimetres")
    turn = _upright_from_file(down)
    path, content = read_shape(path, ENDINGS, "a triangle mesh")
    vertices, faces = _triangles(path, content)
    corners = corners_of(vertices, faces)
    if not np.isfinite(corners).all():
        bad = int(np.count_nonzero(~np.isfinite(corners).all(axis=1)))
        raise FileError(f"{path} has {bad} corners that are not finite, expected numbers")
    _check_size(path, corners, unit)
    vertices = np.nan_to_num(vertices) @ turn.T * unit
    corners = corners_of(vertices, faces)
    low, high = corners.min(axis=0), corners.max(axis=0)
    try:
        return Mesh(vertices=vertices - [*(low + high)[:2] / 2, low[2]], faces=faces)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


def _triangles(path: Path, content: bytes) -> tuple[Floats, Any]:
    try:
        import trimesh
    except ImportError as error:
        raise InputError(
            f"{path} is a triangle mesh and trimesh, which reads it, is missing: "
            "install the extra skinfield[mesh]"
        ) from error
    ending = path.suffix.lower()[1:]
    if ending == "stl" and content[:5].lower() != b"solid" and len(content) >= 84:
        count = int.from_bytes(content[80:84], "little")
        if len(content) < 84 + 50 * count:
            raise FileError(
                f"{path} is cut off: it says {count} triangles and has room for "
                f"{(len(content) - 84) // 50}, expected a whole binary STL"
            )
    log, unheard = logging.getLogger("trimesh"), logging.NullHandler()
    log.addHandler(unheard)  # nobody who listens to no log is told of normals, which do not matter
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # without its path, so that a file that names others opens none of them
            found = trimesh.load(io.BytesIO(content), file_type=ending, process=False)
            if isinstance(found, trimesh.Scene):
                found = found.to_mesh()
            shape: Any = found
            vertices = np.asarray(shape.vertices, dtype=np.float64)
            faces = np.asarray(shape.faces, dtype=np.int64)
    except Exception as error:  # a parser of others, fed with any bytes
        raise FileError(
            f"{path} cannot be read as {ending.upper()}, expected a triangle mesh: {error}"
        ) from error
    finally:
        log.removeHandler(unheard)
    if vertices.shape[1:] != (3,) or faces.shape[1:] != (3,) or not len(faces):
        raise FileError(f"{path} holds no triangles in space, expected a mesh: is it cut off?")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise FileError(
            f"{path} has triangles with corner {faces.max()} and only {len(vertices)} corners, "
            "expected corners that exist: is it cut off?"
        )
    return vertices, faces


def _check_size(path: Path, corners: Floats, unit: float) -> None:
    with np.errstate(over="ignore"):
        largest = float(np.ptp(corners, axis=0).max()) * unit
    if not SMALLEST <= largest <= LARGEST:
        better = "metres (unit 1)" if largest < SMALLEST else "millimetres (unit 1e-3)"
        raise FileError(
            f"{path} measures {largest:.3g} m with a unit of {unit:g} m, expected "
            f"{SMALLEST:g} to {LARGEST:g} m for an indenter: is it in {better}?"
        )


def _upright_from_file(down: Sequence[float]) -> Floats:
    """Rotation (3, 3) that turns `down` to -z by the shortest way."""
    vector = as_floats("down", down)
    check_shape("down", vector, (3,), "direction in the file's axes that points into the skin")
    check_finite("down", vector, "direction in the file's axes that points into the skin")
    length = float(np.linalg.norm(vector))
    check_positive("length of down", length, "a direction has one")
    if vector[2] > 0.999999 * length:
        return np.diag([1.0, -1.0, -1.0])
    rotation, _ = Rotation.align_vectors([[0.0, 0.0, -1.0]], [vector])
    return np.asarray(rotation.as_matrix())
