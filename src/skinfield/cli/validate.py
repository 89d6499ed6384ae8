"""`skinfield validate`: score a solver on cases whose truth is known."""

import math
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from skinfield.cli.named_solver import SOLVER_HELP, solver_from_text
from skinfield.cli.options import MECHANICS
from skinfield.cli.report import console, plural, progress
from skinfield.errors import FileError, InputError

SHOWN = {  # measure, and how the table calls it
    "force_error": "force of all contacts",
    "field_force_error": "force of the field",
    "contact_force_error": "force of a contact found",
    "place_error_m": "place of a contact found, mm",
    "peak_error": "peak pressure",
    "pressure_error": "pressure, relative L2",
    "blurred_pressure_error": "pressure blurred by 2 mm, relative L2",
    "deformation_error": "deformation, relative L2",
    "area_error": "contact area",
}
PER_CASE = {
    "force_error": "force",
    "place_error_mm": "place mm",
    "blurred_pressure_error": "pressure, blurred",
    "deformation_error": "deformation",
    "missed": "missed",
    "false": "false",
}


@click.command(
    short_help="Score a solver on cases whose truth is known.",
    help="""Score a solver on the cases of a folder, or on one file.

CASES holds NPZ files as docs/cases.md describes them: layout, elastomer, readings and truth, from
a simulation, a rig or elsewhere; 'skinfield cases' writes some. The solver is told the layout, the
elastomer and the noise that a case states.

Errors are parts of the truth where no unit stands; the intervals are 95 %, over these cases.

\b
  skinfield cases cases && skinfield validate cases --solver gaussian
  skinfield validate cases --solver my_package.solvers:MySolver --settings '{"snr": 20}' --per-case
  skinfield validate cases --solver tikhonov --require place_error_mm=3 --json scores.json
""",
)
@click.argument("cases")
@click.option("--solver", default="gaussian", show_default=True, help=SOLVER_HELP)
@click.option("--settings", default="{}", help="Settings of the solver, as a JSON object.")
@click.option(
    "--mechanics",
    type=click.Choice(["case", *MECHANICS]),
    default="case",
    show_default=True,
    help="Model of the elastomer that is assumed; 'case' takes what each case says.",
)
@click.option(
    "--grid",
    type=click.IntRange(min=1, max=500),
    default=40,
    show_default=True,
    help="Nodes on a side of the grid.",
)
@click.option(
    "--gate-mm", default=8.0, show_default=True, help="Farther apart, contacts are not the same."
)
@click.option("--per-case", is_flag=True, help="A line per case, too.")
@click.option("--json", "json_path", help="Write summary and cases: .json.")
@click.option("--csv", "csv_path", help="Write a row per case: .csv.")
@click.option(
    "--require",
    multiple=True,
    metavar="MEASURE=MOST",
    help="Exit with 1 where the median, or the share 'missed', is higher; may be repeated.",
)
def validate(cases: str, **options: Any) -> None:
    """Score and report."""
    from skinfield.experiments.cases.files import case_paths, load_case
    from skinfield.experiments.scoring.rows import write_csv, write_json
    from skinfield.experiments.scoring.summary import summarise
    from skinfield.experiments.scoring.table_rows import flat
    from skinfield.experiments.scoring.validation import Entrant, row_of_case

    limits = _limits(options["require"])
    name = options["mechanics"]
    entrant = Entrant(
        solver=solver_from_text(options["solver"], options["settings"]),
        mechanics=None if name == "case" else MECHANICS[name](),
        nodes=options["grid"],
        gate=options["gate_mm"] * 1e-3,
    )
    paths, rows, scores = case_paths(cases), [], []
    with progress() as bar:
        task = bar.add_task("scoring", total=len(paths))
        for path in paths:
            case = load_case(path)
            with _named(path, options["solver"]):
                found = entrant.scores(case)
            rows.append({"file": path.name, **row_of_case(case, found)})
            scores += found
            bar.update(task, advance=1)
    summary = summarise(scores)
    out = console()
    if options["per_case"]:
        out.print(_table_of_cases(rows))
    title = f"{options['solver']} on {plural(len(paths), 'case')}, {plural(len(scores), 'reading')}"
    out.print(_table(summary, title))
    columns = flat(summary)
    if options["csv_path"]:
        write_csv(rows, options["csv_path"])
    if options["json_path"]:
        said = {key: options[key] for key in ("solver", "settings", "mechanics", "grid", "gate_mm")}
        write_json(rows, options["json_path"], options=said, summary=columns)
    for key in ("csv_path", "json_path"):
        if options[key]:
            out.print(f"wrote {options[key]}", highlight=False, soft_wrap=True, markup=False)
    _check(limits, columns)


@contextmanager
def _named(path: Path, solver: str) -> Iterator[None]:
    """Errors name the case; those of a solver from elsewhere also where they come from."""
    try:
        yield
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    except MemoryError as error:
        raise FileError(
            f"{path} does not fit into memory, expected positions in metres on a patch of some "
            f"decimetres, or a coarser --grid: {error}"
        ) from error
    except Exception as error:
        if ":" not in solver:
            raise
        last = traceback.extract_tb(error.__traceback__)[-1]
        raise FileError(
            f"{path}: --solver {solver} fails with {type(error).__name__}: {error} "
            f"({last.filename}, line {last.lineno})"
        ) from error


def _limits(texts: tuple[str, ...]) -> dict[str, float]:
    from skinfield.experiments.scoring.table_rows import COLUMNS

    limits = {}
    for text in texts:
        name, _, most = text.partition("=")
        try:
            limits[name] = float(most)
        except ValueError:
            name = ""
        if name not in COLUMNS:
            raise InputError(
                f"--require is {text!r}, expected MEASURE=NUMBER with one of {', '.join(COLUMNS)}"
            )
    return limits


def _check(limits: dict[str, float], columns: dict[str, Any]) -> None:
    """Exit with 1 where a limit is exceeded, or where there is no number to compare."""
    failed = []
    for name, most in limits.items():
        value = float(columns[f"{name}_median" if f"{name}_median" in columns else name])
        if not value <= most:
            failed.append(f"{name} is {value:.4g}, required at most {most:g}")
    if failed:
        click.echo("\n".join(failed), err=True)
        raise click.exceptions.Exit(1)


def _table(summary: Any, title: str) -> Any:
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    table.add_column("error of")
    for column in ("median", "95 % interval", "90th percentile"):
        table.add_column(column, justify="right")
    for key, label in SHOWN.items():
        figures = summary.measures[key]
        scale = 1e3 if key.endswith("_m") else 1.0
        table.add_row(label, *_shown(figures.median, scale), _number(figures.p90.value * scale))
    for label, rate in (
        ("contacts missed", summary.missed),
        ("readings with a false contact", summary.false_share),
    ):
        table.add_row(label, *_shown(rate, 1.0), "")
    return table


def _shown(interval: Any, scale: float) -> tuple[str, str]:
    low, high = _number(interval.low * scale), _number(interval.high * scale)
    return _number(interval.value * scale), f"{low} to {high}"


def _number(value: float, decimals: int = 3) -> str:
    """Fixed decimals; a dash for what does not exist, such as the place of what was missed."""
    return f"{value:.{decimals}f}" if math.isfinite(value) else "–"


def _table_of_cases(rows: list[dict[str, Any]]) -> Any:
    from rich.table import Table

    table = Table(title="Medians over each case's readings", title_justify="left")
    table.add_column("case", overflow="fold")
    table.add_column("true N", justify="right")
    for label in PER_CASE.values():
        table.add_column(label, justify="right")
    for row in rows:
        numbers = [_number(row[key], 2) for key in PER_CASE]
        table.add_row(str(row["case"]), f"{row['true_force_N']:.2f}", *numbers)
    return table
