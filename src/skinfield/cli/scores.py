"""Scores as tables on the terminal, and the limits that a user sets for them."""

import math
import sys
from collections.abc import Sequence
from typing import Any

from skinfield.cli.report import say
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
RATES = {"missed": "contacts missed", "false_share": "readings with a false contact"}
PER_CASE = {
    "force_error": "force",
    "place_error_mm": "place mm",
    "blurred_pressure_error": "pressure, blurred",
    "deformation_error": "deformation",
    "missed": "missed",
    "false": "false",
}


def limits_from_texts(texts: Sequence[str]) -> dict[str, float]:
    """Highest allowed values by measure, from texts such as "missed=0.1"."""
    from skinfield.lab.score import MEASURES, RATES

    known = (*MEASURES[:-2], "force_bias", *RATES)  # times are not for limits

    limits = {}
    for text in texts:
        name, _, most = text.partition("=")
        try:
            limits[name] = float(most)
        except ValueError:
            name = ""
        if name not in known:
            raise InputError(
                f"--require is {text!r}, expected MEASURE=NUMBER with one of {', '.join(known)}"
            )
    return limits


def exceeds(limits: dict[str, float], columns: dict[str, Any]) -> bool:
    """Whether a limit is exceeded, or there is no number to compare, which stderr then says."""
    failed = []
    for name, most in limits.items():
        value = float(columns[f"{name}_median" if f"{name}_median" in columns else name])
        if not value <= most:
            failed.append(f"{name} is {value:.4g}, required at most {most:g}")
    for sentence in failed:
        sys.stderr.write(f"{sentence}\n")
    return bool(failed)


def table_of_summary(summary: dict[str, Any], title: str) -> Any:
    """Medians with their intervals, 90th percentiles and rates."""
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    table.add_column("error of")
    for column in ("median", "95 % interval", "90th percentile"):
        table.add_column(column, justify="right")
    for key, label in SHOWN.items():
        median, low, high, p90 = (
            number(summary[f"{key}_{end}"]) for end in ("median", "low", "high", "p90")
        )
        table.add_row(label, median, f"{low} to {high}", p90)
    for key, label in RATES.items():
        rate, low, high = (number(summary[name]) for name in (key, f"{key}_low", f"{key}_high"))
        table.add_row(label, rate, f"{low} to {high}", "")
    return table


def number(value: float, decimals: int = 3) -> str:
    """Fixed decimals; a dash for what does not exist, such as the place of what was missed."""
    return f"{value:.{decimals}f}" if math.isfinite(value) else "–"


def table_of_cases(rows: Sequence[dict[str, Any]]) -> Any:
    """A line per case."""
    from rich.table import Table

    table = Table(title="Medians over each case's readings", title_justify="left")
    table.add_column("case", overflow="fold")
    table.add_column("true N", justify="right")
    for label in PER_CASE.values():
        table.add_column(label, justify="right")
    for row in rows:
        numbers = [number(row[key], 2) for key in PER_CASE]
        table.add_row(str(row["case"]), f"{row['true_force_N']:.2f}", *numbers)
    return table


def say_written(options: dict[str, Any]) -> None:
    """Name the files that were written."""
    for name in options["output"]:
        say(f"wrote {name}")
