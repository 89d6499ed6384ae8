"""What `skinfield design` prints."""

import numpy as np

from skinfield.cli.report import console
from skinfield.resolution import Judgement, ThicknessComparison

COMPARED = (
    "smallest force found, place unknown",
    "place deviation, size unknown",
    "force deviation, size unknown",
    "two touches told, typical direction",
)


def tell(judgement: Judgement) -> None:
    """Table, shares and verdict of one layout."""
    from rich.table import Table

    design, touch = judgement.design, judgement.touch
    title = (
        f"{design.patch.name}: {touch.force:g} N on a contact of radius {touch.radius * 1e3:g} mm, "
        f"{design.layer.thickness * 1e3:g} mm of {design.layer.young_modulus / 1e3:g} kPa"
    )
    table = Table(title=title, title_justify="left")
    table.add_column("at one place")
    for column in ("unit", "median", "90 %", "worst"):
        table.add_column(column, justify="right")
    for row in judgement.rows():
        table.add_row(row.name, row.unit, *map(_short, (row.median, row.p90, row.worst)))
    console().print(table)
    blind, searched = judgement.blind, judgement.detectable.searched
    independent = searched.independent(judgement.detectable.false_alarm_rate)
    say(
        f"{judgement.blind.blind_share:.1%} of {blind.places.area * 1e6:.0f} mm² is blind (below "
        f"{blind.threshold:.0%} of the best place); {judgement.missed_share:.1%} misses "
        f"{touch.force:g} N; noise is searched as at {independent:.0f} independent places"
    )
    say(judgement.verdict())


def tell_thickness(found: ThicknessComparison) -> None:
    """Table of medians and 95th percentiles by thickness."""
    from rich.table import Table

    touch = found.judgements[0].touch
    title = f"{touch.force:g} N, contact radius {touch.radius * 1e3:g} mm: median / 95 % of places"
    table = Table(title=title, title_justify="left")
    for column in ("thickness mm", "smallest force N", "place mm", "force N", "two touches mm",
                   "blind"):  # fmt: skip
        table.add_column(column, justify="right")
    rows = [found.rows(name) for name in COMPARED]
    for index, judgement in enumerate(found.judgements):
        cells = [f"{_short(row[index].median)} / {_short(row[index].p95)}" for row in rows]
        thickness = f"{found.thickness[index] * 1e3:g}"
        table.add_row(thickness, *cells, f"{judgement.blind.blind_share:.1%}")
    console().print(table)
    place, pair = (found.best(name) * 1e3 for name in (COMPARED[1], COMPARED[3]))
    say(f"sharpest for places at {place:g} mm, for two touches at {pair:g} mm (median)")


def _short(value: float) -> str:
    return f"{value:#.3g}".rstrip(".") if np.isfinite(value) else "never"


def say(words: str) -> None:
    """Print a line as it is."""
    console().print(words, highlight=False, markup=False, soft_wrap=True)
