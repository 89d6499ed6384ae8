"""Files that hold the shape of an indenter: triangle meshes, pictures and tables of heights."""

import io
import logging
import warnings
from collections.abc import Iterable, Sequence
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
from skinfield.simulate.indenters.surfaces import HeightMap, Mesh, corners_of

MOST_BYTES = 256 * 2**20
MESHES, PICTURE, TABLES = (".stl", ".obj", ".ply"), ".png", (".npy", ".csv")
SMALLEST, LARGEST = 0.1e-3, 1.0
"""Metres: what an indenter can measure; beyond them the unit of the file is another one."""
MOST_SAMPLES = 4_000_000
OPAQUE = 0.5


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
    path, (vertices, faces) = Path(path), read_triangles(path)
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


def read_triangles(path: str | Path) -> tuple[Floats, Any]:
    """Corners (V, 3), in the file's unit, and faces (F, 3) of a mesh; raises as `load_mesh`."""
    path, content = _read(path, MESHES, "a triangle mesh")
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


def load_height_map(
    path: str | Path, pixel: float, relief: float | None = None, *, invert: bool = False
) -> HeightMap:
    """Read a height map as an indenter; give it a pose and a load with `dataclasses.replace`.

    In a picture, white stands out most and touches first, and black lies `relief` above it; where
    the picture is transparent there is no body. It is seen from outside the skin: its right is +x
    and its top is +y. Pictures of 8 and 16 bits are read, colours as their brightness.

    A table holds heights in millimetres above the lowest point, NaN where there is no body; its
    rows go up along y, as in `HeightMap`.

    Parameters
    ----------
    path : str or Path
        PNG; or NPY or CSV.
    pixel : float, m
        Distance between pixels or samples.
    relief : float, m
        Of a picture: height from white to black. A table has its own heights.
    invert : bool
        Of a picture: black touches first, as the ink of a rubber stamp.

    Returns
    -------
    HeightMap
        With a force of 1 N.

    Raises
    ------
    FileError
        If the file cannot be read as such, or holds more than 4 million samples.
    InputError
        If `pixel` or `relief` cannot be used, or `relief` is missing for a picture or given for a
        table.
    """
    check_positive("pixel", pixel, "distance between pixels, in metres")
    path, content = _read(path, (PICTURE, *TABLES), "a height map")
    picture = path.suffix.lower() == PICTURE
    if not picture:
        if relief is not None or invert:
            raise InputError(
                f"relief or invert is given for {path.name}, expected neither: a table holds "
                "heights in millimetres"
            )
        heights = _table(path, content) * 1e-3
    elif relief is None:
        raise InputError(
            f"relief is missing for {path.name}, expected the height in metres from white, which "
            "touches first, to black"
        )
    else:
        check_positive("relief", relief, "height from white to black, in metres")
        heights = _picture(path, content, invert)[::-1] * relief
    try:
        return HeightMap(heights=heights, pixel=pixel)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


def _picture(path: Path, content: bytes, invert: bool) -> Floats:
    """Depth below what stands out most, 0 to 1, rows downwards; NaN where transparent."""
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # Pillow warns of a picture that unpacks without end
            with Image.open(io.BytesIO(content), formats=["PNG"]) as image:
                _check_count(path, image.width * image.height)
                if image.mode.startswith("I"):
                    bright = np.asarray(image, dtype=np.float64) / 65535.0
                    solid = np.ones_like(bright)
                else:
                    both = np.asarray(image.convert("RGBA").convert("LA"), dtype=np.float64)
                    bright, solid = both[..., 0] / 255.0, both[..., 1] / 255.0
    except FileError:
        raise
    except Exception as error:  # a parser of others, fed with any bytes
        raise FileError(
            f"{path} cannot be read, expected a PNG picture of 8 or 16 bits: {error}"
        ) from error
    return np.where(solid >= OPAQUE, bright if invert else 1.0 - bright, np.nan)


def _table(path: Path, content: bytes) -> Floats:
    ending = path.suffix.lower()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # an empty CSV
            if ending == ".csv":
                found = np.loadtxt(io.BytesIO(content), delimiter=",", ndmin=2, dtype=np.float64)
            else:
                found = np.load(io.BytesIO(content), allow_pickle=False)
                found = found.astype(np.float64, casting="same_kind")
    except Exception as error:  # a parser of others, fed with any bytes
        raise FileError(
            f"{path} cannot be read, expected a table of heights in millimetres: {error}"
        ) from error
    _check_count(path, found.size)
    if found.ndim != 2:
        raise FileError(f"{path} has shape {found.shape}, expected rows and columns of heights")
    return found


def _check_count(path: Path, count: int) -> None:
    if not 0 < count <= MOST_SAMPLES:
        raise FileError(
            f"{path} holds {count} samples, expected 1 to {MOST_SAMPLES}: make it coarser, a "
            "tenth of the skin's thickness is fine enough"
        )


def _read(path: str | Path, endings: Iterable[str], what: str) -> tuple[Path, bytes]:
    """Path and content of a file with one of `endings`.

    Raises
    ------
    FileError
        If it has another ending, cannot be read, or is larger than any such shape.
    """
    path = Path(path)
    if path.suffix.lower() not in endings:
        raise FileError(f"{path} has another ending, expected {what} in {', '.join(endings)}")
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise FileError(
                f"{path} holds {size / 2**20:.0f} MB, expected at most {MOST_BYTES // 2**20}: "
                "make the shape coarser, a tenth of the skin's thickness is fine enough"
            )
        return path, path.read_bytes()
    except OSError as error:
        raise FileError(
            f"{path} cannot be read, expected {what}: {error.strerror or error}"
        ) from error
