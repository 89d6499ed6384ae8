"""How often intervals of linear solvers hold the truth: a picture, and a table.

  python docs/uncertainty_figures.py [-o FOLDER]     coverage.png into docs/images; prints the table

Two minutes of one core. `skinfield experiments --only intervals` has ContactFit, too.
"""

from pathlib import Path

import click

from skinfield.experiments.coverage.plan import SOLVERS, CoveragePlan
from skinfield.experiments.coverage.section import section_of
from skinfield.experiments.coverage.trials import rows_of_quantity
from skinfield.experiments.scoring.rows import Row

IMAGES = Path(__file__).parent / "images"
PLAN = CoveragePlan(
    solvers=tuple(entry for entry in SOLVERS if entry.linear), presses=300, trials=300
)


def cell(row: Row, name: str) -> str:
    """Percentage of truths in 90 % intervals."""
    return f"{100 * row[name] / row['found']:.0f}"


def table(rows: list[Row]) -> list[str]:
    """Lines of the page's table: stated and calibrated beside each other."""
    lines = []
    for stated, learnt in zip(rows[::2], rows[1::2], strict=True):
        cells = [
            stated["quantity"],
            f"{stated['noise']:g}",
            stated["solver"].replace(", resampled (paper)", "`, resampled"),
            f"{100 * stated['found'] / stated['trials']:.0f}",
            *(cell(row, name) for row in (stated, learnt) for name in ("force_90", "place_90")),
            *(f"{row['force_width']:.1f}" for row in (stated, learnt)),
            *(f"{row['place_radius_mm']:.1f}" for row in (stated, learnt)),
        ]
        cells[2] = f"`{cells[2]}" + ("" if "`" in cells[2] else "`")
        lines.append("| " + " | ".join(cells) + " |")
    return lines


@click.command()
@click.option("-o", "folder", type=click.Path(path_type=Path), default=IMAGES)
def main(folder: Path) -> None:
    """Make the picture and print the table."""
    rows = [row for quantity in PLAN.quantities for row in rows_of_quantity(PLAN, quantity)]
    section = section_of(PLAN, rows)
    (folder / "coverage.png").write_bytes(section.pictures[0].png)
    for line in (*section.sentences, *table(rows)):
        click.echo(line)


if __name__ == "__main__":
    main()
