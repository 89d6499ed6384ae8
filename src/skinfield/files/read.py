"""Reader of any file or folder of skinfield's, told by what is in it."""

import csv
import re
import zlib
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, check_type
from skinfield.estimate.contact_table import (
    COLUMNS,
    LISTED_KINDS,
    ContactTable,
    load_pyarrow,
)
from skinfield.files.layouts.load import FORMATS, fitting_formats, load_layout
from skinfield.files.layouts.own_toml import log_settings
from skinfield.files.mcap.container import MAGIC
from skinfield.files.recordings.open import open_recording
from skinfield.files.results import open_results
from skinfield.reconstruct.serialisation import ARRAYS
from skinfield.signal.calibration_file import FORMAT
from skinfield.skin.log import LogSettings

KINDS = dict(LISTED_KINDS)
PARQUET, ZIP = b"PAR1", b"PK\x03\x04"
MEMBER = "format.npy"  # of the NPZ file of a calibration
DAMAGED = (BadZipFile, EOFError, OSError, OverflowError, RuntimeError, ValueError, zlib.error)
LONG = 1 << 25  # bytes: no layout is longer
HEAD = 1 << 16  # bytes of a file, among which a table's names are
CALIBRATION = re.compile(rb"(?m)^[ \t]*[\"']?format[\"']?[ \t]*=[ \t]*[\"']" + FORMAT.encode())
EXPECTED = "a layout, a calibration, a recording, results or a table of contacts"


def read(path: str | Path, *, skin: str | Path | None = None) -> Any:
    """Read any recording, layout, calibration or result; its content says which it is.

    Parameters
    ----------
    path : str or Path
        Of a file, or of a folder: of results, of a yarpdatadumper log, or of layouts.
    skin : str or Path, optional
        The skin's file that ``skinfield new`` wrote: `path` is a log of it, with the columns and
        units that stand there (``[log]``; else as its format says). It may be a MATLAB, HDF5 or
        NumPy file, too, such as ``"trial.mat:experiment.C"``.

    Returns
    -------
    Skin, Recording, Calibration, TouchCalibration, PressureCalibration, ForceCalibration, \
xarray.Dataset, ContactTable or pyarrow.Table
        A layout is a `Skin`; a recording, of a live skin (MCAP) too, a `Recording`; a folder of
        results a dataset as `open_results` gives it; a table of contacts a `ContactTable` of CSV,
        one of pyarrow's of Parquet: ``to_pandas()`` makes a data frame of either.

    Raises
    ------
    FileError
        If there is nothing, if it is none of these, or if it is broken; the message says what was
        tried.
    InputError
        If `path` or `skin` is no path, or the log lacks a column.
    SkinfieldError
        If a package that reads it is not installed.

    Examples
    --------
    >>> import skinfield as sf
    >>> sf.save_layout(sf.layouts.hexagon72(), "hand.toml")
    >>> sf.read("hand.toml")
    Skin('hexagon72', 72 taxels on 1 patch)
    """
    check_type("path", path, (str, PathLike), f"of {EXPECTED}")
    if skin is not None:
        return open_recording(path, log=_log_of(skin))
    path = Path(path)
    try:
        known = path.exists()
    except (OSError, ValueError) as error:  # a name with a zero byte is a ValueError
        raise FileError(f"{path!s} cannot be opened: {error}; expected {EXPECTED}") from error
    if not known:
        raise FileError(f"{path}: no such file or folder, expected {EXPECTED}")
    return _read_folder(path) if path.is_dir() else _read_file(path)


def _log_of(skin: str | Path) -> LogSettings | None:
    """How logs of a skin are read, as its file has it; None where as their format says."""
    check_type("skin", skin, (str, PathLike), "of the skin's file that `skinfield new` wrote")
    load_layout(skin)
    return log_settings(Path(skin))


def _read_folder(path: Path) -> Any:
    if (path / ARRAYS).is_dir():
        return open_results(path)
    if (path / "data.log").is_file():
        return open_recording(path)
    refused = []
    for what, reader in (("layouts", load_layout), ("a recording", open_recording)):
        try:
            return reader(path)
        except FileError as error:
            refused.append(f"as {what}: {error}")
    raise FileError(
        f"{path} is none of the folders that are known, expected results ({ARRAYS} in it), layouts "
        f"or a yarpdatadumper log; {'; '.join(refused)}"
    )


def _read_file(path: Path) -> Any:
    data = _beginning(path)
    if data.startswith(MAGIC):  # it encloses layouts and calibrations
        return open_recording(path)
    if CALIBRATION.search(data[:HEAD]) or (data.startswith(ZIP) and _is_calibration(path)):
        from skinfield.calibrate import load_calibration

        return load_calibration(path)
    if data.startswith(PARQUET):
        return _read_parquet(path)
    if _is_contact_table(data):
        return _read_contact_csv(path)
    if fitting_formats(data):
        return load_layout(path)
    try:
        return open_recording(path)
    except FileError as error:
        layouts = ", ".join(form.NAME for form in FORMATS)
        raise FileError(
            f"{error}; tried as a layout ({layouts}), as a calibration ({FORMAT}), as a table of "
            "contacts (CSV, Parquet), and as a recording"
        ) from error


def _beginning(path: Path) -> bytes:
    """All of a file, or of a long one, which only a recording is, its first part."""
    try:
        with path.open("rb") as file:
            return file.read(LONG)
    except OSError as error:
        raise FileError(
            f"{path} cannot be read: {error.strerror or error}; expected {EXPECTED}"
        ) from error


def _is_calibration(path: Path) -> bool:
    """Whether an NPZ file says so; True too where that is damaged, which its reader explains."""
    try:
        archive = ZipFile(path)
    except DAMAGED:  # of what kind it was is not known: the last reader that is tried says why
        return False
    with archive:
        if MEMBER not in archive.namelist():
            return False
        try:
            with archive.open(MEMBER) as file:
                return FORMAT.encode("utf-32-le") in file.read(HEAD)
        except DAMAGED:
            return True


def _lines(data: bytes) -> Iterator[str]:
    yield from data[:HEAD].decode("utf-8", "replace").splitlines()


def _is_contact_table(data: bytes) -> bool:
    head = next((line for line in _lines(data) if not line.startswith("#")), "")
    return head.split(",")[: len(COLUMNS)] == list(COLUMNS)


def _read_parquet(path: Path) -> Any:
    arrow = load_pyarrow()
    try:
        table = arrow.parquet.read_table(path)
    except (OSError, ValueError, arrow.ArrowException) as error:
        raise FileError(
            f"{path} cannot be read: {error}; expected a whole table of contacts"
        ) from error
    missing = [name for name in COLUMNS if name not in table.column_names]
    if missing:
        raise FileError(
            f"{path} is a table without {', '.join(missing[:3])}, expected the columns of a table "
            f"of contacts: {', '.join(COLUMNS)}"
        )
    return table


def _read_contact_csv(path: Path) -> ContactTable:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            names, *rows = (
                row for row in csv.reader(line for line in file if line[:1] != "#") if row
            )
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"column {twice[0]!r} is there twice")
        for number, row in enumerate(rows, 1):
            if len(row) != len(names):
                raise ValueError(f"row {number} has {len(row)} values, expected {len(names)}")
        cells = zip(*rows, strict=True) if rows else ((),) * len(names)
        columns = {name: _column(name, each) for name, each in zip(names, cells, strict=True)}
    except (OSError, ValueError, OverflowError, csv.Error) as error:
        raise FileError(
            f"{path} cannot be read: {error}; expected a whole table of contacts"
        ) from error
    return ContactTable(columns)


def _column(name: str, cells: Sequence[str]) -> NDArray[Any]:
    """Values of a column; of one that no table of contacts has, numbers, or else words."""
    kind = KINDS.get(name)
    if kind is not None and kind.kind == "U":
        return np.array(cells, np.str_)
    try:
        if kind is not None and kind.kind == "i" and all(cells):
            return np.array([int(cell) for cell in cells], np.int64)
        return np.array([float(cell or "nan") for cell in cells], np.float64)
    except ValueError as error:
        if kind is None:
            return np.array(cells, np.str_)
        raise ValueError(f"column {name}: {error}") from error
