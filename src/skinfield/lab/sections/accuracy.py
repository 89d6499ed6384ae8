"""Accuracy in the report: errors on random presses beside the bound."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.errors import SkinfieldError
from skinfield.lab.accuracy import (
    PRIORS,
    AccuracyPlan,
    Findings,
    accuracy_plan,
    accuracy_rows,
    group_rows,
    parts_of,
)
from skinfield.lab.case_sets import SILICONE
from skinfield.lab.plots import LIMIT, STEPS, Panel, Scale, distribution, draw_panels
from skinfield.lab.report import (
    Cell,
    Picture,
    Section,
    Settings,
    Table,
    Verdict,
    verdict_of,
)
from skinfield.lab.runner import Task
from skinfield.lab.score import Row, column, where
from skinfield.lab.validation import CONTACT, GAUSSIAN, PAPER
from skinfield.plot.style import number

PAIRED = (  # median with its interval, and the 90th percentile
    ("force_error", "force (%)", 100.0),
    ("place_error_mm", "place (mm)", 1.0),
    ("contact_force_error", "force of a contact (%)", 100.0),
    ("blurred_pressure_error", "pressure, blurred by 2 mm (%)", 100.0),
    ("deformation_error", "deformation (%)", 100.0),
)
PLAIN = (
    ("missed", "missed (%)", 100.0),
    ("false_per_reading", "false contacts per reading", 1.0),
    ("idle_false_per_reading", "in noise alone", 1.0),
    ("place_held", "place within its 90 % region (%)", 100.0),
    ("force_held", "force within its 90 % interval (%)", 100.0),
    ("cold_ms_median", "time, cold (ms)", 1.0),
    ("warm_ms_median", "time, warm (ms)", 1.0),
)
NAMES = {PAPER: "paper's method", GAUSSIAN: "GaussianField", CONTACT: "ContactFit"}
ERRORS = (  # column, label, factor, ends of the axis
    ("force_error", "error of the force (%)", 100.0, (0.3, 200.0)),
    ("place_error_mm", "error of place (mm)", 1.0, (0.01, 8.0)),
)


def accuracy_parts(settings: Settings) -> list[Task]:
    """Shares of the campaign."""
    return parts_of(accuracy_plan(settings.size.name, settings.seed))


def accuracy(settings: Settings, results: Sequence[dict[str, Any] | None]) -> Section:
    """The section from the results of its parts."""
    plan = accuracy_plan(settings.size.name, settings.seed)
    findings = Findings.of(results)
    if not findings.rows:
        raise SkinfieldError("none of the parts of accuracy could be computed, expected some")
    table = accuracy_rows(findings, seed=plan.seed)
    groups = sorted(
        group_rows(findings.rows, seed=plan.seed), key=lambda row: (row["quantity"], row["noise"])
    )
    presses = len({row["case"] for row in findings.rows})
    return Section(
        name="accuracy",
        title="Accuracy on random presses, beside the bound",
        claim="Peaks and shapes are looked at; no table of errors is given.",
        sentences=(
            f"{presses} random presses on {plan.layout}, {SILICONE.thickness * 1e3:g} mm of "
            "silicone: of twenty, twelve by single balls of 2 to 15 mm radius (some cones), five "
            "by two or three bodies, three by flats, bars or rings; 0.2 to 3 N each.",
            "The truth is the contact solver's on squares of its own. The solvers are told layout, "
            "elastomer and noise, and of exact readings a noise of 10 Pa or 1e-4. Each press is "
            "taken up by itself, without the reading before; warm is a second reading of the same "
            "press. Times are of one of several processes at once: benchmarks/bench_fit.py has "
            "better ones.",
        ),
        pictures=tuple(picture_of_errors(quantity, findings) for quantity in plan.quantities),
        tables=(
            *(
                Table.of(
                    quantity,
                    f"{quantity.capitalize()}: medians with their 95 % intervals (bootstrap over "
                    "the presses) and 90th percentiles. Places and forces of contacts are of those "
                    "found within 8 mm. The bounds are errors of an estimate at the Cramér-Rao "
                    "bound, for presses by balls.",
                    [_cells(row, PLAIN, p90=True) for row in where(table, quantity=quantity)],
                )
                for quantity in plan.quantities
            ),
            Table.of(
                "groups",
                "Medians with their 95 % intervals by what presses: one ball or cone, several, "
                "others.",
                [
                    {"reads": row["quantity"], "presses": f"{row['presses']} {row['group']}"}
                    | _cells(row, PLAIN[:2])
                    for row in groups
                ],
            ),
            Table.of("summary", "The tables with all columns.", table, on_page=False),
            Table.of("presses", "Each press.", findings.rows, on_page=False),
        ),
        verdicts=tuple(_verdicts(plan, table)),
    )


def noise_in_words(quantity: str, noise: float) -> str:
    """Such as "0.38 kPa"; "exact" for none."""
    if noise == 0.0:
        return "exact"
    return f"{noise / 1e3:g} kPa" if quantity == "stress" else f"{noise:g}"


def name_of(method: str) -> str:
    """What an entrant is called in words."""
    return NAMES.get(method, method.rpartition(":")[2])


def _verdicts(plan: AccuracyPlan, table: Sequence[Row]) -> list[Verdict]:
    """At the lowest noise of each quantity."""
    out = []
    for quantity in plan.quantities:
        noise = min(level.noise for level in plan.levels if level.quantity == quantity)
        best = where(table, quantity=quantity, noise=noise)
        shape = {
            row["method"]: 100 * row["pressure_error_median"]
            for row in best
            if "pressure_error_median" in row
        }
        lowest = min(shape.values())
        words = ", ".join(f"{value:.0f} % ({name_of(name)})" for name, value in shape.items())
        out.append(
            Verdict(
                "table",
                f"force distributions are reconstructed ({quantity})",
                f"pressure off by {words}, relative L2, median; readings "
                f"{noise_in_words(quantity, noise)}",
                verdict_of(lowest < 20, lowest < 50),
            )
        )
    return out


def _cells(
    row: Row, plain: Sequence[tuple[str, str, float]], *, p90: bool = False
) -> dict[str, Cell]:
    """Row of a table: measures with their intervals, then plain numbers."""
    cells: dict[str, Cell] = {
        "noise": noise_in_words(row["quantity"], row["noise"]),
        "solver": name_of(row["method"]),
    }
    for key, name, factor in PAIRED:
        cells[name] = _interval(row, key, factor)
        if p90:
            high = row.get(f"{key}_p90")
            cells[f"{name}, p90"] = None if high is None else factor * high
    for key, name, factor in plain:
        cells[name] = None if row.get(key) is None else factor * row[key]
    return cells


def _interval(row: Row, key: str, factor: float) -> str | None:
    if row.get(f"{key}_median") is None:
        return None
    middle = number(factor * row[f"{key}_median"], 2)
    if row.get(f"{key}_low") is None:
        return middle
    low, high = (number(factor * row[f"{key}_{end}"], 2) for end in ("low", "high"))
    return f"{middle} [{low}–{high}]"


def picture_of_errors(quantity: str, findings: Findings) -> Picture:
    """Share of readings below each error of force and place, noise by noise."""
    rows, balls = findings.rows, {row["case"] for row in findings.bound}
    noises = list(dict.fromkeys(row["noise"] for row in where(rows, quantity=quantity)))
    solvers = list(dict.fromkeys(row["method"] for row in rows))
    panels = []
    for key, label, factor, ends in ERRORS:
        scale = Scale(
            x=label, y="share of readings", log_x=True, x_limits=ends, y_limits=(0.0, 1.02)
        )
        line = []
        for noise in noises:
            curves = []
            for name in (*solvers, *PRIORS):
                mine = where(
                    findings.bound if name in PRIORS else rows,
                    quantity=quantity, noise=noise, method=name,
                )  # fmt: skip
                mine = [row for row in mine if not balls or row["case"] in balls]
                if mine:
                    look = LIMIT if name in PRIORS else STEPS
                    errors = factor * np.abs(column(mine, key))
                    curves.append(distribution(name_of(name), errors, ends, look))
            title = ("noise " if noise else "") + noise_in_words(quantity, noise)
            line.append(Panel(title, "", tuple(curves), scale))
        panels.append(line)
    count = len(balls) if balls else len({row["case"] for row in rows})
    caption = (
        f"{quantity.capitalize()} read with the noise named above each panel: share of {count} "
        f"presses{', by balls alone,' if balls else ''} whose error of the force of all contacts "
        "(top) and mean error of place of those found (bottom) is below a value; where nothing is "
        "found there is no place, so that curves of place end below 1."
    )
    if balls:
        caption += (
            " Black: what an unbiased estimate at the Cramér-Rao bound would show, with the "
            "balls' sizes known, and known to a standard deviation of 0.6 in the logarithm."
        )
    return Picture.of(f"errors-{quantity}", caption, draw_panels(panels))
