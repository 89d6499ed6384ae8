"""Reconstruction jobs: intake of a recording, its windows, and many of them on Dask.

A recording is read and conditioned in one pass, whatever its length; its windows are then
reconstructed one by one, here or by workers. A manifest says which windows are complete, so that a
run that was ended goes on where it was.
"""

import logging
import os
import secrets
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from skinfield.cli.options import (
    OF_UNIT,
    CountSettings,
    conditioning_of,
    mechanics_of,
    nodes_for,
    patch_of,
    quantity_of,
    skin_from_text,
    solver_of,
)
from skinfield.cli.report import progress
from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, SkinfieldError
from skinfield.estimate import ContactFinder
from skinfield.estimate.contact_table import Row, rows_from_estimate
from skinfield.files.fields import Arrays, series_of
from skinfield.files.manifest import Manifest, Totals
from skinfield.files.pending import Pending, explained
from skinfield.files.results import Results, read_results
from skinfield.files.results_writer import (
    ResultsWriter,
    create_fields,
    write_contacts_at,
    write_fields_at,
)
from skinfield.reconstruct.bulk import CHUNK, RUN
from skinfield.reconstruct.conditioned import impossible_note
from skinfield.reconstruct.diagnostics import Conditioning, Survey, survey
from skinfield.reconstruct.serialisation import ReconstructorConfig, checksum, plain_from_value
from skinfield.signal import NoFilter
from skinfield.skin import Grid, Patch
from skinfield.skin.reading import Recording

PIECE = 1 << 20  # numbers that are conditioned together: 8 MB
FEWEST, MOST = 2048, 16384  # readings that are: enough to see motion, and what stands still
STEPS = {"linear": CHUNK, "iterative": 2 * RUN}  # readings that are answered together
OF_CONDITIONING = ("board", "no_load", "gain", "calibration", "smoothing_ms", "noise")
OF_MODEL = ("grid", "solver", "mechanics", "quantity", "thickness_mm", "modulus_kpa", "poisson")


class RowsFile:
    """Stamps and numbers of many readings in files without name.

    Parameters
    ----------
    folder : Path
        Where there is room.
    width : int
        Numbers of a reading.
    """

    def __init__(self, folder: Path, width: int) -> None:
        self.width, self._count = width, 0
        self._stamps = TemporaryFile(dir=folder)  # noqa: SIM115
        self._values = TemporaryFile(dir=folder)  # noqa: SIM115

    def __len__(self) -> int:
        return self._count

    def write(self, stamp_ns: NDArray[np.int64], values: Floats) -> None:
        """Add readings (T, width) with their stamps (T,)."""
        for file, rows, kind in ((self._stamps, stamp_ns, "i8"), (self._values, values, "f8")):
            file.seek(0, os.SEEK_END)
            file.write(np.ascontiguousarray(rows, kind).data)
        self._count += len(stamp_ns)

    def stamps(self, first: int, last: int) -> NDArray[np.int64]:
        """Of readings first to last, ns."""
        return np.asarray(self._rows(self._stamps, np.empty(last - first, np.int64), first))

    def values(self, first: int, last: int) -> Floats:
        """Readings first to last, (last - first, width)."""
        return np.asarray(self._rows(self._values, np.empty((last - first, self.width)), first))

    @staticmethod
    def _rows(file: Any, out: NDArray[Any], first: int) -> NDArray[Any]:
        file.seek(first * out.itemsize * (out.size // max(len(out), 1)))
        file.readinto(out.data)
        return out


class ResultsFile(RowsFile):
    """Conditioned readings in files without name, until the end of the run."""

    def __init__(self, folder: Path, config: ReconstructorConfig, source: str) -> None:
        super().__init__(folder, len(config.patch))
        self.results = Results(config, self, source=source)

    def close(self, notes: tuple[str, ...] = ()) -> None:
        """Add what was assumed, found and left out."""
        self.results.notes = notes


class Writer(Protocol):
    """Takes conditioned readings: a `ResultsWriter` or a `ResultsFile`."""

    def write(self, stamp_ns: NDArray[np.int64], readings: Floats, /) -> None:
        """Add readings (T, L) with their stamps (T,)."""
        ...

    def close(self, notes: tuple[str, ...] = ()) -> None:
        """Finish, with what was assumed, found and left out."""
        ...


@dataclass(eq=False)
class Spool:
    """A recording's numbers in a file, in the order of the patch's taxels."""

    patch: Patch
    rows: RowsFile
    like: Recording | None = None
    notes: tuple[str, ...] = ()
    skipped: int = 0
    divisor: int = 1

    def add(self, block: Recording) -> None:
        """Append readings."""
        from skinfield.files import readings_for

        mine = readings_for(block, self.patch)
        self.rows.write(mine.stamp_ns, mine.counts)
        if self.like is None:
            self.like = replace(mine, stamp_ns=mine.stamp_ns[:0], counts=mine.counts[:0])
            self.notes = mine.notes[len(block.notes) :]

    def blocks(self) -> Iterator[Recording]:
        """All of it again, in blocks of one size, but for the last: a short rest joins it."""
        assert self.like is not None
        size = int(np.clip(PIECE // len(self.patch), FEWEST, MOST))
        count, first = len(self.rows), 0
        while first < count:
            last = first + size if count - first >= 2 * size else count
            stamps = self.rows.stamps(first, last) // self.divisor
            yield replace(self.like, stamp_ns=stamps, counts=self.rows.values(first, last))
            first = last


def take_in(
    recording: str,
    options: Mapping[str, Any],
    folder: Path,
    writer_of: Callable[[ReconstructorConfig, str], Writer],
    *,
    quiet: bool = False,
) -> int:
    """Read and condition a recording in one pass.

    Parameters
    ----------
    recording : str
    options : mapping
        Of the command: layout, patch, model and conditioning.
    folder : Path
        With room for the recording's numbers.
    writer_of : function of config and source
        Makes what takes the conditioned readings.
    quiet : bool
        No progress is shown.

    Returns
    -------
    int
        Lines that were skipped.
    """
    patch = patch_of(skin_from_text(options["layout"]), options["patch"])
    layer = Layer(options["thickness_mm"] * 1e-3, options["modulus_kpa"] * 1e3, options["poisson"])
    grid = Grid.square(patch, nodes=options["grid"] or nodes_for(patch))
    how = conditioning_of(patch, CountSettings(**{name: options[name] for name in OF_CONDITIONING}))
    with explained(folder), Progress(disable=True) if quiet else progress() as bar:
        spool = _spooled(recording, Spool(patch, RowsFile(folder, len(patch))), bar)
        assert spool.like is not None
        unit = spool.like.unit
        name = options["quantity"] or OF_UNIT[unit]
        quantity = quantity_of(name)
        bar.add_task("looking for rest and faults", total=None)
        found = survey(spool.blocks, patch, layer, quantity, how)
        config = ReconstructorConfig(
            patch,
            layer,
            grid,
            mechanics_of(options["mechanics"]),
            quantity,
            solver_of(options["solver"]),
            found.noise_std,
            ContactFinder(),
        )
        _condition(spool, found, how, writer_of(config, spool.like.source))
    return spool.skipped


def _spooled(recording: str, spool: Spool, bar: Progress) -> Spool:
    """Everything that a recording holds, parsed once."""
    from skinfield.files import stream_recording

    task = bar.add_task("reading", total=None)
    opened = stream_recording(
        recording, progress=lambda done, total: bar.update(task, completed=done, total=total)
    )
    if isinstance(opened, Recording):
        for first in range(0, len(opened), MOST):
            part = slice(first, first + MOST)
            spool.add(replace(opened, stamp_ns=opened.stamp_ns[part], counts=opened.counts[part]))
    else:
        for block in opened.blocks():
            spool.add(block)
        spool.divisor = opened.divisor
    spool.notes, spool.skipped = opened.notes + spool.notes, opened.skipped
    if spool.like is None:
        raise InputError(f"{recording} holds no reading, expected one or more")
    bar.remove_task(task)
    return spool


def _condition(spool: Spool, found: Survey, how: Conditioning, writer: Writer) -> None:
    """Condition block by block; a filter's state goes on from each to the next."""
    assert spool.like is not None
    state = None
    if not isinstance(how.filter, NoFilter):
        state = how.filter.prepare(len(spool.patch), found.rate)
    impossible, dropped, count = 0, 0, 0
    for block in spool.blocks():
        values, low = found.conditioner.counted(block.counts)
        if state is not None:
            values = values.copy()
            for row in values:
                state.apply(row, row)
        there = np.asarray(~np.isnan(values).all(axis=1))
        writer.write(block.stamp_ns[there], values[there])
        impossible, dropped = impossible + low, dropped + int((~there).sum())
        count += len(there)
    if dropped == count:
        raise InputError(
            f"{spool.like.source} has no reading with a valid taxel, expected some: "
            "check the layout, the board's convention and the calibration"
        )
    quantity = found.conditioner.quantity
    notes = (*spool.notes, *found.notes, *impossible_note(impossible, quantity))
    if dropped:
        notes += (f"{dropped} of {count} readings have no valid taxel: left out",)
    writer.close(notes)


@dataclass(frozen=True, eq=False)
class Part:
    """What some readings give: totals, rows for a table of contacts, fields if they are wanted."""

    totals: Totals
    rows: list[Row]
    series: Arrays | None


def parts(results: Results, readings: range, fields: bool) -> Iterator[Part]:
    """Reconstruct readings in a row, step by step; steps begin at multiples of their size.

    Runs of an iterative solver begin at multiples of their size, too, so that what a reading gives
    depends on neither steps nor windows.
    """
    names = ("pressure", "displacement") if fields else ("pressure",)
    size = STEPS["linear" if results.bulk(names).is_linear else "iterative"]
    start_ns = int(results.readings.stamps(0, 1)[0])
    first = readings.start
    while first < readings.stop:
        last, begun = min(first - first % size + size, readings.stop), time.perf_counter()
        estimate = results.estimates(first, last, names)
        force = estimate.pressure.sum(axis=1, dtype=np.float64) * results.config.grid.cell_area
        load = np.array([sum(c.normal_force for c in each) for each in estimate.contacts])
        rows = list(rows_from_estimate(estimate, first, start_ns))
        series = series_of(estimate) if fields else None
        best = int(np.argmax(load))
        totals = Totals(
            readings=last - first,
            load=float(load.sum()),
            highest_load=float(load[best]),
            peak=first + best,
            force=float(force.sum()),
            highest_force=float(force.max()),
            contacts=sum(map(len, estimate.contacts)),
            seconds=time.perf_counter() - begun,
            silent=np.flatnonzero(~estimate.valid.any(axis=0)).tolist(),
        )
        yield Part(totals, rows, series)
        first = last


# ---- jobs of workers


def intake_job(recording: str, options: Mapping[str, Any], part: str, fields: bool) -> list[int]:
    """Read and condition a recording into a folder of results; its readings and skipped lines."""
    place = Pending(Path(part), Path(part))
    place.discard()  # of a run that was ended
    try:
        skipped = take_in(
            recording,
            options,
            place.part.parent,
            lambda config, source: ResultsWriter(place, config, source),
            quiet=True,
        )
        results = read_results(place.part, computed=True)
        if fields:
            create_fields(place.part, results.config.grid, len(results))
    except BaseException:
        place.discard()
        raise
    return [len(results), skipped]


def window_job(part: str, token: str, first: int, last: int, fields: bool) -> dict[str, Any]:
    """Reconstruct readings first to last of a folder of results into it; their totals."""
    totals, rows, at = Totals(), [], first
    for each in parts(_prepared(part, token), range(first, last), fields):
        if each.series is not None:
            write_fields_at(Path(part), at, each.series)
        totals.add(each.totals)
        rows += each.rows
        at += each.totals.readings
    write_contacts_at(Path(part), first, rows, last - first)
    return asdict(totals)


@lru_cache(maxsize=4)
def _prepared(part: str, token: str) -> Results:
    """Results whose reconstructor serves all windows of this process; `token` is of one run."""
    return read_results(part, computed=True)


# ---- Dask


def settings_of(options: Mapping[str, Any]) -> dict[str, Any]:
    """What results depend on, beside the recordings: options, layout and calibration."""
    patch = patch_of(skin_from_text(options["layout"]), options["patch"])
    how = conditioning_of(patch, CountSettings(**{name: options[name] for name in OF_CONDITIONING}))
    return {
        **{name: options[name] for name in (*OF_CONDITIONING, *OF_MODEL, "store_fields")},
        "layout": options["layout"],
        "patch": patch.name,
        "layout_checksum": checksum(plain_from_value("patch", patch)),
        "calibration_checksum": checksum(plain_from_value("calibration", how.calibration)),
    }


Watch = Callable[[str, str, int], None]  # "intake" or "window", name, readings


def run_jobs(
    manifest: Manifest, options: Mapping[str, Any], client: Any, watch: Watch
) -> dict[str, str]:
    """Do what a manifest lacks, on the workers of a Dask client.

    Parameters
    ----------
    manifest : Manifest
        Kept up to date.
    options : mapping
        Of the command.
    client : distributed.Client
        Its workers see the files under the same names.
    watch : function of kind, name and readings
        Called once a recording was taken in, and for each window.

    Returns
    -------
    dict
        What went wrong, by the recordings' names; the others are complete.
    """
    from distributed import as_completed

    fields, token = bool(options["store_fields"]), secrets.token_hex(8)
    jobs: dict[str, tuple[str, int | None]] = {}
    failures: dict[str, str] = {}
    queue: Any = as_completed()  # type: ignore[no-untyped-call]

    def submit(name: str, first: int | None, job: Callable[..., Any], *words: Any) -> None:
        future = client.submit(job, *words, pure=False)
        jobs[future.key] = name, first
        queue.add(future)

    def submit_windows(name: str) -> None:
        entry, part = manifest.entries[name], str(manifest.part(name).resolve())
        for first, last in entry.left():
            submit(name, first, window_job, part, token, first, last, fields)

    for name in manifest.names:
        entry = manifest.entries[name]
        if entry.readings < 0:
            part = str(manifest.part(name).resolve())
            submit(name, None, intake_job, entry.path, options, part, fields)
            continue
        watch("intake", name, entry.readings)
        for window in entry.windows.values():
            watch("window", name, window["readings"])
        submit_windows(name)
    for future in queue:
        name, begun = jobs.pop(future.key)
        entry, error = manifest.entries[name], future.exception()
        if error is not None:
            failures.setdefault(name, _sentence(error))
            continue
        result = future.result()
        if begun is None:
            entry.readings, entry.skipped = result
            watch("intake", name, entry.readings)
            submit_windows(name)
        else:
            entry.windows[str(begun)] = result
            watch("window", name, result["readings"])
        if entry.left():
            manifest.save()
        else:
            manifest.settle()
    return failures


def _sentence(error: BaseException) -> str:
    """What went wrong, for the user."""
    from distributed import KilledWorker

    if isinstance(error, SkinfieldError):
        return str(error)
    if isinstance(error, KilledWorker):
        return (
            "workers died on it again and again, mostly because memory ran out: take fewer "
            "--workers"
        )
    return f"{type(error).__name__}: {error}"


@contextmanager
def dask_client(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """A client of a scheduler that runs elsewhere, or of as many local processes as are wanted.

    Raises
    ------
    InputError
        If there is no scheduler.
    SkinfieldError
        If dask is not installed.
    """
    try:
        import distributed
    except ImportError as error:
        raise SkinfieldError(
            f"several recordings need {error.name}, which is not installed: "
            "pip install 'skinfield[batch]', or give one recording and -o contacts.csv"
        ) from error
    dask: Any = distributed  # its functions have no types
    if scheduler is not None:
        try:
            client = dask.Client(scheduler, timeout="10s")
        except (OSError, ValueError) as error:
            raise InputError(
                f"--scheduler is {scheduler!r}, where nobody answers ({error}); expected the "
                "address of a Dask scheduler such as tcp://10.0.0.1:8786"
            ) from error
        with client:
            yield client
        return
    local = dask.LocalCluster(
        n_workers=workers or cores(),
        threads_per_worker=1,
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL,
    )
    with local, dask.Client(local) as client:
        yield client


def cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1
