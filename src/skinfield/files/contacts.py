"""Contacts of every reading, to CSV or Parquet."""

import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Protocol

import numpy as np

from skinfield.errors import InputError
from skinfield.estimate import Estimate
from skinfield.estimate.contact_table import (
    COLUMNS,
    Row,
    Value,
    arrow_schema,
    arrow_table,
    load_pyarrow,
    rows_from_estimate,
)
from skinfield.files.pending import Closing, Pending, explained, pending

CHUNK = 16384  # rows held before they are written: some megabytes


class _Table(Protocol):
    def append(self, rows: Sequence[Row]) -> None: ...
    def finish(self) -> None: ...


@dataclass
class ContactWriter(Closing):
    """Writes the contacts of estimates as they come; made by `open_contacts`.

    Memory is bounded: rows are written in chunks. The file has its name once `close` was called.
    """

    place: Pending
    file: IO[bytes]
    table: _Table
    readings: int = 0
    start_ns: int | None = None
    rows: list[Row] = field(default_factory=list)

    def write(self, estimate: Estimate) -> None:
        """Add the contacts of an estimate of one reading or of many.

        Raises
        ------
        FileError
            If the file cannot be written; what was there before is left as it was.
        """
        count = len(estimate) if estimate.is_batch else 1
        if not count:
            return
        if self.start_ns is None:
            self.start_ns = int(np.ravel(estimate.stamp_ns)[0])
        self.write_rows(rows_from_estimate(estimate, self.readings, self.start_ns), count)

    def write_rows(self, rows: Iterable[Row], readings: int) -> None:
        """Add what `contact_table.rows_from_estimate` makes of some readings, maybe elsewhere."""
        for row in rows:
            self.rows.append(row)
            if len(self.rows) >= CHUNK:
                self._flush()
        self.readings += readings

    def close(self) -> None:
        """Write what is left and give the file its name."""
        if self.file.closed:
            return
        try:
            self._flush()
            with explained(self.place.target):
                self.table.finish()
                self.file.flush()
                os.fsync(self.file.fileno())
                self.file.close()
            self.place.commit()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Give up: the unfinished file is removed."""
        with suppress(OSError, ValueError):  # a full disk refuses the rest: it goes anyway
            self.table.finish()
        with suppress(OSError):
            self.file.close()
        self.place.discard()

    def _flush(self) -> None:
        rows, self.rows = self.rows, []
        with explained(self.place.target):
            self.table.append(rows)


def open_contacts(path: str | Path) -> ContactWriter:
    """Start a table of contacts, CSV or Parquet by the extension.

    Parameters
    ----------
    path : str or Path
        Ends in `.csv` or `.parquet`. One row per contact and reading, and one row with `contact`
        -1 and nothing in the contact's own columns for a reading without contact, so that every
        reading is there: `table[table.contact >= 0]` are the contacts,
        `table.drop_duplicates("reading")` the readings. Units stand in the names of the columns.

    Returns
    -------
    ContactWriter
        Use it in a `with` block, or call `close`.

    Raises
    ------
    InputError
        For another extension.
    FileError
        If the file cannot be made.
    SkinfieldError
        If pyarrow is not installed and the table is to be Parquet.
    """
    kind = Path(path).suffix.lower()
    if kind not in (".csv", ".parquet"):
        raise InputError(f"path is {str(path)!r}, expected a name that ends in .csv or .parquet")
    make = _Parquet if kind == ".parquet" else _Csv
    if kind == ".parquet":
        load_pyarrow()  # before a file is made
    place = pending(path)
    with explained(place.target):
        file = place.part.open("xb")
    return ContactWriter(place, file, make(file))


def write_contacts(path: str | Path, estimates: Estimate | Iterable[Estimate]) -> None:
    """Write the contacts of one estimate or of a run of them; see `open_contacts`."""
    with open_contacts(path) as writer:
        for estimate in [estimates] if isinstance(estimates, Estimate) else estimates:
            writer.write(estimate)


class _Csv:
    def __init__(self, file: IO[bytes]) -> None:
        self.file = file
        self.header = ",".join(COLUMNS) + "\n"

    def append(self, rows: Sequence[Row]) -> None:
        lines = (",".join(map(_text, row)) + "\n" for row in rows)
        self.file.write((self.header + "".join(lines)).encode())
        self.header = ""

    def finish(self) -> None:
        pass  # the last chunk was written by `append`


def _text(value: Value) -> str:
    if value is None:
        return ""
    return f"{value:.9g}" if isinstance(value, float) else str(value)


class _Parquet:
    def __init__(self, file: IO[bytes]) -> None:
        self.writer = load_pyarrow().parquet.ParquetWriter(file, arrow_schema())

    def append(self, rows: Sequence[Row]) -> None:
        self.writer.write_table(arrow_table(rows))

    def finish(self) -> None:
        self.writer.close()
