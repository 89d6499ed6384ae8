"""`skinfield validate`: score solvers on cases whose truth is known."""

import os
from pathlib import Path
from typing import Any

import click

from skinfield.cli.contenders import method_from_options, named
from skinfield.cli.named_solver import SOLVER_HELP
from skinfield.cli.options import MECHANICS, QUANTITIES
from skinfield.cli.outputs import check_output
from skinfield.cli.report import console, plural, progress
from skinfield.cli.scores import (
    check_limits,
    limits_from_texts,
    say_written,
    table_of_cases,
    table_of_summary,
)
from skinfield.errors import InputError, check_positive

PAPER_HELP = " 'paper' is the paper's method: half-space, interpolated taxels, 20 x 20 nodes."


def _options(function: Any) -> Any:
    for option in reversed(
        (
            click.option(
                "--solver",
                "solvers",
                multiple=True,
                help=SOLVER_HELP + PAPER_HELP + " May be repeated. Default gaussian; with --unseen "
                "paper, gaussian and contact.",
            ),
            click.option(
                "--settings", default="{}", help="Settings of the solver, as a JSON object."
            ),
            click.option(
                "--mechanics",
                type=click.Choice(["case", *MECHANICS]),
                default="case",
                show_default=True,
                help="Model of the elastomer that is assumed; 'case' takes what each case says.",
            ),
            click.option(
                "--grid",
                type=click.IntRange(min=1, max=500),
                default=40,
                show_default=True,
                help="Nodes on a side of the grid.",
            ),
            click.option(
                "--gate-mm",
                default=8.0,
                show_default=True,
                help="Farther apart, contacts are not the same.",
            ),
            click.option(
                "--noise",
                "noises",
                type=float,
                multiple=True,
                help="Of a reading, in the quantity's unit, added to exact readings; 0 adds none. "
                "May be repeated. Default what the cases hold.",
            ),
            click.option(
                "--unseen",
                type=click.IntRange(1, 100_000),
                help="So many random presses, made here, instead of CASES.",
            ),
            click.option(
                "--quantity",
                "quantities",
                type=click.Choice([name for name in QUANTITIES if name != "gap"]),
                multiple=True,
                help="What taxels read, with --unseen. May be repeated. Default both.",
            ),
            click.option(
                "--layout",
                default="icub_hexagon",
                show_default=True,
                help="Generator of the patch, with --unseen.",
            ),
            click.option(
                "--idle",
                type=click.IntRange(1, 10_000_000),
                default=5000,
                show_default=True,
                help="Readings of noise alone, with --unseen.",
            ),
            click.option(
                "--seed",
                type=click.IntRange(min=0),
                default=0,
                show_default=True,
                help="Of presses and noise, with --unseen or --noise.",
            ),
            click.option(
                "--workers",
                type=click.IntRange(min=1),
                default=os.cpu_count() or 1,
                show_default="one per core",
                help="Processes at once, with --unseen.",
            ),
            click.option(
                "--keep",
                type=click.Path(file_okay=False),
                help="Folder of what --unseen has computed: a run that was stopped goes on there.",
            ),
            click.option(
                "--figures",
                type=click.Path(file_okay=False),
                help="Folder for a picture of the errors per quantity, with --unseen or --noise.",
            ),
            click.option("--per-case", is_flag=True, help="A line per case, too."),
            click.option("--json", "json_path", help="Write summary and cases: .json."),
            click.option("--csv", "csv_path", help="Write a row per case: .csv."),
            click.option(
                "--require",
                multiple=True,
                metavar="MEASURE=MOST",
                help="Exit with 1 where the median, or the share 'missed', is higher; may be "
                "repeated.",
            ),
        )
    ):
        function = option(function)
    return function


@click.command(
    short_help="Score solvers on cases whose truth is known.",
    help="""Score a solver on the cases of a folder, or on one file.

CASES holds NPZ files as docs/cases.md describes them: layout, elastomer, readings and truth, from
a simulation, a rig or elsewhere; 'skinfield cases' writes some. The solver is told the layout, the
elastomer and the noise that a case states.

Errors are parts of the truth where no unit stands; the intervals are 95 %, over these cases.

With --noise, or with --unseen in place of CASES, several solvers are set beside each other at
several noises, with what is found in noise alone, the time per reading cold and warm, and, of
presses by balls, the Cramér-Rao bound.

\b
  skinfield cases cases && skinfield validate cases --solver gaussian
  skinfield validate cases --solver my_package.solvers:MySolver --settings '{"snr": 20}' --per-case
  skinfield validate cases --solver tikhonov --require place_error_mm=3 --json scores.json
  skinfield validate --unseen 200 --keep campaign --csv table.csv
  skinfield validate --unseen 20 --quantity stress --noise 0 --noise 400 --solver gaussian
""",
)
@click.argument("cases", required=False)
@_options
@click.pass_context
def validate(context: click.Context, /, cases: str | None, **options: Any) -> None:
    """Score and report."""
    from skinfield.cli import unseen

    limits_from_texts(options["require"])
    check_positive("--gate-mm", options["gate_mm"], "distance of contacts that are the same, in mm")
    for ending in ("csv", "json"):
        check_output(f"--{ending}", options[f"{ending}_path"], f".{ending}")
    if (cases is None) == (options["unseen"] is None):
        raise InputError(
            "expected either CASES, a folder or file, or --unseen with a number of presses"
        )
    _check_together(
        context,
        unseen=cases is None,
        noisy=bool(options["noises"]),
        named=bool(options["solvers"]),
    )
    if cases is None:
        unseen.validate_unseen(options)
    elif options["noises"]:
        unseen.validate_at_noises(cases, options)
    else:
        _score_as_it_is(cases, options)


def _check_together(context: click.Context, *, unseen: bool, noisy: bool, named: bool) -> None:
    """Refuse what would have no effect."""
    chosen = (named or not unseen, "--solver: with --unseen alone, solvers come as they are")
    needs = {
        **dict.fromkeys(("settings", "mechanics", "grid"), chosen),
        **dict.fromkeys(("quantities", "layout", "idle", "workers", "keep"), (unseen, "--unseen")),
        "figures": (unseen or noisy, "--unseen or --noise"),
        "seed": (unseen or noisy, "--unseen or --noise"),
        "per_case": (not unseen and not noisy, "CASES as they are: --json has every press"),
    }
    for parameter in context.command.params:
        fits, to = needs.get(str(parameter.name), (True, ""))
        given = context.get_parameter_source(str(parameter.name))
        if not fits and given is click.core.ParameterSource.COMMANDLINE:
            raise InputError(f"{parameter.opts[0]} has no effect here: it belongs to {to}")


def _score_as_it_is(cases: str, options: dict[str, Any]) -> None:
    """Score solvers one after another on the readings that the cases hold."""
    from skinfield.experiments.cases.files import case_paths
    from skinfield.experiments.scoring.rows import write_csv, write_json
    from skinfield.experiments.scoring.table_rows import flat

    paths, rows, summaries = case_paths(cases), [], {}
    for solver in options["solvers"] or ("gaussian",):
        entrant = method_from_options(solver, options).entrant(options["gate_mm"] * 1e-3)
        found, summary = _scored(paths, solver, entrant)
        if options["per_case"]:
            console().print(table_of_cases(found))
        title = f"{solver} on {plural(len(paths), 'case')}, {plural(summary.readings, 'reading')}"
        console().print(table_of_summary(summary, title))
        rows += found
        summaries[solver] = flat(summary)
    one = len(summaries) == 1
    if options["csv_path"]:
        write_csv(rows, options["csv_path"])
    if options["json_path"]:
        said = {key: options[key] for key in ("settings", "mechanics", "grid", "gate_mm")}
        said["solver"] = next(iter(summaries)) if one else list(summaries)
        result = next(iter(summaries.values())) if one else summaries
        write_json(rows, options["json_path"], options=said, summary=result)
    say_written(options)
    for columns in summaries.values():
        check_limits(limits_from_texts(options["require"]), columns)


def _scored(paths: list[Path], solver: str, entrant: Any) -> tuple[list[dict[str, Any]], Any]:
    """A row per case, and the summary of all their readings."""
    from skinfield.experiments.cases.files import load_case
    from skinfield.experiments.scoring.summary import summarise
    from skinfield.experiments.scoring.validation import row_of_case

    rows, scores = [], []
    with progress() as bar:
        task = bar.add_task(f"scoring {solver}", total=len(paths))
        for path in paths:
            case = load_case(path)
            with named(path, solver):
                found = entrant.scores(case)
            rows.append({"file": path.name, "solver": solver, **row_of_case(case, found)})
            scores += found
            bar.update(task, advance=1)
    return rows, summarise(scores)
