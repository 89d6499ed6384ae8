"""`skinfield reconstruct`: a recording becomes fields and contacts."""

from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click
import numpy as np
from click.core import ParameterSource

from skinfield.cli.inputs import LAYOUT_HELP
from skinfield.cli.options import conditioning_options, model_options
from skinfield.cli.reconstruct_progress import readings_progress
from skinfield.cli.reconstruct_report import Run, report
from skinfield.cli.report import say_notes
from skinfield.errors import InputError
from skinfield.pipeline.batch_results import LazyResults

ENDING = ".skinfield"
KEPT = ("recording", "output", "fields_path", "summary_path", "plot", "reading", "part",
        "processes", "device")  # options that mean something for results as well  # fmt: skip


@click.command(
    short_help="Turn a recording into contacts, fields and a picture.",
    help=f"""Turn a recording of a skin into force, deformation and contacts.

RECORDING is a yarpdatadumper log or its folder, a CySkin text recording, or a CSV or NPZ file of
your own; or results that an earlier run left with -o run.skinfield. {LAYOUT_HELP}

Counts become ΔC/C₀ through the board's convention and a gain, or a calibration file; without one
the gain is a guess and forces are true up to one factor, which 'skinfield calibrate scale' finds.
What was assumed, skipped or left out is said in notes.

A recording may be longer than memory. -o run.skinfield keeps its readings and what reconstructs
them, far less than the fields, which are computed when they are looked at: in Python
with skinfield.open_results, here with --slice. Contacts are found where a table or a summary asks
for them; without, the reading of the highest summed pressure is shown. Long work is done by as many
processes as there are cores. Solvers that start from the reading before (nonnegative, contact) do
so within runs of 64 readings and begin anew at each: the answers do not depend on the processes.

\b
  skinfield reconstruct right_foot/data.log --layout right_foot.txt -o contacts.csv --plot foot.png
  skinfield reconstruct press.csv --layout hexagon72 --grid 40 --fields press.zarr
  skinfield reconstruct hours.csv --layout hexagon72 --grid 40 -o hours.skinfield
  skinfield reconstruct hours.skinfield --slice 100:200 --fields part.npz
""",
)
@click.argument("recording")
@click.option("--layout", "layout", help="Layout file, or generator by name.")
@click.option("--patch", help="Which patch, where the layout has several.")
@click.option(
    "-o",
    "--output",
    multiple=True,
    help="Contacts of every reading: .csv or .parquet; or all results: .skinfield. Repeatable.",
)
@click.option("--fields", "fields_path", help="Pressure and displacement: .npz or .zarr.")
@click.option("--summary", "summary_path", help="Summary of the run: .json.")
@click.option("--plot", help="Figure of the reading with the highest load: .png, .pdf or .svg.")
@click.option("--reading", type=int, help="Draw and list this reading (from 0) instead.")
@click.option(
    "--slice",
    "part",
    metavar="FROM:TO",
    help="Readings to work on, from 0, TO left out; .skinfield keeps all.",
)
@click.option(
    "--processes",
    type=click.IntRange(1, 1024),
    help="How many work at once. Default one, and all cores where it takes long.",
)
@click.option(
    "--device",
    help="Where the products of a linear solver are computed: numpy, or cuda, cuda:1, mps or cpu "
    "of PyTorch (pip install 'skinfield[gpu]'). Default this process and others.",
)
@model_options(grid=20)
@conditioning_options
def reconstruct(recording: str, layout: str | None, patch: str | None, **options: Any) -> None:
    """Reconstruct a recording."""
    from skinfield.figures import check_name

    if options["plot"]:
        check_name(options["plot"])
    if options["device"]:
        _check_device(options["device"], options["processes"])
    with ExitStack() as files:
        sinks = Sinks.of(options, files)
        ready = recording.rstrip("/").lower().endswith(ENDING) and Path(recording).is_dir()
        if ready:
            _refuse_without_effect(click.get_current_context(), sinks)
            path, skipped = Path(recording), 0
        else:
            from skinfield.cli.reconstruct_intake import take_in

            if layout is None:
                raise click.MissingParameter(param_hint="'--layout'", param_type="option")
            path = sinks.results or Path(files.enter_context(_beside(options))) / f"run{ENDING}"
            skipped = take_in(recording, layout, patch, path, options)
        from skinfield.sources import open_results

        results = open_results(path)
        say_notes(results.notes)
        run = _run(path, results, sinks, options)
        shown = results.estimate(run.shown)
        sinks.close()
        said = {key: value for key, value in options.items() if key in KEPT or not ready}
        report(results, run, shown, {**said, "skipped": skipped})


def _beside(options: dict[str, Any]) -> TemporaryDirectory[str]:
    """A folder for the readings until the end: where the outputs go, as there is room."""
    named = [*options["output"], options["fields_path"], options["summary_path"]]
    first = next((name for name in named if name), None)
    folder = None if first is None else Path(first).absolute().parent
    return TemporaryDirectory(prefix=".skinfield-", dir=folder)


def _refuse_without_effect(context: click.Context, sinks: "Sinks") -> None:
    """Results know their layout, their model and what counts mean."""
    given = [
        parameter.opts[-1]
        for parameter in context.command.params
        if parameter.name not in KEPT
        and context.get_parameter_source(str(parameter.name)) == ParameterSource.COMMANDLINE
    ]
    if sinks.results is not None:
        given.append(f"-o {sinks.results.name}")
    if given:
        raise InputError(
            f"{', '.join(given)} would have no effect: expected none beside results, which were "
            "made with theirs; give the recording itself"
        )


@dataclass
class Sinks:
    """Where results go, by the endings of their names."""

    tables: list[Any] = field(default_factory=list)
    fields: Any = None
    results: Path | None = None

    @classmethod
    def of(cls, options: dict[str, Any], files: ExitStack) -> "Sinks":
        """Open what is asked for; each is discarded where anything fails."""
        from skinfield.sinks import open_contacts, open_fields
        from skinfield.sinks.pending import pending

        made = cls()
        for name in (options["summary_path"], options["plot"]):
            if name:
                pending(name)  # makes nothing: it says what is wrong with the folder
        for name in options["output"]:
            if not name.lower().endswith(ENDING):
                made.tables.append(files.enter_context(open_contacts(name)))
            elif made.results is None:
                made.results = pending(name).target
            else:
                raise InputError(f"--output names two {ENDING} files, expected one at most")
        if options["fields_path"]:
            made.fields = files.enter_context(open_fields(options["fields_path"]))
        return made

    def write(self, part: Any, results: LazyResults) -> None:
        """Take what a piece of work gives."""
        for table in self.tables:
            table.write_rows(part.rows, len(part.load))
        if self.fields is not None:
            self.fields.write_series(results.grid, part.series)

    def close(self) -> None:
        """Give all files their names."""
        for sink in (*self.tables, *([self.fields] if self.fields is not None else [])):
            sink.close()


def _run(path: Path, results: LazyResults, sinks: Sinks, options: dict[str, Any]) -> Run:
    """Reconstruct what is asked for; readings that nothing needs are not."""
    run = Run(_readings_of(options["part"], len(results)))
    reading = options["reading"]
    if reading is not None and reading not in run.readings:
        raise InputError(
            f"--reading is {reading}, expected {run.readings.start} to {run.readings.stop - 1}"
        )
    if options["device"] and not results.is_linear:
        raise InputError(
            f"--device is {options['device']} and the solver is not linear, expected no device, or "
            "one of the solvers whose answer is a product, such as gaussian"
        )
    contacts = bool(sinks.tables or options["summary_path"])
    only_kept = sinks.results is not None and not results.is_linear  # its fields come later
    if contacts or sinks.fields is not None or (reading is None and not only_kept):
        _over_all(path, results, sinks, run, contacts, options)
    else:
        _survey(results, run)
    run.shown = run.shown if reading is None else reading
    return run


def _over_all(
    path: Path,
    results: LazyResults,
    sinks: Sinks,
    run: Run,
    contacts: bool,
    options: dict[str, Any],
) -> None:
    from skinfield.cli.reconstruct_work import Task, parts

    task = Task(path, contacts, sinks.fields is not None, options["device"])
    processes = 1 if options["device"] else options["processes"]
    with readings_progress() as bar:
        line = bar.add_task("reconstructing", total=len(run.readings))
        for part in parts(task, results, run.readings, processes):
            sinks.write(part, results)
            run.add(part)
            bar.update(line, advance=len(part.load))


def _check_device(device: str, processes: int | None) -> None:
    """Raise InputError for a device that is not there, or that many would have to share."""
    from skinfield.pipeline.array_backend import ArrayBackend

    ArrayBackend.on(device)
    if processes not in (None, 1):
        raise InputError(
            f"--processes is {processes} beside --device {device}, expected none or 1: a device's "
            "memory and time are taken by one process"
        )


def _survey(results: LazyResults, run: Run) -> None:
    """The reading that is highest, and taxels that never answer, without a solver."""
    highest = -np.inf
    for first in range(run.readings.start, run.readings.stop, 4096):
        values = results.readings[first : min(first + 4096, run.readings.stop)]
        mean = np.nansum(values, axis=1)
        best = int(np.argmax(mean))
        if mean[best] > highest:
            highest, run.shown = float(mean[best]), first + best
        dead = np.isnan(values).all(axis=0)
        run.dead = dead if run.dead is None else run.dead & dead


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
