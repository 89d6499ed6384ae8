"""`skinfield calibrate`: what a known load says about the skin."""

from typing import TYPE_CHECKING, Annotated

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from skinfield.cli import options, report
from skinfield.cli.main import new_app
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.errors import Floats, InputError, as_floats

if TYPE_CHECKING:
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.reconstruct.serialisation import ReconstructorConfig

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
    layout: options.LayoutText,
    patch: options.PatchName = None,
    axis: str = "-z",
    seconds: str | None = None,
    output: Annotated[str | None, options.OUTPUT] = None,
    plot: str | None = None,
    force: options.Force = False,
    as_json: options.Json = False,
    counts: options.Counts = options.CountSettings(),
    elastomer: options.OfElastomer = Elastomer(),
    model: options.Model = ModelSettings(),
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
    axis : str
        Of the sensor, into the skin.
    seconds : str, optional
        FROM,TO: part of the skin's recording to fit, s.
    output : str, optional
        File of the result (.json).
    plot : str, optional
        Figure of both forces over time: .png, .pdf or .svg.
    """
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.files import open_recording, write_summary
    from skinfield.plot import save
    from skinfield.signal import column_of, fit_scale
    from skinfield.signal.plot import draw_timeline

    report.check_picture("--plot", plot, force)
    report.check_output("--output", output, force, ".json")
    sensor = open_recording(force_file)
    reference = column_of(sensor, axis)
    plan = JobPlan.of(layout, patch, counts, elastomer, model)
    config, all_stamps, loads = _loads_of(recording, plan)
    within = _part_of(all_stamps, seconds)
    stamps, loads = all_stamps[within], loads[within]
    fit = fit_scale(stamps, loads, sensor.stamp_ns, reference)
    modulus = config.layer.young_modulus * 1e-3 * fit.factor
    model_used = {
        "grid": config.grid.shape[0],
        "poisson": config.layer.poisson_ratio,
        "thickness_mm": config.layer.thickness * 1e3,
        "solver": plan.model.solver,
    }
    result = fit.numbers() | {"modulus_kpa": modulus, "recording": recording, "force": force_file}
    result |= model_used
    words = ", ".join(f"{name.replace('_', ' ')} {each}" for name, each in model_used.items())
    lines = [fit.sentences(modulus), f"the modulus holds for {words} only"]
    if output:
        write_summary(output, result)
    if plot:
        figure = draw_timeline(
            (stamps - stamps[0]) * 1e-9,
            fit.factor * loads,
            fit.reference,
            label=f"skin x {fit.factor:.3g} (E = {modulus:.3g} kPa)",
            reference_label=f"force/torque sensor, {axis}",
            title=f"{config.patch.name}: normal force",
        )
        save(figure, plot)
    report.finish(as_json, result, (output, plot), lines)


def _loads_of(
    recording: str, plan: "JobPlan"
) -> "tuple[ReconstructorConfig, NDArray[np.int64], Floats]":
    """What reconstructs a recording, its stamps (T,) ns, and their normal force (T,) N."""
    from skinfield.cli.reconstruct_jobs import parts, place_of, take_in
    from skinfield.files.results import read_results

    with place_of(None) as place:
        take_in(recording, plan, place)
        results = read_results(place.part)
        report.say_notes(results.notes)
        loads: list[Floats] = []
        with report.progress("reconstructing", len(results)) as step:
            for part in parts(results, range(len(results)), fields=False):
                loads.append(part.force)
                step(sum(map(len, loads)))
        return results.config, results.stamps(0, len(results)), np.concatenate(loads)


def _part_of(stamps: NDArray[np.int64], seconds: str | None) -> NDArray[np.bool_]:
    """Readings from one time to another, after the first reading."""
    if seconds is None:
        return np.ones(len(stamps), dtype=np.bool_)
    ends = seconds.split(",")
    if len(ends) != 2:
        raise InputError(f"--seconds is {seconds!r}, expected two numbers such as 0,6.5")
    low, high = as_floats("--seconds", ends)
    time = (stamps - stamps[0]) * 1e-9
    part = (time >= low) & (time <= high)
    if not part.any():
        raise InputError(f"--seconds is {seconds!r}, expected a part of 0 to {time[-1]:.2f} s")
    return np.asarray(part)
