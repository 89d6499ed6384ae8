"""Where Hooke's law stops being true: a picture, its numbers, and the agreement of three methods.

  python docs/fem_figures.py               docs/images/linear-elasticity.png, linear-elasticity.csv
  python docs/fem_figures.py --agreement   prints the table lattice - exact - finite elements

The first takes about three minutes, the second half a minute.
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import click
import numpy as np

import skinfield as sf
from skinfield.errors import Floats, InputError
from skinfield.lab.fem import (
    AxisymmetricSolution,
    FlatProfile,
    Profile,
    SphereProfile,
    indent,
    indent_large,
    pad_capacitance,
)
from skinfield.lab.sections.agreement import agreement_table, agreements
from skinfield.plot import save
from skinfield.plot.style import BLUE, FAINT, INK, ORANGE, QUIET, add_title, new_figure, style

DOCS = Path(__file__).parent
LAYER = sf.Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)
PAD = 4e-3  # m
FINEST = 0.03  # thicknesses; below the contact
GREEN = "#009e73"  # Okabe and Ito's
LIMIT = 0.05  # of an error that is called large
RADII = np.linspace(0.0, 10e-3, 401)
BODIES: dict[str, tuple[Profile, float, str]] = {  # name: body, deepest m, colour
    "half-sphere 12 mm": (SphereProfile(radius=6e-3), 1.6e-3, INK),
    "half-sphere 6 mm": (SphereProfile(radius=3e-3), 1.7e-3, ORANGE),
    "cylinder 3 mm": (FlatProfile(radius=1.5e-3, edge_radius=0.3e-3, flank=4.0), 1.0e-3, BLUE),
    "cylinder 12 mm": (FlatProfile(radius=6e-3, edge_radius=0.3e-3, flank=4.0), 0.5e-3, GREEN),
}
PANELS = {  # error: title, note
    "force": ("Force", "at the same depth"),
    "contact_radius": ("Contact radius", "at the same force"),
    "base_peak": ("Peak of the base stress", "at the same force"),
    "reading": ("Reading ΔC/C₀ of a centred pad", "at the same force"),
}


@dataclass(frozen=True)
class Row:
    """One press at large strain, and how far off Hooke's law is, relative."""

    body: str
    depth_over_h: float
    newtons: float
    force: float
    contact_radius: float
    base_peak: float
    reading: float


def reading(found: AxisymmetricSolution) -> float:
    """Laplace's equation in the gap that this surface leaves."""
    edges = [found.contact_radius]
    return float(pad_capacitance(2e-3, found.indentation, [0.0], PAD, edges=edges)[0])


def compare(name: str, body: Profile, true: AxisymmetricSolution) -> Row:
    """Hooke's law beside the truth; NaN where it has no answer."""
    same_depth = indent(LAYER, body, depth=true.depth)
    errors = [np.nan, np.nan, np.nan]
    try:
        same_force = indent(LAYER, body, force=true.force)
        errors = [
            same_force.contact_radius / true.contact_radius - 1,
            same_force.base_stress(RADII).max() / true.base_stress(RADII).max() - 1,
            reading(same_force) / reading(true) - 1,
        ]
    except InputError as error:
        if "sinks" not in str(error):
            raise
    depth = true.depth / LAYER.thickness
    return Row(name, depth, true.force, same_depth.force / true.force - 1, *map(float, errors))


def rows() -> Iterator[Row]:
    """Every body, pressed deeper and deeper."""
    for name, (body, deepest, _) in BODIES.items():
        path = indent_large(LAYER, body, depth=deepest, steps=24, finest=FINEST)
        last = path.last
        end = path.stopped or "the depth asked for"
        click.echo(
            f"{name}: {len(path.solutions)} steps to {last.depth / LAYER.thickness:.2f} h, "
            f"{last.force:.2f} N; {end}"
        )
        wanted = np.linspace(0.0, last.depth, 18)[1:]
        depths = np.array([found.depth for found in path.solutions])
        for index in sorted({int(np.abs(depths - depth).argmin()) for depth in wanted}):
            yield compare(name, body, path.solutions[index])


def threshold(depth: Floats, error: Floats) -> float:
    """Depth/h from which the error stays above the limit; NaN where it never does."""
    known = np.isfinite(error)
    depth, size = depth[known], np.abs(error[known])
    above = np.flatnonzero(size > LIMIT)
    if not len(above):
        return float("nan")
    first = above[0]
    if first == 0:
        return float(depth[0])
    low, high = size[first - 1], size[first]
    share = (LIMIT - low) / (high - low)
    return float(depth[first - 1] + share * (depth[first] - depth[first - 1]))


def draw(found: list[Row]) -> None:
    """Draw the errors over the depth."""
    with style():
        figure = new_figure(9.6, 6.6)
        for index, (field, (title, note)) in enumerate(PANELS.items()):
            left, bottom = 0.08 + 0.48 * (index % 2), 0.57 - 0.49 * (index // 2)
            axes = figure.add_axes((left, bottom, 0.40, 0.33))
            axes.axhspan(-100 * LIMIT, 100 * LIMIT, color=FAINT, alpha=0.4, lw=0)
            axes.axhline(0.0, color=QUIET, lw=0.7)
            for name, (_, _, colour) in BODIES.items():
                mine = [row for row in found if row.body == name]
                depth = [row.depth_over_h for row in mine]
                error = [100 * getattr(row, field) for row in mine]
                axes.plot(depth, error, color=colour, marker=".", ms=4, label=name)
            axes.set(xlim=(0, 0.9), ylabel="error of Hooke's law (%)")
            if field == "contact_radius":
                axes.set_ylim(-8, 8)
            axes.set_xlabel("depth / thickness")
            axes.spines[["top", "right"]].set_visible(False)
            add_title(axes, "abcd"[index], title, note + "; grey: within 5 %")
            if index == 0:
                axes.legend(frameon=False, fontsize=8, loc="lower left")
        save(figure, DOCS / "images" / "linear-elasticity.png")


def write(found: list[Row]) -> None:
    """Write the numbers of the picture."""
    names = [field.name for field in fields(Row)]
    with (DOCS / "linear-elasticity.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(names)
        for row in found:
            numbers = [f"{getattr(row, name):.4g}" for name in names[1:]]
            table.writerow([row.body, *numbers])


def limits(found: list[Row]) -> None:
    """Print from which depth on each quantity is off by more than the limit."""
    click.echo(f"\ndepth/h from which Hooke's law is more than {LIMIT:.0%} off (nan: not reached)")
    for name in BODIES:
        mine = [row for row in found if row.body == name]
        depth = np.array([row.depth_over_h for row in mine])
        force = np.array([row.newtons for row in mine])
        for field in PANELS:
            at = threshold(depth, np.array([getattr(row, field) for row in mine]))
            newtons = float(np.interp(at, depth, force))
            click.echo(f"  {name:18} {field:15} {at:.2f}   {newtons:.2f} N")


def agreement() -> None:
    """Print the agreement of the three methods."""
    table = agreement_table(agreements())
    click.echo("| " + " | ".join(table.columns) + " |")
    click.echo("|" + " --- |" * len(table.columns))
    for row in table.rows:
        cells = [f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in row]
        click.echo("| " + " | ".join(cells) + " |")


@click.command()
@click.option("--agreement", "only", is_flag=True, help="The table of the three methods instead.")
def main(only: bool) -> None:
    """Make the picture and its numbers."""
    if only:
        agreement()
        return
    found = list(rows())
    draw(found)
    write(found)
    limits(found)


if __name__ == "__main__":
    main()
