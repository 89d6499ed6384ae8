"""A summary as the columns of a table, the unit in each name."""

from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.scoring.summary import MEASURES, Summary


def _column(measure: str) -> str:
    return measure[:-2] + "_mm" if measure.endswith("_m") else measure


COLUMNS = (*(_column(name) for name in MEASURES), "missed", "false_share", "false_per_reading")


def flat(summary: Summary) -> Row:
    """Columns of a summary; lengths in mm.

    ``_median``, ``_low`` and ``_high`` are the median and its interval, ``_p90`` the 90th
    percentile; rates stand under their own names.
    """
    row: Row = {"readings": summary.readings}
    for name, figures in summary.measures.items():
        scale, key = (1e3 if name.endswith("_m") else 1.0), _column(name)
        row[f"{key}_median"] = figures.median.value * scale
        row[f"{key}_low"] = figures.median.low * scale
        row[f"{key}_high"] = figures.median.high * scale
        row[f"{key}_p90"] = figures.p90.value * scale
    for key, rate in (("missed", summary.missed), ("false_share", summary.false_share)):
        row |= {key: rate.value, f"{key}_low": rate.low, f"{key}_high": rate.high}
    return row | {"false_per_reading": summary.false_per_reading}
