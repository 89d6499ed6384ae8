"""Exports of live recordings: counts of every patch, contacts, cycles and what happened.

Everything comes in pieces and is written as it comes: memory does not grow with the recording. The
result has its name once it is whole.
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints
from skinfield.layout import Patch
from skinfield.sinks.sink import Closing

ENDINGS = (".parquet", ".csv", ".zarr", ".h5")
TABLES = ("contacts", "fit_contacts", "patch_cycles", "cycles")  # fits: where there is one
Rows = NDArray[np.void]


@dataclass(frozen=True, eq=False)
class Exported:
    """What is exported, as far as it is known at the beginning.

    Attributes
    ----------
    source : str
        File that it comes from.
    patches : tuple of Patch
    units : tuple of str
        Of the patches' counts.
    tables : dict of str to dtype
        Fields of `TABLES`.
    """

    source: str
    patches: tuple[Patch, ...]
    units: tuple[str, ...]
    tables: dict[str, np.dtype[Any]]


class LiveExport(Closing):
    """Takes the parts of a recording in any order of pieces; made by `open_export`."""

    @abstractmethod
    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """Add readings (T, L) of a patch, in the order of its taxels; NaN where there was none."""

    @abstractmethod
    def add_rows(self, table: str, rows: Rows) -> None:
        """Add rows of one of `TABLES`."""

    @abstractmethod
    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """Add what was measured each second, and what happened."""


def open_export(path: str | Path, what: Exported) -> LiveExport:
    """Begin an export; its format is that of the ending.

    Parameters
    ----------
    path : str or Path
        Ends in .parquet or .csv (counts of all patches there, the rest in files beside it), .zarr
        or .h5 (everything in one).
    what : Exported

    Raises
    ------
    InputError
        For another ending.
    SkinfieldError
        If the package that writes it is not installed.
    FileError
        If it cannot be written there.
    """
    from skinfield.sinks.live_flat import CsvFile, FlatExport, ParquetFile
    from skinfield.sinks.live_stores import hdf5_export, zarr_export

    ending = Path(path).suffix.lower()
    if ending == ".csv":
        return FlatExport(Path(path), what, CsvFile)
    if ending == ".parquet":
        return FlatExport(Path(path), what, ParquetFile)
    if ending == ".zarr":
        return zarr_export(path, what)
    if ending == ".h5":
        return hdf5_export(path, what)
    raise InputError(f"{path} ends in {ending!r}, expected one of {', '.join(ENDINGS)}")


def flat_columns(rows: np.dtype[Any]) -> list[tuple[str, np.dtype[Any]]]:
    """Names and types of a table's columns, where a field of n numbers becomes n columns."""
    columns = []
    for name in rows.names or ():
        field = rows[name]
        for index in np.ndindex(field.shape):
            columns.append(("_".join((name, *map(str, index))), field.base))
    return columns


def flat_values(rows: Rows) -> list[NDArray[Any]]:
    """Values of `flat_columns`, each (T,)."""
    values = []
    for name in rows.dtype.names or ():
        field = rows[name]
        for index in np.ndindex(field.shape[1:]):
            values.append(np.ascontiguousarray(field[(slice(None), *index)]))
    return values
