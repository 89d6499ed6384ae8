"""Accuracy in the report: errors on random presses beside the bound, and two points told apart."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.lab.accuracy import (
    KNOWN,
    PRIORS,
    AccuracyPlan,
    Findings,
    accuracy_plan,
    accuracy_rows,
    group_rows,
    parts_of,
)
from skinfield.lab.plots import LIMIT, STEPS, Curve, Panel, Scale, distribution, draw_panels
from skinfield.lab.report import (
    Cell,
    Missing,
    Picture,
    Section,
    Settings,
    Table,
    Verdict,
    verdict_of,
)
from skinfield.lab.runner import Task
from skinfield.lab.score import Row, column, where, wilson
from skinfield.lab.validation import CONTACT, GAUSSIAN, PAPER, Entrant, Level
from skinfield.plot.style import number

HALF = 0.5  # share found as two that tells a distance
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


def accuracy(settings: Settings, results: Sequence[dict[str, Any] | None]) -> Section | Missing:
    """The section from the results of its parts."""
    plan = accuracy_plan(settings.size.name, settings.seed)
    findings = Findings.of(results)
    if not findings.rows:
        return Missing("accuracy: none of its parts could be computed")
    table = accuracy_rows(findings, plan.resamples, plan.seed)
    pictures = [picture_of_errors(quantity, findings) for quantity in plan.quantities]
    pictures += [_picture_of_pairs(plan, findings.pairs)] if findings.pairs else []
    return Section(
        name="accuracy",
        title="Accuracy on random presses, beside the bound",
        claim="Peaks and shapes are looked at; no table of errors is given.",
        sentences=tuple(_sentences(plan, findings, table)),
        pictures=tuple(pictures),
        tables=(
            *(_table(quantity, table) for quantity in plan.quantities),
            _groups(group_rows(findings.rows, seed=plan.seed)),
            Table.of("two-points", "Two balls found as two.", findings.pairs, on_page=False),
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


def _sentences(plan: AccuracyPlan, findings: Findings, table: Sequence[Row]) -> list[str]:
    presses = len({row["case"] for row in findings.rows})
    words = [
        f"{presses} random presses on {plan.layout}, {plan.layer.thickness * 1e3:g} mm of "
        "silicone: of twenty, twelve by single balls of 2 to 15 mm radius (some cones), five by "
        "two or three bodies, three by flats, bars or rings; 0.2 to 3 N each.",
        "The truth is the contact solver's on squares of its own. The solvers are told layout, "
        "elastomer and noise, and of exact readings a noise of 10 Pa or 1e-4. Each press is taken "
        "up by itself, without the reading before; warm is a second reading of the same press. "
        "Times are of one of several processes at once: benchmarks/bench_fit.py has better ones.",
    ]
    for level in plan.levels:
        parts = []
        for name in (*(entrant.name for entrant in plan.entrants), KNOWN):
            for row in where(table, quantity=level.quantity, noise=level.noise, method=name):
                who = "the bound (known balls)" if name == KNOWN else name_of(name)
                force, place = 100 * row["force_error_median"], row["place_error_mm_median"]
                parts.append(f"{who} {number(force, 2)} % and {number(place, 2)} mm")
        words.append(
            f"{level.quantity.capitalize()}, {noise_in_words(level.quantity, level.noise)}: "
            f"{'; '.join(parts)} (median errors of force and place)."
        )
    return [*words, _half(plan, findings.pairs)] if findings.pairs else words


def _half(plan: AccuracyPlan, pairs: Sequence[Row]) -> str:
    """From which distance on half of the pairs are seen, level by level."""
    parts = []
    for level in plan.pairs:
        each = []
        for entrant in plan.entrants:
            mine = _of_pair(pairs, level, entrant)
            seen = [r["distance_mm"] for r in mine if r["found"] >= HALF * r["trials"]]
            each.append(f"{name_of(entrant.name)} {f'{min(seen):g} mm' if seen else 'never'}")
        noise = noise_in_words(level.quantity, level.noise)
        parts.append(f"{level.quantity} at {noise}: {', '.join(each)}")
    return f"First distance tried at which half of the pairs are found as two: {'; '.join(parts)}."


def _of_pair(pairs: Sequence[Row], level: Level, entrant: Entrant) -> list[Row]:
    mine = where(pairs, quantity=level.quantity, noise=level.noise, method=entrant.name)
    return sorted(mine, key=lambda row: float(row["distance_mm"]))


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


def _table(quantity: str, table: Sequence[Row]) -> Table:
    rows = []
    for row in where(table, quantity=quantity):
        cells: dict[str, Cell] = {
            "noise": noise_in_words(quantity, row["noise"]),
            "solver": name_of(row["method"]),
        }
        for key, name, factor in PAIRED:
            p90 = row.get(f"{key}_p90")
            cells[name] = _interval(row, key, factor)
            cells[f"{name}, p90"] = None if p90 is None else factor * p90
        rows.append(cells | _plain(row, PLAIN))
    caption = (
        f"{quantity.capitalize()}: medians with their 95 % intervals (bootstrap over the presses) "
        "and 90th percentiles. Places and forces of contacts are of those found within 8 mm. The "
        "bounds are errors of an estimate at the Cramér-Rao bound, for presses by balls."
    )
    return Table.of(quantity, caption, rows)


def _groups(rows: Sequence[Row]) -> Table:
    """Medians by what presses."""
    cells = [
        {
            "reads": row["quantity"],
            "noise": noise_in_words(row["quantity"], row["noise"]),
            "presses": f"{row['presses']} {row['group']}",
            "solver": name_of(row["method"]),
        }
        | {name: _interval(row, key, factor) for key, name, factor in PAIRED}
        | _plain(row, PLAIN[:2])
        for row in sorted(rows, key=lambda row: (row["quantity"], row["noise"]))
    ]
    caption = (
        "Medians with their 95 % intervals by what presses: one ball or cone, several, others."
    )
    return Table.of("groups", caption, cells)


def _plain(row: Row, columns: Sequence[tuple[str, str, float]]) -> dict[str, Cell]:
    return {name: None if row.get(k) is None else f * row[k] for k, name, f in columns}


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


def _picture_of_pairs(plan: AccuracyPlan, pairs: Sequence[Row]) -> Picture:
    """Share of two balls found as two, against their distance."""
    low, high = 1e3 * plan.distances[0] - 0.3, 1e3 * plan.distances[-1] + 0.3
    scale = Scale(
        x="distance (mm)",
        y="share found as two",
        y_limits=(0.0, 1.02),
        x_limits=(low, high),
        x_ticks=tuple(t for t in range(0, 100, 2) if low <= t <= high),
        marks=True,
    )
    panels = []
    for level in plan.pairs:
        curves = [
            _share_of_pairs(entrant, mine)
            for entrant in plan.entrants
            if (mine := _of_pair(pairs, level, entrant))
        ]
        note = f"noise {noise_in_words(level.quantity, level.noise)}"
        panels.append(Panel(level.quantity, note, tuple(curves), scale))
    caption = (
        f"Two balls of 6 mm with 1 N each, {plan.trials} presses at random places and angles per "
        "distance: exactly two contacts found, each nearer than half the distance to its own "
        "ball. Shaded: 95 % intervals (Wilson)."
    )
    return Picture.of("two-points", caption, draw_panels([panels]))


def _share_of_pairs(entrant: Entrant, rows: Sequence[Row]) -> Curve:
    low, high = np.array([wilson(row["found"], row["trials"]) for row in rows]).T
    share: Floats = column(rows, "found") / column(rows, "trials")
    return Curve(name_of(entrant.name), column(rows, "distance_mm"), share, low, high)
