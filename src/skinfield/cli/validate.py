"""`skinfield validate`: score solvers on cases whose truth is known."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from rich.console import Console

from skinfield.cli import options, report
from skinfield.cli.contenders import entrant_from_options, named
from skinfield.cli.scores import (
    PER_CASE,
    exceeds,
    limits_from_texts,
    table_of_noises,
    table_of_summary,
)
from skinfield.errors import InputError
from skinfield.settings.tree import Positive, Range

WIDE = 160  # columns of the terminal that a table of several noises takes
Rows = list[dict[str, Any]]


def validate(
    cases: str | None = None,
    /,
    *,
    solver: tuple[str, ...] = (),
    settings: str = "{}",
    mechanics: Literal["case", "layer", "covered-layer", "half-space"] = "case",
    grid: Annotated[int, Range(2, 500, "nodes on a side")] = 40,
    gate_mm: Annotated[float, Positive("distance of contacts that are the same, in mm")] = 8.0,
    noise: Annotated[tuple[float, ...], Range(0.0, 1e12, "0: none")] = (),
    unseen: Annotated[int | None, Range(1, 100_000, "random presses")] = None,
    quantity: tuple[Literal["capacitance", "stress"], ...] = (),
    layout: options.LayoutText = "icub_hexagon",
    idle: Annotated[int, Range(1, 10_000_000, "readings of noise alone")] = 5000,
    workers: options.Workers = None,
    seed: options.Seed = 0,
    per_case: bool = False,
    output: Annotated[tuple[str, ...], options.OUTPUT] = (),
    force: options.Force = False,
    as_json: options.Json = False,
    require: tuple[str, ...] = (),
) -> int:
    """Score a solver on the cases of a folder, or on one file.

    CASES holds NPZ files as docs/cases.md describes them: layout, elastomer, readings and truth,
    from a simulation, a rig or elsewhere; 'skinfield cases' writes some. The solver is told the
    layout, the elastomer and the noise that a case states.

    Errors are parts of the truth where no unit stands; the intervals are 95 %, over these cases.

    With --noise, or with --unseen in place of CASES, several solvers are set beside each other at
    several noises, with the share of forces within their 90 % intervals and the time per reading
    cold and warm; with --unseen also what is found in noise alone and, of presses by balls, the
    Cramér-Rao bound.

      skinfield cases cases && skinfield validate cases --solver gaussian
      skinfield validate cases --solver my_package.solvers:MySolver --settings '{"snr": 20}'
      skinfield validate cases --solver tikhonov --require place_error_mm=3 -o scores.json
      skinfield validate exact --noise 0 --noise 400 --solver gaussian --solver contact
      skinfield validate --unseen 200 -o table.csv
      skinfield validate --unseen 20 --quantity stress --noise 400 --solver contact

    Parameters
    ----------
    cases : str, optional
        DIR of cases, or the file of one (.npz).
    solver : tuple of str
        One of gaussian, contact, nonnegative, tikhonov, pseudo-inverse, inverse; or your own as
        package.module:Class, from what is installed or lies in the current folder; or paper, its
        method: half-space, interpolated taxels, 20 x 20 nodes. Again for more. Default gaussian;
        with --unseen paper, gaussian and contact.
    settings : str
        Settings of the solver, as a JSON object.
    mechanics : str
        Model of the elastomer that is assumed; 'case' takes what each case says.
    grid : int
        Nodes on a side of the grid.
    gate_mm : float, mm
        Farther apart, contacts are not the same, mm.
    noise : tuple of float
        Of a reading, in the quantity's unit, added to exact readings; 0 adds none. Again for more.
        Default what the cases hold.
    unseen : int, optional
        So many random presses, made here, instead of CASES.
    quantity : tuple of str
        What taxels read, with --unseen. Again for more. Default both.
    idle : int
        Readings of noise alone, with --unseen.
    per_case : bool
        A line per case, too.
    output : tuple of str
        Summary and cases (.json), or a row per case (.csv); again for both.
    require : tuple of str
        MEASURE=MOST: exit with 1 where the median, or the share 'missed', is higher; again for
        more.
    """
    values = dict(locals())
    limits_from_texts(require)
    for name in output:
        report.check_output("--output", name, force, ".csv", ".json")
    if (cases is None) == (unseen is None):
        raise InputError(
            "expected either CASES, a folder or file, or --unseen with a number of presses"
        )
    _check_together(values)
    if unseen is not None:
        return int(_score_unseen(values))
    return int(_score_at_noises(values) if noise else _score_as_it_is(values))


def _check_together(values: dict[str, Any]) -> None:
    """Refuse what would have no effect."""
    unseen, noisy = values["unseen"] is not None, bool(values["noise"])
    named = (
        bool(values["solver"]) or not unseen,
        "--solver: with --unseen alone, solvers come as they are",
    )
    needs = {
        **dict.fromkeys(("settings", "mechanics", "grid"), named),
        **dict.fromkeys(("quantity", "layout", "idle", "workers"), (unseen, "--unseen")),
        "seed": (unseen or noisy, "--unseen or --noise"),
        "per_case": (not unseen and not noisy, "CASES as they are: -o FILE.json has every press"),
    }
    for name, flag in options.flags_set(validate, values):
        fits, owner = needs.get(name, (True, ""))
        if not fits:
            raise InputError(f"{flag} has no effect here: it belongs to {owner}")


def _score_as_it_is(values: dict[str, Any]) -> bool:
    """Score solvers one after another on the readings that the cases hold."""
    from skinfield.lab.case_files import case_paths

    paths, rows, summaries = case_paths(values["cases"]), [], {}
    lines: list[report.Shown] = []
    for solver in values["solver"] or ("gaussian",):
        mine, summary = _scored(paths, solver, entrant_from_options(solver, values))
        if values["per_case"]:
            lines.append(report.table_of("Medians over each case's readings", mine, PER_CASE))
        readings = report.plural(summary["readings"], "reading")
        title = f"{solver} on {report.plural(len(paths), 'case')}, {readings}"
        lines.append(table_of_summary(summary, title))
        rows += mine
        summaries[solver] = summary
    one = len(summaries) == 1
    result = next(iter(summaries.values())) if one else summaries
    about = {key: values[key] for key in ("settings", "mechanics", "grid", "gate_mm")}
    about["solver"] = next(iter(summaries)) if one else list(summaries)
    files = {"options": about, "summary": result}
    report.finish(values["as_json"], result, lines=lines)
    return _finish(values, rows, rows, files, list(summaries.values()))


def _finish(
    values: dict[str, Any], rows: Rows, csv: Rows, about: dict[str, Any], judged: Rows
) -> bool:
    """Write what was scored; whether a limit is exceeded."""
    from skinfield.lab.score import write_csv, write_json

    for name in values["output"]:
        if name.lower().endswith(".csv"):
            write_csv(csv, name)
        else:
            write_json(rows, name, **about)
        if not values["as_json"]:
            report.say(f"wrote {name}")
    limits = limits_from_texts(values["require"])
    exceeded = [exceeds(limits, columns) for columns in judged]  # each is named
    return any(exceeded)


def _scored(paths: list[Path], solver: str, entrant: Any) -> tuple[list[dict[str, Any]], Any]:
    """A row per case, and the summary of all their readings."""
    from skinfield.lab.case_files import load_case
    from skinfield.lab.score import summarise
    from skinfield.lab.validation import row_of_case

    rows, scores = [], []
    with report.progress(f"scoring {solver}", len(paths)) as step:
        for path in paths:
            case = load_case(path)
            with named(path, solver):
                each = entrant.scores(case)
            rows.append({"file": path.name, "solver": solver, **row_of_case(case, each)})
            scores += each
            step()
    return rows, summarise([score.row() for score in scores])


def _score_unseen(values: dict[str, Any]) -> bool:
    """Press at random, score every solver at every noise, and report beside the bound."""
    from skinfield.lab.accuracy import NOISES, AccuracyPlan, computed
    from skinfield.lab.validation import Level, known_entrants

    quantities = values["quantity"] or tuple(NOISES)
    if values["noise"] and len(quantities) > 1:
        raise InputError("--noise is in a quantity's unit, expected one --quantity beside it")
    levels = [(each, noise) for each in quantities for noise in values["noise"] or NOISES[each]]
    chosen = [entrant_from_options(name, values) for name in values["solver"]]
    gate = values["gate_mm"] * 1e-3
    plan = AccuracyPlan(
        entrants=tuple(chosen or (replace(each, gate=gate) for each in known_entrants())),
        levels=tuple(Level(*each) for each in dict.fromkeys(levels)),
        layout=values["layout"],
        presses=values["unseen"],
        idle=values["idle"],
        seed=values["seed"],
    )
    number = options.processes(values["workers"])
    patch = plan.patch.name  # an unknown one is said before anything is computed
    with report.progress("unseen presses") as step:
        findings = computed(plan, number, step)
    return _report_noises(findings, patch, values)


def _score_at_noises(values: dict[str, Any]) -> bool:
    """Add noises to cases that hold exact readings, score every solver, and report."""
    from skinfield.lab.accuracy import Findings
    from skinfield.lab.case_files import case_paths, load_case
    from skinfield.lab.validation import Level, noise_seed, rows_of_case

    tried = [entrant_from_options(name, values) for name in values["solver"] or ("gaussian",)]
    paths: list[Path] = case_paths(values["cases"])
    rows: Rows = []
    with report.progress("scoring", len(paths)) as step:
        for index, path in enumerate(paths):
            case, seed = load_case(path), noise_seed(values["seed"], index)
            levels = [Level(case.quantity, noise) for noise in values["noise"]]
            for method in tried:
                with named(path, method.name):
                    scored = rows_of_case(case, levels, [method], seed)
                rows += [{"case": case.name, "file": path.name} | row for row in scored]
            step()
    return _report_noises(Findings(rows, [], [], []), values["cases"], values)


def _report_noises(findings: Any, where: str, values: dict[str, Any]) -> bool:
    """Print a table for each quantity, and write; whether a limit is exceeded."""
    from skinfield.lab.accuracy import accuracy_rows, group_rows

    summary = accuracy_rows(findings, seed=values["seed"])
    count = report.plural(len({row["case"] for row in findings.rows}), "case")
    if values["as_json"]:
        report.print_json(summary)
    else:  # wider than other tables
        out = Console(width=max(report.console().width, WIDE))
        for quantity in dict.fromkeys(row["quantity"] for row in summary):
            mine = [row for row in summary if row["quantity"] == quantity]
            out.print(table_of_noises(mine, f"{quantity}: {count} on {where}"))
    about = {"options": {"on": where}, "summary": summary}
    about["groups"] = group_rows(findings.rows, seed=values["seed"])
    judged = [row for row in summary if "missed" in row]  # not the bound
    return _finish(values, findings.rows, summary, about, judged)
