"""Several solvers at several noises: on random presses, or on cases with exact readings."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Console

from skinfield.cli.contenders import method_from_options, named
from skinfield.cli.report import console, plural, progress
from skinfield.cli.scores import check_limits, limits_from_texts, say_written
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
FINE, COARSE, MANY = (6, 7), (4, 5), 20  # balls for the bound: of as many presses, and of fewer


def validate_unseen(options: dict[str, Any]) -> None:
    """Press at random, score every solver at every noise, and report."""
    from skinfield.experiments.trust.campaign import computed
    from skinfield.experiments.trust.plan import NOISES, Level, TrustPlan, methods
    from skinfield.layout.generators import by_name

    quantities = options["quantities"] or tuple(NOISES)
    if options["noises"] and len(quantities) > 1:
        raise InputError("--noise is in a quantity's unit, expected one --quantity beside it")
    levels = [
        Level(quantity, noise)
        for quantity in quantities
        for noise in options["noises"] or NOISES[quantity]
    ]
    names = options["solvers"]
    plan = TrustPlan(
        methods=tuple(method_from_options(n, options) for n in names) if names else methods(),
        levels=tuple(dict.fromkeys(levels)),
        gate=options["gate_mm"] * 1e-3,
        layout=options["layout"],
        presses=options["unseen"],
        idle=options["idle"],
        bound_grid=FINE if options["unseen"] >= MANY else COARSE,
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
    _report(found, options, plan.layout)


def validate_at_noises(cases: str, options: dict[str, Any]) -> None:
    """Add noises to cases that hold exact readings, score every solver, and report."""
    from skinfield.experiments.cases.files import case_paths, load_case
    from skinfield.experiments.trust.attempts import noise_seed, rows_of_case
    from skinfield.experiments.trust.campaign import Found
    from skinfield.experiments.trust.plan import Level

    paths, rows = case_paths(cases), []
    tried = [method_from_options(name, options) for name in options["solvers"] or ("gaussian",)]
    with progress() as bar:
        task = bar.add_task("scoring", total=len(paths))
        for index, path in enumerate(paths):
            case = load_case(path)
            levels = [Level(case.quantity, noise) for noise in options["noises"]]
            for method in tried:
                with named(path, method.name):
                    made = rows_of_case(
                        case,
                        levels,
                        [method],
                        noise_seed(options["seed"], index),
                        options["gate_mm"] * 1e-3,
                    )
                    rows += [{"case": case.name, "file": path.name} | row for row in made]
            bar.update(task, advance=1)
    _report(Found(rows, [], [], []), options, str(cases))


@contextmanager
def _folder(kept: str | None) -> Iterator[Path]:
    """The folder that is asked for, or one that goes away."""
    if kept is not None:
        yield Path(kept)
        return
    with TemporaryDirectory(prefix="skinfield-") as folder:
        yield Path(folder)


def _report(found: Any, options: dict[str, Any], where: str) -> None:
    from skinfield.experiments.scoring.rows import write_csv, write_json
    from skinfield.experiments.trust.table import accuracy_rows, group_rows

    rows = found.rows
    table = accuracy_rows(rows, found.bound, found.idle, seed=options["seed"])
    presses = len({row["case"] for row in rows})
    for quantity in dict.fromkeys(row["quantity"] for row in table):
        mine = [row for row in table if row["quantity"] == quantity]
        title = f"{quantity}: {plural(presses, 'case')} on {where}"
        Console(width=max(console().width, WIDE)).print(table_of_noises(mine, title))
    if options["csv_path"]:
        write_csv(table, options["csv_path"])
    if options["json_path"]:
        about = {"options": {"on": where}, "summary": table, "idle": found.idle}
        about["groups"] = group_rows(rows, seed=options["seed"])
        write_json(rows, options["json_path"], **about)
    say_written(options)
    if options["figures"]:
        _draw(found, Path(options["figures"]))
    limits = limits_from_texts(options["require"])
    for row in table:
        if "missed" in row:
            check_limits(limits, row)


def _draw(found: Any, folder: Path) -> None:
    """Write a picture of the errors for each quantity."""
    from skinfield.experiments.trust.pictures import picture_of_errors
    from skinfield.sinks.pending import write_bytes

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FileError(f"{folder} cannot be made: {error}, expected a folder") from error
    for quantity in dict.fromkeys(row["quantity"] for row in found.rows):
        picture = picture_of_errors(quantity, found.rows, found.bound)
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
