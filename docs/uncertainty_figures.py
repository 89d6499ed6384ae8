"""How often intervals of linear solvers hold the truth: a picture, and a table.

  python docs/uncertainty_figures.py [-o FOLDER]     coverage.png into docs/images; prints the table
  python docs/uncertainty_figures.py --two           prints what holds of two bodies at once

Two minutes of one core, and half a minute. ContactFit is in the report of
`skinfield experiments --only intervals`.
"""

from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np

import skinfield as sf
from skinfield.lab.cases import TrueContact
from skinfield.lab.score import Row, matched
from skinfield.lab.sections.coverage import (
    SOLVERS,
    CoveragePlan,
    rehearsal_of,
    rows_of_quantity,
    section_of,
)

IMAGES = Path(__file__).parent / "images"
PAIRS = 250  # of presses at each distance
PLAN = CoveragePlan(
    solvers=tuple(each for each in SOLVERS if each[0] != "ContactFit"), presses=300, trials=300
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


def two_bodies() -> Iterator[str]:
    """What 90 % intervals that are learnt from one body at a time hold of two, by distance.

    Stress at the typical noise, Gaussian field. Readings of two presses are added: they are so far
    apart that neither changes the other's contact.
    """
    made, rng = rehearsal_of(PLAN, "stress"), np.random.default_rng(0)
    grid = sf.Grid.square(PLAN.patch, nodes=PLAN.nodes)
    plain = sf.Reconstructor(PLAN.patch, PLAN.layer, grid, quantity=sf.BaseStress())
    noise, learnt = plain.model.noise_std, plain.calibrated(PLAN.presses, PLAN.seed)
    apart = np.linalg.norm(made.places[:, None] - made.places[None], axis=2)
    for low, high in ((8e-3, 12e-3), (12e-3, 16e-3), (16e-3, 40e-3)):
        pairs = np.argwhere(np.triu((apart >= low) & (apart < high)))
        held = []
        for pair in pairs[rng.permutation(len(pairs))[:PAIRS]]:
            reading = made.readings[pair].sum(axis=0) + noise * rng.standard_normal(len(noise))
            true = [
                TrueContact((float(made.places[i, 0]), float(made.places[i, 1])), made.forces[i])
                for i in pair
            ]
            found = learnt(reading).contacts
            for match in matched(PLAN.patch, true, found)[0]:
                contact, force = found[match.estimated], match.true_force
                ends = contact.force_interval(0.9)
                inside = match.distance <= contact.place_radius(0.9)
                held.append((ends[0] <= force <= ends[1], inside))
        shares = ", ".join(f"{100 * share:.0f} %" for share in np.mean(held, axis=0))
        yield f"{1e3 * low:g} to {1e3 * high:g} mm: force and place {shares} of {len(held)}"


@click.command()
@click.option("-o", "folder", type=click.Path(path_type=Path), default=IMAGES)
@click.option("--two", is_flag=True, help="Two bodies at once instead.")
def main(folder: Path, two: bool) -> None:
    """Make the picture and print the table."""
    if two:
        for line in two_bodies():
            click.echo(line)
        return
    rows = [row for quantity in PLAN.quantities for row in rows_of_quantity(PLAN, quantity)]
    section = section_of(PLAN, rows)
    (folder / "coverage.png").write_bytes(section.pictures[0].png)
    for line in (*section.sentences, *table(rows)):
        click.echo(line)


if __name__ == "__main__":
    main()
