"""Exports of live recordings to one HDF5 file or one Zarr store."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, SkinfieldError
from skinfield.sinks.field_stores import load_zarr
from skinfield.sinks.live_tables import Exported, LiveExport, Rows
from skinfield.sinks.pending import Pending, explained, pending

CHUNK = 1 << 20  # bytes of a chunk, about
Array = NDArray[Any]
Grow = Callable[[Any, Array], None]
Create = Callable[[Any, str, tuple[int, ...], Any], Any]


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
