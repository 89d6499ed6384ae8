"""Make the picture of the page on the non-negative field, and print the numbers that it quotes.

  python docs/figures/non_negative.py            docs/images/non-negative.png and the tables
  python docs/figures/non_negative.py --picture  the picture alone

How long it takes is in benchmarks/bench_nonnegative.py.

The presses are those of `skinfield.lab.case_sets`, solved on cells of 0.25 mm and
carried to places that no setting was chosen by.
"""

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import click
import numpy as np
from looks import draw_field

import skinfield as sf
from skinfield.errors import Floats
from skinfield.lab.case_sets import AROUND, KINDS
from skinfield.lab.cases import Case
from skinfield.lab.score import column
from skinfield.lab.validation import Entrant
from skinfield.plot import add_colour_bar, add_title, new_figure, save, signed_colours, style
from skinfield.simulate import Press, press

IMAGES = Path(__file__).parents[1] / "images"
PATCH = sf.layouts.hexagon72()
SOLVERS: dict[str, Any] = {"GaussianField": sf.GaussianField(), "NonNegative": sf.NonNegative()}
SHAPES = {
    "bar": "bar_16x3_2N",
    "ring": "ring_10_2N",
    "flat end": "flat12_3N",
    "ball": "ball12_1N",
}
POSES = 20
DRAWS = 2
SHOWN = {"bar": (-4e-3, 5e-3, 0.5), "ring": (6e-3, -6e-3, 0.0)}  # m, m, rad


@lru_cache(maxsize=8)
def solved(shape: str) -> Press:
    """A press at the origin, once."""
    kind = next(kind for kind in KINDS if kind.name == SHAPES[shape])
    return press(kind.layer, list(kind.bodies), extent=2 * AROUND, cell=0.25e-3)


def cases(shape: str, quantity: str) -> Iterator[Case]:
    """The press at places of the inner patch, each with some draws of typical noise."""
    rng = np.random.default_rng(20_25)
    for index in range(POSES):
        x, y = rng.uniform(-0.3, 0.3, 2) * np.ptp(PATCH.plane, axis=0)
        pose = (float(x), float(y), float(rng.uniform(0, 2 * np.pi)))
        yield Case.from_press(shape, solved(shape), PATCH, quantity, pose).with_noise(index, DRAWS)


def tables() -> None:
    """Print medians of errors for both solvers."""
    for quantity in ("stress", "capacitance"):
        click.echo(
            f"\n{quantity}: field's force | contacts' force | place mm | blurred | L2 | more"
        )
        for shape in SHAPES:
            truths = list(cases(shape, quantity))
            for name, solver in SOLVERS.items():
                entrant = Entrant(solver=solver)
                rows = [row for case in truths for row in entrant.rows(case)]
                columns = [
                    column(rows, key)
                    for key in (
                        "total_force_error",
                        "force_error",
                        "place_error_mm",
                        "blurred_pressure_error",
                        "pressure_error",
                    )
                ]
                field, force, place, blurred, sharp = (float(np.nanmedian(c)) for c in columns)
                more = np.mean([row["false"] for row in rows])
                low, high = np.quantile(1 + columns[0], [0.1, 0.9])
                click.echo(
                    f"  {shape:8s} {name:13s} {1 + field:5.2f} [{low:.2f}, {high:.2f}] | "
                    f"{1 + force:5.2f} | {place:.2f} | {blurred:.2f} | {sharp:.2f} | "
                    f"{more:.2f}"
                )


def on_cells(case: Case, grid: sf.Grid) -> Floats:
    """Mean of the true pressure over each cell of a grid, (K,) Pa."""
    truth = case.truth
    place = np.round((truth.plane - grid.origin) / grid.pitch).astype(int)
    rows, columns = grid.shape
    inside = ((place >= 0) & (place < [columns, rows])).all(axis=1)
    node = place[inside, 1] * columns + place[inside, 0]
    total = np.bincount(node, truth.pressure[inside], minlength=len(grid))
    return np.asarray(total * (truth.cell / grid.pitch) ** 2)


def fields(case: Case, grid: sf.Grid) -> dict[str, Floats]:
    """Truth and what both solvers make of a case's reading, (K,) kPa."""
    found = {"Truth": on_cells(case, grid) * 1e-3}
    for name, solver in SOLVERS.items():
        rec = sf.Reconstructor(
            PATCH,
            case.layer,
            grid,
            quantity=sf.Capacitance(),
            noise_std=case.noise_std,
            solver=solver,
        )
        found[name] = rec(case.draws[0]).pressure * 1e-3
    return found


def picture() -> None:
    """Truth and what both solvers make of capacitance with typical noise."""
    grid = sf.Grid.square(PATCH)
    with style():
        figure = new_figure(9.6, 6.4)
        for row, (shape, pose) in enumerate(SHOWN.items()):
            case = Case.from_press(shape, solved(shape), PATCH, "capacitance", pose).with_noise(1)
            drawn = fields(case, grid)
            colours, scale = signed_colours(np.stack(list(drawn.values())))
            for column, (name, pressure) in enumerate(drawn.items()):
                axes = figure.add_axes((0.06 + column * 0.295, 0.57 - row * 0.49, 0.27, 0.36))
                image = draw_field(axes, PATCH, grid, pressure, cmap=colours, norm=scale)
                x, y = pose[0] * 1e3, pose[1] * 1e3
                axes.set(xlim=(x - 14, x + 14), ylim=(y - 12, y + 12), xlabel="x (mm)")
                if column == 0:
                    axes.set_ylabel("y (mm)")
                else:
                    axes.set_yticklabels([])
                force = pressure.sum() * 1e3 * grid.cell_area
                note = f"sum of the field {force:.2f} N".replace("-", "−")
                add_title(axes, "abcdef"[3 * row + column], f"{name}, {shape}", note)
                if column == 2:
                    add_colour_bar(axes, image, "pressure (kPa)")
        save(figure, IMAGES / "non-negative.png")


@click.command()
@click.option("--picture", "drawn", is_flag=True, help="Only the picture.")
def main(drawn: bool) -> None:
    """Make picture and tables."""
    IMAGES.mkdir(exist_ok=True)
    picture()
    if not drawn:
        tables()


if __name__ == "__main__":
    main()
