"""Contacts of every reading, to CSV or Parquet."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.estimate import Estimate
from skinfield.estimate.contact_table import COLUMNS, WHOLE, WORDS, Row, rows_from_estimate
from skinfield.files.pending import Closing
from skinfield.files.tables import Table

CHUNK = 16384  # rows held before they are written: some megabytes


@dataclass
class ContactWriter(Closing):
    """Writes the contacts of estimates as they come; made by `open_contacts`.

    Memory is bounded: rows are written in chunks. The file has its name once `close` was called.
    """

    table: Table
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
        try:
            self._flush()
            self.table.close()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Give up: the unfinished file is removed."""
        self.table.discard()

    def _flush(self) -> None:
        rows, self.rows = self.rows, []
        if rows:
            self.table.add(list(zip(*rows, strict=True)), len(rows))


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
    return ContactWriter(Table(path, [(name, _dtype_of(name)) for name in COLUMNS]))


def _dtype_of(name: str) -> np.dtype[Any]:
    return np.dtype("i8" if name in WHOLE else "U" if name in WORDS else "f8")


def write_contacts(path: str | Path, estimates: Estimate | Iterable[Estimate]) -> None:
    """Write the contacts of one estimate or of a run of them; see `open_contacts`."""
    with open_contacts(path) as writer:
        for estimate in [estimates] if isinstance(estimates, Estimate) else estimates:
            writer.write(estimate)
