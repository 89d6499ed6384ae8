"""Several solvers at several noises: on random presses, or on cases with exact readings."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Console

from skinfield.cli.contenders import entrant_from_options, named
from skinfield.cli.report import console, plural, print_json, progress
from skinfield.cli.scores import exceeds, limits_from_texts, say_written
from skinfield.errors import FileError, InputError

SHOWN = (  # columns of the accuracy rows, what the table calls them, and decimals
    ("force_error", 100.0, "force\n%", 0),
    ("place_error_mm", 1.0, "place\nmm", 2),
    ("contact_force_error", 100.0, "contact\nforce %", 0),
    ("blurred_pressure_error", 100.0, "blurred\npress. %", 0),
    ("deformation_error", 100.0, "deform.\n%", 0),
)
RATES = (
    ("missed", 100.0, "missed\n%", 0),
    ("false_per_reading", 1.0, "false per\nreading", 2),
    ("idle_false_per_reading", 1.0, "in noise\nalone", 4),
)
TIMES = (("cold_ms", 1.0, "cold\nms", 1), ("warm_ms", 1.0, "warm\nms", 2))
WIDE = 150  # columns of the terminal that the table takes


def validate_unseen(options: dict[str, Any]) -> bool:
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
    with _folder(options["keep"]) as folder, progress() as bar:
        task = bar.add_task("unseen presses")
        found = computed(
            plan,
            folder,
            options["workers"],
            lambda done, of: bar.update(task, completed=done, total=of),
        )
    return _report(found, options, plan.layout)


def validate_at_noises(cases: str, options: dict[str, Any]) -> bool:
    """Add noises to cases that hold exact readings, score every solver, and report."""
    from skinfield.lab.accuracy import Findings
    from skinfield.lab.case_files import case_paths, load_case
    from skinfield.lab.validation import Level, noise_seed, rows_of_case

    paths, rows = case_paths(cases), []
    tried = [entrant_from_options(name, options) for name in options["solver"] or ("gaussian",)]
    with progress() as bar:
        task = bar.add_task("scoring", total=len(paths))
        for index, path in enumerate(paths):
            case = load_case(path)
            levels = [Level(case.quantity, noise) for noise in options["noise"]]
            for method in tried:
                with named(path, method.name):
                    seed = noise_seed(options["seed"], index)
                    made = rows_of_case(case, levels, [method], seed)
                    rows += [{"case": case.name, "file": path.name} | row for row in made]
            bar.update(task, advance=1)
    return _report(Findings(rows, [], [], []), options, str(cases))


@contextmanager
def _folder(kept: str | None) -> Iterator[Path]:
    """The folder that is asked for, or one that goes away."""
    if kept is not None:
        yield Path(kept)
        return
    with TemporaryDirectory(prefix="skinfield-") as folder:
        yield Path(folder)


def _report(found: Any, options: dict[str, Any], where: str) -> bool:
    """Print and write; whether a limit is exceeded."""
    from skinfield.lab.accuracy import accuracy_rows, group_rows
    from skinfield.lab.score import write_csv, write_json

    rows = found.rows
    table = accuracy_rows(found, seed=options["seed"])
    presses = len({row["case"] for row in rows})
    for quantity in dict.fromkeys(row["quantity"] for row in table):
        mine = [row for row in table if row["quantity"] == quantity]
        if options["as_json"]:
            continue
        title = f"{quantity}: {plural(presses, 'case')} on {where}"
        Console(width=max(console().width, WIDE)).print(table_of_noises(mine, title))
    about = {"options": {"on": where}, "summary": table, "idle": found.idle}
    about["groups"] = group_rows(rows, seed=options["seed"])
    for name in options["output"]:
        if name.lower().endswith(".csv"):
            write_csv(table, name)
        else:
            write_json(rows, name, **about)
    if options["as_json"]:
        print_json(table)
    else:
        say_written(options)
    if options["figures"]:
        _draw(found, Path(options["figures"]))
    limits = limits_from_texts(options["require"])
    exceeded = [exceeds(limits, row) for row in table if "missed" in row]  # each is named
    return any(exceeded)


def _draw(found: Any, folder: Path) -> None:
    """Write a picture of the errors for each quantity."""
    from skinfield.files.pending import write_bytes
    from skinfield.lab.sections.accuracy import picture_of_errors

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FileError(f"{folder} cannot be made: {error}, expected a folder") from error
    for quantity in dict.fromkeys(row["quantity"] for row in found.rows):
        picture = picture_of_errors(quantity, found)
        path = folder / f"{picture.name}.png"
        write_bytes(path, picture.png)
        console().print(f"wrote {path}", highlight=False, soft_wrap=True, markup=False)


def table_of_noises(rows: Sequence[dict[str, Any]], title: str) -> Any:
    """Medians and 90th percentiles, noise by noise and solver by solver."""
    from rich import box
    from rich.table import Table

    title += "; median/90th percentile"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("noise", justify="right")
    table.add_column("solver")
    for _, _, label, _ in (*SHOWN, *RATES, *TIMES):
        table.add_column(label, justify="right")
    for index, row in enumerate(rows):
        new = index == 0 or row["noise"] != rows[index - 1]["noise"]
        last = index + 1 == len(rows) or rows[index + 1]["noise"] != row["noise"]
        cells = [f"{row['noise']:g}" if new else "", row["method"].rpartition(":")[2]]
        cells += [_pair(row, key, factor, digits) for key, factor, _, digits in SHOWN]
        cells += [_one(row.get(key), factor, digits) for key, factor, _, digits in RATES]
        cells += [_pair(row, key, factor, digits) for key, factor, _, digits in TIMES]
        table.add_row(*cells, end_section=last)
    return table


def _pair(row: dict[str, Any], key: str, factor: float, digits: int) -> str:
    if f"{key}_median" not in row:
        return ""
    middle = _one(row[f"{key}_median"], factor, digits)
    return f"{middle}/{_one(row[f'{key}_p90'], factor, digits)}"


def _one(value: float | None, factor: float, digits: int) -> str:
    """A number; an exponent would hide how large it is, so what is huge is cut."""
    if value is None:
        return ""
    if not math.isfinite(value):
        return "–"
    return f"{value * factor:.{digits}f}" if abs(value) * factor < 1e4 else ">9999"
