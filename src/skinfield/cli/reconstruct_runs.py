"""Runs of reconstruction: one recording in this process, many by workers, what they print."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import skinfield as sf
from skinfield.cli import options, report
from skinfield.cli.reconstruct_jobs import Part, Plan, dask_client, parts, run_jobs, take_in
from skinfield.cli.report import Column
from skinfield.errors import InputError, SkinfieldError
from skinfield.files.manifest import Manifest, Totals
from skinfield.files.pending import Pending, pending
from skinfield.files.results import Results, read_results
from skinfield.reconstruct.serialisation import CONTACTS

ENDING = ".skinfield"
RECORDING = (
    Column("recording", "recording"), Column("readings", "readings", decimals=0),
    Column("s", "duration_s", decimals=2), Column("skipped", "skipped_lines", decimals=0),
    Column("left out", "taxels_left_out", decimals=0), Column("contacts", "contacts", decimals=0),
    Column("highest N", "highest_force_N", decimals=2),
    Column("at reading", "highest_load_reading", decimals=0),
)  # fmt: skip


# ---- one recording, in this process


@dataclass(frozen=True)
class Wanted:
    """What is to be made of one recording, as the command's options say."""

    output: tuple[str, ...]
    fields: str | None
    summary: str | None
    plot: str | None
    reading: int | None
    slice_: str | None


class Sinks:
    """Where results of one recording go, by the endings of their names; discarded on failure.

    Attributes
    ----------
    names : list of str
        Of all files that are written.
    place : Pending
        Of the readings: results that are wanted, or in a folder that goes away.
    """

    def __init__(self, wanted: Wanted, files: ExitStack) -> None:
        from skinfield.files import open_contacts, open_fields

        files_wanted = (*wanted.output, wanted.fields, wanted.summary, wanted.plot)
        self.names = [name for name in files_wanted if name]
        stores = [name for name in wanted.output if name.lower().endswith(ENDING)]
        if len(stores) > 1:
            raise InputError(f"--output names two {ENDING} folders, expected one at most")
        self.stored, self._files = bool(stores), files
        if stores:
            self.place = pending(stores[0])
            files.push(self._discard_results)
        self.tables = [
            files.enter_context(open_contacts(name)) for name in wanted.output if name not in stores
        ]
        self.fields = files.enter_context(open_fields(wanted.fields)) if wanted.fields else None
        if not stores:
            parent = Path(self.names[0]).absolute().parent if self.names else None  # has room
            folder = TemporaryDirectory(prefix=".skinfield-", dir=parent)
            unnamed = Path(files.enter_context(folder)) / "readings"
            self.place = Pending(unnamed, unnamed)

    def add_contacts(self) -> None:
        """Let results that are wanted have their contacts, too."""
        from skinfield.files import open_contacts

        folder = self.place.part / CONTACTS
        folder.mkdir()
        name = folder / f"{0:012d}.parquet"
        self.tables.append(self._files.enter_context(open_contacts(name)))

    def write(self, part: Part, grid: Any) -> None:
        """Take what some readings give."""
        for each in self.tables:
            each.write_rows(part.rows)
        if self.fields is not None and part.series is not None:
            self.fields.write_series(grid, part.series)

    def close(self) -> None:
        """Give all files their names."""
        for sink in (*self.tables, self.fields):
            if sink is not None:
                sink.close()
        if self.stored:
            self.place.commit()

    def _discard_results(self, kind: object, *_: object) -> None:
        if kind is not None:
            self.place.discard()


def reconstruct_one(recording: str, plan: Plan | None, wanted: Wanted, as_json: bool) -> None:
    """Reconstruct a recording, or the results that it is where there is no plan."""
    with ExitStack() as files:
        sinks, skipped = Sinks(wanted, files), 0
        if plan is None:
            results = read_results(recording)
        else:
            skipped = take_in(recording, plan, sinks.place)
            results = read_results(sinks.place.part)
            if sinks.stored and wanted.slice_ is None:
                sinks.add_contacts()
        report.say_notes(results.notes)
        totals, readings = _run(results, sinks, wanted)
        shown = results.estimate(totals.peak)
        sinks.close()
        if sinks.stored:  # they have their name now
            whole = read_results(sinks.place.target)
            results.stamp_ns, results.readings = whole.stamp_ns, whole.readings
        summary = _summary(results, totals, readings, skipped, plan)
        if wanted.summary:
            from skinfield.files import write_summary

            write_summary(wanted.summary, summary)
        report.say_notes(doubts(results.reconstructor, shown))
        if wanted.plot:
            reading = results.values(totals.peak, totals.peak + 1)[0]
            report.save_picture(wanted.plot, shown, reading, results.config.quantity)
        report.finish(
            as_json, summary, sinks.names, _lines(results, totals, readings, shown, skipped)
        )


def _run(results: Results, sinks: Sinks, wanted: Wanted) -> tuple[Totals, range]:
    """Reconstruct what is asked for; where one reading is and no file, it alone."""
    readings, reading = _readings_of(wanted.slice_, len(results)), wanted.reading
    totals, fields = Totals(), sinks.fields is not None
    if reading is not None and reading not in readings:
        raise InputError(
            f"--reading is {reading}, expected {readings.start} to {readings.stop - 1}"
        )
    if reading is not None and not (sinks.tables or fields or wanted.summary):
        readings = range(reading, reading + 1)
    with report.progress("reconstructing", len(readings)) as step:
        for part in parts(results, readings, fields):
            sinks.write(part, results.config.grid)
            totals.add(part.totals)
            step(totals.readings)
    totals.peak = totals.peak if reading is None else reading
    return totals, readings


def _readings_of(text: str | None, count: int) -> range:
    """Readings that `--slice` names."""
    if text is None:
        return range(count)
    try:
        low, high = (int(word) if word.strip() else None for word in text.split(":"))
    except ValueError:
        raise InputError(f"--slice is {text!r}, expected two numbers such as 100:200") from None
    found = range(count)[slice(low, high)]
    if not found:
        raise InputError(f"--slice is {text!r}, expected readings of 0:{count}")
    return found


# ---- many recordings, by workers


def reconstruct_many(
    recordings: tuple[str, ...],
    folder: Path,
    plan: Plan,
    cluster: tuple[int, str | None],
    store_fields: bool,
    as_json: bool,
) -> None:
    """Reconstruct all that a manifest lacks, on so many workers or on a scheduler's."""
    plan, failures = plan.everywhere(), dict[str, str]()
    manifest = Manifest.open(folder, recordings, plan.settings(store_fields))
    if not all(manifest.entries[name].complete for name in manifest.names):
        with dask_client(*cluster) as client, _watched(len(manifest.names)) as watch:
            failures = run_jobs(manifest, plan, store_fields, client, watch)
    rows = _rows_of(manifest)
    lines = [report.table_of(f"results in {folder}", rows, RECORDING)] if rows else []
    report.finish(as_json, {"folder": str(folder), "recordings": rows}, lines=lines)
    if failures:
        each = "\n\n".join(f"{name}: {why}" for name, why in failures.items())
        count = report.plural(len(manifest.names), "recording")
        raise SkinfieldError(
            f"{len(failures)} of {count} failed, the others are complete; the same command "
            f"tries again.\n\n{each}"
        )


@contextmanager
def _watched(recordings: int) -> Iterator[Callable[[str, str, int], None]]:
    """Progress over all readings that are known of."""
    with report.progress(f"reading {report.plural(recordings, 'recording')}") as step:
        known = {"intake": 0, "window": 0, "recordings": 0}

        def watch(kind: str, _: str, readings: int) -> None:
            known[kind] += readings
            known["recordings"] += kind == "intake"
            missing = recordings - known["recordings"]
            what = f"reading {report.plural(missing, 'recording')}, " if missing else ""
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
                "recording": f"{name}{ENDING}",
                "readings": entry.readings,
                "duration_s": _seconds(results, range(len(results))),
                "skipped_lines": entry.skipped,
                "taxels_left_out": len(totals.silent or ()),
                "contacts": totals.contacts,
                "highest_force_N": totals.highest_load,
                "highest_load_reading": totals.peak,
            }
        )
    return rows


# ---- what is printed of one


def _lines(
    results: Results, totals: Totals, readings: range, shown: sf.Estimate, skipped: int
) -> Iterator[report.Shown]:
    """A line on all readings, and the contacts of one."""
    patch = results.config.patch
    took = totals.seconds / len(readings) if totals.seconds else shown.latency
    yield (
        f"{results.source}: {report.plural(len(readings), 'reading')} in "
        f"{_seconds(results, readings):.2f} s, {len(patch)} taxels of {patch.name} "
        f"({len(totals.silent or ())} left out), {skipped} lines skipped; "
        f"{took * 1e3:.3g} ms per reading"
    )
    when = _seconds(results, range(totals.peak + 1))
    load = sum(contact.normal_force for contact in shown.contacts)
    contacts = report.plural(len(shown.contacts), "contact")
    title = f"reading {totals.peak} at {when:.2f} s: {load:.2f} N in {contacts}"
    yield report.table_of_contacts(shown.contacts, title)


def _seconds(results: Results, readings: range) -> float:
    """From the first to the last of some readings, s."""
    first, last = (int(results.stamps(at, at + 1)[0]) for at in (readings[0], readings[-1]))
    return (last - first) * 1e-9


def doubts(reconstructor: sf.Reconstructor, shown: sf.Estimate) -> list[str]:
    """What about an estimate cannot be, and what to try."""
    found, grid, layer = [], shown.grid, reconstructor.layer
    if grid.pitch > reconstructor.patch.pitch:
        found.append(
            f"cells of {grid.pitch * 1e3:.1f} mm are wider than the taxels' distance of "
            f"{reconstructor.patch.pitch * 1e3:.1f} mm: a finer --grid gives other forces"
        )
    deepest = float(shown.indentation.max()) / layer.thickness
    if deepest > 0.8:
        found.append(
            f"an indentation of {deepest:.1f} times the thickness is beyond a linear model: the "
            "gain, the modulus or Poisson's ratio does not fit this skin"
        )
    if shown.pressure.min() < -0.5 * shown.pressure.max():
        foam = ": if the elastomer is a foam or a fabric, try --poisson 0.3"
        found.append(
            f"pressure falls to {shown.pressure.min() / 1e3:.0f} kPa beside "
            f"{shown.pressure.max() / 1e3:.0f} kPa, and nothing pulls"
            f"{foam if layer.poisson_ratio > 0.45 else '; linear solvers do not know that'}"
        )
    return found


def _summary(
    results: Results, totals: Totals, readings: range, skipped: int, plan: Plan | None
) -> dict[str, Any]:
    """What `--json` prints and `--summary` writes."""
    count, config = totals.readings, results.config
    kind = type(config.quantity).__name__
    values = {} if plan is None else plan.as_dict()
    return {
        "recording": results.source,
        "readings": count,
        "duration_s": _seconds(results, readings),
        "skipped_lines": skipped,
        "patch": config.patch.name,
        "taxels": len(config.patch),
        "taxels_left_out": len(totals.silent or ()),
        "quantity": next(name for name, each in options.QUANTITIES.items() if each == kind),
        "solver": repr(config.solver),
        "layer": repr(config.layer),
        "grid": list(config.grid.shape),
        "options": {name: value for name, value in values.items() if value is not None},
        "contact_force_N": {"mean": totals.load / count, "highest": totals.highest_load},
        "field_force_N": {"mean": totals.force / count, "highest": totals.highest_force},
        "contacts_per_reading": totals.contacts / count,
        "highest_load_reading": totals.peak,
        "latency_ms_per_reading": totals.seconds / count * 1e3,
        "notes": list(results.notes),
    }
