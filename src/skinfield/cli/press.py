"""`skinfield press`: rigid bodies on the skin, and what the skin feels of them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.cli.settings import Elastomer, MechanicsName
from skinfield.errors import Floats
from skinfield.settings import Positive

if TYPE_CHECKING:
    from skinfield.simulate import Indenter, Press

DEFAULT = "sphere radius=6 force=1"
PICTURE = "press.png"
PLACELESS = "hexagon72"  # stands for a virtual skin where no taxels are
ROOM = 20.0  # mm around the reference points of the indenters
LABELS = {"capacitance": ("ΔC/C₀ (%)", 100.0), "gap": ("indentation (% of the layer)", 100.0),
          "stress": ("base stress (kPa)", 1e-3)}  # fmt: skip
BODY = (
    Column("#", "number", decimals=0), Column("body", "body"),
    Column("force N", "force_N", decimals=3), Column("depth mm", "depth_m", 1e3, 3),
    Column("x mm", "x_m", 1e3, 3), Column("y mm", "y_m", 1e3, 3),
    Column("area mm²", "area_m2", 1e6, 1), Column("peak kPa", "peak_Pa", 1e-3, 1),
)  # fmt: skip


def press(
    *,
    indenter: tuple[str, ...] = (),
    layout: str | None = None,
    patch: options.PatchName = None,
    quantity: options.Reads = "capacitance",
    mechanics: MechanicsName | None = None,
    extent_mm: Annotated[float | None, Positive("side of the skin, mm")] = None,
    cell_mm: Annotated[float, Positive("side of a cell, mm")] = 0.4,
    friction: Annotated[float | None, Positive("Coulomb's coefficient")] = None,
    plot: str | None = None,
    output: Annotated[str | None, options.OUTPUT] = None,
    force: options.Force = False,
    as_json: options.Json = False,
    elastomer: options.OfElastomer = Elastomer(),
) -> None:
    """Press rigid bodies on the skin: pressure, depth, readings.

    It says how deep they sink, where they touch, and what taxels below them read, all without
    noise.

    Each --indenter is a shape and key=value words in mm, N and degrees. Load it with force=1 or
    depth=0.3; lean it with tilt_x=, tilt_y= about its own axes, turn it with rotation=, push it
    sideways with shear_x=, shear_y=.

      sphere    radius
      cylinder  radius [edge_radius]
      cone      radius half_angle [edge_radius]            angle from the axis
      bar       length width [edge_radius]                 flat face, length along x
      finger    width length [second] [apart] [growth]     soft, its pressure is imposed
      rod       radius length [edge_radius]                lies along x
      wedge     length width half_angle [edge_radius]      straight edge along x
      ring      inner_radius outer_radius [edge_radius]
      mesh      file [unit_mm] [down=0,0,-1]               STL, OBJ, PLY
      heightmap file pixel [relief] [invert]               PNG (white touches first), NPY, CSV

      skinfield press
      skinfield press --indenter "cylinder radius=5 edge_radius=0.5 tilt_y=3 depth=0.3"
      skinfield press --indenter "sphere radius=6 x=-8" --indenter "ring inner_radius=3
          outer_radius=5 x=8 force=2" --skin hexagon72 -o press.npz
      skinfield press --indenter "sphere radius=6 force=1 shear_x=0.4" --friction 0.6
      skinfield press --indenter "mesh file=part.stl force=2" --plot part.png
      skinfield press --indenter "heightmap file=logo.png pixel=0.1 relief=1 force=5"

    Parameters
    ----------
    indenter : tuple of str
        A body that presses, see above; again for more. Default "sphere radius=6 force=1".
    layout : str, optional
        Layout file, or a generator by name, whose taxels read the press.
    mechanics : str, optional
        Model of the elastomer. Default the profile's.
    extent_mm : float, mm, optional
        Side of the square of skin around the origin, mm.
    cell_mm : float, mm
        Side of a cell of the results, mm.
    friction : float, optional
        Coulomb's coefficient, for bodies with a shear. Default no limit: they stick.
    plot : str, optional
        Picture to write: .png, .pdf or .svg. Default press.png, or a name that is free.
    output : str, optional
        File of fields, readings and resultants to write (.npz).
    """
    from skinfield.files.pending import write_npz
    from skinfield.lab.scenarios.indenters import indenter_from_text
    from skinfield.plot import save
    from skinfield.simulate import press as pressed
    from skinfield.simulate.pressing.plot import draw_press
    from skinfield.simulate.pressing.press import arrays_of

    picture = report.free_name(PICTURE) if plot is None else plot
    report.check_picture("--plot", picture, force)
    report.check_output("--output", output, force, ".npz")
    profile = options.profile_in_use(elastomer, layout=layout or PLACELESS)
    texts = indenter or (DEFAULT,)
    bodies = [options.parsed("--indenter", text, indenter_from_text) for text in texts]
    taxels = None if layout is None else options.patch_of(options.skin_from_text(layout), patch)
    result = pressed(
        options.layer_of(elastomer, profile),
        bodies,
        extent=_extent(bodies) if extent_mm is None else extent_mm * 1e-3,
        cell=cell_mm * 1e-3,
        mechanics=options.mechanics_of(mechanics or profile.mechanics),
        friction=friction,
    )
    label, factor = LABELS[quantity]
    readings = None
    if taxels is not None:
        readings = result.readings(taxels.plane, taxels.pad_diameter, quantity)
    shown = None if readings is None else readings * factor
    save(draw_press(result, taxels, shown, label=label), picture)
    if output is not None:
        write_npz(output, arrays_of(result, taxels))
    plain = _plain(result, readings)
    report.finish(as_json, plain, (picture, output), _lines(plain, shown, label))


def _extent(bodies: "list[Indenter]") -> float:
    """Side of a square around the origin that holds the places of all bodies, m."""
    far = max(float(np.abs([body.position, body.lowest]).max()) for body in bodies)
    return 2 * (far + ROOM * 1e-3)


def _plain(result: "Press", readings: Floats | None) -> dict[str, Any]:
    """What a press comes to, in SI units."""
    from skinfield.simulate.pressing.press import parts_of

    return {
        "bodies": parts_of(result),
        "force_N": result.force,
        "moment_Nm": [float(each) for each in result.moment],
        "area_m2": result.contact_area,
        "residual": result.residual,
        "readings": None if readings is None else readings.tolist(),
    }


def _lines(plain: dict[str, Any], readings: Floats | None, label: str) -> Iterator[report.Shown]:
    yield report.table_of("Indenters", plain["bodies"], BODY)
    moment = ", ".join(report.fixed(each * 1e3, 2) for each in plain["moment_Nm"])
    yield (
        f"in all {plain['force_N']:.3f} N, moment {moment} N mm about the origin; "
        f"{plain['area_m2'] * 1e6:.1f} mm² touch; residual {plain['residual']:.1e}"
    )
    if readings is not None:
        high, low = int(readings.argmax()), int(readings.argmin())
        yield (
            f"{label} of {len(readings)} taxels: from {report.fixed(readings[low], 2)} at taxel "
            f"{low} to {report.fixed(readings[high], 2)} at taxel {high}"
        )
