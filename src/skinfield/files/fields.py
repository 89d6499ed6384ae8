"""Files of fields: NPZ and Zarr, the fields of every reading with their units."""

import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from shutil import copyfileobj
from tempfile import TemporaryFile
from typing import IO, Any, Protocol
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, SkinfieldError
from skinfield.estimate import Estimate
from skinfield.files.pending import Closing, Pending, explained, pending
from skinfield.skin import Grid

Arrays = dict[str, NDArray[Any]]
SERIES = {  # arrays with an axis of readings: type, axes after it, unit, meaning
    "stamp_ns": ("i8", (), "ns", "time of the reading, since the epoch of its source"),
    "pressure": ("f4", ("row", "column"), "Pa", "normal traction, positive in compression"),
    "pressure_std": ("f4", ("row", "column"), "Pa", "one standard deviation of the pressure"),
    "displacement": ("f4", ("row", "column", "axis"), "m", "of the surface, in the patch's frame"),
}
FIXED = {  # arrays that all readings share
    "position": ("f8", ("row", "column", "axis"), "m", "of the nodes, in the patch's frame"),
}
CHUNK_BYTES, MOST = 4 << 20, 512  # of all fields together; readings of a chunk
FORMAT = "skinfield fields 1"


def readings_per_chunk(grid: Grid) -> int:
    """Readings whose fields fill `CHUNK_BYTES`, about: a power of two up to `MOST`."""
    return min(MOST, 1 << max(1, CHUNK_BYTES // (len(grid) * 20)).bit_length() - 1)


def series_of(estimate: Estimate) -> Arrays:
    """Arrays of `SERIES`, each with a leading axis of readings."""
    shape = (-1, *estimate.grid.shape)
    count = len(estimate) if estimate.is_batch else 1
    return {
        "stamp_ns": np.broadcast_to(np.asarray(estimate.stamp_ns, np.int64), count),
        "pressure": estimate.pressure.reshape(shape).astype(np.float32),
        "pressure_std": np.broadcast_to(
            estimate.pressure_std.reshape(shape).astype(np.float32), (count, *estimate.grid.shape)
        ),
        "displacement": estimate.displacement.reshape(*shape, 3).astype(np.float32),
    }


def fixed_of(grid: Grid) -> Arrays:
    """Arrays of `FIXED`."""
    return {"position": grid.positions.reshape(*grid.shape, 3)}


def attributes_of(grid: Grid) -> dict[str, Any]:
    """What is said of the whole file."""
    return {
        "format": FORMAT,
        "patch": grid.patch.name,
        "pitch_m": grid.pitch,
        "cell_area_m2": grid.cell_area,
    }


class _Store(Protocol):
    def begin(self, grid: Grid) -> None: ...
    def append(self, series: Arrays) -> None: ...
    def finish(self) -> None: ...
    def discard(self) -> None: ...


@dataclass
class FieldWriter(Closing):
    """Writes the fields of estimates as they come; made by `open_fields`."""

    store: _Store
    grid: Grid | None = None
    held: list[Arrays] = field(default_factory=list)
    readings_held: int = 0
    is_open: bool = True

    def write(self, estimate: Estimate) -> None:
        """Add the fields of an estimate of one reading or of many.

        Raises
        ------
        InputError
            If the estimate is on another grid than those before.
        FileError
            If the file cannot be written.
        """
        self.write_series(estimate.grid, series_of(estimate))

    def write_series(self, grid: Grid, series: Arrays) -> None:
        """Add what `series_of` makes of an estimate, perhaps in another process."""
        count, start = len(series["stamp_ns"]), 0
        if not count:
            return
        if self.grid is None:
            self.store.begin(grid)
            self.grid = grid
        _check_grid(self.grid, grid)
        chunk = readings_per_chunk(grid)
        while start < count:  # whole chunks, so that none is written twice
            take = min(count - start, chunk - self.readings_held)
            self.held.append({key: a[start : start + take] for key, a in series.items()})
            self.readings_held += take
            start += take
            if self.readings_held == chunk:
                self._flush()

    def close(self) -> None:
        """Write what is left and give the file its name."""
        if not self.is_open:
            return
        try:
            if self.grid is None:
                raise InputError("no estimate was written, expected one or more: no grid is known")
            self._flush()
            self.store.finish()
            self.is_open = False
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Give up: what was written is removed."""
        self.is_open = False
        self.store.discard()

    def _flush(self) -> None:
        held, self.held, self.readings_held = self.held, [], 0
        if held:
            self.store.append({key: np.concatenate([part[key] for part in held]) for key in SERIES})


def open_fields(path: str | Path) -> FieldWriter:
    """Start a file of fields, NPZ or Zarr by the extension.

    Parameters
    ----------
    path : str or Path
        Ends in `.npz` or `.zarr`. Either is written as the estimates come, so memory stays bounded;
        NPZ is compressed at the end, out of files beside it. Both hold `stamp_ns` (T,), `pressure`
        (T, rows, columns) Pa and its `pressure_std`, `displacement` (T, rows, columns, 3) m and
        `position` (rows, columns, 3) m, the fields in single precision. Units are attributes in
        Zarr, and in NPZ a JSON text under the key `attributes`.

    Returns
    -------
    FieldWriter
        Use it in a `with` block, or call `close`.

    Raises
    ------
    InputError
        For another extension.
    FileError
        If the file cannot be made.
    SkinfieldError
        If zarr is not installed and the file is to be Zarr.
    """
    kind = Path(path).suffix.lower()
    if kind == ".npz":
        return FieldWriter(NpzStore(pending(path)))
    if kind == ".zarr":
        return FieldWriter(ZarrStore(pending(path), load_zarr()))
    raise InputError(f"path is {str(path)!r}, expected a name that ends in .npz or .zarr")


def write_fields(path: str | Path, estimates: Estimate | Iterable[Estimate]) -> None:
    """Write the fields of one estimate or of a run of them; see `open_fields`."""
    with open_fields(path) as writer:
        for estimate in [estimates] if isinstance(estimates, Estimate) else estimates:
            writer.write(estimate)


def _check_grid(first: Grid, other: Grid) -> None:
    same = first is other or (
        first.shape == other.shape
        and first.pitch == other.pitch
        and np.array_equal(first.positions, other.positions)
    )
    if not same:
        raise InputError(
            f"estimate is on a grid of {other.shape} nodes, expected the {first.shape} nodes of "
            "the first one: one file holds one grid"
        )


@dataclass
class NpzStore:
    """Arrays that grow in files of their own; an NPZ file, which cannot grow, is made of them."""

    place: Pending
    grid: Grid | None = None
    readings: int = 0
    files: dict[str, IO[bytes]] = field(default_factory=dict)

    def begin(self, grid: Grid) -> None:
        """Open the files."""
        self.grid = grid
        with explained(self.place.target):
            for name in SERIES:
                self.files[name] = TemporaryFile(dir=self.place.target.parent)  # noqa: SIM115

    def append(self, series: Arrays) -> None:
        """Add readings."""
        self.readings += len(series["stamp_ns"])
        with explained(self.place.target):
            for name, file in self.files.items():
                file.write(np.ascontiguousarray(series[name], SERIES[name][0]).data)

    def finish(self) -> None:
        """Give the result its name."""
        assert self.grid is not None
        units = {name: spec[2] for name, spec in {**SERIES, **FIXED}.items()}
        said = json.dumps({**attributes_of(self.grid), "units": units})
        with explained(self.place.target):
            with ZipFile(self.place.part, "x", ZIP_DEFLATED) as archive:
                for name, file in self.files.items():
                    self._copy(archive, name, file)
                for name, values in (*fixed_of(self.grid).items(), ("attributes", np.array(said))):
                    with archive.open(f"{name}.npy", "w") as member:
                        np.lib.format.write_array(member, values, allow_pickle=False)
            self.place.commit()
        self._close()

    def _copy(self, archive: ZipFile, name: str, file: IO[bytes]) -> None:
        assert self.grid is not None
        kind, axes, _, _ = SERIES[name]
        shape = (self.readings, *_shape(axes, self.grid))
        head = {"descr": np.dtype(kind).str, "fortran_order": False, "shape": shape}
        file.seek(0)
        with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
            np.lib.format.write_array_header_1_0(member, head)
            copyfileobj(file, member, 1 << 20)

    def discard(self) -> None:
        """Remove what was written."""
        self._close()
        self.place.discard()

    def _close(self) -> None:
        for file in self.files.values():
            with suppress(OSError):  # a full disk refuses what is left: it goes anyway
                file.close()
        self.files.clear()


@dataclass
class ZarrStore:
    """A Zarr group that grows chunk by chunk."""

    place: Pending
    zarr: Any
    group: Any = None

    def begin(self, grid: Grid) -> None:
        """Write what all readings share."""
        with explained(self.place.target):
            self.group = self.zarr.create_group(self.place.part, attributes=attributes_of(grid))
            for name in SERIES:
                create_series(self.group, name, grid)
            create_fixed(self.group, grid)

    def append(self, series: Arrays) -> None:
        """Add readings."""
        with explained(self.place.target):
            for name, values in series.items():
                self.group[name].append(values)

    def finish(self) -> None:
        """Give the result its name."""
        self.place.commit()

    def discard(self) -> None:
        """Remove what was written."""
        self.place.discard()


def create_series(group: Any, name: str, grid: Grid, readings: int = 0) -> None:
    """Make an array of `SERIES` for so many readings, in a Zarr group."""
    kind, axes, unit, meaning = SERIES[name]
    shape = _shape(axes, grid)
    count = readings_per_chunk(grid)
    create_array(group, name, kind, (readings, *shape), (count, *shape), unit, meaning,
                 ("reading", *axes))  # fmt: skip


def create_fixed(group: Any, grid: Grid) -> None:
    """Write the arrays of `FIXED` into a Zarr group."""
    for name, (kind, axes, unit, meaning) in FIXED.items():
        shape = _shape(axes, grid)
        create_array(group, name, kind, shape, shape, unit, meaning, axes)
        group[name][...] = fixed_of(grid)[name]


def create_array(
    group: Any,
    name: str,
    kind: str,
    shape: tuple[int, ...],
    chunks: tuple[int, ...],
    unit: str,
    meaning: str,
    axes: tuple[str, ...],
) -> None:
    """Make an array in a Zarr group, each chunk with a checksum; NaN where nothing is written."""
    from zarr.codecs import BloscCodec, Crc32cCodec

    group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype=kind,
        fill_value=float("nan") if kind[-2] == "f" else 0,
        compressors=(BloscCodec(cname="zstd", clevel=3, shuffle="bitshuffle"), Crc32cCodec()),
        dimension_names=axes,
        attributes={"units": unit, "long_name": meaning},
        config={"write_empty_chunks": True},  # a chunk that is missing is a damage
    )


def _shape(axes: tuple[str, ...], grid: Grid) -> tuple[int, ...]:
    sizes = {"row": grid.shape[0], "column": grid.shape[1], "axis": 3}
    return tuple(sizes[axis] for axis in axes)


def load_zarr() -> Any:
    """The zarr package; raises SkinfieldError if it is not installed."""
    try:
        import zarr
    except ImportError as error:
        raise SkinfieldError(
            "Zarr needs zarr, which is not installed: pip install 'skinfield[zarr]', or write .npz"
        ) from error
    return zarr
