"""`skinfield calibrate`: what a known load says about the skin."""

from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from skinfield.cli.inputs import LAYOUT_HELP
from skinfield.cli.job import Job, prepare
from skinfield.cli.options import conditioning_options, model_options
from skinfield.cli.report import console, progress, say_notes
from skinfield.errors import Floats, InputError, as_floats
from skinfield.reading import Recording


@click.group(
    context_settings={"max_content_width": 100},
    help="""Calibrate a skin against loads that are known.

The gain from counts to capacitance and the elastomer's modulus are rarely known, and every force
is proportional to them. A force sensor recorded beside the skin gives their product.

\b
  skinfield calibrate scale skin/right_foot right_foot/analog:o --layout right_foot.txt
""",
)
def calibrate() -> None:
    """Calibrate a skin."""


@calibrate.command(
    short_help="Fit one modulus to a force sensor's recording.",
    help=f"""Fit one number, the elastomer's modulus, so that the reconstructed normal force follows
a force/torque sensor that was recorded beside the skin.

RECORDING is the skin's, FORCE that of the sensor: a yarpdatadumper log of fx fy fz mx my mz, or a
CSV with columns time_s,fx,fy,fz. {LAYOUT_HELP}

All forces of a linear reconstruction scale with the modulus, so the fit is least squares in one
factor. It is made on the first half of the recording and judged on the second, and on all of it;
a skin that misses part of the load, or a model that does not hold, shows as an error that no factor
removes.

\b
  skinfield calibrate scale skin/right_foot right_foot/analog:o --layout right_foot.txt --plot f.png
  skinfield calibrate scale skin.csv force.csv --layout hexagon72 --axis z --seconds 2,10
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
@click.option("--seconds", metavar="FROM,TO", help="Part of the skin's recording to fit.")
@click.option("--summary", "summary_path", help="Result: .json.")
@click.option("--plot", help="Figure of both forces over time: .png, .pdf or .svg.")
@model_options(grid=20)
@conditioning_options
def scale(
    recording: str,
    force: str,
    layout: str,
    patch: str | None,
    axis: str,
    summed: str,
    seconds: str | None,
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
    found = _forces(job, summed)
    part = _part_of(job.conditioned.recording, seconds)
    stamps, forces = job.conditioned.recording.stamp_ns[part], found[part]
    fit = fit_scale(stamps, forces, sensor.stamp_ns, reference)
    modulus = options["modulus_kpa"] * fit.factor
    out = console()
    out.print(fit.sentences(modulus), highlight=False, soft_wrap=True)
    model = {name: options[name] for name in ("grid", "poisson", "thickness_mm", "solver")}
    held = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in model.items())
    out.print(f"the modulus holds for {held} only", highlight=False)
    result = fit.numbers() | {"modulus_kpa": modulus, "recording": recording, "force": force}
    result |= model
    if options["summary_path"]:
        from skinfield.sinks import write_summary

        write_summary(options["summary_path"], result)
    if options["plot"]:
        from skinfield.figures import draw_timeline, save

        figure = draw_timeline(
            (stamps - stamps[0]) * 1e-9,
            fit.factor * forces,
            fit.reference,
            label=f"skin x {fit.factor:.3g} (E = {modulus:.3g} kPa)",
            reference_label=f"force/torque sensor, {axis}",
            title=f"{job.reconstructor.patch.name}: normal force, {summed} summed",
        )
        save(figure, options["plot"])
    for name in ("summary_path", "plot"):
        if options[name]:
            out.print(f"wrote {options[name]}", highlight=False, soft_wrap=True)


def _forces(job: Job, summed: str) -> Floats:
    """Normal force of every reading, (T,) N."""
    found: list[float] = []
    with progress() as bar:
        task = bar.add_task("reconstructing", total=len(job))
        for _, batch in job.estimates():
            if summed == "contacts":
                found += [sum(c.normal_force for c in contacts) for contacts in batch.contacts]
            else:
                found += np.asarray(batch.normal_force).tolist()
            bar.update(task, advance=len(batch))
    return np.array(found)


def _part_of(recording: Recording, seconds: str | None) -> NDArray[np.bool_]:
    """Readings from one time to another, after the first reading."""
    if seconds is None:
        return np.ones(len(recording), dtype=np.bool_)
    ends = seconds.split(",")
    if len(ends) != 2:
        raise InputError(f"--seconds is {seconds!r}, expected two numbers such as 0,6.5")
    low, high = as_floats("--seconds", ends)
    part = (recording.time >= low) & (recording.time <= high)
    if not part.any():
        raise InputError(
            f"--seconds is {seconds!r}, expected a part of 0 to {recording.time[-1]:.2f} s"
        )
    return np.asarray(part)
