"""Contacts you can trust, in the report: the table, the errors beside the bound, two points."""

from collections.abc import Sequence
from typing import Any

from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.section import Cell, Missing, Part, Section, Table
from skinfield.experiments.settings import Settings
from skinfield.experiments.trust.ball_bound import KNOWN
from skinfield.experiments.trust.campaign import Found, gathered, trust_parts
from skinfield.experiments.trust.pictures import (
    name_of,
    noise_in_words,
    picture_of_errors,
    picture_of_pairs,
)
from skinfield.experiments.trust.plan import TrustPlan, trust_plan
from skinfield.experiments.trust.table import accuracy_rows, group_rows
from skinfield.figures.style import number

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
HALF = 0.5  # share found as two that tells a distance


def trust_parts_of(settings: Settings) -> list[Part]:
    """Shares of the campaign."""
    return trust_parts(trust_plan(settings.size.name, settings.seed))


def trust(settings: Settings, results: Sequence[dict[str, Any] | None]) -> Section | Missing:
    """The section from the results of its parts."""
    plan = trust_plan(settings.size.name, settings.seed)
    found = gathered(plan, results)
    if not found.rows:
        return Missing("trust: none of its parts could be computed")
    table = accuracy_rows(found.rows, found.bound, found.idle, plan.resamples, plan.seed)
    pictures = [
        picture_of_errors(quantity, found.rows, found.bound) for quantity in plan.quantities
    ]
    pictures += [picture_of_pairs(plan, found.pairs)] if found.pairs else []
    return Section(
        name="trust",
        title="Contacts you can trust: unseen presses",
        claim="",
        sentences=tuple(_sentences(plan, found, table)),
        pictures=tuple(pictures),
        tables=(
            *(_table(quantity, table) for quantity in plan.quantities),
            _groups(group_rows(found.rows, seed=plan.seed)),
            _pairs(found),
            *_files(found, table),
        ),
    )


def _row_of(table: Sequence[Row], quantity: str, noise: float, method: str) -> Row | None:
    wanted = (quantity, noise, method)
    mine = [r for r in table if (r["quantity"], r["noise"], r["method"]) == wanted]
    return mine[0] if mine else None


def _sentences(plan: TrustPlan, found: Found, table: Sequence[Row]) -> list[str]:
    presses = len({row["case"] for row in found.rows})
    words = [
        f"{presses} random presses on {plan.layout}, {plan.layer.thickness * 1e3:g} mm of "
        "silicone: of twenty, twelve by single balls of 2 to 15 mm radius (some cones), five by "
        "two or three bodies, three by flats, bars or rings; 0.2 to 3 N each.",
        "The truth is the contact solver's on squares of its own. The solvers are told layout, "
        "elastomer and noise, and of exact readings a noise of 10 Pa or 1e-4. Each press is taken "
        "up by itself, without the reading before; warm is a second reading of the same press. "
        "Times are of one of several processes at once: benchmarks/bench_fit.py has better ones.",
    ]
    for quantity in plan.quantities:
        noises = [level.noise for level in plan.levels if level.quantity == quantity]
        for noise in noises:
            said = [
                f"{name_of(method.name)} {_in_words(row)}"
                for method in plan.methods
                if (row := _row_of(table, quantity, noise, method.name)) is not None
            ]
            bound = _row_of(table, quantity, noise, KNOWN)
            said += [f"the bound (known balls) {_in_words(bound)}"] if bound else []
            words.append(
                f"{quantity.capitalize()}, {noise_in_words(quantity, noise)}: "
                f"{'; '.join(said)} (median errors of force and place)."
            )
    return [*words, _half(plan, found.pairs)] if found.pairs else words


def _in_words(row: Row) -> str:
    force, place = 100 * row["force_error_median"], row["place_error_mm_median"]
    return f"{number(force, 2)} % and {number(place, 2)} mm"


def _half(plan: TrustPlan, pairs: Sequence[Row]) -> str:
    """From which distance on half of the pairs are seen, level by level."""
    said = []
    for level in plan.pairs:
        each = []
        for method in plan.methods:
            wanted = (level.quantity, level.noise, method.name)
            mine = [r for r in pairs if (r["quantity"], r["noise"], r["method"]) == wanted]
            seen = [r["distance_mm"] for r in mine if r["found"] >= HALF * r["trials"]]
            each.append(f"{name_of(method.name)} {f'{min(seen):g} mm' if seen else 'never'}")
        said.append(
            f"{level.quantity} at {noise_in_words(level.quantity, level.noise)}: {', '.join(each)}"
        )
    return f"First distance tried at which half of the pairs are found as two: {'; '.join(said)}."


def _table(quantity: str, table: Sequence[Row]) -> Table:
    names = [name for _, name, _ in PAIRED]
    columns = ["noise", "solver", *(c for n in names for c in (n, "p90"))]
    columns += [name for _, name, _ in PLAIN]
    rows: list[tuple[Cell, ...]] = []
    for row in (row for row in table if row["quantity"] == quantity):
        cells: list[Cell] = [noise_in_words(quantity, row["noise"]), name_of(row["method"])]
        for key, _, factor in PAIRED:
            p90 = row.get(f"{key}_p90")
            cells += [_interval(row, key, factor), None if p90 is None else factor * p90]
        cells += [None if row.get(k) is None else f * row[k] for k, _, f in PLAIN]
        rows.append(tuple(cells))
    caption = (
        f"{quantity.capitalize()}: medians with their 95 % intervals (bootstrap over the presses) "
        "and 90th percentiles. Places and forces of contacts are of those found within 8 mm. The "
        "bounds are errors of an estimate at the Cramér-Rao bound, for presses by balls."
    )
    return Table(quantity, caption, tuple(columns), tuple(rows))


def _groups(rows: Sequence[Row]) -> Table:
    """Medians by what presses."""
    columns = ["reads", "noise", "presses", "solver", *(name for _, name, _ in PAIRED)]
    columns += [name for _, name, _ in PLAIN[:2]]
    cells = [
        (
            row["quantity"],
            noise_in_words(row["quantity"], row["noise"]),
            f"{row['presses']} {row['group']}",
            name_of(row["method"]),
            *(_interval(row, key, factor) for key, _, factor in PAIRED),
            *(factor * row[key] for key, _, factor in PLAIN[:2]),
        )
        for row in sorted(rows, key=lambda row: (row["quantity"], row["noise"]))
    ]
    caption = (
        "Medians with their 95 % intervals by what presses: one ball or cone, several, others."
    )
    return Table("groups", caption, tuple(columns), tuple(cells))


def _interval(row: Row, key: str, factor: float) -> str | None:
    if row.get(f"{key}_median") is None:
        return None
    middle = number(factor * row[f"{key}_median"], 2)
    if row.get(f"{key}_low") is None:
        return middle
    low, high = (number(factor * row[f"{key}_{end}"], 2) for end in ("low", "high"))
    return f"{middle} [{low}–{high}]"


def _pairs(found: Found) -> Table:
    keys = ("quantity", "noise", "method", "distance_mm", "found", "trials")
    rows = tuple(tuple(row[key] for key in keys) for row in found.pairs)
    return Table("two-points", "Two balls found as two.", keys, rows, shown=False)


def _files(found: Found, table: Sequence[Row]) -> list[Table]:
    """All numbers, for the CSV files."""
    named = (
        ("summary", "The tables with all columns.", table),
        ("presses", "Each press.", found.rows),
    )
    tables = []
    for name, caption, rows in named:
        keys = tuple(dict.fromkeys(key for row in rows for key in row))
        cells = tuple(tuple(row.get(key) for key in keys) for row in rows)
        tables.append(Table(name, caption, keys, cells, shown=False))
    return tables
