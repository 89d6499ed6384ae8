"""Scores as tables on the terminal, and the limits that a user sets for them."""

import math
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from rich.box import SIMPLE_HEAD

from skinfield.cli.report import Column, fixed, table
from skinfield.errors import InputError

SHOWN = {  # measure, and how the table calls it
    "force_error": "force of all contacts",
    "field_force_error": "force of the field",
    "contact_force_error": "force of a contact found",
    "place_error_mm": "place of a contact found, mm",
    "peak_error": "peak pressure",
    "pressure_error": "pressure, relative L2",
    "blurred_pressure_error": "pressure blurred by 2 mm, relative L2",
    "deformation_error": "deformation, relative L2",
    "area_error": "contact area",
}
AT_NOISES = (  # columns of the accuracy rows, what the table calls them, and decimals
    ("force_error", 100.0, "force\n%", 0),
    ("place_error_mm", 1.0, "place\nmm", 2),
    ("contact_force_error", 100.0, "contact\nforce %", 0),
    ("blurred_pressure_error", 100.0, "blurred\npress. %", 0),
    ("deformation_error", 100.0, "deform.\n%", 0),
    ("force_held", 100.0, "force in\ninterval %", 0),
    ("missed", 100.0, "missed\n%", 0),
    ("false_per_reading", 1.0, "false per\nreading", 2),
    ("idle_false_per_reading", 1.0, "in noise\nalone", 4),
    ("cold_ms", 1.0, "cold\nms", 1),
    ("warm_ms", 1.0, "warm\nms", 2),
)
RATES = {"missed": "contacts missed", "false_share": "readings with a false contact"}
PER_CASE = (
    Column("case", "case"), Column("true N", "true_force_N", decimals=2),
    Column("force", "force_error", decimals=2), Column("place mm", "place_error_mm", decimals=2),
    Column("pressure, blurred", "blurred_pressure_error", decimals=2),
    Column("deformation", "deformation_error", decimals=2),
    Column("missed", "missed", decimals=2), Column("false", "false", decimals=2),
)  # fmt: skip


def limits_from_texts(texts: Sequence[str]) -> dict[str, float]:
    """Highest allowed values by measure, from texts such as "missed=0.1"."""
    from skinfield.lab.score import MEASURES, RATES

    known = (*MEASURES[:-2], "force_bias", *RATES)  # times are not for limits

    limits = {}
    for text in texts:
        name, _, most = text.partition("=")
        with suppress(ValueError):
            limits[name] = float(most)
        if name not in known or name not in limits:
            raise InputError(
                f"--require is {text!r}, expected MEASURE=NUMBER with one of {', '.join(known)}"
            )
    return limits


def exceeds(limits: dict[str, float], columns: dict[str, Any]) -> bool:
    """Whether a limit is exceeded, or there is no number to compare, which stderr then says."""
    failed = False
    for name, most in limits.items():
        value = float(columns.get(f"{name}_median", columns.get(name, math.nan)))
        if not value <= most:
            failed = True
            sys.stderr.write(f"{name} is {value:.4g}, required at most {most:g}\n")
    return failed


def table_of_summary(summary: dict[str, Any], title: str) -> Any:
    """Medians with their intervals, 90th percentiles and rates."""
    made = table(title, ("error of",), ("median", "95 % interval", "90th percentile"))
    for key, label in SHOWN.items():
        median, low, high, p90 = (
            fixed(summary[f"{key}_{end}"], 3) for end in ("median", "low", "high", "p90")
        )
        made.add_row(label, median, f"{low} to {high}", p90)
    for key, label in RATES.items():
        rate, low, high = (fixed(summary[name], 3) for name in (key, f"{key}_low", f"{key}_high"))
        made.add_row(label, rate, f"{low} to {high}", "")
    return made


def table_of_noises(rows: Sequence[dict[str, Any]], title: str) -> Any:
    """Medians and 90th percentiles, noise by noise and solver by solver."""
    known = set().union(*rows)
    shown = [each for each in AT_NOISES if {each[0], f"{each[0]}_median"} & known]
    labels = [label for _, _, label, _ in shown]
    title += "; median/90th percentile"
    made = table(title, ("noise", "solver"), labels, box=SIMPLE_HEAD)
    for index, row in enumerate(rows):
        new = index == 0 or row["noise"] != rows[index - 1]["noise"]
        last = index + 1 == len(rows) or rows[index + 1]["noise"] != row["noise"]
        cells = [f"{row['noise']:g}" if new else "", row["method"].rpartition(":")[2]]
        for key, factor, _, digits in shown:
            ends = (f"{key}_median", f"{key}_p90") if f"{key}_median" in row else (key,)
            cells.append("/".join(_cut(row.get(end, math.nan) * factor, digits) for end in ends))
        made.add_row(*cells, end_section=last)
    return made


def _cut(value: float, digits: int) -> str:
    """A number; an exponent would hide how large it is, so what is huge is cut."""
    return fixed(value, digits) if not 1e4 <= abs(value) < math.inf else ">9999"
