"""Height maps: grey pictures and tables of heights."""

import io
import warnings
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats, InputError, check_positive
from skinfield.files.shapes.content import read_shape
from skinfield.simulate import HeightMap

PICTURE, TABLES = ".png", (".npy", ".csv")
MOST_SAMPLES = 4_000_000
OPAQUE = 0.5


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
    path, content = read_shape(path, (PICTURE, *TABLES), "a height map")
    picture = path.suffix.lower() == PICTURE
    if picture and relief is None:
        raise InputError(
            f"relief is missing for {path.name}, expected the height in metres from white, which "
            "touches first, to black"
        )
    if not picture and (relief is not None or invert):
        raise InputError(
            f"relief or invert is given for {path.name}, expected neither: a table holds heights "
            "in millimetres"
        )
    if picture and relief is not None:
        check_positive("relief", relief, "height from white to black, in metres")
        heights = _picture(path, content, invert)[::-1] * relief
    else:
        heights = _table(path, content) * 1e-3
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
