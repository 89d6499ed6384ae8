"""`skinfield press`: rigid bodies on the skin, and what the skin feels of them."""

from typing import Any

import click
import numpy as np

from skinfield.cli.indenters import indenter_from_text
from skinfield.cli.inputs import skin_from_text
from skinfield.cli.options import (
    MECHANICS,
    QUANTITIES,
    layer_from_options,
    layer_options,
    patch_of,
)
from skinfield.cli.report import console
from skinfield.errors import Floats
from skinfield.layout import Patch
from skinfield.simulate import Indenter, Press
from skinfield.simulate.pressing.parts import Part, parts_of

DEFAULT = "sphere radius=6 force=1"
ROOM = 20.0  # mm around the reference points of the indenters
LABELS = {"capacitance": ("ΔC/C₀ (%)", 100.0), "gap": ("indentation (% of the layer)", 100.0),
          "stress": ("base stress (kPa)", 1e-3)}  # fmt: skip


@click.command(
    short_help="Press rigid bodies on the skin: pressure, depth, readings.",
    help="""Press rigid bodies on the skin and say how deep they sink, where they touch, and what
taxels below them read, all without noise.

Each --indenter is a shape and key=value words in mm, N and degrees. Load it with force=1 or
depth=0.3; lean it with tilt_x=, tilt_y= about its own axes, turn it with rotation=, push it
sideways with shear_x=, shear_y=.

\b
  sphere    radius
  cylinder  radius [edge_radius]
  cone      radius half_angle [edge_radius]            angle from the axis
  bar       length width [edge_radius]                 flat face, length along x
  rod       radius length [edge_radius]                lies along x
  wedge     length width half_angle [edge_radius]      straight edge along x
  ring      inner_radius outer_radius [edge_radius]
  mesh      file [unit_mm] [down=0,0,-1]               STL, OBJ, PLY
  heightmap file pixel [relief] [invert]               PNG (white touches first), NPY, NPZ, CSV

\b
  skinfield press
  skinfield press --indenter "cylinder radius=5 edge_radius=0.5 tilt_y=3 depth=0.3"
  skinfield press --indenter "sphere radius=6 x=-8" --indenter "ring inner_radius=3
      outer_radius=5 x=8 force=2" --layout hexagon72 -o press.npz
  skinfield press --indenter "mesh file=part.stl force=2" --plot part.png
  skinfield press --indenter "heightmap file=logo.png pixel=0.1 relief=1 force=5"
""",
)
@click.option(
    "--indenter",
    "indenters",
    multiple=True,
    metavar="WORDS",
    help=f"A body that presses; may be given several times.  [default: {DEFAULT}]",
)
@click.option("--layout", help="Layout file or generator whose taxels read the press.")
@click.option("--patch", help="Name or number of the patch of a layout with several.")
@click.option(
    "--quantity",
    type=click.Choice(list(QUANTITIES)),
    default="capacitance",
    show_default=True,
    help="What a taxel reads.",
)
@click.option(
    "--mechanics",
    type=click.Choice(list(MECHANICS)),
    default="layer",
    show_default=True,
    help="Model of the elastomer.",
)
@click.option("--extent-mm", type=float, help="Side of the square of skin around the origin.")
@click.option("--cell-mm", default=0.4, show_default=True, help="Side of a cell of the results.")
@click.option("--plot", default="press.png", show_default=True, help="Picture to write.")
@click.option("-o", "--output", help="File of fields, readings and resultants to write (.npz).")
@layer_options
def press(
    indenters: tuple[str, ...],
    layout: str | None,
    patch: str | None,
    quantity: str,
    mechanics: str,
    extent_mm: float | None,
    cell_mm: float,
    plot: str,
    output: str | None,
    **options: Any,
) -> None:
    """Press, tell, draw, write."""
    from skinfield.figures import check_name, save
    from skinfield.figures.press import draw_press
    from skinfield.simulate import press as pressed
    from skinfield.sinks.presses import check_press_name, save_press

    check_name(plot)
    if output is not None:
        check_press_name(output)
    bodies = [indenter_from_text(text) for text in indenters or (DEFAULT,)]
    taxels = None if layout is None else patch_of(skin_from_text(layout), patch)
    found = pressed(
        layer_from_options(**options),
        bodies,
        extent=_extent(bodies) if extent_mm is None else extent_mm * 1e-3,
        cell=cell_mm * 1e-3,
        mechanics=MECHANICS[mechanics](),
    )
    _tell(found)
    label, factor = LABELS[quantity]
    readings = None
    if taxels is not None:
        readings = found.readings(taxels.plane, taxels.pad_diameter, quantity) * factor
        _tell_readings(taxels, readings, label)
    save(draw_press(found, taxels, readings, label=label), plot)
    _say(f"wrote {plot}")
    if output is not None:
        save_press(found, output, taxels)
        _say(f"wrote {output}")


def _extent(bodies: list[Indenter]) -> float:
    """Side of a square around the origin that holds the places of all bodies, m."""
    far = max(float(np.abs([body.position, body.lowest]).max()) for body in bodies)
    return 2 * (far + ROOM * 1e-3)


def _tell(found: Press) -> None:
    from rich.table import Table

    table = Table(title="Indenters", title_justify="left")
    for column in ("#", "body"):
        table.add_column(column)
    for column in ("force N", "depth mm", "x mm", "y mm", "area mm²", "peak kPa"):
        table.add_column(column, justify="right")
    for index, part in enumerate(parts_of(found), start=1):
        table.add_row(str(index), *_row(part))
    console().print(table)
    moment = ", ".join(_fixed(part * 1e3, 2) for part in found.moment)
    _say(
        f"in all {found.force:.3f} N, moment {moment} N mm about the origin; "
        f"{found.contact_area * 1e6:.1f} mm² touch; residual {found.residual:.1e}"
    )


def _row(part: Part) -> list[str]:
    """Cells of the table for one indenter."""
    load = (part.force, part.depth * 1e3, *(part.centre * 1e3))
    return [part.indenter.kind, *(_fixed(value, 3) for value in load),
            f"{part.area * 1e6:.1f}", f"{part.peak / 1e3:.1f}"]  # fmt: skip


def _tell_readings(patch: Patch, readings: Floats, label: str) -> None:
    high, low = int(readings.argmax()), int(readings.argmin())
    _say(
        f"{label} of {len(patch)} taxels: from {_fixed(readings[low], 2)} at taxel "
        f"{low} to {_fixed(readings[high], 2)} at taxel {high}"
    )


def _fixed(value: float, decimals: int) -> str:
    """Write a number without a minus before nothing."""
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def _say(words: str) -> None:
    console().print(words, highlight=False, markup=False, soft_wrap=True)
