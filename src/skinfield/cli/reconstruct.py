"""`skinfield reconstruct`: recordings become contacts and fields."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

from skinfield.cli.options import (
    LIVE,
    OUTPUT,
    Counts,
    CountSettings,
    Force,
    Json,
    Model,
    OfElastomer,
    flags_set,
    processes,
)
from skinfield.cli.reconstruct_jobs import Part, Plan, dask_client, parts, run_jobs, take_in
from skinfield.cli.report import (
    Column,
    check_output,
    check_picture,
    console,
    finish,
    plural,
    print_json,
    progress,
    say,
    say_notes,
    table_of,
    table_of_contacts,
)
from skinfield.elastic import BaseStress, Capacitance, Quantity
from skinfield.errors import InputError, SkinfieldError
from skinfield.estimate import Estimate
from skinfield.files.manifest import Manifest, Totals
from skinfield.files.pending import Pending, pending
from skinfield.files.results import Results, read_results
from skinfield.reconstruct import Reconstructor
from skinfield.reconstruct.serialisation import CONTACTS
from skinfield.settings import Elastomer, ModelSettings

ENDING = ".skinfield"
OF_RESULTS = (  # options for results as well
    "output", "fields", "summary", "plot", "reading", "slice_", "workers", "scheduler",
    "store_fields", "force", "as_json",
)  # fmt: skip
RECORDING = (
    Column("recording", "recording"), Column("readings", "readings", decimals=0),
    Column("s", "duration_s", decimals=2), Column("skipped", "skipped_lines", decimals=0),
    Column("left out", "taxels_left_out", decimals=0), Column("contacts", "contacts", decimals=0),
    Column("highest N", "highest_force_N", decimals=2),
    Column("at reading", "highest_load_reading", decimals=0),
)  # fmt: skip
OF_ONE = ("fields", "summary", "plot", "reading", "slice_")
OF_MANY = ("workers", "scheduler", "store_fields")


def reconstruct(
    *recording: str,
    layout: str | None = None,
    patch: str | None = None,
    output: Annotated[tuple[str, ...], OUTPUT] = (),
    fields: str | None = None,
    summary: str | None = None,
    plot: str | None = None,
    reading: int | None = None,
    slice_: str | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    store_fields: bool = False,
    force: Force = False,
    as_json: Json = False,
    counts: Counts = CountSettings(),
    elastomer: OfElastomer = Elastomer(),
    model: Model = ModelSettings(),
) -> None:
    """Turn recordings of a skin into force, deformation and contacts.

    A RECORDING is a yarpdatadumper log or its folder, a CySkin text recording, a CSV or NPZ file of
    your own, or what 'skinfield record' wrote; or results that an earlier run left with -o
    run.skinfield.

    Counts become ΔC/C₀ through the board's convention and a gain, or a calibration file; without
    one the gain is a guess and forces are true up to one factor, which 'skinfield calibrate scale'
    finds. What was assumed, skipped or left out is said in notes.

    A recording may be longer than memory. -o run.skinfield stores its readings, its contacts and
    what reconstructs them, far less than the fields, which are computed when they are looked at: in
    Python with skinfield.open_results, here with --slice. Solvers that start from the reading
    before (nonnegative, contact) do so within runs of 64 readings and begin anew at each.

    Several recordings, or one by several processes, go into a folder: -o DIR gets results of each,
    made window by window by Dask's workers, here or on a cluster. What is complete stands in
    DIR/manifest.json: the same command goes on where a run was ended.

      skinfield reconstruct foot/data.log --skin right_foot.txt -o contacts.csv --plot foot.png
      skinfield reconstruct press.csv --skin hexagon72 --grid 40 --fields press.zarr
      skinfield reconstruct touch.mcap -o contacts.csv
      skinfield reconstruct hours.csv --skin hexagon72 --grid 40 -o hours.skinfield
      skinfield reconstruct hours.skinfield --slice 100:200 --fields part.npz
      skinfield reconstruct mon.csv tue.csv wed.csv --skin hexagon72 --workers 8 -o week

    Parameters
    ----------
    recording : str
        Recordings, or a folder of results.
    layout : str, optional
        Layout file, or a generator by name. Default what a recording (.mcap) has enclosed.
    patch : str, optional
        Name or number of the patch of a layout with several.
    output : tuple of str
        Contacts of every reading: .csv or .parquet; or all results: .skinfield; again for more. Or
        a DIR, for results of several recordings.
    fields : str, optional
        Pressure and displacement: .npz or .zarr.
    summary : str, optional
        Summary of the run: .json.
    plot : str, optional
        Figure of the reading with the highest load: .png, .pdf or .svg.
    reading : int, optional
        Draw and list this reading (from 0) instead.
    slice_ : str, optional
        FROM:TO: readings to work on, from 0, TO left out; .skinfield holds all.
    workers : int, optional
        Processes that work into a DIR. Default as many as there are cores.
    scheduler : str, optional
        Of a Dask cluster whose workers see the same files, such as tcp://10.0.0.1:8786.
    store_fields : bool
        Into a DIR, store the fields of every reading, too, as Zarr.
    as_json : bool
        Summary of the run as one JSON object.
    """
    flags = flags_set(reconstruct, dict(locals()))
    folder = _folder_of(recording, output)
    _refuse(flags, OF_MANY if folder is None else OF_ONE, folder)
    if not recording:
        raise InputError("RECORDING is missing, expected one recording or more")
    results = any(_is_results(each) for each in recording)
    if results and (folder is not None or len(recording) > 1):
        raise InputError(
            f"{ENDING} folders are results already, expected recordings for {folder}, or one "
            "folder of results"
        )
    if layout is None and recording[0].lower().endswith(LIVE):
        layout = recording[0]
    if layout is None and not results:
        raise InputError("--skin is missing, expected a layout file, or a generator by name")
    plan = None
    if layout is not None and not results:
        plan = Plan.of(layout, patch, counts, elastomer, model)
    if plan is not None and folder is not None:
        many = Many(recording, folder, processes(workers), scheduler, store_fields)
        _reconstruct_many(many, plan, as_json)
        return
    for name in (*output, fields, summary):
        check_output("--output", name, force)
    check_picture("--plot", plot, force)
    if plan is None:
        _refuse_without_effect(flags, output)
    wanted = Wanted(output, fields, summary, plot, reading, slice_)
    _reconstruct_one(recording[0], plan, wanted, as_json)


def _folder_of(recordings: tuple[str, ...], outputs: tuple[str, ...]) -> Path | None:
    """Where results of many go: the output that has no ending."""
    folders = [name for name in outputs if not Path(name).suffix]
    if folders and len(outputs) > 1:
        raise InputError(
            f"-o names {', '.join(outputs)}, expected the folder {folders[0]} alone: it gets "
            "contacts and results of each recording"
        )
    if not folders and len(recordings) > 1:
        raise InputError(
            f"{len(recordings)} recordings, expected -o DIR, a name without an ending, which "
            "gets results of each; or one recording"
        )
    return Path(folders[0]) if folders else None


def _is_results(recording: str) -> bool:
    return recording.rstrip("/").lower().endswith(ENDING) and Path(recording).is_dir()


def _refuse(flags: list[tuple[str, str]], names: tuple[str, ...], folder: Path | None) -> None:
    """Options of the other way to work."""
    odd = [text for name, text in flags if name in names]
    if odd and folder is None:
        raise InputError(
            f"{', '.join(odd)} would have no effect: expected -o DIR, a name without an ending, "
            "into which workers write"
        )
    if odd:
        raise InputError(
            f"{', '.join(odd)} would have no effect beside -o {folder}: expected none; ask the "
            f"folders of results in it, such as 'skinfield reconstruct {folder}/NAME{ENDING}'"
        )


def _refuse_without_effect(flags: list[tuple[str, str]], outputs: tuple[str, ...]) -> None:
    """Results know their layout, their model and what counts mean."""
    odd = [text for name, text in flags if name not in OF_RESULTS]
    odd += [f"-o {Path(name).name}" for name in outputs if name.lower().endswith(ENDING)]
    if odd:
        raise InputError(
            f"{', '.join(odd)} would have no effect: expected none beside results, which were "
            "made with theirs; give the recording itself"
        )


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

    @property
    def files(self) -> list[str]:
        """All that are written."""
        names = (*self.output, self.fields, self.summary, self.plot)
        return [name for name in names if name]


class Sinks:
    """Where results of one recording go, by the endings of their names.

    Parameters
    ----------
    wanted : Wanted
    files : ExitStack
        Discards them where anything fails.

    Attributes
    ----------
    place : Pending
        Of the readings: results that are wanted, or in a folder that goes away.
    """

    def __init__(self, wanted: Wanted, files: ExitStack) -> None:
        from skinfield.files import open_contacts, open_fields

        for name in (wanted.summary, wanted.plot):
            if name:
                pending(name)  # makes nothing: it says what is wrong with the folder
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
            parent = Path(wanted.files[0]).absolute().parent if wanted.files else None  # has room
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
            each.write_rows(part.rows, part.totals.readings)
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


def _reconstruct_one(recording: str, plan: Plan | None, wanted: Wanted, as_json: bool) -> None:
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
        say_notes(results.notes)
        totals, readings = _run(results, sinks, wanted)
        shown = results.estimate(totals.shown)
        sinks.close()
        if sinks.stored:  # they have their name now
            results.readings = read_results(sinks.place.target).readings
        summary = _summary(results, totals, readings, skipped, plan)
        if wanted.summary:
            from skinfield.files import write_summary

            write_summary(wanted.summary, summary)
        if not as_json:
            _show(results, totals, readings, shown, skipped)
        say_notes(doubts(results.reconstructor, shown))
        if wanted.plot:
            _plot(results, totals.shown, shown, wanted.plot)
        finish(as_json, summary, wanted.files)


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
    with progress("reconstructing", len(readings)) as step:
        for part in parts(results, readings, fields):
            sinks.write(part, results.config.grid)
            totals.add(part.totals)
            step(totals.readings)
    totals.shown = totals.shown if reading is None else reading
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


@dataclass(frozen=True)
class Many:
    """Recordings, and how workers are to reconstruct them into a folder."""

    recordings: tuple[str, ...]
    folder: Path
    workers: int
    scheduler: str | None
    store_fields: bool


def _reconstruct_many(many: Many, plan: Plan, as_json: bool) -> None:
    """Reconstruct all that a manifest lacks, and say what there is."""
    plan, failures = plan.everywhere(), dict[str, str]()
    manifest = Manifest.open(many.folder, many.recordings, plan.settings(many.store_fields))
    if not all(manifest.entries[name].complete for name in manifest.names):
        with (
            dask_client(many.workers, many.scheduler) as client,
            _watched(len(manifest.names)) as watch,
        ):
            failures = run_jobs(manifest, plan, many.store_fields, client, watch)
    _report_many(manifest, as_json)
    if failures:
        each = "\n\n".join(f"{name}: {why}" for name, why in failures.items())
        raise SkinfieldError(
            f"{len(failures)} of {plural(len(manifest.names), 'recording')} failed, the others "
            f"are complete; the same command tries again.\n\n{each}"
        )


@contextmanager
def _watched(recordings: int) -> Iterator[Callable[[str, str, int], None]]:
    """Progress over all readings that are known of."""
    with progress(f"reading {plural(recordings, 'recording')}") as step:
        known = {"intake": 0, "window": 0, "recordings": 0}

        def watch(kind: str, _: str, readings: int) -> None:
            known[kind] += readings
            known["recordings"] += kind == "intake"
            missing = recordings - known["recordings"]
            what = f"reading {plural(missing, 'recording')}, " if missing else ""
            step(known["window"], known["intake"], f"{what}reconstructing")

        yield watch


def _report_many(manifest: Manifest, as_json: bool) -> None:
    """A row for each recording that is complete, after its notes."""
    rows = []
    for name in manifest.names:
        entry = manifest.entries[name]
        if not entry.complete:
            continue
        results, totals = read_results(manifest.target(name)), entry.totals()
        say_notes(f"{name}: {note}" for note in results.notes)
        rows.append(
            {
                "recording": f"{name}{ENDING}",
                "readings": entry.readings,
                "duration_s": _seconds(results, range(len(results))),
                "skipped_lines": entry.skipped,
                "taxels_left_out": len(totals.silent or ()),
                "contacts": totals.contacts,
                "highest_force_N": totals.highest_load,
                "highest_load_reading": totals.shown,
            }
        )
    if as_json:
        print_json({"folder": str(manifest.folder), "recordings": rows})
    elif rows:
        console().print(table_of(f"results in {manifest.folder}", rows, RECORDING))


# ---- what is printed of one


def _show(results: Results, totals: Totals, readings: range, shown: Estimate, skipped: int) -> None:
    """Print a line on all readings, and the contacts of one."""
    patch = results.config.patch
    took = totals.seconds / len(readings) if totals.seconds else shown.latency
    say(
        f"{results.source}: {plural(len(readings), 'reading')} in "
        f"{_seconds(results, readings):.2f} s, {len(patch)} taxels of {patch.name} "
        f"({len(totals.silent or ())} left out), {skipped} lines skipped; "
        f"{took * 1e3:.3g} ms per reading"
    )
    when = _seconds(results, range(totals.shown + 1))
    load = sum(contact.normal_force for contact in shown.contacts)
    contacts = plural(len(shown.contacts), "contact")
    title = f"reading {totals.shown} at {when:.2f} s: {load:.2f} N in {contacts}"
    console().print(table_of_contacts(shown.contacts, title))


def _seconds(results: Results, readings: range) -> float:
    """From the first to the last of some readings, s."""
    first, last = (
        int(results.readings.stamps(at, at + 1)[0]) for at in (readings[0], readings[-1])
    )
    return (last - first) * 1e-9


def doubts(reconstructor: Reconstructor, shown: Estimate) -> list[str]:
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
    options = {} if plan is None else plan.as_dict()
    return {
        "recording": results.source,
        "readings": count,
        "duration_s": _seconds(results, readings),
        "skipped_lines": skipped,
        "patch": config.patch.name,
        "taxels": len(config.patch),
        "taxels_left_out": len(totals.silent or ()),
        "quantity": _name_of(config.quantity),
        "solver": repr(config.solver),
        "layer": repr(config.layer),
        "grid": list(config.grid.shape),
        "options": {name: value for name, value in options.items() if value is not None},
        "contact_force_N": {"mean": totals.load / count, "highest": totals.highest_load},
        "field_force_N": {"mean": totals.force / count, "highest": totals.highest_force},
        "contacts_per_reading": totals.contacts / count,
        "highest_load_reading": totals.shown,
        "latency_ms_per_reading": totals.seconds / count * 1e3,
        "notes": list(results.notes),
    }


def _plot(results: Results, index: int, shown: Estimate, path: str) -> None:
    from skinfield.plot import draw_estimate, save

    quantity = results.config.quantity
    unit = {"1": "%", "Pa": "kPa"}[quantity.unit]
    reading = results.readings.values(index, index + 1)[0]
    figure = draw_estimate(shown, reading, quantity_name=quantity.symbol, quantity_unit=unit)
    save(figure, path)


def _name_of(quantity: Quantity) -> str:
    """As `--quantity` has it."""
    if isinstance(quantity, Capacitance):
        return "capacitance"
    return "stress" if isinstance(quantity, BaseStress) else "gap"
