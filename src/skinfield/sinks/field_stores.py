"""Files of fields: NPZ and Zarr."""

import json
from contextlib import suppress
from dataclasses import dataclass, field
from shutil import copyfileobj
from tempfile import TemporaryFile
from typing import IO, Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from skinfield.errors import SkinfieldError
from skinfield.layout import Grid
from skinfield.sinks.field_series import (
    FIXED,
    SERIES,
    Arrays,
    attributes_of,
    fixed_of,
    readings_per_chunk,
)
from skinfield.sinks.pending import Pending, explained


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
        rows, columns = self.grid.shape
        sizes = {"row": rows, "column": columns, "axis": 3}
        kind, axes, _, _ = SERIES[name]
        shape = (self.readings, *(sizes[axis] for axis in axes))
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
        rows, columns = grid.shape
        sizes = {"row": rows, "column": columns, "axis": 3}
        count = readings_per_chunk(grid)
        with explained(self.place.target):
            self.group = self.zarr.create_group(self.place.part, attributes=attributes_of(grid))
            for name, spec in SERIES.items():
                shape = tuple(sizes[axis] for axis in spec[1])
                self._create(name, spec, ("reading",), (0, *shape), (count, *shape))
            for name, spec in FIXED.items():
                shape = tuple(sizes[axis] for axis in spec[1])
                self._create(name, spec, (), shape, shape)
                self.group[name][...] = fixed_of(grid)[name]

    def _create(
        self,
        name: str,
        spec: tuple[str, tuple[str, ...], str, str],
        lead: tuple[str, ...],
        shape: tuple[int, ...],
        chunks: tuple[int, ...],
    ) -> None:
        kind, axes, unit, meaning = spec
        self.group.create_array(
            name,
            shape=shape,
            chunks=chunks,
            dtype=kind,
            dimension_names=(*lead, *axes),
            attributes={"units": unit, "long_name": meaning},
        )

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


def load_zarr() -> Any:
    """The zarr package; raises SkinfieldError if it is not installed."""
    try:
        import zarr
    except ImportError as error:
        raise SkinfieldError(
            "Zarr needs zarr, which is not installed: pip install 'skinfield[zarr]', or write .npz"
        ) from error
    return zarr
