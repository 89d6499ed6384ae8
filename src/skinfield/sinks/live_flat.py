"""Exports of live recordings to CSV or Parquet: one file of counts, small ones beside it."""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, SkinfieldError
from skinfield.sinks.live_tables import Exported, LiveExport, Rows, flat_columns, flat_values
from skinfield.sinks.pending import explained, pending

Column = tuple[str, np.dtype[Any]]
HELD = 1 << 25  # bytes of a group of rows of Parquet


class FlatFile(ABC):
    """One table in one file.

    Parameters
    ----------
    path : Path
    columns : list of (name, dtype)
    notes : dict
        What is said of it, as far as the format can.
    """

    def __init__(self, path: Path, columns: list[Column], notes: dict[str, str]) -> None:
        self.place = pending(path)
        self.columns = columns
        with explained(self.place.target):
            self.begin(notes)

    @abstractmethod
    def begin(self, notes: dict[str, str]) -> None:
        """Open it."""

    @abstractmethod
    def add(self, values: list[NDArray[Any] | None], count: int) -> None:
        """Add rows: a column of `count` values, or None where all are missing."""

    @abstractmethod
    def end(self) -> None:
        """Close it."""

    def finish(self) -> None:
        """Give it its name."""
        with explained(self.place.target):
            self.end()
        self.place.commit()

    def discard(self) -> None:
        """Remove it."""
        with suppress(OSError, ValueError, SkinfieldError):
            self.end()
        self.place.discard()


class CsvFile(FlatFile):
    """Comments, a line of names, one line per row; nothing where a value is missing."""

    ending = ".csv"

    def begin(self, notes: dict[str, str]) -> None:
        """See `FlatFile`."""
        self._file: IO[str] = self.place.part.open("x", encoding="utf-8")
        self._file.writelines(f"# {name} = {text}\n" for name, text in notes.items())
        self._file.write(",".join(name for name, _ in self.columns) + "\n")

    def add(self, values: list[NDArray[Any] | None], count: int) -> None:
        """See `FlatFile`."""
        texts = [[""] * count if value is None else _texts(value) for value in values]
        with explained(self.place.target):
            self._file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))

    def end(self) -> None:
        """See `FlatFile`."""
        self._file.close()


class ParquetFile(FlatFile):
    """Columns by type; null where a value is missing."""

    ending = ".parquet"

    def begin(self, notes: dict[str, str]) -> None:
        """See `FlatFile`."""
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError as error:
            raise SkinfieldError(
                "Parquet needs pyarrow, which is not installed: pip install 'skinfield[parquet]', "
                "or write .csv"
            ) from error
        self._arrow = pyarrow
        schema = pyarrow.schema(
            [(name, pyarrow.from_numpy_dtype(kind)) for name, kind in self.columns],
            metadata=notes,
        )
        self._schema, self._bytes = schema, 0
        self._held: list[Any] = []
        self._writer = parquet.ParquetWriter(self.place.part, schema, compression="zstd")

    def add(self, values: list[NDArray[Any] | None], count: int) -> None:
        """See `FlatFile`."""
        arrow = self._arrow
        columns = [
            arrow.nulls(count, field.type)
            if value is None
            else arrow.array(value, field.type, mask=_missing(value))
            for value, field in zip(values, self._schema, strict=True)
        ]
        self._held.append(arrow.table(columns, schema=self._schema))
        self._bytes += self._held[-1].nbytes
        if self._bytes >= HELD:
            self._write()

    def end(self) -> None:
        """See `FlatFile`."""
        self._write()
        self._writer.close()

    def _write(self) -> None:
        """One group of rows: many small ones of many columns would take long, and much memory."""
        held, self._held, self._bytes = self._held, [], 0
        if held:
            with explained(self.place.target):
                self._writer.write_table(self._arrow.concat_tables(held).combine_chunks())


class FlatExport(LiveExport):
    """Counts in the file that was asked for; contacts and the rest in files beside it.

    Of one patch, the counts' columns are `uid_<uid>` (as `open_recording` reads them); of several,
    `<patch>.<taxel>`, and a row has values of one patch only.
    """

    def __init__(
        self,
        path: Path,
        what: Exported,
        kind: Callable[[Path, list[Column], dict[str, str]], FlatFile],
    ) -> None:
        self._path, self._what = path, what
        self._files: dict[str, FlatFile] = {}
        self._happened = pending(path.with_suffix(".events.json"))
        notes = {"unit": what.units[0] if what.units else "count", "source": what.source}
        single = len(what.patches) == 1
        names = [
            f"uid_{uid}" if single else f"{patch.name}.{taxel}"
            for patch in what.patches
            for taxel, uid in enumerate(patch.uid.tolist())
        ]
        self._starts = np.cumsum([0, *map(len, what.patches)])
        counts: list[Column] = [("stamp_ns", np.dtype(np.int64))]
        counts += [(name, np.dtype("<f4")) for name in names]
        try:
            self._files["counts"] = kind(path, counts, notes)
            for table, rows in what.tables.items():
                beside = path.with_suffix(f".{table}{path.suffix}")
                self._files[table] = kind(beside, flat_columns(rows), {"source": what.source})
        except BaseException:
            self.discard()
            raise

    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """See `LiveExport`."""
        first, last = self._starts[patch], self._starts[patch + 1]
        values: list[NDArray[Any] | None] = [None] * (1 + int(self._starts[-1]))
        values[0] = stamp_ns
        values[1 + first : 1 + last] = list(np.ascontiguousarray(counts.T.astype(np.float32)))
        self._files["counts"].add(values, len(stamp_ns))

    def add_rows(self, table: str, rows: Rows) -> None:
        """See `LiveExport`."""
        self._files[table].add(list(flat_values(rows)), len(rows))

    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """See `LiveExport`."""
        with explained(self._happened.target):
            text = json.dumps({"timing": list(timing), "events": list(events)}, indent=1)
            self._happened.part.write_text(text, encoding="utf-8")

    def close(self) -> None:
        """See `Closing`."""
        try:
            for file in self._files.values():
                file.finish()
            if self._happened.part.exists():
                self._happened.commit()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """See `Closing`."""
        for file in self._files.values():
            file.discard()
        self._happened.discard()


def _texts(values: NDArray[Any]) -> list[str]:
    """Shortest text that reads back as the same number; nothing for NaN."""
    if values.dtype.kind == "f" and values.dtype.itemsize == 4:
        whole = np.isfinite(values) & (values == np.trunc(values)) & (np.abs(values) < 1e7)
        if whole.all():
            return [str(value) for value in values.astype(np.int64).tolist()]
        return ["" if value != value else str(value) for value in values]
    return ["" if value != value else repr(value) for value in values.tolist()]


def _missing(values: NDArray[Any]) -> NDArray[np.bool_] | None:
    return np.isnan(values) if values.dtype.kind == "f" else None
