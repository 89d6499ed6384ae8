"""Exports of live recordings: counts of every patch, contacts, cycles and what happened.

To CSV or Parquet (one file of counts, small ones beside it), or to one HDF5 file or Zarr store.
Everything comes in pieces and is written as it comes: memory does not grow with the recording. The
result has its name once it is whole.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints, SkinfieldError
from skinfield.files.fields import load_zarr
from skinfield.files.pending import Closing, Pending, explained, pending
from skinfield.skin import Patch

ENDINGS = (".parquet", ".csv", ".zarr", ".h5")
TABLES = ("contacts", "fit_contacts", "patch_cycles", "cycles")  # fits: where there is one
HELD = 1 << 25  # bytes of a group of rows of Parquet
CHUNK = 1 << 20  # bytes of a chunk of a store, about
Array = NDArray[Any]
Rows = NDArray[np.void]
Column = tuple[str, np.dtype[Any]]
Grow = Callable[[Any, Array], None]
Create = Callable[[Any, str, tuple[int, ...], Any], Any]


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


class StoreExport(LiveExport):
    """Groups `patches/<name>` (stamp_ns, counts, uid, positions) and one for each table.

    `timing` and `events` are JSON, as bytes.

    Parameters
    ----------
    place : Pending
    root : group
        Of h5py or zarr, which name things alike.
    create : function of group, name, shape of one row, dtype
        Makes an array that can grow.
    grow : function of array and rows
    finish : function
        Closes the file.
    """

    def __init__(
        self,
        place: Pending,
        what: Exported,
        root: Any,
        create: Create,
        grow: Grow,
        finish: Callable[[], None],
    ) -> None:
        self._place, self._root, self._grow, self._finish = place, root, grow, finish
        self._arrays: dict[tuple[str, str], Any] = {}
        self._open = True
        try:
            with explained(place.target):
                root.attrs["source"] = what.source
                self._begin(what, create)
        except BaseException:
            self.discard()
            raise

    def _begin(self, what: Exported, create: Create) -> None:
        patches = self._root.create_group("patches")
        for patch, unit in zip(what.patches, what.units, strict=True):
            group, key = patches.create_group(patch.name.replace("/", "_")), patch.name
            group.attrs.update({"name": patch.name, "link": patch.link, "unit": unit})
            for name, values in (("uid", patch.uid), ("positions", patch.positions)):
                array = create(group, name, values.shape[1:], values.dtype)
                self._grow(array, np.asarray(values))
            self._arrays[key, "stamp_ns"] = create(group, "stamp_ns", (), np.dtype(np.int64))
            self._arrays[key, "counts"] = create(group, "counts", (len(patch),), np.dtype("<f4"))
        for name in ("timing", "events"):  # JSON, as bytes
            self._arrays["", name] = create(self._root, name, (), np.dtype(np.uint8))
        self._patches = [patch.name for patch in what.patches]
        for table, rows in what.tables.items():
            group = self._root.create_group(table)
            for name in rows.names or ():
                field = rows[name]
                self._arrays[f"/{table}", name] = create(group, name, field.shape, field.base)

    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """See `LiveExport`."""
        key = self._patches[patch]
        with explained(self._place.target):
            self._grow(self._arrays[key, "stamp_ns"], stamp_ns)
            self._grow(self._arrays[key, "counts"], counts.astype(np.float32))

    def add_rows(self, table: str, rows: Rows) -> None:
        """See `LiveExport`."""
        with explained(self._place.target):
            for name in rows.dtype.names or ():
                self._grow(self._arrays[f"/{table}", name], np.ascontiguousarray(rows[name]))

    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """See `LiveExport`."""
        with explained(self._place.target):
            for name, values in (("timing", timing), ("events", events)):
                text = np.frombuffer(json.dumps(list(values)).encode(), np.uint8)
                self._grow(self._arrays["", name], text)

    def close(self) -> None:
        """See `Closing`."""
        try:
            with explained(self._place.target):
                self._end()
            self._place.commit()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """See `Closing`."""
        self._end()
        self._place.discard()

    def _end(self) -> None:
        if self._open:
            self._open = False
            self._finish()


def hdf5_export(path: str | Path, what: Exported) -> LiveExport:
    """See `open_export`."""
    try:
        import h5py
    except ImportError as error:
        raise SkinfieldError(
            "HDF5 needs h5py, which is not installed: pip install 'skinfield[hdf5]', or write .zarr"
        ) from error
    place = pending(path)
    with explained(place.target):
        file = h5py.File(place.part, "x")

    def create(group: Any, name: str, row: tuple[int, ...], kind: Any) -> Any:
        size = (_rows(row, kind), *row)
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        return group.create_dataset(
            name, (0, *row), kind, maxshape=(None, *row), chunks=size, **packed
        )

    def grow(array: Any, values: Array) -> None:
        if len(values):
            array.resize(len(array) + len(values), axis=0)
            array[-len(values) :] = values

    return StoreExport(place, what, file, create, grow, file.close)


def zarr_export(path: str | Path, what: Exported) -> LiveExport:
    """See `open_export`."""
    zarr, place = load_zarr(), pending(path)
    with explained(place.target):
        root = zarr.create_group(place.part)

    def create(group: Any, name: str, row: tuple[int, ...], kind: Any) -> Any:
        return group.create_array(
            name, shape=(0, *row), chunks=(_rows(row, kind), *row), dtype=np.dtype(kind)
        )

    def grow(array: Any, values: Array) -> None:
        if len(values):
            array.append(values)

    return StoreExport(place, what, root, create, grow, lambda: None)


def _rows(row: tuple[int, ...], kind: Any) -> int:
    """Of one chunk."""
    size = int(np.prod(row, dtype=np.int64)) * np.dtype(kind).itemsize
    return int(np.clip(CHUNK // max(size, 1), 16, 1 << 14))
