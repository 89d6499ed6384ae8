"""Exports of live recordings: counts of every patch, contacts, cycles and what happened.

To CSV or Parquet (one file of counts, small ones beside it), or to one HDF5 file.
Everything comes in pieces and is written as it comes: memory does not grow with the recording. The
result has its name once it is whole.
"""

import json
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints, SkinfieldError
from skinfield.files.pending import Closing, explained, pending
from skinfield.files.tables import Table, Values
from skinfield.skin import Patch

ENDINGS = (".parquet", ".csv", ".h5")
TABLES = ("contacts", "fit_contacts", "patch_cycles", "cycles")  # fits: where there is one
CHUNK = 1 << 20  # bytes of a chunk of HDF5, about
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
        Ends in .parquet or .csv (counts of all patches there, the rest in files beside it), or .h5
        (everything in one).
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
    if ending not in ENDINGS:
        raise InputError(f"{path} ends in {ending!r}, expected one of {', '.join(ENDINGS)}")
    return (Hdf5Export if ending == ".h5" else FlatExport)(Path(path), what)


def flat_columns(rows: np.dtype[Any]) -> list[tuple[str, np.dtype[Any]]]:
    """Names and types of a table's columns, where a field of n numbers becomes n columns."""
    columns = []
    for name in rows.names or ():
        field = rows[name]
        for index in np.ndindex(field.shape):
            columns.append(("_".join((name, *map(str, index))), field.base))
    return columns


def flat_values(rows: Rows) -> list[Values]:
    """Values of `flat_columns`, each (T,)."""
    values: list[Values] = []
    for name in rows.dtype.names or ():
        field = rows[name]
        for index in np.ndindex(field.shape[1:]):
            values.append(np.ascontiguousarray(field[(slice(None), *index)]))
    return values


class FlatExport(LiveExport):
    """Counts in the file that was asked for; contacts and the rest in files beside it.

    Of one patch, the counts' columns are `uid_<uid>` (as `open_recording` reads them); of several,
    `<patch>.<taxel>`, and a row has values of one patch only.
    """

    def __init__(self, path: Path, what: Exported) -> None:
        self._path, self._what = path, what
        self._files: dict[str, Table] = {}
        self._happened = pending(path.with_suffix(".events.json"))
        notes = {"unit": what.units[0] if what.units else "count", "source": what.source}
        single = len(what.patches) == 1
        names = [
            f"uid_{uid}" if single else f"{patch.name}.{taxel}"
            for patch in what.patches
            for taxel, uid in enumerate(patch.uid.tolist())
        ]
        self._starts = np.cumsum([0, *map(len, what.patches)])
        counts: list[tuple[str, np.dtype[Any]]] = [("stamp_ns", np.dtype(np.int64))]
        counts += [(name, np.dtype("<f4")) for name in names]
        try:
            self._files["counts"] = Table(path, counts, notes)
            for table, rows in what.tables.items():
                beside = path.with_suffix(f".{table}{path.suffix}")
                self._files[table] = Table(beside, flat_columns(rows), {"source": what.source})
        except BaseException:
            self.discard()
            raise

    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """See `LiveExport`."""
        first, last = self._starts[patch], self._starts[patch + 1]
        values: list[Values] = [None] * (1 + int(self._starts[-1]))
        values[0] = stamp_ns
        values[1 + first : 1 + last] = list(np.ascontiguousarray(counts.T.astype(np.float32)))
        self._files["counts"].add(values, len(stamp_ns))

    def add_rows(self, table: str, rows: Rows) -> None:
        """See `LiveExport`."""
        self._files[table].add(flat_values(rows), len(rows))

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
                file.close()
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


class Hdf5Export(LiveExport):
    """Groups `patches/<name>` (stamp_ns, counts, uid, positions) and one for each table.

    `timing` and `events` are JSON, as bytes.
    """

    def __init__(self, path: Path, what: Exported) -> None:
        try:
            import h5py
        except ImportError as error:
            raise SkinfieldError(
                "HDF5 needs h5py, which is not installed: pip install 'skinfield[hdf5]', or write "
                ".csv"
            ) from error
        self._place = pending(path)
        self._arrays: dict[tuple[str, str], Any] = {}
        self._patches = [patch.name for patch in what.patches]
        with explained(self._place.target):
            self._file = h5py.File(self._place.part, "x")
        try:
            with explained(self._place.target):
                self._begin(what)
        except BaseException:
            self.discard()
            raise

    def _begin(self, what: Exported) -> None:
        self._file.attrs["source"] = what.source
        for patch, unit in zip(what.patches, what.units, strict=True):
            group = self._file.create_group(f"patches/{patch.name.replace('/', '_')}")
            group.attrs.update({"name": patch.name, "link": patch.link, "unit": unit})
            for name, values in (("uid", patch.uid), ("positions", patch.positions)):
                _grow(_array(group, name, values.shape[1:], values.dtype), values)
            self._arrays[patch.name, "stamp_ns"] = _array(group, "stamp_ns", (), np.int64)
            self._arrays[patch.name, "counts"] = _array(group, "counts", (len(patch),), np.float32)
        for name in ("timing", "events"):
            self._arrays["", name] = _array(self._file, name, (), np.uint8)
        for table, rows in what.tables.items():
            group = self._file.create_group(table)
            for name in rows.names or ():
                field = rows[name]
                self._arrays[f"/{table}", name] = _array(group, name, field.shape, field.base)

    def _add(self, group: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        with explained(self._place.target):
            for name, values in arrays.items():
                _grow(self._arrays[group, name], np.ascontiguousarray(values))

    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """See `LiveExport`."""
        self._add(self._patches[patch], {"stamp_ns": stamp_ns, "counts": counts.astype(np.float32)})

    def add_rows(self, table: str, rows: Rows) -> None:
        """See `LiveExport`."""
        self._add(f"/{table}", {name: rows[name] for name in rows.dtype.names or ()})

    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """See `LiveExport`."""
        texts = {"timing": json.dumps(list(timing)), "events": json.dumps(list(events))}
        self._add("", {key: np.frombuffer(text.encode(), np.uint8) for key, text in texts.items()})

    def close(self) -> None:
        """See `Closing`."""
        try:
            with explained(self._place.target):
                self._file.close()
            self._place.commit()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """See `Closing`."""
        self._file.close()  # once more does no harm
        self._place.discard()


def _array(group: Any, name: str, row: tuple[int, ...], kind: Any) -> Any:
    """An array of an HDF5 file that can grow."""
    size = int(np.prod(row, dtype=np.int64)) * np.dtype(kind).itemsize
    chunk = int(np.clip(CHUNK // max(size, 1), 16, 1 << 14))
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    shape, most, chunks = (0, *row), (None, *row), (chunk, *row)
    return group.create_dataset(name, shape, kind, maxshape=most, chunks=chunks, **packed)


def _grow(array: Any, values: NDArray[Any]) -> None:
    if len(values):
        array.resize(len(array) + len(values), axis=0)
        array[-len(values) :] = values
