"""Reconstruction jobs: intake of a recording, its windows, and many of them on Dask.

A recording is read and conditioned in one pass, whatever its length; its windows are then
reconstructed one by one, here or by workers. A manifest says which windows are complete, so that a
run that was ended goes on where it was.
"""

import json
import logging
import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.cli.settings import Elastomer, ModelSettings, Settings
from skinfield.errors import Floats, InputError, SkinfieldError
from skinfield.estimate.contact_table import RELATIVE, scale_of
from skinfield.files import rows_from_estimate
from skinfield.files.fields import Arrays, series_of
from skinfield.files.manifest import Manifest, Totals
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.pending import Pending, explained, pending
from skinfield.files.recordings.spool import Spool
from skinfield.files.results import (
    RUN,
    Results,
    ResultsWriter,
    create_fields,
    read_results,
    write_contacts_at,
    write_fields_at,
)
from skinfield.loop.model_config import ModelConfig
from skinfield.plot import plural
from skinfield.reconstruct.diagnostics import Conditioning, Survey, impossible_note, survey
from skinfield.reconstruct.serialisation import checksum, plain_from_value
from skinfield.settings import json_from_value
from skinfield.signal import NoFilter
from skinfield.skin import Patch
from skinfield.skin.log import LogSettings

RECORDING = (
    Column("recording", "recording"), Column("readings", "readings", decimals=0),
    Column("s", "duration_s", decimals=2), Column("skipped", "skipped_lines", decimals=0),
    Column("left out", "taxels_left_out", decimals=0), Column("contacts", "contacts", decimals=0),
    Column("highest N", "highest_force_N", decimals=2),
    Column("at reading", "highest_force_reading", decimals=0),
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class JobPlan:
    """What a reconstruction depends on beside the recording; another process can be sent it.

    Its sections are whole: what was left out is the profile's.
    """

    layout: str
    patch: Patch
    counts: options.CountSettings
    elastomer: Elastomer
    model: ModelSettings
    assumed: tuple[str, ...] = ()  # of "gain" and "modulus", which give the scale of forces
    log: LogSettings = field(default_factory=LogSettings)  # how the recording is read

    @classmethod
    def of(
        cls,
        layout: str,
        patch: str | None,
        counts: options.CountSettings,
        elastomer: Elastomer,
        model: ModelSettings,
    ) -> "JobPlan":
        """Plan with the values of the profile in use, which is named on stderr.

        A layout that is a recording of a live skin brings its settings and calibration; one that
        is a skin's file, its settings and how its logs are read.
        """
        own, log = options.own_settings(layout), LogSettings()
        if own is not None:
            known, log = own
            counts, elastomer, model = _with_own(known, log, counts, elastomer, model)
        board, given, scale = None if counts.board == "auto" else counts.board, elastomer, counts
        recorded = options.settings_in(layout) if layout.lower().endswith(options.LIVE) else None
        if recorded is None:
            profile = options.profile_in_use(elastomer, board, layout)
        else:
            hardware, its = board or recorded.source.hardware, recorded.skin
            elastomer = options.with_own(elastomer, its)
            if counts.gain is None and counts.calibration is None:
                counts = replace(counts, gain=its.gain, calibration=layout)
            counts = replace(counts, no_load=counts.no_load or its.no_load)
            named = scale.calibration or its.calibration  # what it has enclosed may be a tare
            scale = replace(scale, gain=scale.gain or its.gain, calibration=named)
            if its.calibration is not None:
                live = ModelConfig.from_json(json.dumps(LiveRecording.open(layout).configuration))
                elastomer, model = options.by_model(live.layer, live.mechanics, elastomer, model)
            profile = options.profile_in_use(elastomer, hardware, its.first)
        elastomer, model, skin = options.by_touch(counts.calibration, elastomer, model)
        assumed = options.assumed_of(scale, given, skin)
        if recorded is not None and given.modulus_kpa is None and skin is None:
            assumed = assumed if LiveRecording.open(layout).relative else ()  # as it was live
        if counts.calibration:  # workers run in other folders
            counts = replace(counts, calibration=str(Path(counts.calibration).resolve()))
        model = replace(model, solver=model.solver or options.USUAL_SOLVER)
        if "gain" in assumed:
            counts = replace(counts, gain=log.gain)
        return cls(
            layout=layout,
            patch=options.patch_of(options.skin_from_text(layout), patch),
            counts=options.filled(counts, profile),
            elastomer=replace(options.filled(elastomer, profile), profile=profile.name),
            model=options.filled(model, profile),
            assumed=assumed,
            log=log,
        )

    def as_dict(self) -> dict[str, Any]:
        """Its values by their names, without their sections."""
        sections = (self.counts, self.elastomer, self.model)
        values = {name: value for each in sections for name, value in asdict(each).items()}
        return values | {"layout": self.layout}

    def settings(self, store_fields: bool) -> dict[str, Any]:
        """What a manifest keeps: values, with sums of what the files hold that they name."""
        calibration = options.conditioning_of(self.patch, self.counts).calibration
        values = self.as_dict()
        del values["profile"], values["layout"]
        return values | {
            "log": json.loads(json_from_value(self.log)),
            "store_fields": store_fields,
            "patch": self.patch.name,
            "layout_checksum": checksum(plain_from_value("patch", self.patch)),
            "calibration_checksum": checksum(plain_from_value("calibration", calibration)),
        }


def _with_own(
    known: Settings,
    log: LogSettings,
    counts: options.CountSettings,
    elastomer: Elastomer,
    model: ModelSettings,
) -> tuple[options.CountSettings, Elastomer, ModelSettings]:
    """What a skin's file knows for what is not set."""
    told, board = counts.gain is not None or counts.calibration is not None, counts.board
    its = replace(known.skin, gain=None, calibration=None) if told else known.skin
    counts = options.with_own(counts, its)
    if board == "auto":
        counts = replace(counts, board=log.board)
    return counts, options.with_own(elastomer, its), options.with_own(model, known.model)


@contextmanager
def place_of(store: str | None, parent: Path | None = None) -> Iterator[Pending]:
    """Where a recording is taken in: results of this name, or a folder that goes away."""
    if store is None:
        with TemporaryDirectory(prefix=".skinfield-", dir=parent) as folder:
            yield Pending(Path(folder) / "readings", Path(folder) / "readings")
        return
    place = pending(store)
    try:
        yield place
        place.commit()
    except BaseException:
        place.discard()
        raise


def take_in(
    recording: str, plan: JobPlan, place: Pending, *, quiet: bool = False
) -> tuple[Results, int]:
    """Read and condition a recording in one pass, into a folder of results; follow its rest.

    Beside the place's part there is room for the recording's numbers. Returns the results, and the
    number of lines that were skipped.
    """
    patch, layer = plan.patch, options.layer_of(plan.elastomer)
    counts, folder = plan.counts, place.part.parent
    if all((name or "").lower().endswith(options.LIVE) for name in (counts.calibration, recording)):
        counts = replace(counts, calibration=recording)  # each has its own
    if recording.lower().endswith(options.LIVE) and plan.log.columns:  # no log of its own
        counts = replace(counts, board="auto", gain=None if "gain" in plan.assumed else counts.gain)
    how = options.conditioning_of(patch, counts)
    with explained(folder), report.progress("reading", quiet=quiet) as step:
        spool = Spool(recording, patch, folder, step, plan.log)
        quantity = options.quantity_of(plan.model.quantity or options.OF_UNIT[spool.like.unit])
        step(0, what="looking for rest and faults")
        found = survey(spool.blocks, patch, layer, quantity, how)
        relative = options.is_relative(plan.assumed, spool.like.unit)
        config = options.config_of(patch, layer, quantity, found.noise_std, plan.model, relative)
        writer = ResultsWriter(place, config, spool.like.source)
        _condition(spool, found, how, writer)
    results = read_results(place.part)
    if len(results) > RUN:
        with report.progress("following rest", len(results), quiet=quiet) as step:
            results.store_rest(step)
    return results, spool.skipped


def _condition(spool: Spool, found: Survey, how: Conditioning, writer: ResultsWriter) -> None:
    """Condition block by block; a filter's state goes on from each to the next."""
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


class PartialResults(NamedTuple):
    """What some readings give."""

    totals: Totals
    force: Floats  # (T,) N, of each reading
    rows: list[tuple[int | float | str | None, ...]]  # of a table of contacts
    series: Arrays | None  # fields, if they are wanted


def parts(results: Results, readings: range, fields: bool) -> Iterator[PartialResults]:
    """Reconstruct readings in a row, run by run; runs begin at multiples of their size.

    So what a reading gives does not depend on the windows.
    """
    start_ns = int(results.stamps(0, 1)[0])
    first = readings.start
    while first < readings.stop:
        last, begun = min(first - first % RUN + RUN, readings.stop), time.perf_counter()
        estimate = results.estimates(first, last)
        force = estimate.normal_force
        rows = list(rows_from_estimate(estimate, first, start_ns))
        series = series_of(estimate) if fields else None
        best = int(np.argmax(force))
        totals = Totals(
            readings=last - first,
            force=float(force.sum()),
            highest_force=float(force[best]),
            peak=first + best,
            contacts=sum(map(len, estimate.contacts)),
            seconds=time.perf_counter() - begun,
            silent=np.flatnonzero(~estimate.valid.any(axis=0)).tolist(),
        )
        yield PartialResults(totals, force, rows, series)
        first = last


def seconds_of(results: Results, readings: range) -> float:
    """From the first to the last of some readings, s."""
    first, last = (int(results.stamps(at, at + 1)[0]) for at in (readings[0], readings[-1]))
    return (last - first) * 1e-9


# ---- jobs of workers


def intake_job(recording: str, plan: JobPlan, part: str, fields: bool) -> list[int]:
    """Read and condition a recording into a folder of results; its readings and skipped lines."""
    place = Pending(Path(part), Path(part))
    place.discard()  # of a run that was ended
    try:
        results, skipped = take_in(recording, plan, place, quiet=True)
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
    write_contacts_at(Path(part), first, rows)
    return asdict(totals)


@lru_cache(maxsize=4)
def _prepared(part: str, token: str) -> Results:
    """Results whose reconstructor serves all windows of this process; `token` is of one run."""
    return read_results(part, computed=True)


# ---- Dask


Watch = Callable[[str, str, int], None]  # "intake" or "window", name, readings


def run_jobs(
    manifest: Manifest, plan: JobPlan, fields: bool, client: Any, watch: Watch
) -> dict[str, str]:
    """Do what a manifest lacks, on the workers of a Dask client.

    The manifest is kept up to date; the workers see the files under the same names. Returns what
    went wrong, by the recordings' names; the others are complete.
    """
    from distributed import as_completed

    token = secrets.token_hex(8)
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
            submit(name, None, intake_job, entry.path, plan, part, fields)
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
def dask_client(workers: int, scheduler: str | None) -> Iterator[Any]:
    """A client of a scheduler that runs elsewhere, or of as many local processes as are wanted.

    Raises SkinfieldError where dask is not installed, InputError where there is no scheduler.
    """
    try:
        import distributed
    except ImportError as error:
        raise SkinfieldError(
            f"several recordings need {error.name}, which is not installed: "
            "pip install 'skinfield[batch]', or give one recording and -o contacts.csv"
        ) from error
    dask: Any = distributed  # its functions have no types
    with ExitStack() as parts:
        address: Any = scheduler or parts.enter_context(
            dask.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
        )
        try:
            client = parts.enter_context(dask.Client(address, timeout="10s"))
        except (OSError, ValueError) as error:
            raise InputError(
                f"--scheduler is {scheduler!r}, where nobody answers ({error}); expected the "
                "address of a Dask scheduler such as tcp://10.0.0.1:8786"
            ) from error
        yield client


def reconstruct_many(
    recordings: tuple[str, ...],
    folder: Path,
    plan: JobPlan,
    cluster: tuple[int, str | None],
    store_fields: bool,
    as_json: bool,
) -> None:
    """Reconstruct all that a manifest lacks, on so many workers or on a scheduler's."""
    failures: dict[str, str] = {}
    manifest = Manifest.open(folder, recordings, plan.settings(store_fields))
    if not all(manifest.entries[name].complete for name in manifest.names):
        with dask_client(*cluster) as client, _watched(len(manifest.names)) as watch:
            failures = run_jobs(manifest, plan, store_fields, client, watch)
    rows = _rows_of(manifest)
    columns = report.in_scale(RECORDING, any(row["scale"] == RELATIVE for row in rows))
    lines = [report.table_of(f"results in {folder}", rows, columns)] if rows else []
    report.finish(as_json, {"folder": str(folder), "recordings": rows}, lines=lines)
    if failures:
        each = "\n\n".join(f"{name}: {why}" for name, why in failures.items())
        count = plural(len(manifest.names), "recording")
        raise SkinfieldError(
            f"{len(failures)} of {count} failed, the others are complete; the same command "
            f"tries again.\n\n{each}"
        )


@contextmanager
def _watched(recordings: int) -> Iterator[Callable[[str, str, int], None]]:
    """Progress over all readings that are known of."""
    with report.progress(f"reading {plural(recordings, 'recording')}") as step:
        known = {"intake": 0, "window": 0, "recordings": 0}

        def watch(kind: str, _: str, readings: int) -> None:
            known[kind] += readings
            known["recordings"] += kind == "intake"
            missing = recordings - known["recordings"]
            what = f"reading {plural(missing, 'recording')}, " if missing else ""
            step(known["window"], known["intake"], f"{what}reconstructing")

        yield watch


def _rows_of(manifest: Manifest) -> list[dict[str, Any]]:
    """A row for each recording that is complete; its notes are said."""
    rows = []
    for name in manifest.names:
        entry = manifest.entries[name]
        if not entry.complete:
            continue
        results, totals = read_results(manifest.target(name)), entry.totals()
        report.say_notes(f"{name}: {note}" for note in results.notes)
        rows.append(
            {
                "recording": f"{name}.skinfield",
                "readings": entry.readings,
                "duration_s": seconds_of(results, range(len(results))),
                "skipped_lines": entry.skipped,
                "taxels_left_out": len(totals.silent or ()),
                "contacts": totals.contacts,
                "scale": scale_of(results.config.relative),
                "highest_force_N": totals.highest_force,
                "highest_force_reading": totals.peak,
            }
        )
    return rows
