"""Fields of every reading with their units: NPZ files, and arrays of Zarr in results."""

import json
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from shutil import copyfileobj
from tempfile import TemporaryFile
from typing import IO, Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.estimate import Estimate
from skinfield.files.pending import Closing, explained, pending
from skinfield.skin import Grid

Arrays = dict[str, NDArray[Any]]
SERIES = {  # arrays with an axis of readings: type, axes after it, unit, meaning
    "stamp_ns": ("i8", (), "ns", "time of the reading, since the epoch of its source"),
    "pressure": ("f4", ("row", "column"), "Pa", "normal traction, positive in compression"),
    "pressure_std": ("f4", ("row", "column"), "Pa", "one standard deviation of the pressure"),
    "displacement": ("f4", ("row", "column", "axis"), "m", "of the surface, in the patch's frame"),
}
POSITION = "f8", ("row", "column", "axis"), "m", "of the nodes, in the patch's frame"
CHUNK_BYTES, MOST = 4 << 20, 512  # of all fields together; readings of a chunk
COPIED = 1 << 20  # bytes at once, into an archive
FORMAT = "skinfield fields 1"


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


class FieldWriter(Closing):
    """File of the fields of estimates that is written as they come; see `write_fields`, too.

    Use it in a `with` block, or call `close`.

    Parameters
    ----------
    path : str or Path
        Ends in `.npz`. It is compressed at the end, out of files beside it, so memory stays
        bounded. It holds `stamp_ns` (T,), `pressure` (T, rows, columns) Pa and its `pressure_std`,
        `displacement` (T, rows, columns, 3) m and `position` (rows, columns, 3) m, the fields in
        single precision; and under the key `attributes` the units, as a JSON text.

    Raises
    ------
    InputError
        For another extension.
    FileError
        If the file cannot be made.
    """

    def __init__(self, path: str | Path) -> None:
        if Path(path).suffix.lower() != ".npz":
            raise InputError(
                f"path is {str(path)!r}, expected a name that ends in .npz; a folder of results "
                "(.skinfield) holds the fields of long runs"
            )
        self._place, self._open = pending(path), True
        self._grid: Grid | None = None
        self._files: dict[str, IO[bytes]] = {}

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
        if not len(series["stamp_ns"]):
            return
        folder = self._place.target.parent
        with explained(self._place.target):
            if self._grid is None:
                self._grid = grid
                self._files = {name: TemporaryFile(dir=folder) for name in SERIES}  # noqa: SIM115
            if grid is not self._grid and not np.array_equal(grid.positions, self._grid.positions):
                raise InputError(
                    f"estimate is on a grid of {grid.shape} nodes, expected the {self._grid.shape} "
                    "nodes of the first one: one file holds one grid"
                )
            for name, file in self._files.items():
                file.write(np.ascontiguousarray(series[name], SERIES[name][0]).data)

    def close(self) -> None:
        """Write what is left and give the file its name."""
        if not self._open:
            return
        try:
            if self._grid is None:
                raise InputError("no estimate was written, expected one or more: no grid is known")
            with explained(self._place.target):
                self._pack(self._grid)
            self._place.commit()
        finally:
            self.discard()

    def discard(self) -> None:
        """Give up: what was written is removed."""
        self._open = False
        for file in self._files.values():
            with suppress(OSError):  # a full disk refuses what is left: it goes anyway
                file.close()
        self._place.discard()

    def _pack(self, grid: Grid) -> None:
        units = {name: spec[2] for name, spec in {**SERIES, "position": POSITION}.items()}
        facts = {"format": FORMAT, "patch": grid.patch.name, "pitch_m": grid.pitch}
        facts |= {"cell_area_m2": grid.cell_area, "units": units}
        with ZipFile(self._place.part, "x", ZIP_DEFLATED) as archive:
            for name, file in self._files.items():
                kind, axes, _, _ = SERIES[name]
                row = np.dtype((kind, _shape(axes, grid)))
                shape = (file.tell() // row.itemsize, *row.shape)
                head = {"descr": row.base.str, "fortran_order": False, "shape": shape}
                file.seek(0)
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, head)
                    copyfileobj(file, member, COPIED)
            places = grid.positions.reshape(*grid.shape, 3)
            for name, values in (("position", places), ("attributes", np.array(json.dumps(facts)))):
                with archive.open(f"{name}.npy", "w") as member:
                    np.lib.format.write_array(member, values, allow_pickle=False)


open_fields = FieldWriter


def write_fields(path: str | Path, estimates: Estimate | Iterable[Estimate]) -> None:
    """Write the fields of one estimate or of a run of them; see `open_fields`."""
    with open_fields(path) as writer:
        for estimate in [estimates] if isinstance(estimates, Estimate) else estimates:
            writer.write(estimate)


def create_array(
    group: Any,
    name: str,
    spec: tuple[str, tuple[str, ...], str, str],
    shape: tuple[int, ...],
    chunks: tuple[int, ...],
) -> None:
    """Make an array in a Zarr group, each chunk with a checksum; NaN where nothing is written.

    `spec` is as in `SERIES`; an axis of readings may come before its axes.
    """
    from zarr.codecs import BloscCodec, Crc32cCodec

    kind, axes, unit, meaning = spec
    group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype=kind,
        # of a chunk that holds nothing else no file is written: no reading has this stamp
        fill_value=float("nan") if kind[0] == "f" else -(1 << 63),
        compressors=(BloscCodec(cname="zstd", clevel=3, shuffle="bitshuffle"), Crc32cCodec()),
        dimension_names=("reading", *axes)[-len(shape) :],
        attributes={"units": unit, "long_name": meaning},
    )


def create_arrays(group: Any, grid: Grid, readings: int) -> None:
    """Make room for the fields of so many readings in a Zarr group, and write what they share."""
    count = min(MOST, 1 << max(1, CHUNK_BYTES // (len(grid) * 20)).bit_length() - 1)
    for name, spec in SERIES.items():
        if name != "stamp_ns":
            shape = _shape(spec[1], grid)
            create_array(group, name, spec, (readings, *shape), (count, *shape))
    positions = grid.positions.reshape(*grid.shape, 3)
    create_array(group, "position", POSITION, positions.shape, positions.shape)
    group["position"][...] = positions


def _shape(axes: tuple[str, ...], grid: Grid) -> tuple[int, ...]:
    sizes = {"row": grid.shape[0], "column": grid.shape[1], "axis": 3}
    return tuple(sizes[axis] for axis in axes)


def load_zarr() -> Any:
    """The zarr package, loaded where it is used: it takes some tenths of a second."""
    import zarr

    return zarr
