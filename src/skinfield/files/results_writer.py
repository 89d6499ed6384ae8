"""Results folder: a Zarr group of readings, fields and settings, and contacts as Parquet.

    run.skinfield/
      results.zarr/      attributes: layout, grid, elastomer, solver; notes; source
        stamp_ns/        (T,) int64, ns
        readings/        (T, L) float64, in the quantity's unit; NaN where a taxel did not answer
        pressure/ pressure_std/ displacement/ position/      where fields are stored
      contacts.parquet/  one row per contact and reading: `estimate.contact_table.COLUMNS`

It is of Zarr format 3; every chunk has a checksum. Fields that are not stored are computed from the
readings when somebody looks at them: `open_results`.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, check_shape
from skinfield.estimate.contact_table import Row
from skinfield.files.fields import SERIES, Arrays, create_array, create_arrays, load_zarr
from skinfield.files.pending import Pending, explained, pending
from skinfield.files.tables import open_contacts
from skinfield.reconstruct import Reconstructor
from skinfield.reconstruct.serialisation import (
    ARRAYS,
    CONTACTS,
    ReconstructorConfig,
    attributes_from_results,
)
from skinfield.skin import Grid

BLOCK = 4096  # readings of a chunk


class ResultsWriter:
    """Writes the readings of a recording as they come.

    Parameters
    ----------
    place : Pending
        Folder of results; it gets its name from whoever made the place.
    config : ReconstructorConfig
    source : str
        Where the readings come from.

    Raises
    ------
    InputError
        If a part of the reconstructor is not skinfield's own.
    FileError
        If the folder cannot be made.
    SkinfieldError
        If zarr is not installed.
    """

    def __init__(self, place: Pending, config: ReconstructorConfig, source: str = "") -> None:
        self.place, self.config, self.source = place, config, source
        attributes = attributes_from_results(config, (), source)
        zarr, taxels = load_zarr(), len(config.patch)
        with explained(place.target):
            place.part.mkdir()
            self._group = zarr.create_group(place.part / ARRAYS, attributes=attributes)
            create_array(self._group, "stamp_ns", SERIES["stamp_ns"], (0,), (BLOCK,))
            spec = ("f8", ("taxel",), config.quantity.unit, "of the taxels")
            create_array(self._group, "readings", spec, (0, taxels), (BLOCK, taxels))
        self._waiting: list[tuple[NDArray[np.int64], Floats]] = []
        self._count = 0

    def write(self, stamp_ns: NDArray[np.int64], readings: Floats) -> None:
        """Add readings (T, L), in the quantity's unit, with their stamps (T,).

        Raises
        ------
        FileError
            If they cannot be written.
        """
        check_shape("readings", readings, (None, len(self.config.patch)), "one number per taxel")
        check_shape("stamp_ns", stamp_ns, (len(readings),), "one per reading")
        self._waiting.append((stamp_ns, readings))
        self._count += len(readings)
        if self._count >= BLOCK:
            self._flush(self._count - self._count % BLOCK)  # no chunk is written twice

    def close(self, notes: tuple[str, ...] = ()) -> None:
        """Write what is left, and what was assumed, found and left out."""
        self._flush(self._count)
        if not self._group["stamp_ns"].shape[0]:
            raise InputError("no reading was written, expected one or more")
        with explained(self.place.target):
            self._group.update_attributes(attributes_from_results(self.config, notes, self.source))

    def _flush(self, count: int) -> None:
        if not self._waiting:
            return
        stamps, readings = (np.concatenate(each) for each in zip(*self._waiting, strict=True))
        self._waiting, self._count = [(stamps[count:], readings[count:])], len(stamps) - count
        with explained(self.place.target):
            self._group["stamp_ns"].append(stamps[:count])
            self._group["readings"].append(readings[:count])


def create_fields(path: Path, grid: Grid, readings: int) -> None:
    """Make room for the fields of all readings in a folder of results."""
    with explained(path):
        create_arrays(load_zarr().open_group(path / ARRAYS, mode="r+"), grid, readings)


def write_fields_at(path: Path, first: int, series: Arrays) -> None:
    """Write fields of readings from `first` on, which begins a chunk, into a folder of results.

    Parameters
    ----------
    path : Path
    first : int
    series : dict of arrays
        See `files.fields.series_of`.
    """
    group = load_zarr().open_group(path / ARRAYS, mode="r+")
    with explained(path):
        for name, values in series.items():
            if name != "stamp_ns":
                group[name][first : first + len(values)] = values


def write_contacts_at(path: Path, first: int, rows: Sequence[Row]) -> None:
    """Write the table of contacts of readings from `first` on into a folder of results."""
    folder = path / CONTACTS
    with explained(path):
        folder.mkdir(exist_ok=True)
    with open_contacts(folder / f"{first:012d}.parquet") as writer:
        writer.write_rows(rows)


def save_results(
    path: str | Path,
    reconstructor: Reconstructor,
    readings: ArrayLike,
    stamp_ns: ArrayLike | None = None,
    *,
    notes: tuple[str, ...] = (),
    source: str = "",
) -> None:
    """Write readings with what reconstructs them; `open_results` computes the rest.

    Parameters
    ----------
    path : str or Path
        Ends in `.skinfield`.
    reconstructor : Reconstructor
    readings : (T, L) array, in the quantity's unit
        NaN marks a taxel that did not answer; each with a valid taxel.
    stamp_ns : (T,) array, ns, optional
        Default the number of the reading.
    notes : tuple of str
        What was assumed, found and left out.
    source : str
        Where the readings come from.

    Raises
    ------
    InputError
        For another extension, readings that no skin has, or a solver that no file can hold.
    FileError
        If the folder cannot be written.
    SkinfieldError
        If zarr is not installed.
    """
    from skinfield.reconstruct.reconstructor import checked_readings

    table, _ = checked_readings(readings, None, reconstructor.patch, reconstructor.quantity)
    stamps = np.arange(len(table)) if stamp_ns is None else np.asarray(stamp_ns)
    check_shape("stamp_ns", stamps, (len(table),), "one per reading")
    if stamps.dtype.kind not in "iu":
        raise InputError(f"stamp_ns holds {stamps.dtype}, expected whole nanoseconds")
    if int(stamps.max()) > np.iinfo(np.int64).max:
        raise InputError(f"stamp_ns reaches {stamps.max()}, expected nanoseconds below 2**63")
    if Path(path).suffix.lower() != ".skinfield":
        raise InputError(f"path is {str(path)!r}, expected a name that ends in .skinfield")
    place = pending(path)
    try:
        writer = ResultsWriter(place, ReconstructorConfig.of(reconstructor), source)
        writer.write(stamps.astype(np.int64), table)
        writer.close(notes)
        place.commit()
    except BaseException:
        place.discard()
        raise
