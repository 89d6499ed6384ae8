"""The accuracy table: each method at each noise, in few numbers with their intervals."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.scoring.summary import figures_of, rate_of
from skinfield.experiments.trust.ball_bound import KNOWN, UNKNOWN

MEASURES = (  # columns of the rows: errors as parts of the truth, lengths in m, times in s
    "force_error",
    "place_error_m",
    "contact_force_error",
    "blurred_pressure_error",
    "deformation_error",
    "cold_s",
    "warm_s",
)
BOUNDS = (KNOWN, UNKNOWN)
UNITS = {"m": ("mm", 1e3), "s": ("ms", 1e3)}


def accuracy_rows(
    rows: Sequence[Row],
    bound: Sequence[Row] = (),
    idle: Sequence[Row] = (),
    resamples: int = 999,
    seed: int = 0,
) -> list[Row]:
    """One row per quantity, noise and method, with the bounds after the methods.

    ``_median``, ``_low`` and ``_high`` are the median over presses and its 95 % interval, ``_p90``
    the 90th percentile; lengths in mm, times in ms. ``missed`` is a share of the contacts,
    ``false_per_reading`` a mean, ``idle_false_per_reading`` that of noise alone; ``place_held`` and
    ``force_held`` are the shares of the contacts found whose stated 90 % regions hold the truth.
    The bounds are of presses by balls alone, and lack what they do not say.
    """
    out = []
    for quantity, noise in dict.fromkeys((r["quantity"], r["noise"]) for r in rows):
        for name in (*dict.fromkeys(row["method"] for row in rows), *BOUNDS):
            mine = _of(bound if name in BOUNDS else rows, quantity, noise, name)
            if not mine:
                continue
            head: Row = {"quantity": quantity, "noise": noise, "method": name}
            head["presses"] = len({row["case"] for row in mine})
            if name in BOUNDS:
                out.append(head | _plain(mine))
                continue
            found = _of(idle, quantity, noise, name)
            out.append(head | _numbers(mine, resamples, seed) | _rates(mine, found))
    return out


def group_rows(rows: Sequence[Row], resamples: int = 199, seed: int = 0) -> list[Row]:
    """The same, without bounds, for each group of presses: single, several, extended."""
    found: list[Row] = []
    for group in dict.fromkeys(row.get("group", "all") for row in rows):
        mine = [row for row in rows if row.get("group", "all") == group]
        found += [{"group": group} | row for row in accuracy_rows(mine, (), (), resamples, seed)]
    return found


def _of(rows: Sequence[Row], quantity: str, noise: float, method: str) -> list[Row]:
    wanted = (quantity, noise, method)
    return [row for row in rows if (row["quantity"], row["noise"], row["method"]) == wanted]


def column(rows: Sequence[Row], key: str) -> Floats:
    """Numbers of a column, NaN where there is none."""
    values = [row.get(key) for row in rows]
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)


def _named(measure: str) -> tuple[str, float]:
    """Column of a measure, with the unit that it is shown in, and the factor into it."""
    stem, _, end = measure.rpartition("_")
    unit, scale = UNITS.get(end, ("", 1.0))
    return (f"{stem}_{unit}" if unit else measure), scale


def _plain(rows: Sequence[Row]) -> Row:
    """Median and 90th percentile of what the rows have: many draws each, so no interval."""
    found: Row = {}
    for name in [name for name in MEASURES if name in rows[0]]:
        key, scale = _named(name)
        median, p90 = np.quantile(column(rows, name) * scale, [0.5, 0.9])
        found |= {f"{key}_median": float(median), f"{key}_p90": float(p90)}
    return found


def _numbers(rows: Sequence[Row], resamples: int, seed: int) -> Row:
    table = {name: column(rows, name) for name in MEASURES}
    found: Row = {}
    for name, figures in figures_of(table, resamples, seed).items():
        key, scale = _named(name)
        found[f"{key}_median"] = figures.median.value * scale
        found[f"{key}_low"] = figures.median.low * scale
        found[f"{key}_high"] = figures.median.high * scale
        found[f"{key}_p90"] = figures.p90.value * scale
    return found


def _rates(rows: Sequence[Row], idle: Sequence[Row]) -> Row:
    contacts = sum(row["contacts"] for row in rows)
    matched = sum(row["matched"] for row in rows)
    missed = rate_of(sum(row["missed"] for row in rows), contacts)
    found: Row = {
        "contacts": contacts,
        "missed": missed.value,
        "missed_low": missed.low,
        "missed_high": missed.high,
        "false_per_reading": float(np.mean([row["false"] for row in rows])),
    }
    for key in ("place_held", "force_held"):
        held = rate_of(sum(row[key] for row in rows), matched)
        found |= {key: held.value, f"{key}_low": held.low, f"{key}_high": held.high}
    readings = sum(row["idle"] for row in idle)
    if readings:
        found["idle_readings"] = readings
        found["idle_false_per_reading"] = sum(row["false"] for row in idle) / readings
    return found
