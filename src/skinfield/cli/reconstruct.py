"""`skinfield reconstruct`: recordings become contacts and fields."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

from skinfield.cli.options import (
    OUTPUT,
    USUAL_SOLVER,
    CountSettings,
    Force,
    Json,
    flags_given,
    layer_of,
    part,
    profile_in_use,
)
from skinfield.cli.reconstruct_jobs import (
    STEPS,
    Part,
    ResultsFile,
    dask_client,
    parts,
    run_jobs,
    settings_of,
    take_in,
)
from skinfield.cli.report import (
    check_new,
    console,
    plural,
    print_json,
    say,
    say_notes,
    table_of_contacts,
)
from skinfield.elastic import BaseStress, Capacitance, Quantity
from skinfield.errors import InputError, SkinfieldError, check_count
from skinfield.estimate import Estimate
from skinfield.files.manifest import Manifest, Totals
from skinfield.files.results import Results, read_results
from skinfield.reconstruct import Reconstructor
from skinfield.settings import Elastomer, ModelSettings

ENDING = ".skinfield"
OF_RESULTS = (  # options for results as well
    "output", "fields", "summary", "plot", "reading", "slice_", "workers", "scheduler",
    "store_fields", "force", "as_json",
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
    counts: Annotated[CountSettings, part("Counts")] = CountSettings(),
    elastomer: Annotated[Elastomer, part("Elastomer")] = Elastomer(),
    model: Annotated[ModelSettings, part("Model")] = ModelSettings(),
) -> None:
    """Turn recordings of a skin into force, deformation and contacts.

    A RECORDING is a yarpdatadumper log or its folder, a CySkin text recording, or a CSV or NPZ file
    of your own; or results that an earlier run left with -o run.skinfield.

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
      skinfield reconstruct press.csv --skin hexagon72 --grid 40 --fields press.npz
      skinfield reconstruct hours.csv --skin hexagon72 --grid 40 -o hours.skinfield
      skinfield reconstruct hours.skinfield --slice 100:200 --fields part.npz
      skinfield reconstruct mon.csv tue.csv wed.csv --skin hexagon72 --workers 8 -o week

    Parameters
    ----------
    recording : str
        Recordings, or a folder of results.
    layout : str, optional
        Layout file, or a generator by name.
    patch : str, optional
        Name or number of the patch of a layout with several.
    output : tuple of str
        Contacts of every reading: .csv or .parquet; or all results: .skinfield; again for more. Or
        a DIR, for results of several recordings.
    fields : str, optional
        Pressure and displacement: .npz.
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
    values = dict(locals())
    given = flags_given(reconstruct, values)
    if workers is not None:
        check_count("--workers", workers, 1, 1024, "processes")
    folder = _folder_of(recording, output)
    _refuse(given, OF_MANY if folder is None else OF_ONE, folder)
    if not recording:
        raise InputError("RECORDING is missing, expected one recording or more")
    if any(_is_results(each) for each in recording):
        if folder is not None or len(recording) > 1:
            raise InputError(
                f"{ENDING} folders are results already, expected recordings for {folder}, or one "
                "folder of results"
            )
    elif layout is None:
        raise InputError("--skin is missing, expected a layout file, or a generator by name")
    options = plain_options(values, counts, elastomer, model)
    if folder is not None:
        _reconstruct_many(recording, folder, options)
        return
    for name in (*output, fields, summary, plot):
        check_new("output", name, force)
    if plot:
        from skinfield.plot import check_name

        check_name(plot)
    with ExitStack() as files:
        sinks = Sinks.of(options, files)
        if _is_results(recording[0]):
            _refuse_without_effect(given, sinks)
            results, skipped = read_results(recording[0]), 0
        else:
            results, skipped = _taken_in(recording[0], sinks, options, files)
        say_notes(results.notes)
        totals, readings = _run(results, sinks, options)
        shown = results.estimate(totals.peak)
        sinks.close()
        if sinks.results is not None:  # they have their name now
            results.readings = read_results(sinks.results.place.target).readings
        said = {k: v for k, v in options.items() if k in OF_RESULTS or layout}
        report(results, totals, readings, shown, {**said, "skipped": skipped})


def plain_options(
    values: dict[str, Any], counts: CountSettings, elastomer: Elastomer, model: ModelSettings
) -> dict[str, Any]:
    """All that was given, as plain values; what was not, as the profile has it."""
    sections = ("counts", "elastomer", "model", "recording", "force")
    plain = {name: value for name, value in values.items() if name not in sections}
    plain |= asdict(counts) | asdict(model)
    plain["solver"] = model.solver or USUAL_SOLVER
    if values["layout"] is None:  # of results, which hold all that
        return plain
    board = None if counts.board == "auto" else counts.board
    profile = profile_in_use(elastomer, board, values["layout"])
    layer = layer_of(elastomer, profile)
    plain["gain"] = profile.gain if counts.gain is None else counts.gain
    plain["no_load"] = counts.no_load or profile.no_load
    return plain | {
        "profile": profile.name,
        "mechanics": model.mechanics or profile.mechanics,
        "thickness_mm": layer.thickness * 1e3,
        "modulus_kpa": layer.young_modulus * 1e-3,
        "poisson": layer.poisson_ratio,
    }


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


def _refuse(given: list[tuple[str, str]], names: tuple[str, ...], folder: Path | None) -> None:
    """Options of the other way to work."""
    odd = [text for name, text in given if name in names]
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


def _refuse_without_effect(given: list[tuple[str, str]], sinks: "Sinks") -> None:
    """Results know their layout, their model and what counts mean."""
    odd = [text for name, text in given if name not in OF_RESULTS]
    if sinks.results is not None:
        odd.append(f"-o {sinks.results.place.target.name}")
    if odd:
        raise InputError(
            f"{', '.join(odd)} would have no effect: expected none beside results, which were "
            "made with theirs; give the recording itself"
        )


# ---- one recording, in this process


@dataclass
class StoredResults:
    """A folder of results that is being written, with contacts if they are of all readings."""

    place: Any
    whole: bool
    contacts: Any = None

    def write(self, part: Part) -> None:
        """Take the contacts of some readings."""
        from skinfield.files import open_contacts
        from skinfield.reconstruct.serialisation import CONTACTS

        if not self.whole:
            return
        if self.contacts is None:
            folder = self.place.part / CONTACTS
            folder.mkdir()
            self.contacts = open_contacts(folder / f"{0:012d}.parquet")
        self.contacts.write_rows(part.rows, part.totals.readings)

    def close(self) -> None:
        """Give the folder its name."""
        if self.contacts is not None:
            self.contacts.close()
        self.place.commit()

    def discard(self) -> None:
        """Give up: what was written is removed."""
        if self.contacts is not None:
            self.contacts.discard()
        self.place.discard()


@dataclass
class Sinks:
    """Where results of one recording go, by the endings of their names."""

    tables: list[Any] = field(default_factory=list)
    fields: Any = None
    results: StoredResults | None = None

    @classmethod
    def of(cls, options: dict[str, Any], files: ExitStack) -> "Sinks":
        """Open what is asked for; each is discarded where anything fails."""
        from skinfield.files import open_contacts, open_fields
        from skinfield.files.pending import pending

        made = cls()
        for name in (options["summary"], options["plot"]):
            if name:
                pending(name)  # makes nothing: it says what is wrong with the folder
        for name in options["output"]:
            if not name.lower().endswith(ENDING):
                made.tables.append(files.enter_context(open_contacts(name)))
            elif made.results is None:
                made.results = StoredResults(pending(name), whole=options["slice_"] is None)
                files.push(made._discard_results)
            else:
                raise InputError(f"--output names two {ENDING} folders, expected one at most")
        if options["fields"]:
            made.fields = files.enter_context(open_fields(options["fields"]))
        return made

    def write(self, part: Part, grid: Any) -> None:
        """Take what some readings give."""
        for table in self.tables:
            table.write_rows(part.rows, part.totals.readings)
        if self.fields is not None:
            self.fields.write_series(grid, part.series)
        if self.results is not None:
            self.results.write(part)

    def close(self) -> None:
        """Give all files their names."""
        for sink in (*self.tables, self.fields, self.results):
            if sink is not None:
                sink.close()

    def _discard_results(self, kind: object, *_: object) -> None:
        if kind is not None and self.results is not None:
            self.results.discard()


def _taken_in(
    recording: str, sinks: Sinks, options: dict[str, Any], files: ExitStack
) -> tuple[Results, int]:
    """A recording's conditioned readings, in results that are wanted or in a temporary file."""
    from skinfield.files.results_writer import ResultsWriter

    named = [*options["output"], options["fields"], options["summary"]]
    first = next((name for name in named if name), None)
    parent = None if first is None else Path(first).absolute().parent  # there is room
    folder = Path(files.enter_context(TemporaryDirectory(prefix=".skinfield-", dir=parent)))
    if sinks.results is not None:
        place = sinks.results.place
        skipped = take_in(recording, options, folder, lambda *of: ResultsWriter(place, *of))
        return read_results(place.part), skipped
    made: list[ResultsFile] = []

    def temporary(*of: Any) -> ResultsFile:
        made.append(ResultsFile(folder, *of))
        return made[0]

    skipped = take_in(recording, options, folder, temporary)
    return made[0].results, skipped


def _run(results: Results, sinks: Sinks, options: dict[str, Any]) -> tuple[Totals, range]:
    """Reconstruct what is asked for; where one reading is and no file, it alone."""
    readings, reading = _readings_of(options["slice_"], len(results)), options["reading"]
    if reading is not None and reading not in readings:
        raise InputError(
            f"--reading is {reading}, expected {readings.start} to {readings.stop - 1}"
        )
    totals, fields = Totals(), sinks.fields is not None
    if reading is not None and not (sinks.tables or fields or options["summary"]):
        totals.silent = _silent(results, readings)
        totals.readings = len(readings)
    else:
        with readings_progress() as bar:
            line = bar.add_task("reconstructing", total=len(readings))
            for part in parts(results, readings, fields):
                sinks.write(part, results.config.grid)
                totals.add(part.totals)
                bar.update(line, advance=part.totals.readings)
    totals.peak = totals.peak if reading is None else reading
    return totals, readings


def _silent(results: Results, readings: range) -> list[int]:
    """Taxels that never answer."""
    dead = np.ones(len(results.config.patch), np.bool_)
    for first in range(readings.start, readings.stop, STEPS["linear"]):
        last = min(first + STEPS["linear"], readings.stop)
        dead &= np.isnan(results.readings.values(first, last)).all(axis=0)
    return np.flatnonzero(dead).tolist()


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


def _reconstruct_many(recordings: tuple[str, ...], folder: Path, options: dict[str, Any]) -> None:
    """Reconstruct all that a manifest lacks, and say what there is."""
    options = {**options, "layout": _absolute(options["layout"])}
    if options["calibration"] is not None:
        options["calibration"] = _absolute(options["calibration"])
    manifest = Manifest.open(folder, recordings, settings_of(options))
    failures: dict[str, str] = {}
    if not all(manifest.entries[name].complete for name in manifest.names):
        with (
            dask_client(options["workers"], options["scheduler"]) as client,
            _watched(len(manifest.names)) as watch,
        ):
            failures = run_jobs(manifest, options, client, watch)
    _report_many(manifest)
    if failures:
        each = "\n\n".join(f"{name}: {why}" for name, why in failures.items())
        raise SkinfieldError(
            f"{len(failures)} of {plural(len(manifest.names), 'recording')} failed, the others "
            f"are complete; the same command tries again.\n\n{each}"
        )


def _absolute(name: str) -> str:
    """A file's name for workers that run elsewhere; a generator's name as it is."""
    return str(Path(name).resolve()) if Path(name).exists() else name


@contextmanager
def _watched(recordings: int) -> Iterator[Callable[[str, str, int], None]]:
    """Progress over all readings that are known of."""
    with readings_progress() as bar:
        line = bar.add_task(f"reading {plural(recordings, 'recording')}", total=None)
        known = {"intake": 0, "window": 0, "recordings": 0}

        def watch(kind: str, _: str, readings: int) -> None:
            known[kind] += readings
            known["recordings"] += kind == "intake"
            missing = recordings - known["recordings"]
            what = f"reading {plural(missing, 'recording')}, " if missing else ""
            bar.update(
                line,
                total=known["intake"],
                completed=known["window"],
                description=f"{what}reconstructing",
            )

        yield watch


def _report_many(manifest: Manifest) -> None:
    """A row for each recording that is complete, after its notes."""
    table = Table(title=f"results in {manifest.folder}", title_justify="left")
    for column in ("recording", "readings", "s", "skipped", "left out", "contacts", "highest N",
                   "at reading"):  # fmt: skip
        table.add_column(column, justify="left" if column == "recording" else "right")
    for name in manifest.names:
        entry = manifest.entries[name]
        if not entry.complete:
            continue
        results, totals = read_results(manifest.target(name)), entry.totals()
        say_notes(f"{name}: {note}" for note in results.notes)
        stamps = [int(results.readings.stamps(k, k + 1)[0]) for k in (0, len(results) - 1)]
        table.add_row(
            f"{name}{ENDING}",
            str(entry.readings),
            f"{(stamps[1] - stamps[0]) * 1e-9:.2f}",
            str(entry.skipped),
            str(len(totals.silent or ())),
            str(totals.contacts),
            f"{totals.highest_load:.2f}",
            str(totals.peak),
        )
    if table.row_count:
        console().print(table)


# ---- what is printed of one


class _Speed(ProgressColumn):
    """Readings in a second, of the last half minute."""

    def render(self, task: Task) -> Text:
        """Such as 120,000 readings/s."""
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:,.0f} readings/s")


def readings_progress() -> Progress:
    """Bar on stderr with readings per second and the time left; it goes away when it is done."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        _Speed(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )


def report(
    results: Results, totals: Totals, readings: range, shown: Estimate, options: dict[str, Any]
) -> None:
    """Print what was found, and write the summary and the picture that are asked for."""
    seconds = (_stamp(results, readings[-1]) - _stamp(results, readings[0])) * 1e-9
    if options["as_json"]:
        print_json(_summary(results, totals, seconds, options))
    else:
        _show(results, totals, readings, shown, seconds, options["skipped"])
    say_notes(doubts(results.reconstructor, shown))
    if options["summary"]:
        from skinfield.files import write_summary

        write_summary(options["summary"], _summary(results, totals, seconds, options))
    if options["plot"]:
        _plot(results, totals.peak, shown, options["plot"])
    for name in (*options["output"], *(options[k] for k in ("fields", "summary", "plot"))):
        if name and not options["as_json"]:
            say(f"wrote {name}")


def _show(
    results: Results,
    totals: Totals,
    readings: range,
    shown: Estimate,
    seconds: float,
    skipped: int,
) -> None:
    """Print a line on all readings, and the contacts of one."""
    out, patch, start = console(), results.config.patch, _stamp(results, 0)
    took = totals.seconds / len(readings) if totals.seconds else shown.latency
    out.print(
        f"{results.source}: {plural(len(readings), 'reading')} in {seconds:.2f} s, "
        f"{len(patch)} taxels of {patch.name} ({len(totals.silent or ())} left out), "
        f"{skipped} lines skipped; {took * 1e3:.3g} ms per reading",
        highlight=False,
        soft_wrap=True,
    )
    when = (_stamp(results, totals.peak) - start) * 1e-9
    load = sum(contact.normal_force for contact in shown.contacts)
    found = plural(len(shown.contacts), "contact")
    title = f"reading {totals.peak} at {when:.2f} s: {load:.2f} N in {found}"
    out.print(table_of_contacts(shown.contacts, title))


def _stamp(results: Results, reading: int) -> int:
    return int(results.readings.stamps(reading, reading + 1)[0])


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
    results: Results, totals: Totals, seconds: float, options: dict[str, Any]
) -> dict[str, Any]:
    count, config = totals.readings, results.config
    skipped = ("skipped", "as_json", "slice_", *OF_MANY)
    said = {
        key: value for key, value in options.items() if value is not None and key not in skipped
    }
    return {
        "recording": results.source,
        "readings": count,
        "duration_s": seconds,
        "skipped_lines": options["skipped"],
        "patch": config.patch.name,
        "taxels": len(config.patch),
        "taxels_left_out": len(totals.silent or ()),
        "quantity": _name_of(config.quantity),
        "solver": repr(config.solver),
        "layer": repr(config.layer),
        "grid": list(config.grid.shape),
        "options": said,
        "contact_force_N": {"mean": totals.load / count, "highest": totals.highest_load},
        "field_force_N": {"mean": totals.force / count, "highest": totals.highest_force},
        "contacts_per_reading": totals.contacts / count,
        "highest_load_reading": totals.peak,
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
