"""`skinfield validate`: score solvers on cases whose truth is known."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from rich.console import Console

from skinfield.cli.contenders import entrant_from_options, named
from skinfield.cli.options import OUTPUT, Force, Json, flags_set, processes
from skinfield.cli.report import check_output, console, finish, plural, progress, table_of
from skinfield.cli.scores import (
    PER_CASE,
    exceeds,
    limits_from_texts,
    table_of_noises,
    table_of_summary,
)
from skinfield.errors import InputError, check_count, check_positive

WIDE = 160  # columns of the terminal that a table of several noises takes
Rows = list[dict[str, Any]]


def validate(
    cases: str | None = None,
    /,
    *,
    solver: tuple[str, ...] = (),
    settings: str = "{}",
    mechanics: Literal["case", "layer", "covered-layer", "half-space"] = "case",
    grid: int = 40,
    gate_mm: float = 8.0,
    noise: tuple[float, ...] = (),
    unseen: int | None = None,
    quantity: tuple[Literal["capacitance", "stress"], ...] = (),
    layout: str = "icub_hexagon",
    idle: int = 5000,
    workers: int | None = None,
    seed: int = 0,
    per_case: bool = False,
    output: Annotated[tuple[str, ...], OUTPUT] = (),
    force: Force = False,
    as_json: Json = False,
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
    layout : str
        Generator of the patch, with --unseen.
    idle : int
        Readings of noise alone, with --unseen.
    workers : int, optional
        Processes at once, with --unseen. Default one for each core.
    seed : int
        Of presses and noise, with --unseen or --noise.
    per_case : bool
        A line per case, too.
    output : tuple of str
        Summary and cases (.json), or a row per case (.csv); again for both.
    as_json : bool
        Summary as one JSON object.
    require : tuple of str
        MEASURE=MOST: exit with 1 where the median, or the share 'missed', is higher; again for
        more.
    """
    options = dict(locals())
    limits_from_texts(require)
    check_positive("--gate-mm", gate_mm, "distance of contacts that are the same, in mm")
    check_count("--grid", grid, 1, 500, "nodes on a side")
    check_count("--seed", seed, 0, 1 << 63, "of presses and noise")
    check_count("--idle", idle, 1, 10_000_000, "readings of noise alone")
    for name in output:
        check_output("--output", name, force, ".csv", ".json")
    if (cases is None) == (unseen is None):
        raise InputError(
            "expected either CASES, a folder or file, or --unseen with a number of presses"
        )
    _check_together(options)
    if unseen is not None:
        check_count("--unseen", unseen, 1, 100_000, "random presses")
        return int(_score_unseen(options))
    return int(_score_at_noises(options) if noise else _score_as_it_is(options))


def _check_together(options: dict[str, Any]) -> None:
    """Refuse what would have no effect."""
    unseen, noisy = options["unseen"] is not None, bool(options["noise"])
    named = (
        bool(options["solver"]) or not unseen,
        "--solver: with --unseen alone, solvers come as they are",
    )
    needs = {
        **dict.fromkeys(("settings", "mechanics", "grid"), named),
        **dict.fromkeys(("quantity", "layout", "idle", "workers"), (unseen, "--unseen")),
        "seed": (unseen or noisy, "--unseen or --noise"),
        "per_case": (not unseen and not noisy, "CASES as they are: -o FILE.json has every press"),
    }
    for name, flag in flags_set(validate, options):
        fits, owner = needs.get(name, (True, ""))
        if not fits:
            raise InputError(f"{flag} has no effect here: it belongs to {owner}")


def _score_as_it_is(options: dict[str, Any]) -> bool:
    """Score solvers one after another on the readings that the cases hold."""
    from skinfield.lab.case_files import case_paths

    paths, rows, summaries = case_paths(options["cases"]), [], {}
    for solver in options["solver"] or ("gaussian",):
        mine, summary = _scored(paths, solver, entrant_from_options(solver, options))
        if not options["as_json"]:
            if options["per_case"]:
                title = "Medians over each case's readings"
                console().print(table_of(title, mine, PER_CASE))
            readings = plural(summary["readings"], "reading")
            title = f"{solver} on {plural(len(paths), 'case')}, {readings}"
            console().print(table_of_summary(summary, title))
        rows += mine
        summaries[solver] = summary
    one = len(summaries) == 1
    result = next(iter(summaries.values())) if one else summaries
    about = {key: options[key] for key in ("settings", "mechanics", "grid", "gate_mm")}
    about["solver"] = next(iter(summaries)) if one else list(summaries)
    files = {"options": about, "summary": result}
    return _finish(options, rows, rows, files, result, list(summaries.values()))


def _finish(
    options: dict[str, Any], rows: Rows, csv: Rows, about: dict[str, Any], result: Any, judged: Rows
) -> bool:
    """Write and print what was scored; whether a limit is exceeded."""
    from skinfield.files import write_summary
    from skinfield.lab.score import write_csv

    for name in options["output"]:
        if name.lower().endswith(".csv"):
            write_csv(csv, name)
        else:
            write_summary(name, about | {"rows": rows})
    finish(options["as_json"], result, options["output"])
    limits = limits_from_texts(options["require"])
    exceeded = [exceeds(limits, columns) for columns in judged]  # each is named
    return any(exceeded)


def _scored(paths: list[Path], solver: str, entrant: Any) -> tuple[list[dict[str, Any]], Any]:
    """A row per case, and the summary of all their readings."""
    from skinfield.lab.case_files import load_case
    from skinfield.lab.score import summarise
    from skinfield.lab.validation import row_of_case

    rows, scores = [], []
    with progress(f"scoring {solver}", len(paths)) as step:
        for path in paths:
            case = load_case(path)
            with named(path, solver):
                each = entrant.scores(case)
            rows.append({"file": path.name, "solver": solver, **row_of_case(case, each)})
            scores += each
            step()
    return rows, summarise([score.row() for score in scores])


def _score_unseen(options: dict[str, Any]) -> bool:
    """Press at random, score every solver at every noise, and report beside the bound."""
    from skinfield.lab.accuracy import NOISES, AccuracyPlan, computed
    from skinfield.lab.validation import Level, known_entrants

    quantities = options["quantity"] or tuple(NOISES)
    if options["noise"] and len(quantities) > 1:
        raise InputError("--noise is in a quantity's unit, expected one --quantity beside it")
    levels = [(each, noise) for each in quantities for noise in options["noise"] or NOISES[each]]
    chosen = [entrant_from_options(name, options) for name in options["solver"]]
    gate = options["gate_mm"] * 1e-3
    plan = AccuracyPlan(
        entrants=tuple(chosen or (replace(each, gate=gate) for each in known_entrants())),
        levels=tuple(Level(*each) for each in dict.fromkeys(levels)),
        layout=options["layout"],
        presses=options["unseen"],
        idle=options["idle"],
        seed=options["seed"],
    )
    number = processes(options["workers"])
    patch = plan.patch.name  # an unknown one is said before anything is computed
    with progress("unseen presses") as step:
        findings = computed(plan, number, step)
    return _report_noises(findings, patch, options)


def _score_at_noises(options: dict[str, Any]) -> bool:
    """Add noises to cases that hold exact readings, score every solver, and report."""
    from skinfield.lab.accuracy import Findings
    from skinfield.lab.case_files import case_paths, load_case
    from skinfield.lab.validation import Level, noise_seed, rows_of_case

    tried = [entrant_from_options(name, options) for name in options["solver"] or ("gaussian",)]
    paths: list[Path] = case_paths(options["cases"])
    rows: Rows = []
    with progress("scoring", len(paths)) as step:
        for index, path in enumerate(paths):
            case, seed = load_case(path), noise_seed(options["seed"], index)
            levels = [Level(case.quantity, noise) for noise in options["noise"]]
            for method in tried:
                with named(path, method.name):
                    scored = rows_of_case(case, levels, [method], seed)
                rows += [{"case": case.name, "file": path.name} | row for row in scored]
            step()
    return _report_noises(Findings(rows), options["cases"], options)


def _report_noises(findings: Any, where: str, options: dict[str, Any]) -> bool:
    """Print a table for each quantity, and write; whether a limit is exceeded."""
    from skinfield.lab.accuracy import accuracy_rows

    summary = accuracy_rows(findings, seed=options["seed"])
    count = plural(len({row["case"] for row in findings.rows}), "case")
    for quantity in dict.fromkeys(row["quantity"] for row in summary):
        mine = [row for row in summary if row["quantity"] == quantity]
        if not options["as_json"]:
            made = table_of_noises(mine, f"{quantity}: {count} on {where}")
            Console(width=max(console().width, WIDE)).print(made)
    about = {"options": {"on": where}, "summary": summary}
    judged = [row for row in summary if "missed" in row]  # not the bound
    return _finish(options, findings.rows, summary, about, summary, judged)
