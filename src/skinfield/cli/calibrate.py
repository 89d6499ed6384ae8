"""`skinfield calibrate`: what a known load says about the skin."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from skinfield.cli.main import new_app
from skinfield.cli.options import (
    OF_UNIT,
    OUTPUT,
    USUAL_SOLVER,
    CountSettings,
    Force,
    Json,
    conditioning_of,
    layer_of,
    part,
    patch_of,
    profile_in_use,
    quantity_of,
    reconstructor_of,
    skin_from_text,
)
from skinfield.cli.report import check_new, check_output, print_json, progress, say, say_notes
from skinfield.errors import Floats, InputError, as_floats
from skinfield.estimate import Estimate
from skinfield.reconstruct import Reconstructor
from skinfield.reconstruct.conditioned import Conditioned, condition, without_empty
from skinfield.settings import Elastomer, ModelSettings
from skinfield.signal import column_of, fit_scale
from skinfield.skin.reading import Recording

CHUNK = 64  # readings per step of the progress bar; bounds the memory of the fields

calibrate = new_app(
    "calibrate",
    """Calibrate a skin against loads that are known.

The gain from counts to capacitance and the elastomer's modulus are rarely known, and every force
is proportional to them. A force sensor recorded beside the skin gives their product.

  skinfield calibrate scale skin/right_foot right_foot/analog:o --skin right_foot.txt""",
)


@calibrate.command
def scale(
    recording: str,
    force_file: Annotated[str, Parameter(name="FORCE")],
    /,
    *,
    layout: str,
    patch: str | None = None,
    axis: str = "-z",
    summed: Annotated[Literal["contacts", "field"], Parameter(name="--sum")] = "contacts",
    seconds: str | None = None,
    output: Annotated[str | None, OUTPUT] = None,
    plot: str | None = None,
    force: Force = False,
    as_json: Json = False,
    counts: Annotated[CountSettings, part("Counts")] = CountSettings(),
    elastomer: Annotated[Elastomer, part("Elastomer")] = Elastomer(),
    model: Annotated[ModelSettings, part("Model")] = ModelSettings(),
) -> None:
    """Fit the elastomer's modulus so that the normal force follows a force sensor.

    RECORDING is the skin's, FORCE that of the sensor: a yarpdatadumper log of fx fy fz mx my mz, or
    a CSV with columns time_s,fx,fy,fz.

    All forces of a linear reconstruction scale with the modulus, so the fit is least squares in one
    factor. It is made on the first half of the recording and judged on the second, and on all of
    it; a skin that misses part of the load, or a model that does not hold, shows as an error that
    no factor removes.

      skinfield calibrate scale skin/right_foot right_foot/analog:o --skin right_foot.txt
      skinfield calibrate scale skin.csv force.csv --skin hexagon72 --axis z --seconds 2,10

    Parameters
    ----------
    recording : str
        Of the skin.
    force_file : str
        Recording of the force sensor.
    layout : str
        Layout file, or a generator by name.
    patch : str, optional
        Name or number of the patch of a layout with several.
    axis : str
        Of the sensor, into the skin.
    summed : str
        What is summed: the contacts' force, or the whole field's pressure.
    seconds : str, optional
        FROM,TO: part of the skin's recording to fit, s.
    output : str, optional
        File of the result (.json).
    plot : str, optional
        Figure of both forces over time: .png, .pdf or .svg.
    as_json : bool
        The result as one JSON object.
    """
    from skinfield.files import open_recording, write_summary
    from skinfield.plot import check_name, draw_timeline, save

    if plot:
        check_name(plot)
    check_output("--output", output, ".json")
    check_new("--plot", plot, force)
    check_new("--output", output, force)
    sensor = open_recording(force_file)
    reference = column_of(sensor, axis)
    job = prepare(recording, layout, patch, counts, elastomer, model)
    say_notes(job.conditioned.notes)
    sums = _forces(job, summed)
    within = _part_of(job.conditioned.recording, seconds)
    stamps, forces = job.conditioned.recording.stamp_ns[within], sums[within]
    fit = fit_scale(stamps, forces, sensor.stamp_ns, reference)
    layer = job.reconstructor.layer
    modulus = layer.young_modulus * 1e-3 * fit.factor
    held = {
        "grid": job.reconstructor.grid.shape[0],
        "poisson": layer.poisson_ratio,
        "thickness_mm": layer.thickness * 1e3,
        "solver": model.solver or USUAL_SOLVER,
    }
    result = fit.numbers() | {"modulus_kpa": modulus, "recording": recording, "force": force_file}
    result |= held
    if as_json:
        print_json(result)
    else:
        say(fit.sentences(modulus))
        words = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in held.items())
        say(f"the modulus holds for {words} only")
    if output:
        write_summary(output, result)
    if plot:
        figure = draw_timeline(
            (stamps - stamps[0]) * 1e-9,
            fit.factor * forces,
            fit.reference,
            label=f"skin x {fit.factor:.3g} (E = {modulus:.3g} kPa)",
            reference_label=f"force/torque sensor, {axis}",
            title=f"{job.reconstructor.patch.name}: normal force, {summed} summed",
        )
        save(figure, plot)
    for name in (output, plot):
        if name and not as_json:
            say(f"wrote {name}")


@dataclass(frozen=True, eq=False)
class Job:
    """A recording and what reconstructs it."""

    reconstructor: Reconstructor
    conditioned: Conditioned

    def __len__(self) -> int:
        return len(self.conditioned.values)

    def estimates(self) -> Iterator[tuple[int, Estimate]]:
        """Batches of estimates, each with the index of its first reading."""
        stamps = self.conditioned.recording.stamp_ns
        for first in range(0, len(self), CHUNK):
            part = slice(first, first + CHUNK)
            yield first, self.reconstructor(self.conditioned.values[part], stamp_ns=stamps[part])


def prepare(
    path: str,
    layout: str,
    patch_name: str | None,
    counts: CountSettings,
    elastomer: Elastomer,
    model: ModelSettings,
) -> Job:
    """Open, condition and prepare."""
    from skinfield.files import open_recording, readings_for

    patch = patch_of(skin_from_text(layout), patch_name)
    board = None if counts.board == "auto" else counts.board
    profile = profile_in_use(elastomer, board, layout)
    layer, how = layer_of(elastomer, profile), conditioning_of(patch, counts, profile)
    with progress() as bar:
        task = bar.add_task("reading", total=None)
        opened = open_recording(
            path, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    readings = readings_for(opened, patch)
    quantity = quantity_of(model.quantity or OF_UNIT[readings.unit])
    conditioned = without_empty(condition(readings, patch, layer, quantity, how))
    reconstructor = reconstructor_of(patch, layer, quantity, conditioned.noise_std, model, profile)
    return Job(reconstructor, conditioned)


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
