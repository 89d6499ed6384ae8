"""`skinfield design`: judge a layout before it is made."""

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np

from skinfield.cli import options, report
from skinfield.cli.settings import Elastomer
from skinfield.design import Judgement, Places, SkinDesign, Touch, judge
from skinfield.settings import Positive, Range

MAPS = 4  # that `judge` reports
PICTURE = "design.png"


def design(
    layout: options.LayoutWord,
    /,
    *,
    patch: options.PatchName = None,
    quantity: options.Reads = "capacitance",
    mechanics: Literal["layer", "covered-layer"] | None = None,
    noise: Annotated[float | None, Positive("no reading is exact")] = None,
    force_n: Annotated[float, Positive("of the touch, N")] = 0.5,
    radius_mm: Annotated[float | None, Positive("of the contact, mm")] = None,
    false_alarms: Annotated[float, Range(1e-12, 0.1, "a rate per reading")] = 1e-3,
    linear: bool = False,
    pitch_mm: Annotated[float | None, Positive("distance of places, mm")] = None,
    output: Annotated[str | None, options.OUTPUT] = None,
    maps: tuple[str, ...] = (),
    force: options.Force = False,
    as_json: options.Json = False,
    elastomer: options.OfElastomer = Elastomer(),
) -> None:
    """Judge a layout before it is made: blind spots, smallest force, sharpness.

    Where it is blind, which force it finds, how well it tells place, force and two touches apart.
    Nothing is pressed and no solver is asked: these are limits of the layout, the elastomer and the
    noise, which no method can beat.

    LAYOUT is a layout file, or a generator by name such as hexagon72 or cylinder:radius_mm=40
    ('skinfield layout generators' lists them).

    A touch is a round contact of --radius-mm that presses with --force-n. --noise is the standard
    deviation of one reading, in the quantity's unit (ΔC/C₀, or Pa for stress); of the mean of n
    readings, give it divided by the root of n. The table has the median of all places, the 90th
    percentile and the worst; the figure has the maps, dark where the skin is bad.

      skinfield design hexagon72 -o design.png
      skinfield design hexagon72 --thickness-mm 4 --noise 0.005 --force-n 1 --radius-mm 2
      skinfield design right_foot.txt --quantity stress --noise 400 --maps maps.csv

    Parameters
    ----------
    mechanics : str, optional
        Model of the elastomer. Default the profile's.
    noise : float, optional
        Standard deviation of a reading. Default 0.002, for stress 400 Pa.
    force_n : float, N
        Of the touch, N.
    radius_mm : float, mm, optional
        Of the contact, mm. Default half the thickness.
    false_alarms : float
        Rate at which noise alone may be taken for a touch, per reading.
    linear : bool
        Take readings as proportional to the force, also of deep touches.
    pitch_mm : float, mm, optional
        Distance of the places that are judged, mm. Default a tenth of the taxels'.
    output : str, optional
        Figure to write: .png, .pdf or .svg. Default design.png, or a name that is free.
    maps : tuple of str
        File of the maps, one row per place: .csv.
    """
    from skinfield.design.plot import draw_judgement
    from skinfield.files.pending import write_bytes
    from skinfield.plot import save

    picture = report.free_name(PICTURE) if output is None else output
    report.check_picture("--output", picture, force)
    for name in maps:
        report.check_output("--maps", name, force, ".csv")
    skin = options.skin_from_text(layout)
    report.say_notes(skin.notes)
    chosen = options.patch_of(skin, patch)
    profile = options.profile_in_use(elastomer, layout=layout)
    layer = options.layer_of(elastomer, profile)
    candidate = SkinDesign(
        patch=chosen,
        layer=layer,
        mechanics=options.mechanics_of(mechanics or profile.mechanics),
        quantity=options.quantity_of(quantity),
        noise_std=noise,
    )
    candidate = candidate.linear if linear else candidate
    touch = Touch(force_n, layer.thickness / 2 if radius_mm is None else radius_mm * 1e-3)
    places = None if pitch_mm is None else Places.over(chosen, pitch_mm * 1e-3)
    with report.progress("tables", MAPS + 1) as step:
        judgement = judge(
            candidate, touch, places, false_alarm_rate=false_alarms,
            on_map=lambda name: step(what=name),
        )  # fmt: skip
    save(draw_judgement(judgement), picture)
    for name in maps:
        write_bytes(name, judgement.as_csv().encode())
    report.finish(as_json, _plain(judgement), (picture, *maps), _lines(judgement))


def _plain(judgement: Judgement) -> dict[str, object]:
    """Numbers and verdict of one layout."""
    return {
        "patch": judgement.design.patch.name,
        "thickness_mm": judgement.design.layer.thickness * 1e3,
        "blind_share": judgement.blind.blind_share,
        "missed_share": judgement.missed_share,
        "rows": [row._asdict() for row in judgement.rows()],
        "verdict": judgement.verdict(),
    }


def _lines(judgement: Judgement) -> Iterator[report.Shown]:
    """Table, shares and verdict of one layout."""
    design, touch = judgement.design, judgement.touch
    title = (
        f"{design.patch.name}: {touch.force:g} N on a contact of radius {touch.radius * 1e3:g} mm, "
        f"{design.layer.thickness * 1e3:g} mm of {design.layer.young_modulus / 1e3:g} kPa"
    )
    shown = report.table(title, ("at one place",), ("unit", "median", "90 %", "worst"))
    for row in judgement.rows():
        shown.add_row(row.name, row.unit, *map(_short, (row.median, row.p90, row.worst)))
    yield shown
    blind, force = judgement.blind, judgement.detectable
    independent = force.searched.independent(force.false_alarm_rate)
    yield (
        f"{blind.blind_share:.1%} of {blind.places.area * 1e6:.0f} mm² is blind (below "
        f"{blind.threshold:.0%} of the best place); {judgement.missed_share:.1%} misses "
        f"{touch.force:g} N; noise is searched as at {independent:.0f} independent places"
    )
    yield judgement.verdict()


def _short(value: float) -> str:
    return f"{value:#.3g}".rstrip(".") if np.isfinite(value) else "never"
