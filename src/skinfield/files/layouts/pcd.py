"""Point clouds of the Point Cloud Library, `.pcd`: one point per taxel, normals if any."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError
from skinfield.files.layouts.repair import Content, Draft, finding_of_rows
from skinfield.files.layouts.text import integer, read_bytes, spoilt

NAME = "pcd"
EXTENSIONS = (".pcd",)
EXPECTED = "a PCL point cloud: VERSION, FIELDS x y z ..., DATA ascii or binary"
PACKINGS = "DATA ascii or binary: pcl_convert_pcd_ascii_binary in.pcd out.pcd 1 makes one of it"
POINT = ("x", "y", "z")
NORMAL = ("normal_x", "normal_y", "normal_z")
TYPES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
MOST = 10_000_000  # points


@dataclass(frozen=True)
class _Header:
    fields: tuple[str, ...]
    types: tuple[str, ...]  # of numpy
    counts: tuple[int, ...]
    points: int
    data: str
    line: int  # where DATA stands, from 1
    start: int  # of the points, in bytes


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    head = data[:2048]
    return b"FIELDS " in head and (b"\nDATA " in head or head.lstrip(b"# .").startswith(b"PCD"))


def parse(path: Path) -> Content:
    """Contents of a file: one patch.

    Raises
    ------
    FileError
        When the header cannot be used or the points end early.
    """
    data = read_bytes(path)
    header = _header(path, data)
    columns = _columns(path, header, data[header.start :])
    positions = np.column_stack([columns[name] for name in POINT])
    normals = None
    if all(name in columns for name in NORMAL):
        normals = np.column_stack([columns[name] for name in NORMAL])
    good = np.isfinite(positions).all(axis=1)
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


def _header(path: Path, data: bytes) -> _Header:
    entries: dict[str, tuple[int, list[str]]] = {}
    start = line = 0
    while "DATA" not in entries:
        end = data.find(b"\n", start)
        if end < 0 or end - start > 10_000 or line > 100:
            raise spoilt(path, line + 1, "no DATA line", EXPECTED)
        line += 1
        words = data[start:end].decode("ascii", "replace").split()
        start = end + 1
        if words and not words[0].startswith("#"):
            entries[words[0]] = (line, words[1:])
    fields = entries.get("FIELDS", (1, []))[1]
    if not set(POINT) <= set(fields):
        raise spoilt(path, entries.get("FIELDS", (1, []))[0], " ".join(fields), "FIELDS x y z ...")
    sizes = _integers(path, entries, "SIZE", len(fields))
    counts = _integers(path, entries, "COUNT", len(fields), default=1)
    type_line, kinds = entries.get("TYPE", (1, []))
    if len(kinds) != len(fields) or not all(
        size in TYPES.get(kind, ()) for kind, size in zip(kinds, sizes, strict=False)
    ):
        raise spoilt(path, type_line, " ".join(kinds), "TYPE F, I or U, and a SIZE, of each field")
    types = tuple(f"<{kind.lower()}{size}" for kind, size in zip(kinds, sizes, strict=True))
    if "POINTS" in entries:
        points = _integers(path, entries, "POINTS", 1)[0]
    else:
        width, height = (_integers(path, entries, key, 1)[0] for key in ("WIDTH", "HEIGHT"))
        points = width * height
    if not 0 < points <= MOST:
        raise spoilt(path, line, f"{points} points", f"1 to {MOST}")
    form = " ".join(entries["DATA"][1])
    return _Header(tuple(fields), types, tuple(counts), points, form, line, start)


def _integers(
    path: Path,
    entries: dict[str, tuple[int, list[str]]],
    key: str,
    count: int,
    default: int | None = None,
) -> list[int]:
    line, words = entries.get(key, (1, []))
    if not words and default is not None:
        return [default] * count
    if len(words) != count:
        raise spoilt(path, line, " ".join([key, *words]), f"{key} and {count} numbers")
    values = [integer(path, line, word, f"{key} of at most 1000 each", 1) for word in words]
    if key != "POINTS" and key not in ("WIDTH", "HEIGHT") and max(values) > 1000:
        raise spoilt(path, line, " ".join(words), f"{key} of at most 1000 each")
    return values


def _columns(path: Path, header: _Header, body: bytes) -> dict[str, NDArray[np.float64]]:
    """First element of every field, by its name, (N,)."""
    if header.data == "ascii":
        return _ascii(path, header, body)
    kinds = [
        (f"f{i}", kind, (count,))
        for i, (kind, count) in enumerate(zip(header.types, header.counts, strict=True))
    ]
    if header.data != "binary":
        raise spoilt(path, header.line, f"DATA {header.data}", PACKINGS)
    dtype = np.dtype(kinds)
    size = dtype.itemsize * header.points
    if len(body) < size:
        raise FileError(
            f"{path}: {len(body)} bytes after line {header.line}, expected {size} for "
            f"{header.points} points: the file is cut short"
        )
    table = np.frombuffer(body[:size], dtype)
    with np.errstate(all="ignore"):
        return {n: table[f"f{i}"][:, 0].astype(float) for i, n in enumerate(header.fields)}


def _ascii(path: Path, header: _Header, body: bytes) -> dict[str, NDArray[np.float64]]:
    width = sum(header.counts)
    starts = np.cumsum([0, *header.counts[:-1]])
    rows: list[list[float]] = []
    for line, text in enumerate(body.decode("ascii", "replace").split("\n"), header.line + 1):
        words = text.split()
        if not words:
            continue
        if len(words) != width or len(rows) == header.points:
            raise spoilt(path, line, text, f"{header.points} points of {width} numbers")
        try:
            rows.append([float(word) for word in words])
        except ValueError:
            raise spoilt(path, line, text, f"{width} numbers") from None
    if len(rows) != header.points:
        raise FileError(f"{path}: {len(rows)} points, expected {header.points}: it is cut short")
    table = np.array(rows)
    return {n: table[:, i] for n, i in zip(header.fields, starts.tolist(), strict=True)}
