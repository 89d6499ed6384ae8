"""Results folders: readings, settings and contacts as they are written, fields computed lazily.

    run.skinfield/
      results.zarr/      attributes: layout, grid, elastomer, solver; notes; source
        stamp_ns/        (T,) int64, ns
        readings/        (T, L) float64, in the quantity's unit; NaN where a taxel did not answer
        rest/            (R, 2, L) float64, where taxels rest as runs begin, where that is followed
        pressure/ pressure_std/ displacement/ position/      where fields are stored
      contacts.parquet/  one row per contact and reading: `estimate.contact_table.COLUMNS`

`save_results` and `skinfield reconstruct -o run.skinfield` write them, in Zarr format 3; every
chunk has a checksum. Fields that are not stored are computed from the readings when somebody looks
at them: `open_results` gives any slice of them as labelled arrays.
"""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import FileError, Floats, InputError, SkinfieldError, check_count, check_shape
from skinfield.estimate import Estimate
from skinfield.estimate.contact_table import (
    COLUMNS,
    KINDS,
    RELATIVE,
    Row,
    load_pyarrow,
    rows_from_estimate,
)
from skinfield.files.fields import SERIES, Arrays, create_array, create_arrays, load_zarr
from skinfield.files.pending import Pending, explained, pending
from skinfield.files.tables import arrow_schema, open_contacts
from skinfield.reconstruct import Reconstructor, Solver
from skinfield.reconstruct.reconstructor import checked_readings
from skinfield.reconstruct.serialisation import (
    ARRAYS,
    CONTACTS,
    ReconstructorConfig,
    attributes_from_results,
    results_from_attributes,
)
from skinfield.signal.creep import CreepCompensation
from skinfield.skin import Grid

if TYPE_CHECKING:
    import pyarrow
    import xarray

BLOCK = 4096  # readings of a chunk as it is written
RUN = 256  # readings that are answered one from the other
WARM = 32  # readings before a run, from which its first one starts
OUTPUTS = {"pressure": 1, "indentation": 1, "displacement": 3}  # fields, and numbers per node
TEXTS = {
    "pressure": ("Pa", "pressure, compression positive"),
    "indentation": ("m", "displacement into the skin along its normal"),
    "displacement": ("m", "displacement of the surface, in the patch's frame"),
}
_LOCK = threading.RLock()  # a reconstructor answers one at a time


class ResultsWriter:
    """Writes the readings of a recording as they come.

    Parameters
    ----------
    place : Pending
        Folder of results; it gets its name from whoever made the place.
    config : ReconstructorConfig
        If its layer creeps, readings are freed from that before they are written, and the folder's
        layer does not creep.
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
        self._creep = CreepCompensation.of(
            config.layer.relaxation, len(config.patch), config.quantity
        )
        self._creeps = config.layer.relaxation
        self.config = config = config.without_creep
        self.place, self.source = place, source
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
        readings = self._creep.taken(readings, ~np.isnan(readings), stamp_ns)
        self._waiting.append((stamp_ns, readings))
        self._count += len(readings)
        if self._count >= BLOCK:
            self._flush(self._count - self._count % BLOCK)  # no chunk is written twice

    def close(self, notes: tuple[str, ...] = ()) -> None:
        """Write what is left, and what was assumed, found and left out."""
        self._flush(self._count)
        if self._creeps is not None:
            part, seconds = 1.0 - self._creeps.relaxed_fraction, self._creeps.time_constant
            notes = (*notes, f"creep of {part:.1%} within {seconds:.3g} s is taken off")
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
        written = read_results(place.part)
        if reconstructor.layer.relaxation is None:
            written.reconstructor = reconstructor
        written.store_rest()
        place.commit()
    except BaseException:
        place.discard()
        raise


@dataclass(eq=False)
class Results:
    """Readings of a recording and what reconstructs them; it can be pickled.

    Attributes
    ----------
    config : ReconstructorConfig
        Patch, grid, solver and so on.
    path : str
        Of the folder.
    stamp_ns, readings : Zarr arrays (T,) and (T, L)
        As they are stored: see `stamps` and `values`.
    notes : tuple of str
        What was assumed, found and left out when the readings were conditioned.
    source : str
        Where the readings come from.
    stored : mapping
        Zarr arrays of the fields that are stored, by their name.
    rest : (R, 2, L) array
        Where taxels rest as the second run and those after it begin, and the variance of that.
    """

    config: ReconstructorConfig
    path: str
    stamp_ns: Any
    readings: Any
    notes: tuple[str, ...] = ()
    source: str = ""
    stored: Mapping[str, Any] = field(default_factory=dict)
    rest: Floats = field(default_factory=lambda: np.zeros((0, 2, 0)))

    def __len__(self) -> int:
        return int(self.readings.shape[0])

    def stamps(self, first: int, last: int) -> NDArray[np.int64]:
        """Of readings first to last, ns."""
        return np.asarray(self._rows(self.stamp_ns, first, last), np.int64)

    def values(self, first: int, last: int) -> Floats:
        """Readings first to last in the quantity's unit, (last - first, L); NaN where invalid."""
        return np.asarray(self._rows(self.readings, first, last), np.float64)

    def _rows(self, array: Any, first: int, last: int) -> Any:
        try:
            return array[first:last]
        except Exception as error:  # a codec raises what it likes
            raise FileError(
                f"{self.path}: readings {first} to {last} are not as they were written "
                f"({type(error).__name__}: {str(error)[:120]}), expected them unchanged"
            ) from error

    def __getstate__(self) -> dict[str, Any]:
        """Settings and where the readings are; nothing that was prepared."""
        return {name: vars(self)[name] for name in self.__dataclass_fields__}

    @cached_property
    def reconstructor(self) -> Reconstructor:
        """Prepared when it is first needed."""
        return self.config.reconstructor()

    def store_rest(self, step: Callable[[int], None] = lambda count: None) -> None:
        """Answer all readings in turn, and store where taxels rest as runs begin.

        Of solvers that follow it; `step` is called with the number of readings that are done.
        """
        plans = self.reconstructor.plans
        memory, rests = (
            plans.memory(),
            np.zeros(((len(self) - 1) // RUN, 2, len(self.config.patch))),
        )
        if memory.drift is None or not len(rests):
            return
        for run in range(len(rests)):
            begin = run * RUN
            values, stamps = self.values(begin, begin + RUN), self.stamps(begin, begin + RUN)
            for at, (reading, stamp) in enumerate(zip(values, stamps.tolist(), strict=True)):
                if at == RUN - WARM:
                    rests[run] = memory.drift.known
                valid = ~np.isnan(reading)
                memory.solve(plans.of(valid), reading, valid, stamp, None)
            step(begin + len(values))
        self.rest = rests
        group = load_zarr().open_group(Path(self.path) / ARRAYS, mode="r+")
        spec = ("f8", ("run", "moment", "taxel"), self.config.quantity.unit, "where runs begin")
        with explained(Path(self.path)):
            create_array(group, "rest", spec, rests.shape, rests.shape)
            group["rest"][...] = rests

    def estimate(self, reading: int) -> Estimate:
        """Everything of one reading, from those before it in its run.

        Raises
        ------
        InputError
            If there is no such reading.
        """
        check_count("reading", reading, -len(self), len(self) - 1, "one of the recording")
        at = reading % len(self)
        return self.estimates(at, at + 1)[0]

    def estimates(self, first: int, last: int) -> Estimate:
        """Readings first to last as one estimate, whose contacts are found when looked at.

        Runs begin at multiples of `RUN`, from the `WARM` readings before, and these from where
        taxels rest, so that what a reading gives does not depend on which others are wanted.
        """
        each: list[Estimate] = []
        with _LOCK:
            for begin in range(first - first % RUN, last, RUN):
                start, stop = max(begin - WARM, 0), min(begin + RUN, last)
                values, stamps = self.values(start, stop), self.stamps(start, stop)
                run = begin // RUN - 1
                self.reconstructor.plans.reset(
                    self.rest[run] if 0 <= run < len(self.rest) else None
                )
                found = self.reconstructor(values, stamp_ns=stamps)
                each += (found[at] for at in range(max(begin, first) - start, len(found)))
        return Estimate.joined(each, stamp_ns=self.stamps(first, last))

    def fields(self, first: int, last: int, precision: type[np.floating[Any]]) -> NDArray[Any]:
        """Fields of readings first to last, as `OUTPUTS` one after the other, (last - first, R)."""
        with _LOCK:
            estimate = self.estimates(first, last)
            found = [getattr(estimate, name).astype(precision) for name in OUTPUTS]
        return np.concatenate([values.reshape(last - first, -1) for values in found], axis=1)

    def dataset(self, precision: type[np.floating[Any]] = np.float32) -> "xarray.Dataset":
        """See `open_results`."""
        array, packages = _lazy_packages()
        grid, count, patch = self.config.grid, len(self), self.config.patch
        rows, columns = grid.shape
        lazy = self._stored(array) if self.stored else self._lazy(array, precision)
        dims = ("reading", "row", "column", "axis")
        units = {"Pa": RELATIVE, "N": RELATIVE} if self.config.relative else {}
        variables: dict[str, Any] = {
            name: (dims[: values.ndim], values, {"units": units.get(unit, unit), "long_name": text})
            for name, values in lazy.items()
            for unit, text in [TEXTS[name]]
        }
        force = self._blocks(array, self._forces, 1, np.float64)[:, 0]
        known = {
            "units": units.get("N", "N"),
            "long_name": "sum of the contacts, or of the field that answers",
        }
        variables["normal_force"] = ("reading", force, known)
        values = self._blocks(array, self.values, len(patch), np.float64)
        quantity = self.config.quantity
        said = {"units": quantity.unit, "long_name": f"{quantity.symbol} of the taxels"}
        variables["readings"] = (("reading", "taxel"), values, said)
        coords: dict[str, Any] = {
            "reading": ("reading", np.arange(count)),
            "stamp": ("reading", self.stamps(0, count), {"units": "ns"}),
            "taxel": ("taxel", np.arange(len(patch))),
            "taxel_position": (("taxel", "axis"), patch.positions, {"units": "m"}),
            "x": ("column", grid.origin[0] + np.arange(columns) * grid.pitch, {"units": "m"}),
            "y": ("row", grid.origin[1] + np.arange(rows) * grid.pitch, {"units": "m"}),
            "axis": ("axis", ["x", "y", "z"]),
            "position": (dims[1:], grid.positions.reshape(rows, columns, 3), {"units": "m"}),
        }
        attributes = {
            "patch": patch.name,
            "cell_area_m2": grid.cell_area,
            "solver": repr(self.config.solver),
            "layer": repr(self.config.layer),
            "source": self.source,
            "notes": list(self.notes),
        }
        dataset: xarray.Dataset = packages.Dataset(variables, coords, attributes)
        return dataset

    def _lazy(self, array: Any, precision: type[np.floating[Any]]) -> dict[str, Any]:
        """Fields that are computed, all at once."""
        nodes, shape = len(self.config.grid), (len(self), *self.config.grid.shape)
        load = partial(self.fields, precision=precision)
        table = self._blocks(array, load, nodes * sum(OUTPUTS.values()), precision)
        lazy, at = {}, 0
        for name, numbers in OUTPUTS.items():
            width, tail = nodes * numbers, (3,) if numbers == 3 else ()
            lazy[name] = table[:, at : at + width].reshape(*shape, *tail)
            at += width
        return lazy

    def _forces(self, first: int, last: int) -> Floats:
        """Normal forces of readings first to last, (last - first, 1) N."""
        return np.asarray(self.estimates(first, last).normal_force[:, None])

    def _blocks(self, array: Any, load: Any, width: int, kind: Any) -> Any:
        """Rows of all readings that are loaded run by run, as an array of Dask."""
        lengths = [min(RUN, len(self) - first) for first in range(0, len(self), RUN)]
        chunks = tuple(lengths), (width,)
        meta = np.empty((0, 0), kind)
        return array.map_blocks(partial(_chunk_of, load), chunks=chunks, dtype=kind, meta=meta)

    def _stored(self, array: Any) -> dict[str, Any]:
        """Fields as they are stored."""
        found = {name: array.from_zarr(self.stored[name]) for name in ("pressure", "displacement")}
        normals = self.config.grid.normals.reshape(*self.config.grid.shape, 3).astype(np.float32)
        return {**found, "indentation": -(found["displacement"] * normals).sum(axis=-1)}


def _chunk_of(load: Callable[[int, int], NDArray[Any]], block_info: Any = None) -> NDArray[Any]:
    """A chunk of rows of an array, for `dask.array.map_blocks`."""
    return load(*block_info[None]["array-location"][0])


def open_results(
    path: str | Path,
    *,
    solver: Solver | None = None,
    grid: Grid | None = None,
    precision: type[np.floating[Any]] = np.float32,
) -> "xarray.Dataset":
    """Open results: every field of every reading, computed when it is looked at.

    Parameters
    ----------
    path : str or Path
        The folder that was written, `run.skinfield`.
    solver : Solver, optional
        Answer the same readings by another one.
    grid : Grid, optional
        Answer on another one.
    precision : numpy.float32 or numpy.float64
        Of the fields.

    Returns
    -------
    xarray.Dataset
        Over reading, row, column, axis and taxel, with units as attributes: `pressure` Pa,
        `indentation` m, `displacement` m, `normal_force` N and `readings`, as arrays of Dask;
        "relative" where pressure and forces hold up to one factor;
        ``results.pressure[100:200].values`` computes what it needs. Its contacts: `load_contacts`.

    Raises
    ------
    FileError
        If it is no such folder, damaged, cut short, or of another version. Readings are checked
        when they are first read.
    SkinfieldError
        If xarray, dask or zarr is not installed.
    """
    return read_results(path, solver=solver, grid=grid).dataset(precision)


def load_contacts(path: str | Path, readings: slice = slice(None)) -> "pyarrow.Table":
    """Contacts of some readings of results, from the folder, or found now where it has none.

    Parameters
    ----------
    path : str or Path
        The folder that was written, `run.skinfield`.
    readings : slice
        Such as ``slice(1000, 2000)``, of step 1.

    Returns
    -------
    pyarrow.Table
        One row per contact and reading; a reading without a contact has none. Units stand in the
        names of the columns. ``to_pandas()`` makes a data frame of it.

    Raises
    ------
    FileError
        As `open_results`.
    SkinfieldError
        If pyarrow or zarr is not installed.
    """
    results, arrow = read_results(path), load_pyarrow()
    first, last, step = readings.indices(len(results))
    check_count("readings.step", step, 1, 1, "readings in a row")
    folder = Path(path) / CONTACTS
    if folder.is_dir():
        inside = [("reading", ">=", first), ("reading", "<", last)]
        try:
            return arrow.parquet.read_table(folder, filters=inside)
        except (OSError, ValueError, arrow.ArrowException) as error:
            raise FileError(f"{folder} cannot be read: {error}; is the folder whole?") from error
    start_ns = int(results.stamps(0, 1)[0])
    rows: list[Row] = []
    for begin in range(first, last, RUN):
        estimate = results.estimates(begin, min(begin + RUN, last))
        rows += rows_from_estimate(estimate, begin, start_ns)
    named = [dict(zip(COLUMNS, row, strict=True)) for row in rows]
    return arrow.Table.from_pylist(named, schema=arrow_schema(KINDS))


def read_results(
    path: str | Path,
    *,
    solver: Solver | None = None,
    grid: Grid | None = None,
    computed: bool = False,
) -> Results:
    """The readings of a folder of results, and what reconstructs them; see `open_results`.

    With `computed`, stored fields are not looked at: they may be incomplete.
    """
    attributes, arrays = _opened(path)
    config, notes, source = results_from_attributes(attributes, f"{path}/{ARRAYS}")
    stamps, readings = (_checked(path, arrays, name) for name in ("stamp_ns", "readings"))
    if readings.shape != (*stamps.shape, len(config.patch)) or not stamps.size:
        raise FileError(
            f"{path} holds {readings.shape} readings and {stamps.shape} stamps, expected one or "
            f"more of {len(config.patch)} taxels: cut short, or of other results"
        )
    stored = {}
    if "displacement" in arrays and not computed:
        stored = {name: _checked(path, arrays, name) for name in ("pressure", "displacement")}
    if solver is not None or grid is not None:
        config = replace(
            config,
            solver=config.solver if solver is None else solver,
            grid=config.grid if grid is None else grid.on(config.patch),
        )
        stored = {}
    rest = np.asarray(_checked(path, arrays, "rest")[...]) if "rest" in arrays else None
    if rest is None or rest.shape[1:] != (2, len(config.patch)):
        rest = np.zeros((0, 2, 0))
    return Results(config, str(path), stamps, readings, notes, source, stored, rest)


def _opened(path: str | Path) -> tuple[Any, dict[str, Any]]:
    """Attributes and arrays of a folder."""
    zarr = load_zarr()
    try:
        folder = Path(path).absolute() / ARRAYS
        if not (folder / "zarr.json").is_file():
            raise FileError(
                f"{folder} is no Zarr group, expected results that were written with "
                "skinfield reconstruct -o run.skinfield"
            )
        group = zarr.open_group(folder, mode="r", zarr_format=3)
        return group.attrs, dict(group.arrays())
    except FileError:
        raise
    except Exception as error:  # a damaged text raises whatever zarr makes of it
        raise FileError(
            f"{str(path)!r} cannot be opened: {str(error)[:200]}; expected results"
        ) from error


def _checked(path: str | Path, arrays: Mapping[str, Any], name: str) -> Any:
    """An array all of whose chunks are there."""
    kinds = {"stamp_ns": "int64", "readings": "float64", "rest": "float64"}
    kind = kinds.get(name, "float32")
    array = arrays.get(name)
    if array is None or str(array.dtype) != kind:
        raise FileError(f"{path} holds no {name} of {kind}, expected them: is the folder whole?")
    if array.nchunks_initialized != array.nchunks:
        raise FileError(
            f"{path}/{ARRAYS}/{name} has {array.nchunks_initialized} of {array.nchunks} chunks, "
            "expected all: cut short"
        )
    return array


def _lazy_packages() -> tuple[Any, Any]:
    try:
        import dask.array
        import xarray
    except ImportError as error:
        raise SkinfieldError(
            f"results need {error.name}, which is not installed: pip install 'skinfield[batch]'"
        ) from error
    return dask.array, xarray
