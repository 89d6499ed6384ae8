"""Positions of taxels from a picture of the array: equal dots on a plain ground, scan or drawing.

The ground is a plane of colour through the border of the picture, so that the light may fade. What
differs from it, by the threshold of Otsu (IEEE Trans. SMC 9(1), 62-66, 1979), are marks; taxels are
at their centroids.
"""

import io
from pathlib import Path

import numpy as np
from scipy import ndimage

from skinfield.errors import FileError, Floats, InputError, check_positive, needs
from skinfield.files.layouts.positions import Positions
from skinfield.files.layouts.text import read_bytes
from skinfield.plot import plural
from skinfield.signal.boards import Bools
from skinfield.skin.geometry import nearest_distance

HEADS = (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"BM", b"II*\0", b"MM\0*")
DRAWINGS = (b"%PDF", b"%!PS", b"<svg", b"PK\x03\x04")
LARGEST = 50_000_000  # pixels
CONTRAST = 24.0  # of 255, between marks and ground
SPECK, SMALL, LARGE = 0.1, 0.5, 1.7  # of the median area of the marks
LEAST = 6  # pixels of a mark
LINE = 0.3  # of its box, that a line or a frame fills at most
ROW = 0.5  # distances of neighbours, between two rows at least
TILT = 20.0  # degrees, of the rows of a picture at most


def is_picture(head: bytes) -> bool:
    """Whether a file that begins so is a picture, or a drawing that can become one."""
    return head.startswith(HEADS + DRAWINGS) or b"<svg" in head[:400]


def positions_in_picture(
    path: Path, pitch: float | None = None, width: float | None = None
) -> Positions:
    """Positions of the dots of a picture, by rows from top to bottom, each from left to right.

    Parameters
    ----------
    path : Path
        PNG, JPEG, BMP, GIF or TIFF.
    pitch : float, m, optional
        Distance of neighbours: the median of the distances to the nearest one.
    width : float, m, optional
        From the centre of the leftmost to that of the rightmost taxel; one of the two.

    Returns
    -------
    Positions
        About the middle of their box; x to the right, y upwards in the picture.

    Raises
    ------
    FileError
        If it is no picture, or no equal dots are found in it.
    InputError
        If its scale is not given, or twice; or Pillow is missing.
    """
    image = _pixels(path)
    centres, size, notes = _dots(path, image)
    metres = _scale(path, centres, pitch, width)
    centres = centres[_order(centres)]
    middle = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    places = np.zeros((len(centres), 3))
    places[:, :2] = (centres - middle) * [metres, -metres]
    notes = (
        f"{plural(len(centres), 'dot')} of {size * metres * 1e3:.3g} mm in {path.name}, by rows "
        "from top to bottom, each from left to right: check the numbers in the picture", *notes,
    )  # fmt: skip
    return Positions(places, None, (), "mm", False, notes)


def _pixels(path: Path) -> Floats:
    """Colours (H, W, 3) of a picture on white, as it is to be seen, 0 to 255."""
    data = read_bytes(path)
    if data.startswith(DRAWINGS) or b"<svg" in data[:400]:
        raise FileError(f"{path} is a drawing, expected a picture: export it as PNG")
    with needs("PIL", "skinfield[plot]", "pictures of arrays"):
        from PIL import Image, ImageOps
    try:
        with Image.open(io.BytesIO(data)) as opened:
            if opened.width * opened.height > LARGEST or min(opened.size) < 8:
                raise FileError(
                    f"{path} has {opened.width} x {opened.height} pixels, expected 8 x 8 or more, "
                    f"{LARGEST // 10**6} million at most"
                )
            seen = ImageOps.exif_transpose(opened).convert("RGBA")
            ground = Image.new("RGBA", seen.size, "white")
            return np.asarray(Image.alpha_composite(ground, seen).convert("RGB"), float)
    except FileError:
        raise
    except Exception as error:  # whatever a decoder of damaged bytes raises
        raise FileError(f"{path} is no picture that can be read ({error}), expected PNG") from error


def _dots(path: Path, image: Floats) -> tuple[Floats, float, tuple[str, ...]]:
    """Centres (L, 2) of equal dots, and their median diameter, in pixels; and what was left out."""
    labels, count = ndimage.label(ndimage.binary_fill_holes(_marks(path, image)), np.ones((3, 3)))
    areas = np.bincount(labels.ravel(), minlength=count + 1)[1:].astype(float)
    known = np.flatnonzero(areas >= LEAST)
    if not len(known):
        raise FileError(f"{path} holds no dot of {LEAST} pixels, expected one for each taxel")
    usual = float(np.median(areas[known]))
    specks = areas < max(SPECK * usual, LEAST)
    centres = np.array(ndimage.center_of_mass(labels > 0, labels, np.arange(1, count + 1)))[:, ::-1]
    odd = ~specks & ((areas < SMALL * usual) | (areas > LARGE * usual))
    if odd.any():
        x, y = centres[np.argmax(odd)]
        raise FileError(
            f"{path}: {odd.sum()} of {plural(int((~specks).sum()), 'mark')} differ in size from "
            f"the others ({usual:.0f} pixels), the first at pixel {x:.0f}, {y:.0f}; expected equal "
            "dots that do not touch, on a plain ground, without words"
        )
    left = int(specks.sum())
    notes = (f"left out, as too small for dots: {plural(left, 'speck')}",) if left else ()
    return centres[~specks], float(np.sqrt(4.0 * usual / np.pi)), notes


def _marks(path: Path, image: Floats) -> Bools:
    """Pixels (H, W) that are no ground, without lines and frames."""
    rows, columns = np.indices(image.shape[:2])
    edge = np.zeros(image.shape[:2], bool)
    edge[[0, -1]] = edge[:, [0, -1]] = True
    plane = np.column_stack([np.ones(rows.size), rows.ravel(), columns.ravel()])
    of_edge, colours = plane[edge.ravel()], image[edge]
    off = np.abs(colours - np.median(colours, axis=0)).max(axis=1)
    near = off <= np.median(off) + CONTRAST  # a mark may reach the border
    ground = plane @ np.linalg.lstsq(of_edge[near], colours[near], rcond=None)[0]
    differs = np.abs(image - ground.reshape(image.shape)).max(axis=2)
    level = _otsu(differs)
    if not differs[differs > level].size or differs[differs > level].mean() < CONTRAST:
        raise FileError(f"{path} is all of one colour, expected dots on a plain ground")
    marks: Bools = differs > level
    labels, count = ndimage.label(marks, np.ones((3, 3)))
    for number, box in enumerate(ndimage.find_objects(labels), 1):
        tall, wide = (each.stop - each.start for each in box)
        long = tall > 0.5 * image.shape[0] or wide > 0.5 * image.shape[1]
        if count > 1 and long and (labels[box] == number).mean() < LINE:
            marks[box][labels[box] == number] = False
    return marks


def _otsu(values: Floats) -> float:
    """Threshold that parts values in two classes, farthest apart beside their spread."""
    counts, edges = np.histogram(values, 256, (0.0, 256.0))
    middles = 0.5 * (edges[1:] + edges[:-1])
    below, sums = np.cumsum(counts), np.cumsum(counts * middles)
    above = below[-1] - below
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = below * above * (sums / below - (sums[-1] - sums) / above) ** 2
    return float(edges[1:][np.nanargmax(np.nan_to_num(apart))])


def _scale(path: Path, centres: Floats, pitch: float | None, width: float | None) -> float:
    """Metres per pixel."""
    if len(centres) == 1:
        return 1e-3
    if (pitch is None) == (width is None):
        raise InputError(
            f"the scale of {path} is {'unknown' if pitch is None else 'given twice'}, expected "
            "--pitch-mm, the distance of neighbours, or --width-mm, from the leftmost to the "
            "rightmost taxel"
        )
    if pitch is not None:
        check_positive("pitch", pitch, "distance of neighbours")
        return pitch / float(np.median(nearest_distance(np.column_stack([centres, 0 * centres]))))
    assert width is not None
    check_positive("width", width, "of the array")
    across = float(np.ptp(centres[:, 0]))
    if across < 1.0:
        raise InputError(f"dots of {path} stand above each other, expected --pitch-mm")
    return width / across


def _order(centres: Floats) -> list[int]:
    """Centres (L, 2) by rows, which may be tilted, and in these from left to right."""
    from scipy.spatial import KDTree

    if len(centres) == 1:
        return [0]
    near, which = map(np.asarray, KDTree(centres).query(centres, min(7, len(centres))))
    step = float(np.median(near[:, 1]))
    along = centres[which[:, 1:]] - centres[:, None]
    angles = np.degrees(np.arctan2(along[..., 1], along[..., 0]))
    angles = angles[(near[:, 1:] < 1.4 * step) & (np.abs(angles) < TILT)]
    tilt = np.radians(np.median(angles)) if len(angles) else 0.0
    x, y = (centres @ [[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]]).T
    down = np.argsort(y)
    row = np.empty(len(centres), int)
    row[down] = np.cumsum(np.r_[False, np.diff(y[down]) > ROW * step])
    return [int(each) for each in np.lexsort((x, row))]
