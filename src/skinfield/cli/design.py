"""`skinfield design`: judge a layout before it is made."""

from typing import Any

import click

from skinfield.cli.design_report import say, tell, tell_thickness
from skinfield.cli.inputs import LAYOUT_HELP, skin_from_text
from skinfield.cli.options import MECHANICS, QUANTITIES, patch_of
from skinfield.cli.outputs import check_output
from skinfield.cli.report import progress, say_notes
from skinfield.errors import InputError
from skinfield.mechanics import Layer
from skinfield.observation import Quantity
from skinfield.resolution import (
    Places,
    SkinDesign,
    Terms,
    Touch,
    compare_thickness,
    judge,
)

MAPS = 4  # that `judge` tells of


@click.command(
    short_help="Judge a layout before it is made: blind spots, smallest force, sharpness.",
    help=f"""Judge a layout before it is made: where it is blind, which force it finds, how well it
tells place, force and two touches apart. Nothing is pressed and no solver is asked: these are
limits of the layout, the elastomer and the noise, which no method can beat.

{LAYOUT_HELP}

A touch is a round contact of --radius mm that presses with --force N. --noise is the standard
deviation of one reading, in the quantity's unit (ΔC/C₀, or Pa for stress); of the mean of n
readings, give it divided by the root of n. The table has the median of all places, the 90th
percentile and the worst; the figure has the maps, dark where the skin is bad.

\b
  skinfield design hexagon72 -o design.png
  skinfield design hexagon72 --thickness 4 --noise 0.005 --force 1 --radius 2
  skinfield design right_foot.txt --quantity stress --noise 400 --csv maps.csv
  skinfield design hexagon72 --quantity stress --compare-thickness 1,2,3,4,6 -o thickness.png
""",
)
@click.argument("text", metavar="LAYOUT")
@click.option("--patch", help="Name or number of the patch of a layout with several.")
@click.option(
    "--thickness",
    "--thickness-mm",
    "thickness_mm",
    default=2.0,
    show_default=True,
    help="Of the elastomer, mm.",
)
@click.option(
    "--modulus",
    "--modulus-mpa",
    "modulus_mpa",
    type=float,
    help="Young's modulus, MPa, instead of --modulus-kpa.",
)
@click.option("--modulus-kpa", type=float, help="Young's modulus, kPa.  [default: 150]")
@click.option("--poisson", default=0.5, show_default=True, help="Poisson's ratio, 0 to 0.5.")
@click.option(
    "--quantity",
    type=click.Choice(list(QUANTITIES)),
    default="capacitance",
    show_default=True,
    help="What a taxel reads.",
)
@click.option(
    "--mechanics",
    type=click.Choice([n for n in MECHANICS if n != "half-space"]),
    default="layer",
    show_default=True,
    help="Model of the elastomer.",
)
@click.option(
    "--noise",
    type=float,
    help="Standard deviation of a reading.  [default: 0.002, for stress 400 Pa]",
)
@click.option(
    "--force", "--force-n", "force_n", default=0.5, show_default=True, help="Of the touch, N."
)
@click.option(
    "--radius",
    "--radius-mm",
    "radius_mm",
    type=float,
    help="Of the contact, mm.  [default: half the thickness]",
)
@click.option(
    "--false-alarms",
    default=1e-3,
    show_default=True,
    help="Rate at which noise alone may be taken for a touch, per reading.",
)
@click.option(
    "--detection", default=0.9, show_default=True, help="Rate at which the smallest force is found."
)
@click.option(
    "--two-point-errors",
    default=0.05,
    show_default=True,
    help="Rate of taking two touches for one, and one for two.",
)
@click.option(
    "--linear",
    is_flag=True,
    help="Take readings as proportional to the force, also of deep touches.",
)
@click.option(
    "--pitch-mm",
    type=float,
    help="Distance of the places that are judged.  [default: a tenth of the taxels']",
)
@click.option(
    "--compare-thickness",
    metavar="MM,MM,...",
    help="Judge the same touch under several thicknesses, and draw that instead.",
)
@click.option(
    "-o",
    "--output",
    default="design.png",
    show_default=True,
    help="Figure to write: .png, .pdf or .svg.",
)
@click.option("--csv", "csv_file", help="File of the maps, one row per place (.csv).")
@click.option("--json", "json_file", help="File of the maps and all numbers (.json).")
def design(
    text: str,
    patch: str | None,
    pitch_mm: float | None,
    compare_thickness: str | None,
    output: str,
    csv_file: str | None,
    json_file: str | None,
    **options: Any,
) -> None:
    """Judge, tell, draw, write."""
    from skinfield.figures import check_name

    check_name(output)
    files = _files(csv_file, json_file, compare_thickness)
    skin = skin_from_text(text)
    say_notes(skin.notes)
    chosen = patch_of(skin, patch)
    layer = _layer(**options)
    candidate = SkinDesign(
        patch=chosen,
        layer=layer,
        mechanics=MECHANICS[options["mechanics"]](),
        quantity=_quantity(options["quantity"]),
        noise_std=options["noise"],
    )
    candidate = candidate.linear if options["linear"] else candidate
    radius = layer.thickness / 2 if options["radius_mm"] is None else options["radius_mm"] * 1e-3
    touch = Touch(options["force_n"], radius)
    terms = Terms(
        false_alarm_rate=options["false_alarms"],
        detection_rate=options["detection"],
        error_rate=options["two_point_errors"],
    )
    if compare_thickness is not None:
        _compare(candidate, touch, terms, _thicknesses(compare_thickness), output)
        return
    places = None if pitch_mm is None else Places.over(chosen, pitch_mm * 1e-3)
    _judge(candidate, touch, terms, places, output, files)


def _files(csv_file: str | None, json_file: str | None, compare: str | None) -> list[str]:
    """Files of maps to write, checked before any work."""
    files = []
    for name, ending in ((csv_file, ".csv"), (json_file, ".json")):
        if name is None:
            continue
        if compare is not None:
            raise InputError(
                f"--{ending[1:]} is {name!r} beside --compare-thickness, expected one of them: "
                "maps are written of one thickness"
            )
        check_output(f"--{ending[1:]}", name, ending)
        files.append(name)
    return files


def _layer(
    thickness_mm: float,
    modulus_mpa: float | None,
    modulus_kpa: float | None,
    poisson: float,
    **_others: Any,
) -> Layer:
    if modulus_mpa is not None and modulus_kpa is not None:
        raise InputError(
            f"--modulus is {modulus_mpa} MPa and --modulus-kpa {modulus_kpa}, expected one of them"
        )
    modulus = 150e3 if modulus_kpa is None else modulus_kpa * 1e3
    return Layer(
        thickness_mm * 1e-3, modulus if modulus_mpa is None else modulus_mpa * 1e6, poisson
    )


def _quantity(name: str) -> Quantity:
    return QUANTITIES[name]()


def _thicknesses(text: str) -> list[float]:
    try:
        return [float(part) * 1e-3 for part in text.split(",")]
    except ValueError:
        raise InputError(
            f"--compare-thickness is {text!r}, expected thicknesses in mm such as 1,2,4"
        ) from None


def _judge(
    candidate: SkinDesign,
    touch: Touch,
    terms: Terms,
    places: Places | None,
    output: str,
    files: list[str],
) -> None:
    from skinfield.figures import save
    from skinfield.figures.design import draw_judgement
    from skinfield.sinks.judgements import save_judgement

    with progress() as bar:
        task = bar.add_task("tables", total=MAPS + 1)
        judgement = judge(
            candidate,
            touch,
            places,
            terms=terms,
            on_map=lambda name: bar.update(task, description=name, advance=1),
        )
    tell(judgement)
    save(draw_judgement(judgement), output)
    for file in (output, *(str(save_judgement(judgement, name)) for name in files)):
        say(f"wrote {file}")


def _compare(
    candidate: SkinDesign, touch: Touch, terms: Terms, thicknesses: list[float], output: str
) -> None:
    from skinfield.figures import save
    from skinfield.figures.design import draw_thickness

    with progress() as bar:
        task = bar.add_task("thickness", total=len(thicknesses))
        told: list[float] = []

        def on_thickness(thickness: float) -> None:
            bar.update(task, description=f"{thickness * 1e3:g} mm", completed=len(told))
            told.append(thickness)

        found = compare_thickness(
            candidate, touch, thicknesses, terms=terms, on_thickness=on_thickness
        )
    tell_thickness(found)
    save(draw_thickness(found), output)
    say(f"wrote {output}")
