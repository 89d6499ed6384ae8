"""Fields of every reading, to NPZ or Zarr."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

from skinfield.errors import InputError
from skinfield.fields import Estimate
from skinfield.layout import Grid
from skinfield.sinks.field_series import SERIES, Arrays, readings_per_chunk, series_of
from skinfield.sinks.field_stores import NpzStore, ZarrStore, load_zarr
from skinfield.sinks.pending import pending
from skinfield.sinks.sink import Closing


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
        """Add what `field_series.series_of` makes of an estimate, perhaps in another process."""
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
