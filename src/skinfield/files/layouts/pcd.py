"""Point clouds of the Point Cloud Library, `.pcd`: one point per taxel, normals if any."""

import io
import re
import warnings
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.files.layouts.repair import Content, Draft, finding_of_rows
from skinfield.files.layouts.text import integer, read_bytes, spoilt

NAME = "pcd"
EXTENSIONS = (".pcd",)
EXPECTED = "a PCL point cloud: VERSION, FIELDS x y z ..., DATA ascii, binary or binary_compressed"
POINT = ("x", "y", "z")
NORMAL = ("normal_x", "normal_y", "normal_z")
TYPES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
MOST = 10_000_000  # points
MOST_EACH = 1000  # of SIZE and COUNT
LONGEST = 100_000  # bytes of a header


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    head = data[:2048]
    return b"FIELDS " in head and (b"\nDATA " in head or head.lstrip(b"# .").startswith(b"PCD"))


def parse(path: Path) -> Content:
    """Contents of a file: one patch."""
    columns = _columns(path, read_bytes(path))
    positions = np.column_stack([columns[name] for name in POINT])
    normals = None
    if all(name in columns for name in NORMAL):
        normals = np.column_stack([columns[name] for name in NORMAL])
    good = np.asarray(np.isfinite(positions).all(axis=1))
    findings = finding_of_rows(
        "no-pose", "warning", ~good, path.stem, "point", "without a place (NaN); left out"
    )
    keep = np.flatnonzero(good)
    if not len(keep):
        raise FileError(f"{path}: no point has a place, expected one or more taxels")
    draft = Draft(
        positions[keep],
        keep,
        None if normals is None else np.nan_to_num(normals[keep], posinf=0.0, neginf=0.0),
        channel=keep,
        uid=keep.astype(np.uint64),
        n_channels=len(positions),
        name=path.stem,
    )
    return Content(path, path.stem, (draft,), tuple(findings))


class _Header:
    """Words of a header by their first one, up to DATA."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path
        found = re.search(rb"^DATA[^\n]*\n", data[:LONGEST], re.MULTILINE)
        if found is None:
            raise spoilt(path, None, "no DATA line", EXPECTED)
        self.end = found.end()
        lines = [line.split() for line in data[: self.end].decode("ascii", "replace").split("\n")]
        self.words = {words[0]: words[1:] for words in lines if words}

    def wrong(self, key: str, expected: str) -> FileError:
        return spoilt(self.path, None, " ".join([key, *self.words.get(key, [])]), expected)

    def numbers(self, key: str, count: int, highest: int = MOST) -> list[int]:
        words = self.words.get(key, [])
        expected = f"{key} and {count} numbers from 1 to {highest}"
        values = [integer(self.path, None, word, expected, 1) for word in words]
        if len(values) != count or max(values) > highest:
            raise self.wrong(key, expected)
        return values


def _columns(path: Path, data: bytes) -> dict[str, Floats]:
    """First element of every field, by its name, (N,)."""
    header = _Header(path, data)
    fields, kinds = header.words.get("FIELDS", []), header.words.get("TYPE", [])
    if not set(POINT) <= set(fields):
        raise header.wrong("FIELDS", "FIELDS x y z ...")
    sizes, counts = header.numbers("SIZE", len(fields), MOST_EACH), [1] * len(fields)
    if "COUNT" in header.words:
        counts = header.numbers("COUNT", len(fields), MOST_EACH)
    if len(kinds) != len(fields) or not all(
        size in TYPES.get(kind, ()) for kind, size in zip(kinds, sizes, strict=True)
    ):
        raise header.wrong("TYPE", "TYPE F, I or U, and a SIZE, of each field")
    if "POINTS" in header.words:
        (points,) = header.numbers("POINTS", 1)
    else:
        points = header.numbers("WIDTH", 1)[0] * header.numbers("HEIGHT", 1)[0]
    if points > MOST:
        raise header.wrong("HEIGHT", f"{MOST} points at most")
    packing, body = " ".join(header.words["DATA"]), data[header.end :]
    if packing == "ascii":
        table = _ascii(path, body, points, sum(counts))
        starts = np.cumsum([0, *counts[:-1]]).tolist()
        return {name: table[:, start] for name, start in zip(fields, starts, strict=True)}
    if packing not in ("binary", "binary_compressed"):
        raise header.wrong("DATA", "DATA ascii, binary or binary_compressed")
    types = [f"<{kind.lower()}{size}" for kind, size in zip(kinds, sizes, strict=True)]
    width = int(np.dot(sizes, counts))
    if packing == "binary_compressed":
        body = _unpacked(path, body, width * points)
    if len(body) < width * points:
        raise FileError(
            f"{path}: {len(body)} bytes behind the header, expected {width * points} for {points} "
            "points: the file is cut short"
        )
    starts = np.cumsum([0, *np.multiply(sizes, counts)[:-1]]).tolist()
    columns = {}
    for name, kind, start, size, count in zip(fields, types, starts, sizes, counts, strict=True):
        by_field = (points * start, (size * count,))  # compressed: one field after the other
        offset, strides = (start, (width,)) if packing == "binary" else by_field
        column: Floats = np.ndarray((points,), kind, body, offset, strides)
        with np.errstate(all="ignore"):
            columns[name] = column.astype(np.float64)
    return columns


def _unpacked(path: Path, body: bytes, size: int) -> bytes:
    """Unpack LZF behind its two sizes, (packed, unpacked) uint32, to exactly `size` bytes.

    A control byte below 32 is followed by that many + 1 literal bytes; any other holds the length
    (3 bits, a further byte when all are set, plus 2) and the distance (13 bits, plus 1) of a copy
    from what was unpacked before.
    """
    packed = int.from_bytes(body[:4], "little")
    data, out, at = body[8 : 8 + packed], bytearray(), 0
    try:
        while at < len(data) and len(out) <= size:
            control, at = data[at], at + 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length, at = length + data[at], at + 1
            first, at = len(out) - ((control & 31) << 8 | data[at]) - 1, at + 1
            if first < 0:
                raise IndexError
            for i in range(first, first + length + 2):  # byte by byte: a copy may overlap itself
                out.append(out[i])
    except IndexError:
        out.clear()
    if len(data) < packed or len(out) != size:
        raise FileError(
            f"{path}: {len(data)} of {packed} bytes of LZF unpack to {len(out)}, expected {size}: "
            "the file is cut short or broken; save the cloud again, also as DATA binary"
        )
    return bytes(out)


def _ascii(path: Path, body: bytes, points: int, width: int) -> Floats:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of nothing at all
            table = np.loadtxt(io.BytesIO(body), comments=None, ndmin=2)
    except ValueError as error:
        raise FileError(
            f"{path}: {str(error)[:200]} of the points, expected lines of {width} numbers"
        ) from error
    if table.shape != (points, width):
        raise FileError(
            f"{path}: points are {table.shape}, expected {points} of {width} numbers: it is cut "
            "short"
        )
    return np.asarray(table, np.float64)
