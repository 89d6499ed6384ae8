"""Tables written piece by piece, CSV or Parquet by the extension: any, and those of contacts."""

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.estimate import Estimate
from skinfield.estimate.contact_table import KINDS, Row, load_pyarrow, rows_from_estimate
from skinfield.files.pending import Closing, explained, pending

HELD = 1 << 25  # bytes of a group of rows of Parquet
Columns = Sequence[tuple[str, np.dtype[Any]]]
Values = Sequence[Any] | NDArray[Any] | None  # of a column; None where all are missing


class TableFile(Closing):
    """A table that has its name once it is closed.

    Parameters
    ----------
    path : str or Path
        Ends in `.csv` or `.parquet`.
    columns : sequence of (name, dtype)
    notes : mapping, optional
        What is said of the table: comments of a CSV, metadata of a Parquet file.

    Raises
    ------
    InputError
        For another extension.
    FileError
        If the file cannot be made.
    SkinfieldError
        If pyarrow is not installed and the table is to be Parquet.
    """

    def __init__(
        self, path: str | Path, columns: Columns, notes: Mapping[str, str] | None = None
    ) -> None:
        kind = Path(path).suffix.lower()
        if kind not in (".csv", ".parquet"):
            raise InputError(
                f"path is {str(path)!r}, expected a name that ends in .csv or .parquet"
            )
        if kind == ".parquet":
            load_pyarrow()  # before a file is made
        self.place = pending(path)
        with explained(self.place.target):
            self._file = self.place.part.open("xb")
            make = _Parquet if kind == ".parquet" else _Csv
            self._rows = make(self._file, columns, notes or {})

    def add(self, values: Sequence[Values], count: int) -> None:
        """Add rows: `count` values of each column, NaN or None where one is missing.

        Raises
        ------
        FileError
            If the file cannot be written; what was there before is left as it was.
        """
        with explained(self.place.target):
            self._rows.add(values, count)

    def close(self) -> None:
        """Write what is left and give the file its name."""
        if self._file.closed:
            return
        try:
            with explained(self.place.target):
                self._rows.finish()
                self._file.flush()
                os.fsync(self._file.fileno())
                self._file.close()
            self.place.commit()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Give up: the unfinished file is removed."""
        with suppress(OSError, ValueError):  # a full disk refuses the rest: it goes anyway
            self._rows.finish()
        with suppress(OSError):
            self._file.close()
        self.place.discard()


class _Csv:
    """Comments, a line of names, one line per row; nothing where a value is missing."""

    def __init__(self, file: IO[bytes], columns: Columns, notes: Mapping[str, str]) -> None:
        self._file = file
        lines = [f"# {name} = {text}\n" for name, text in notes.items()]
        file.write("".join([*lines, ",".join(name for name, _ in columns), "\n"]).encode())

    def add(self, values: Sequence[Values], count: int) -> None:
        texts = [[""] * count if each is None else _texts(each) for each in values]
        self._file.write("".join(",".join(row) + "\n" for row in zip(*texts, strict=True)).encode())

    def finish(self) -> None:
        pass  # all is written


def _texts(values: Sequence[Any] | NDArray[Any]) -> list[str]:
    """Shortest text that reads back as the same number; nothing for NaN and None."""
    if isinstance(values, np.ndarray):
        if values.dtype == np.float32:
            whole = np.isfinite(values) & (values == np.trunc(values)) & (np.abs(values) < 1e7)
            if whole.all():
                return [str(value) for value in values.astype(np.int64).tolist()]
            return ["" if value != value else str(value) for value in values]
        values = values.tolist()
    return ["" if value is None or value != value else str(value) for value in values]


class _Parquet:
    """Columns by type; null where a value is missing."""

    def __init__(self, file: IO[bytes], columns: Columns, notes: Mapping[str, str]) -> None:
        self._arrow = arrow = load_pyarrow()
        self._schema = arrow_schema(columns).with_metadata(dict(notes))
        self._writer = arrow.parquet.ParquetWriter(file, self._schema, compression="zstd")
        self._held: list[Any] = []
        self._bytes = 0

    def add(self, values: Sequence[Values], count: int) -> None:
        arrays = [
            self._arrow.nulls(count, field.type)
            if each is None
            else self._arrow.array(each, field.type, mask=_missing(each))
            for each, field in zip(values, self._schema, strict=True)
        ]
        self._held.append(self._arrow.table(arrays, schema=self._schema))
        self._bytes += self._held[-1].nbytes
        if self._bytes >= HELD:  # many small groups of many columns would take long, and memory
            self._write()

    def finish(self) -> None:
        if self._writer.is_open:
            self._write()
            self._writer.close()

    def _write(self) -> None:
        held, self._held, self._bytes = self._held, [], 0
        if held:
            self._writer.write_table(self._arrow.concat_tables(held).combine_chunks())


def arrow_schema(columns: Columns) -> Any:
    """Types of columns for pyarrow."""
    arrow = load_pyarrow()
    types = [arrow.string() if k.kind == "U" else arrow.from_numpy_dtype(k) for _, k in columns]
    return arrow.schema(list(zip((name for name, _ in columns), types, strict=True)))


def _missing(values: Any) -> NDArray[np.bool_] | None:
    floats = isinstance(values, np.ndarray) and values.dtype.kind == "f"
    return np.isnan(values) if floats else None


class ContactWriter(TableFile):
    """Table of contacts that is written as they come, CSV or Parquet by the extension.

    Use it in a `with` block, or call `close`.

    Parameters
    ----------
    path : str or Path
        Ends in `.csv` or `.parquet`. One row per contact and reading; a reading without a contact
        has none. Units stand in the names of the columns.

    Raises
    ------
    InputError, FileError, SkinfieldError
        As `TableFile`.
    """

    def __init__(self, path: str | Path) -> None:
        super().__init__(path, KINDS)
        self._readings = 0
        self._start_ns: int | None = None

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
        if self._start_ns is None:
            self._start_ns = int(np.ravel(estimate.stamp_ns)[0])
        self.write_rows(rows_from_estimate(estimate, self._readings, self._start_ns))
        self._readings += count

    def write_rows(self, rows: Iterable[Row]) -> None:
        """Add what `contact_table.rows_from_estimate` makes of some readings, maybe elsewhere."""
        found = list(rows)
        if found:
            self.add(list(zip(*found, strict=True)), len(found))


open_contacts = ContactWriter


def write_contacts(path: str | Path, estimates: Estimate | Iterable[Estimate]) -> None:
    """Write the contacts of one estimate or of a run of them; see `open_contacts`."""
    with open_contacts(path) as writer:
        for estimate in [estimates] if isinstance(estimates, Estimate) else estimates:
            writer.write(estimate)
