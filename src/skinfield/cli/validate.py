"""`skinfield validate`: score solvers on cases whose truth is known."""

import os
from pathlib import Path
from typing import Annotated, Any, Literal

from skinfield.cli.contenders import entrant_from_options, named
from skinfield.cli.options import OUTPUT, Force, Json, flags_given
from skinfield.cli.report import check_new, check_output, console, plural, print_json, progress
from skinfield.cli.scores import (
    exceeds,
    limits_from_texts,
    say_written,
    table_of_cases,
    table_of_summary,
)
from skinfield.errors import InputError, check_count, check_positive


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
    from skinfield.cli import unseen as at_noises

    options = dict(locals())
    limits_from_texts(require)
    check_positive("--gate-mm", gate_mm, "distance of contacts that are the same, in mm")
    for name, value, low, high in (
        ("--grid", grid, 1, 500), ("--unseen", unseen, 1, 100_000),
        ("--idle", idle, 1, 10_000_000), ("--seed", seed, 0, 1 << 63),
        ("--workers", workers, 1, 1 << 12),
    ):  # fmt: skip
        if value is not None:
            check_count(name, value, low, high, "see --help")
    for name in output:
        if Path(name).suffix.lower() not in (".csv", ".json"):
            raise InputError(f"--output is {name!r}, expected a name that ends in .csv or .json")
        check_output("--output", name, Path(name).suffix.lower())
        check_new("--output", name, force)
    if (cases is None) == (unseen is None):
        raise InputError(
            "expected either CASES, a folder or file, or --unseen with a number of presses"
        )
    _check_together(
        flags_given(validate, options),
        unseen=cases is None,
        noisy=bool(noise),
        named=bool(solver),
    )
    options["workers"] = workers or os.cpu_count() or 1
    if cases is None:
        failed = at_noises.validate_unseen(options)
    elif noise:
        failed = at_noises.validate_at_noises(cases, options)
    else:
        failed = _score_as_it_is(cases, options)
    return int(failed)


def _check_together(
    given: list[tuple[str, str]], *, unseen: bool, noisy: bool, named: bool
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
    for name, flag in given:
        fits, to = needs.get(name, (True, ""))
        if not fits:
            raise InputError(f"{flag} has no effect here: it belongs to {to}")


def _score_as_it_is(cases: str, options: dict[str, Any]) -> bool:
    """Score solvers one after another on the readings that the cases hold."""
    from skinfield.lab.case_files import case_paths
    from skinfield.lab.score import write_csv, write_json

    paths, rows, summaries = case_paths(cases), [], {}
    for solver in options["solver"] or ("gaussian",):
        entrant = entrant_from_options(solver, options)
        found, summary = _scored(paths, solver, entrant)
        if options["per_case"] and not options["as_json"]:
            console().print(table_of_cases(found))
        if not options["as_json"]:
            readings = plural(summary["readings"], "reading")
            title = f"{solver} on {plural(len(paths), 'case')}, {readings}"
            console().print(table_of_summary(summary, title))
        rows += found
        summaries[solver] = summary
    one = len(summaries) == 1
    result = next(iter(summaries.values())) if one else summaries
    said = {key: options[key] for key in ("settings", "mechanics", "grid", "gate_mm")}
    said["solver"] = next(iter(summaries)) if one else list(summaries)
    for name in options["output"]:
        if name.lower().endswith(".csv"):
            write_csv(rows, name)
        else:
            write_json(rows, name, options=said, summary=result)
    if options["as_json"]:
        print_json(result)
    else:
        say_written(options)
    limits = limits_from_texts(options["require"])
    exceeded = [exceeds(limits, columns) for columns in summaries.values()]  # each is named
    return any(exceeded)


def _scored(paths: list[Path], solver: str, entrant: Any) -> tuple[list[dict[str, Any]], Any]:
    """A row per case, and the summary of all their readings."""
    from skinfield.lab.case_files import load_case
    from skinfield.lab.score import summarise
    from skinfield.lab.validation import row_of_case

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
    return rows, summarise([score.row() for score in scores])
