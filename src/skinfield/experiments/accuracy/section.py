"""The accuracy table in the report: its rows in short, a picture, and all of it as a file."""

from collections.abc import Sequence

import numpy as np

from skinfield.experiments.accuracy.picture import accuracy_figure
from skinfield.experiments.accuracy.plan import ANYWHERE, accuracy_plan
from skinfield.experiments.accuracy.rows import accuracy_tasks
from skinfield.experiments.paper.presses import BALL
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.section import Cell, Missing, Part, Picture, Section, Table, Verdict
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import png_of

COUNTS = 1.0  # of noise in the tables that are shown
SHOWN = (  # key, column, factor
    ("contact_force_error", "force of the contact, error (%)", 100.0),
    ("place_error_mm", "place, error (mm)", 1.0),
    ("peak_error", "peak pressure, error (%)", 100.0),
    ("pressure_error", "pressure, relative L2 (%)", 100.0),
    ("deformation_error", "deformation, relative L2 (%)", 100.0),
    ("area_error", "contact area, error (%)", 100.0),
)
RATES = (("missed", "missed (%)"), ("false_share", "readings with a false contact (%)"))
BOUNDS = (
    ("bound_place_mm", "bound of place (mm)", 1.0),
    ("bound_force", "bound of force (%)", 1e2),
)
PAPER, OURS = ("inverse (paper)", "half-space"), ("Gaussian field", "layer")


def accuracy_parts(settings: Settings) -> list[Part]:
    """One per indenter and load."""
    plan = accuracy_plan(settings.size.name)
    return [
        Part(name.replace(" ", "-"), function, arguments)
        for name, function, arguments in accuracy_tasks(plan)
    ]


def accuracy(settings: Settings, results: Sequence[list[Row] | None]) -> Section | Missing:
    """The table from the rows of its parts."""
    rows = [row for part in results for row in part or ()]
    known = [row for row in rows if row.get("readings")]
    if not known:
        return Missing("accuracy table: none of its parts could be computed")
    plan = accuracy_plan(settings.size.name)
    shown = [r for r in known if r["place"] == ANYWHERE and r["noise_counts"] == COUNTS]
    return Section(
        name="accuracy",
        title="Accuracy of every solver, beside the bound",
        claim="Peaks and shapes are looked at; no table of errors is given.",
        sentences=tuple(_sentences(known, shown, rows, plan.poses)),
        pictures=(_picture(rows),),
        tables=(_pooled(shown), _of_ball(shown), _everything(rows)),
        verdicts=tuple(_verdicts(shown)),
    )


def _of(rows: Sequence[Row], solver: str, model: str, quantity: str = "") -> list[Row]:
    return [
        row
        for row in rows
        if (row["solver"], row["model"]) == (solver, model) and quantity in ("", row["quantity"])
    ]


def _median(rows: Sequence[Row], key: str) -> float:
    """Median over rows, of those that have a number."""
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(np.median(values)) if values else float("nan")


def _sentences(
    known: Sequence[Row], shown: Sequence[Row], rows: Sequence[Row], poses: int
) -> list[str]:
    noise = sorted({row["noise_counts"] for row in known})
    unit = "count" if noise == [1.0] else "counts"
    sinks = sorted({f"{r['indenter']} at {r['load_N']:g} N" for r in rows if "sinks" in r["note"]})
    refused = [row for row in rows if row["note"] and "sinks" not in row["note"]]
    words = [
        f"{len(known)} combinations of solver, model of the elastomer, quantity, indenter, place "
        f"and load, each over {poses} presses, at a noise of "
        f"{', '.join(f'{each:g}' for each in noise)} {unit} of the iCub's byte. All are judged "
        "against the contact solver on the bonded layer; the bound is that of Cramér and Rao for "
        "place and force, with the indenter known, at the same noise.",
        "At one count, anywhere on the patch, medians over indenters and loads: "
        + "; ".join(_in_short(shown, quantity) for quantity in _quantities(shown))
        + ".",
        "Errors of place and of a contact's force are over the presses that were found; the bound "
        "is that of an unbiased estimate over all of them, so that where it is wide, what is found "
        "can lie below it.",
    ]
    if sinks:
        words.append(f"Left out: {', '.join(sinks)}: by linear elasticity through the layer.")
    if refused:
        words.append(f"{len(refused)} combinations were refused; their notes are in the file.")
    return words


def _quantities(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["quantity"] for row in rows))


def _in_short(shown: Sequence[Row], quantity: str) -> str:
    parts = []
    for who, (solver, model) in (("paper", PAPER), ("ours", OURS)):
        mine = _of(shown, solver, model, quantity)
        force = 100 * _median(mine, "contact_force_error_median")
        place = _median(mine, "place_error_mm_median")
        parts.append(f"{who} {force:.0f} % of force and {place:.1f} mm")
    mine = _of(shown, *OURS, quantity)
    bound = (
        f"{100 * _median(mine, 'bound_force'):.0f} % and {_median(mine, 'bound_place_mm'):.2f} mm"
    )
    return f"{quantity}: {', '.join(parts)}, bound {bound}"


def _verdicts(shown: Sequence[Row]) -> list[Verdict]:
    found = []
    for quantity in [name for name in _quantities(shown) if name != "gap"]:
        each = {who: _of(shown, *who, quantity) for who in (PAPER, OURS)}
        shape = [100 * _median(rows, "pressure_error_median") for rows in each.values()]
        force = [100 * _median(rows, "contact_force_error_median") for rows in each.values()]
        best = min(shape)
        found.append(
            Verdict(
                "table",
                f"force distributions are reconstructed ({quantity})",
                f"pressure off by {shape[0]:.0f} % (paper) and {shape[1]:.0f} % (ours), relative "
                f"L2; force of a contact by {force[0]:.0f} % and {force[1]:.0f} %; medians",
                "holds" if best < 20 else "holds only in part" if best < 50 else "does not hold",
            )
        )
    return found


def _pooled(shown: Sequence[Row]) -> Table:
    """One row per quantity, model and solver."""
    groups = dict.fromkeys((r["quantity"], r["model"], r["solver"]) for r in shown)
    rows = []
    for quantity, model, solver in groups:
        mine = _of(shown, solver, model, quantity)
        cells: list[Cell] = [quantity, model, solver]
        cells += [factor * _median(mine, f"{key}_median") for key, _, factor in SHOWN]
        cells += [100 * _mean(mine, key) for key, _ in RATES]
        cells += [factor * _median(mine, key) for key, _, factor in BOUNDS]
        rows.append(tuple(cells))
    columns = ("reads", "model", "solver", *_names())
    caption = (
        "At one count of noise, anywhere on the patch: medians over indenters and loads of the "
        "medians over presses, and mean rates. Errors in % are parts of the truth."
    )
    return Table("summary", caption, columns, tuple(rows))


def _names() -> tuple[str, ...]:
    return (
        *(name for _, name, _ in SHOWN),
        *(name for _, name in RATES),
        *(name for _, name, _ in BOUNDS),
    )


def _mean(rows: Sequence[Row], key: str) -> float:
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(np.mean(values)) if values else float("nan")


def _of_ball(shown: Sequence[Row]) -> Table:
    """The 1.2 cm half-sphere with its intervals, paper and ours."""
    rows = []
    for row in shown:
        if row["indenter"] != BALL.name or (row["solver"], row["model"]) not in (PAPER, OURS):
            continue
        cells: list[Cell] = [row["quantity"], row["load_N"], f"{row['solver']}, {row['model']}"]
        cells += [_interval(row, key, factor) for key, _, factor in SHOWN[:5]]
        cells += [_rate(row, key) for key, _ in RATES]
        cells += [None if row[k] is None else f * row[k] for k, _, f in BOUNDS]
        rows.append(tuple(cells))
    names = [name for name in _names() if name != SHOWN[5][1]]
    columns = ("reads", "load (N)", "solver and model", *names)
    caption = (
        "The 1.2 cm half-sphere at one count of noise, anywhere on the patch: medians over presses "
        "with their 95 % intervals (bootstrap; Wilson for rates)."
    )
    return Table("half-sphere", caption, columns, tuple(rows))


def _interval(row: Row, key: str, factor: float) -> str:
    middle, low, high = (row[f"{key}_{end}"] for end in ("median", "low", "high"))
    if middle is None:
        return "–"
    digits = 0 if factor > 1 else 1
    found = f"{factor * middle:.{digits}f}"
    if low is None or high is None:  # of a single press
        return found
    return f"{found} [{factor * low:.{digits}f}–{factor * high:.{digits}f}]"


def _rate(row: Row, key: str) -> str:
    low, high = row[f"{key}_low"], row[f"{key}_high"]
    return f"{100 * row[key]:.0f} [{100 * low:.0f}–{100 * high:.0f}]"


def _everything(rows: Sequence[Row]) -> Table:
    keys = tuple(dict.fromkeys(key for row in rows for key in row))
    cells = tuple(tuple(row.get(key) for key in keys) for row in rows)
    return Table("all", "Every row of the table.", keys, cells, shown=False)


def _picture(rows: Sequence[Row]) -> Picture:
    caption = (
        "The 1.2 cm half-sphere at one count of noise: error of place and force and presses missed "
        "against the load, by what taxels read; dotted, the Cramér-Rao bound for the same presses."
    )
    return Picture("errors", caption, png_of(accuracy_figure(rows, COUNTS)))
