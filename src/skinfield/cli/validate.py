"""`skinfield validate`: score solvers on cases whose truth is known."""

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Literal

from rich.console import Console

from skinfield.cli.contenders import entrant_from_options, named
from skinfield.cli.options import OUTPUT, Force, Json, flags_set, processes
from skinfield.cli.report import check_output, console, finish, note, plural, progress
from skinfield.cli.scores import (
    exceeds,
    limits_from_texts,
    table_of_cases,
    table_of_noises,
    table_of_summary,
)
from skinfield.errors import FileError, InputError, check_count, check_positive

WIDE = 150  # columns of the terminal that a table of several noises takes
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
    seed: int = 0,
    workers: int | None = None,
    keep: str | None = None,
    figures: str | None = None,
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
    several noises, with what is found in noise alone, the time per reading cold and warm, and, of
    presses by balls, the Cramér-Rao bound.

      skinfield cases cases && skinfield validate cases --solver gaussian
      skinfield validate cases --solver my_package.solvers:MySolver --settings '{"snr": 20}'
      skinfield validate cases --solver tikhonov --require place_error_mm=3 -o scores.json
      skinfield validate --unseen 200 --keep campaign -o table.csv
      skinfield validate --unseen 20 --quantity stress --noise 0 --noise 400 --solver gaussian

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
    seed : int
        Of presses and noise, with --unseen or --noise.
    workers : int, optional
        Processes at once, with --unseen. Default one for each core.
    keep : str, optional
        DIR of what --unseen has computed: a run that was stopped goes on there.
    figures : str, optional
        DIR for a picture of the errors per quantity, with --unseen or --noise.
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
    for name, value, low, high in (
        ("--grid", grid, 1, 500), ("--unseen", unseen, 1, 100_000),
        ("--idle", idle, 1, 10_000_000), ("--seed", seed, 0, 1 << 63),
    ):  # fmt: skip
        if value is not None:
            check_count(name, value, low, high, "see --help")
    for name in output:
        check_output("--output", name, force, ".csv", ".json")
    if (cases is None) == (unseen is None):
        raise InputError(
            "expected either CASES, a folder or file, or --unseen with a number of presses"
        )
    flags = flags_set(validate, options)
    _check_together(flags, unseen=cases is None, noisy=bool(noise), named=bool(solver))
    if cases is None:
        return int(_score_unseen(options))
    return int(_score_at_noises(cases, options) if noise else _score_as_it_is(cases, options))


def _check_together(
    flags: list[tuple[str, str]], *, unseen: bool, noisy: bool, named: bool
) -> None:
    """Refuse what would have no effect."""
    chosen = (named or not unseen, "--solver: with --unseen alone, solvers come as they are")
    needs = {
        **dict.fromkeys(("settings", "mechanics", "grid"), chosen),
        **dict.fromkeys(("quantity", "layout", "idle", "workers", "keep"), (unseen, "--unseen")),
        "figures": (unseen or noisy, "--unseen or --noise"),
        "seed": (unseen or noisy, "--unseen or --noise"),
        "per_case": (not unseen and not noisy, "CASES as they are: -o FILE.json has every press"),
    }
    for name, flag in flags:
        fits, to = needs.get(name, (True, ""))
        if not fits:
            raise InputError(f"{flag} has no effect here: it belongs to {to}")


def _score_as_it_is(cases: str, options: dict[str, Any]) -> bool:
    """Score solvers one after another on the readings that the cases hold."""
    from skinfield.lab.case_files import case_paths

    paths, rows, summaries = case_paths(cases), [], {}
    for solver in options["solver"] or ("gaussian",):
        mine, summary = _scored(paths, solver, entrant_from_options(solver, options))
        if not options["as_json"]:
            if options["per_case"]:
                console().print(table_of_cases(mine))
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
    from skinfield.lab.score import write_csv, write_json

    for name in options["output"]:
        if name.lower().endswith(".csv"):
            write_csv(csv, name)
        else:
            write_json(rows, name, **about)
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
    """Press at random, score every solver at every noise, and report."""
    from skinfield.lab.accuracy import NOISES, AccuracyPlan, computed
    from skinfield.lab.validation import Level, known_entrants
    from skinfield.skin.generators import by_name

    quantities = options["quantity"] or tuple(NOISES)
    if options["noise"] and len(quantities) > 1:
        raise InputError("--noise is in a quantity's unit, expected one --quantity beside it")
    levels = [
        Level(quantity, noise)
        for quantity in quantities
        for noise in options["noise"] or NOISES[quantity]
    ]
    names = options["solver"]
    entrants = tuple(entrant_from_options(name, options) for name in names) or tuple(
        replace(entrant, gate=options["gate_mm"] * 1e-3) for entrant in known_entrants()
    )
    plan = AccuracyPlan(
        entrants=entrants,
        levels=tuple(dict.fromkeys(levels)),
        layout=options["layout"],
        presses=options["unseen"],
        idle=options["idle"],
        seed=options["seed"],
    )
    by_name(plan.layout)  # an unknown one is said before anything is computed
    with ExitStack() as parts:
        kept = options["keep"] or parts.enter_context(TemporaryDirectory(prefix="skinfield-"))
        step = parts.enter_context(progress("unseen presses"))
        findings = computed(plan, Path(kept), processes(options["workers"]), step)
    return _report(findings, options, plan.layout)


def _score_at_noises(cases: str, options: dict[str, Any]) -> bool:
    """Add noises to cases that hold exact readings, score every solver, and report."""
    from skinfield.lab.accuracy import Findings
    from skinfield.lab.case_files import case_paths, load_case
    from skinfield.lab.validation import Level, noise_seed, rows_of_case

    paths, rows = case_paths(cases), []
    tried = [entrant_from_options(name, options) for name in options["solver"] or ("gaussian",)]
    with progress("scoring", len(paths)) as step:
        for index, path in enumerate(paths):
            case = load_case(path)
            levels = [Level(case.quantity, noise) for noise in options["noise"]]
            for method in tried:
                with named(path, method.name):
                    seed = noise_seed(options["seed"], index)
                    made = rows_of_case(case, levels, [method], seed)
                    rows += [{"case": case.name, "file": path.name} | row for row in made]
            step()
    return _report(Findings(rows, [], [], []), options, str(cases))


def _report(findings: Any, options: dict[str, Any], where: str) -> bool:
    """Print and write; whether a limit is exceeded."""
    from skinfield.lab.accuracy import accuracy_rows, group_rows

    rows = findings.rows
    table = accuracy_rows(findings, seed=options["seed"])
    presses = len({row["case"] for row in rows})
    for quantity in dict.fromkeys(row["quantity"] for row in table):
        mine = [row for row in table if row["quantity"] == quantity]
        if options["as_json"]:
            continue
        title = f"{quantity}: {plural(presses, 'case')} on {where}"
        Console(width=max(console().width, WIDE)).print(table_of_noises(mine, title))
    about = {"options": {"on": where}, "summary": table, "idle": findings.idle}
    about["groups"] = group_rows(rows, seed=options["seed"])
    if options["figures"]:
        _draw(findings, Path(options["figures"]))
    return _finish(options, rows, table, about, table, [row for row in table if "missed" in row])


def _draw(findings: Any, folder: Path) -> None:
    """Write a picture of the errors for each quantity."""
    from skinfield.files.pending import write_bytes
    from skinfield.lab.sections.accuracy import picture_of_errors

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FileError(f"{folder} cannot be made: {error}, expected a folder") from error
    for quantity in dict.fromkeys(row["quantity"] for row in findings.rows):
        picture = picture_of_errors(quantity, findings)
        path = folder / f"{picture.name}.png"
        write_bytes(path, picture.png)
        note(f"wrote {path}")
