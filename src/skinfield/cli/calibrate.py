"""`skinfield calibrate`: what a known load says about the skin."""

from typing import Any

import click
import numpy as np

from skinfield.cli.inputs import LAYOUT_HELP
from skinfield.cli.options import conditioning_options, model_options
from skinfield.cli.reconstruct import prepare
from skinfield.cli.report import console, progress, say_notes


@click.group(context_settings={"max_content_width": 100})
def calibrate() -> None:
    """Calibrate a skin against loads that are known."""


@calibrate.command(
    short_help="Fit one modulus to a force sensor's recording.",
    help=f"""Fit one number, the elastomer's modulus, so that the reconstructed normal force follows
a force/torque sensor that was recorded beside the skin.

RECORDING is the skin's, FORCE that of the sensor (a yarpdatadumper log of fx fy fz mx my mz, or a
CSV with as many columns). {LAYOUT_HELP}

All forces of a linear reconstruction scale with the modulus, so the fit is least squares in one
factor. It is made on the first half of the recording and judged on the second, and on all of it;
a skin that misses part of the load, or a model that does not hold, shows as an error that no factor
removes.

\b
  skinfield calibrate scale skin/right_foot right_foot/analog:o --layout right_foot.txt --plot f.png
""",
)
@click.argument("recording")
@click.argument("force")
@click.option("--layout", "layout", required=True, help="Layout file, or generator by name.")
@click.option("--patch", help="Which patch, where the layout has several.")
@click.option("--axis", default="-z", show_default=True, help="Of the sensor, into the skin.")
@click.option(
    "--sum",
    "summed",
    type=click.Choice(["contacts", "field"]),
    default="contacts",
    show_default=True,
    help="What is summed: the contacts' force, or the whole field's pressure.",
)
@click.option("--summary", "summary_path", help="Result: .json.")
@click.option("--plot", help="Figure of both forces over time: .png, .pdf or .svg.")
@model_options
@conditioning_options
def scale(
    recording: str,
    force: str,
    layout: str,
    patch: str | None,
    axis: str,
    summed: str,
    **options: Any,
) -> None:
    """Fit a modulus."""
    from skinfield.calibrate import column_of, fit_scale
    from skinfield.figures import check_name
    from skinfield.sources import open_recording

    if options["plot"]:
        check_name(options["plot"])
    sensor = open_recording(force)
    reference = column_of(sensor, axis)
    job = prepare(recording, layout, patch, **options)
    say_notes(job.conditioned.notes)
    found: list[float] = []
    with progress() as bar:
        task = bar.add_task("reconstructing", total=len(job))
        for _, batch in job.estimates():
            if summed == "contacts":
                found += [sum(c.normal_force for c in contacts) for contacts in batch.contacts]
            else:
                found += np.asarray(batch.normal_force).tolist()
            bar.update(task, advance=len(batch))
    stamps = job.conditioned.recording.stamp_ns
    fit = fit_scale(stamps, np.array(found), sensor.stamp_ns, reference)
    modulus = options["modulus_kpa"] * fit.factor
    out = console()
    out.print(fit.sentences(modulus), highlight=False)
    result = fit.numbers() | {"modulus_kpa": modulus, "recording": recording, "force": force}
    if options["summary_path"]:
        from skinfield.sinks import write_summary

        write_summary(options["summary_path"], result)
    if options["plot"]:
        from skinfield.figures import draw_timeline, save

        figure = draw_timeline(
            (stamps - stamps[0]) * 1e-9,
            fit.factor * np.array(found),
            fit.reference,
            label=f"skin x {fit.factor:.3g} (E = {modulus:.3g} kPa)",
            reference_label=f"force/torque sensor, {axis}",
            title=f"{job.reconstructor.patch.name}: normal force, {summed} summed",
        )
        save(figure, options["plot"])
    for name in ("summary_path", "plot"):
        if options[name]:
            out.print(f"wrote {options[name]}", highlight=False)
