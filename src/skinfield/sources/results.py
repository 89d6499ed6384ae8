"""Results that `sinks.save_results` and `skinfield reconstruct -o run.skinfield` wrote."""

import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats
from skinfield.pipeline.batch_format import (
    BLOCK,
    READINGS,
    SETTINGS,
    STAMPS,
    TYPES,
    content_from_text,
    widened,
)
from skinfield.pipeline.batch_recipe import Recipe
from skinfield.pipeline.batch_results import LazyResults
from skinfield.pipeline.batch_text import value_from_plain
from skinfield.pipeline.conditioner import Conditioner

LARGEST = 1 << 30  # bytes of settings: more is no settings file


def open_results(
    path: str | Path,
    *,
    precision: type[np.floating[Any]] = np.float32,
    cache_bytes: int = 256 << 20,
) -> LazyResults:
    """Open results: every field of every reading, computed when it is looked at.

    Parameters
    ----------
    path : str or Path
        The folder that was written, `run.skinfield`.
    precision : numpy.float32 or numpy.float64
        Of the fields.
    cache_bytes : int
        Of what was computed last, that stays in memory.

    Returns
    -------
    LazyResults
        Such as ``results.pressure[100:200]`` (100, K), ``results.contacts[5]``.

    Raises
    ------
    FileError
        If it is no such folder, damaged, cut short, or of another version. Readings are checked
        when they are first read.
    """
    folder = _absolute(path)
    content = content_from_text(_text(folder), str(folder / SETTINGS))
    try:
        recipe = Recipe.from_plain(content["recipe"])
        calibration = value_from_plain("calibration", content["calibration"])
        board = value_from_plain("board", content["board"])
        kind, rows, taxels = content["type"], content["readings"], content["taxels"]
        stamp_sums, sums = content["sums"][STAMPS], content["sums"][READINGS]
        notes, source = tuple(map(str, content["notes"])), str(content["source"])
    except (KeyError, TypeError, AttributeError) as error:
        raise FileError(
            f"{folder / SETTINGS} lacks or misplaces {error}, expected what skinfield writes"
        ) from error
    if kind not in TYPES or taxels != len(recipe.patch) or type(rows) is not int or rows < 1:
        raise FileError(
            f"{folder / SETTINGS} has {rows!r} readings of {taxels!r} taxels of type {kind!r}, "
            f"expected one or more of {len(recipe.patch)} of one of {', '.join(TYPES)}"
        )
    conditioner = None
    if calibration is not None:
        conditioner = Conditioner(recipe.quantity, recipe.layer, calibration, board)
    kept = StoredReadings(
        _column(folder / STAMPS, "<i8", (rows,), stamp_sums),
        _column(folder / READINGS, kind, (rows, taxels), sums),
        conditioner,
    )
    return LazyResults(
        recipe, kept, precision=precision, cache_bytes=cache_bytes, notes=notes, source=source
    )


@dataclass
class Column:
    """An array on the disk, of which some rows are read at a time; it can be pickled.

    The file is opened for each read, so nothing is left open and threads do not meet.
    """

    path: Path
    kind: np.dtype[Any]
    shape: tuple[int, ...]
    start: int
    sums: list[int]
    checked: set[int] = field(default_factory=set)

    def rows(self, first: int, last: int) -> NDArray[Any]:
        """Rows first to last; raises FileError if they are not as they were written."""
        begin, end = first // BLOCK, -(-last // BLOCK)
        if all(block in self.checked for block in range(begin, end)):
            return self._read(first, last)
        start = begin * BLOCK
        whole = self._read(start, min(end * BLOCK, self.shape[0]))
        for block in range(begin, end):
            part = whole[block * BLOCK - start : (block + 1) * BLOCK - start]
            if zlib.crc32(part.data) != self.sums[block]:
                raise FileError(
                    f"{self.path}: readings {block * BLOCK} to {block * BLOCK + len(part)} are "
                    "not as they were written (their sum differs), expected them unchanged"
                )
            self.checked.add(block)
        return whole[first - start : last - start]

    def _read(self, first: int, last: int) -> NDArray[Any]:
        width = int(np.prod(self.shape[1:], dtype=np.int64))
        try:
            with self.path.open("rb") as file:
                file.seek(self.start + first * width * self.kind.itemsize)
                found = np.fromfile(file, self.kind, (last - first) * width)
        except OSError as error:
            raise FileError(f"{self.path} cannot be read: {error.strerror or error}") from error
        if len(found) < (last - first) * width:
            raise FileError(f"{self.path} has been cut short, expected {self.shape[0]} readings")
        return found.reshape(last - first, *self.shape[1:])


@dataclass
class StoredReadings:
    """Readings in a file of results; see `KeptReadings`."""

    column_of_stamps: Column
    column: Column
    conditioner: Conditioner | None

    def __len__(self) -> int:
        return int(self.column.shape[0])

    def stamps(self, first: int, last: int) -> NDArray[np.int64]:
        """Of readings first to last, ns."""
        return np.asarray(self.column_of_stamps.rows(first, last), np.int64)

    def recorded(self, first: int, last: int) -> Floats:
        """Readings first to last as they were recorded, (last - first, L)."""
        return widened(self.column.rows(first, last))

    def values(self, first: int, last: int) -> Floats:
        """Readings first to last in the quantity's unit, (last - first, L)."""
        recorded = self.recorded(first, last)
        return recorded if self.conditioner is None else self.conditioner(recorded)


def _absolute(path: str | Path) -> Path:
    """The folder, wherever the program goes afterwards."""
    try:
        return Path(path).absolute()
    except (OSError, ValueError) as error:
        raise FileError(f"{str(path)!r} cannot be opened: {error}; expected results") from error


def _text(folder: Path) -> str:
    file = folder / SETTINGS
    try:
        if not file.is_file():
            raise FileError(
                f"{folder} holds no {SETTINGS}, expected results that were written with "
                "skinfield reconstruct -o run.skinfield"
            )
        if file.stat().st_size > LARGEST:
            raise FileError(f"{file} has {file.stat().st_size} bytes, expected settings")
        return file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{file} cannot be read: {error}; expected results") from error


def _column(path: Path, kind: str, shape: tuple[int, ...], sums: Any) -> Column:
    """An array's file, whose head and length are as the settings say."""
    try:
        with path.open("rb") as file:
            if np.lib.format.read_magic(file) != (1, 0):
                raise ValueError("another version of NPY")
            found, fortran, dtype = np.lib.format.read_array_header_1_0(file)
            start, size = file.tell(), path.stat().st_size
    except Exception as error:  # numpy parses the head as Python: it may raise anything
        raise FileError(
            f"{path} cannot be read ({type(error).__name__}: {str(error)[:120]}), expected the "
            f"NPY array of results"
        ) from error
    wanted = int(np.prod(shape, dtype=np.int64)) * np.dtype(kind).itemsize
    if (found, fortran, dtype.str, size - start) != (shape, False, kind, wanted):
        raise FileError(
            f"{path} holds {dtype} {found} in {size - start} bytes, expected {kind} {shape} in "
            f"{wanted}: cut short, or of other results"
        )
    blocks = -(-shape[0] // BLOCK)
    if not isinstance(sums, list | tuple) or len(sums) != blocks:
        raise FileError(f"{path.parent / SETTINGS} has no {blocks} sums of {path.name}")
    return Column(path, np.dtype(kind), shape, start, list(sums))
