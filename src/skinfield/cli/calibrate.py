"""`skinfield calibrate`: what a known load says about the skin."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from skinfield.cli import options, report
from skinfield.cli.main import new_app
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.errors import Floats, InputError, check_positive

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from skinfield.calibrate import (
        ForceCalibration,
        LayerComparison,
        PressureCalibration,
        TouchCalibration,
    )
    from skinfield.cli.calibration_inputs import Series
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.reconstruct.serialisation import ReconstructorConfig
    from skinfield.skin import Patch
    from skinfield.skin.log import LogSettings

PLACE_STD = 0.3e-3  # m, of taxels as they are made
TimeColumn = Annotated[
    str | None, Parameter(help="Column of the times of RECORDING, where it is a plain table.")
]
TaxelColumns = Annotated[
    str | None,
    Parameter(help="Columns of the taxels of RECORDING, such as 3-282, where it is a plain table."),
]
CalibrationFile = Annotated[
    str | None, options.OUTPUT, Parameter(help="Calibration file (.toml, .npz).")
]
LAYERS = (
    report.Column("layer", "layer"), report.Column("probability", "probability", decimals=2),
    report.Column("model error %", "model_error", 100.0, 1),
    report.Column("forces, of the stated", "force_ratio", decimals=2),
)  # fmt: skip
ReportFolder = Annotated[
    str | None, Parameter(name="--report", help="DIR for a page with figures and a verdict.")
]

calibrate = new_app(
    "calibrate",
    """Calibrate a skin against loads that are known, and try the calibration on another recording.

  skinfield calibrate layer touches.csv --skin palm.toml
  skinfield calibrate touch presses.csv --skin palm.toml -o cal.toml --report palm
  skinfield calibrate force palm.csv scale.csv --skin palm.toml -o cal.toml --report palm
  skinfield calibrate pressure bag.csv gauge.csv --unit kPa -o cal.toml
  skinfield calibrate check cal.toml other.csv other_scale.csv --skin palm.toml
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
    from skinfield.signal import column_of, fit_scale

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
        of = f"skin x {fit.factor:.3g} (E = {modulus:.3g} kPa)", f"force/torque sensor, {axis}"
        _draw_forces(plot, stamps, fit.factor * loads, fit.reference, *of, config.patch.name)
    report.finish(as_json, result, (output, plot), lines)


def _draw_forces(
    path: str,
    stamps: NDArray[np.int64],
    loads: Floats,
    reference: Floats,
    label: str,
    reference_label: str,
    name: str,
) -> None:
    """Draw the skin's forces and those of a sensor, (T,) N, over time into a file."""
    from skinfield.plot import save
    from skinfield.signal.plot import draw_timeline

    labels = {"label": label, "reference_label": reference_label}
    time, title = (stamps - stamps[0]) * 1e-9, f"{name}: normal force"
    save(draw_timeline(time, loads, reference, title=title, **labels), path)


@calibrate.command(name="force")
def by_force(
    recording: str,
    labels_file: Annotated[str, Parameter(name="LABELS")],
    /,
    *more: Annotated[str, Parameter(name="MORE", show=False)],
    layout: options.LayoutText,
    patch: options.PatchName = None,
    time: TimeColumn = None,
    columns: TaxelColumns = None,
    labels: str | None = None,
    unit: str | None = None,
    offset: str | None = None,
    output: CalibrationFile = None,
    report_folder: ReportFolder = None,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Calibrate the total force on a patch by a force sensor, or a robot's probe.

    RECORDING is the skin's. LABELS is a log of fx fy fz, or a table of numbers: by time, if both
    have times (a delay is found), else row by row. Of three axes the one that varies most is taken.
    Forces are positive in compression: labels that fall as the skin is pressed are turned, which is
    said, and so is what they read at rest. A dead sensor is refused. Further recordings, each with
    its labels, may follow.

      skinfield calibrate force skin/r_foot r_foot/analog:o --skin r_foot.txt -o cal.toml
      skinfield calibrate force a.csv a_scale.csv b.csv b_scale.csv --skin palm.toml -o cal.toml
      skinfield calibrate force palm.csv scale.csv --labels force_N --skin palm.toml -o cal.toml

    Parameters
    ----------
    recording : str
        Of the skin.
    labels_file : str
        Forces: a log, a CSV, FILE.mat:NAME, FILE.npz:NAME.
    labels : str, optional
        Columns of the forces, one or three. Default all but the times.
    unit : str, optional
        Of the labels: N, kN or mN. Default as columns are named, such as force_kN, else N.
    offset : str, optional
        What the sensor reads without load, to be taken off: as many numbers as labels have columns,
        in their unit.
    """
    from skinfield.calibrate.by_force import fit_force
    from skinfield.calibrate.plot import draw_trivial
    from skinfield.cli.calibration_inputs import forces_together
    from skinfield.cli.calibration_report import draw_answers

    _check_files(output, report_folder, force)
    its = options.patch_of(options.skin_from_text(layout), patch)
    files = (recording, labels_file, *more)
    counts, forces, notes = forces_together(
        files, its, time=time, columns=columns, labels=labels, unit=unit, offset=offset,
        log=options.log_of(layout),
    )  # fmt: skip
    made, foretold = fit_force(its, counts, forces)
    facts = {
        "recording": ", ".join(files[::2]), "labels": ", ".join(files[1::2]),
        "readings": str(len(counts)), "mean force": f"{made.mean_force:.4g} N",
        "error": f"{made.residual_std:.3g} N rms",
    }  # fmt: skip
    result = {"rmse_N": made.residual_std, "constant_rmse_N": made.constant_rmse} | {
        "sum_rmse_N": made.sum_rmse, "ridge_rmse_N": made.ridge_rmse, "verdict": made.verdict
    }  # fmt: skip
    figures = {}
    if report_folder:
        figures = {
            "Each fifth foretold from the others": draw_answers(
                foretold, made.label(forces), its.name
            ),
            "Error beside trivial answers": draw_trivial(made.residual_std, made.rmse),
        }
    report.say_notes(notes)
    shown = "Calibration by force", facts, figures, notes
    _finish(made, result, shown, output, report_folder, as_json)


@calibrate.command(name="pressure")
def by_pressure(
    recording: str,
    labels_file: Annotated[str, Parameter(name="PRESSURE")],
    /,
    *,
    time: TimeColumn = None,
    columns: TaxelColumns = None,
    labels: str | None = None,
    unit: str | None = None,
    output: CalibrationFile = None,
    report_folder: ReportFolder = None,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Calibrate the taxels of a foam by a known uniform pressure, as of a vacuum bag.

    Places of taxels are not needed. A solid silicone, which no uniform pressure thins, is refused.

      skinfield calibrate pressure bag.csv gauge.csv --labels p_kPa --unit kPa -o cal.toml
      skinfield calibrate pressure a.mat:trial.C a.mat:trial.P --columns 3- --unit bar -o cal.toml

    Parameters
    ----------
    recording : str
        Of the skin, readings evenly spaced in time.
    labels_file : str
        The pressure: a CSV, FILE.mat:NAME, FILE.npz:NAME.
    labels : str, optional
        Column of the pressure. Default the only one beside the times.
    unit : str, optional
        Of the pressure: Pa, kPa, MPa, bar, mbar, psi. Default as columns are named, such as p_kPa,
        else Pa.
    """
    from skinfield.calibrate import pressure as fit
    from skinfield.calibrate.plot import draw_errors
    from skinfield.cli.calibration_inputs import label_series, skin_series, together

    _check_files(output, report_folder, force)
    skin = skin_series(recording, None, time, columns)
    counts, reference, notes = together(skin, label_series(labels_file, labels, unit, "Pa"))
    made = fit(counts, reference[:, 0])
    broken = {f"taxel {k}": why for k, why in enumerate(made.reasons) if why}
    facts = {
        "recording": recording, "pressure": labels_file, "readings": str(len(counts)),
        "time constants": ", ".join(f"{each:g}" for each in made.time_constants) + " readings",
        "taxels": f"{int(made.usable.sum())} of {len(made)} answer, "
        f"{int(np.isfinite(made.shift).sum())} are shifted by their board at times",
    }  # fmt: skip
    result = {
        "rmse_Pa": float(np.median(made.rmse[made.usable])), "usable": int(made.usable.sum()),
        "line_rmse_Pa": float(np.median(made.line_rmse[made.usable])), "verdict": made.verdict,
    }  # fmt: skip
    figures = {"Error of each taxel": draw_errors(made)} if report_folder else {}
    report.say_notes(notes)
    notes = (*notes, *(f"{name}: {why}" for name, why in broken.items()))  # on the page
    shown = "Calibration by pressure", facts, figures, notes
    _finish(made, result, shown, output, report_folder, as_json)


@calibrate.command
def touch(
    *recordings: Annotated[str, Parameter(name="RECORDING", negative=())],
    layout: options.LayoutText,
    patch: options.PatchName = None,
    known: float | None = None,
    at: str | None = None,
    output: Annotated[str | None, options.OUTPUT] = None,
    report_folder: ReportFolder = None,
    force: options.Force = False,
    as_json: options.Json = False,
    counts: options.Counts = options.CountSettings(),
    elastomer: options.OfElastomer = Elastomer(),
) -> None:
    """Calibrate a skin by touches of which nothing is known.

    Some hundred presses of balls, fingertips or tools, one at a time, all over the skin, tell how
    thick the elastomer is, its Poisson's ratio, whether a cover lies on it, and the gain of each
    taxel beside the others. Pauses of seconds after touches also tell how the elastomer creeps,
    which is then undone. Forces remain relative until one is known, as of a weight laid down.

      skinfield calibrate touch presses.csv --skin palm.toml -o cal.toml --report palm
      skinfield calibrate touch presses.csv --skin palm.toml --known 0.981 --at 12.5,14 -o cal.toml
      skinfield calibrate touch monday.csv tuesday.csv --skin palm.toml -o cal.toml

    Parameters
    ----------
    *recordings : str
        Of the presses, one or more. Each has a rest of its own, as read between
        presses; that of the first is kept.
    known : float, optional
        Force, N, of what presses during --at.
    at : str, optional
        FROM,TO: when the known force pressed, s after the first reading of the first recording.
    output : str, optional
        Calibration file (.toml, .npz), for `skinfield reconstruct --calibration`.
    """
    from skinfield.calibrate import touch as fit
    from skinfield.calibrate.plot import draw_gains
    from skinfield.cli.calibration_inputs import presses_in
    from skinfield.cli.calibration_report import facts_of_touches
    from skinfield.cli.reconstruct_jobs import JobPlan

    _check_files(output, report_folder, force)
    if (known is None) != (at is None):
        raise InputError("--known and --at belong together: a force, and when it pressed")
    if known is not None:
        check_positive("--known", known, "the force in N of what presses during --at")
    plan = JobPlan.of(layout, patch, counts, elastomer, ModelSettings())
    layer, how = options.layer_of(plan.elastomer), options.conditioning_of(plan.patch, plan.counts)
    presses = presses_in(recordings, plan, layer, how)
    forces = None
    if known is not None:
        forces = np.full(len(presses.readings), np.nan)
        forces[: presses.first][_part_of(presses.stamps[: presses.first], at)] = known
    with report.progress("fitting presses and skin"):
        made = fit(
            plan.patch, presses.readings, noise_std=how.noise_std, layer=layer,
            known_force=forces, place_std=PLACE_STD, stamp_ns=presses.stamps,
        )  # fmt: skip
    counted = presses.calibration
    if counted is not None:
        rest = np.where(counted.alive, presses.rest * counted.gain, 0.0)
        made = made.with_counts(replace(counted, baseline=counted.baseline + rest))
    beside = 100.0 * (made.gain - 1.0)
    gains = {"Gain of each taxel": draw_gains(plan.patch, beside, "gain beside the others (%)")}
    report.say_notes(presses.notes)
    facts, result = facts_of_touches(made, recordings)
    shown = "Calibration by touch", facts, gains if report_folder else {}, presses.notes
    _finish(made, result, shown, output, report_folder, as_json)


@calibrate.command
def layer(
    *recordings: Annotated[str, Parameter(name="RECORDING", negative=())],
    layout: options.LayoutText,
    patch: options.PatchName = None,
    report_folder: ReportFolder = None,
    force: options.Force = False,
    as_json: options.Json = False,
    counts: options.Counts = options.CountSettings(),
    elastomer: options.OfElastomer = Elastomer(),
    model: options.Model = ModelSettings(),
) -> None:
    """Compare the layer that is stated with others, by touches of which nothing is known.

    Twenty touches of anything, all over the skin, tell whether it reads as the thickness, Poisson's
    ratio and cover that are stated, or like a softer elastomer, a foam, one with another cover, a
    thinner or a thicker one, each with its probability. What reads alike is named together.

      skinfield calibrate layer touches.csv --skin palm.toml
      skinfield calibrate layer touches.csv --skin palm.toml --thickness-mm 3 --poisson 0.45

    Parameters
    ----------
    *recordings : str
        Of the touches, one or more. Each has a rest of its own, as read between them.
    """
    from skinfield.calibrate import compare_layers
    from skinfield.calibrate.plot import draw_layers
    from skinfield.cli.calibration_inputs import presses_in
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.elastic import BondedLayer

    _check_files(None, report_folder, force)
    plan = JobPlan.of(layout, patch, counts, elastomer, model)
    stated, how = options.layer_of(plan.elastomer), options.conditioning_of(plan.patch, plan.counts)
    held = options.mechanics_of(plan.model.mechanics or "")
    if not isinstance(held, BondedLayer):
        raise InputError(
            "--mechanics is half-space, expected layer or covered-layer, which have a thickness"
        )
    presses = presses_in(recordings, plan, stated, how)
    with report.progress("fitting touches by each layer"):
        made = compare_layers(
            plan.patch, presses.readings, layer=stated, mechanics=held, noise_std=how.noise_std
        )
    rows = made.to_rows()
    result = {"verdict": made.verdict, "fits": made.fits, "layers": rows}
    facts = {"recording": ", ".join(recordings), "touches": str(len(made.place))}
    figures = {"Probability of each layer": draw_layers(made)} if report_folder else {}
    report.say_notes(presses.notes)
    shown = "Layers compared", facts, figures, presses.notes
    table = report.table_of(None, rows, LAYERS)
    _finish(made, result, shown, None, report_folder, as_json, table)


@calibrate.command
def check(
    calibration: Annotated[str, Parameter(name="CAL")],
    recording: str,
    labels_file: Annotated[str | None, Parameter(name="LABELS")] = None,
    /,
    *,
    layout: Annotated[str | None, options.LayoutText] = None,
    patch: options.PatchName = None,
    time: TimeColumn = None,
    columns: TaxelColumns = None,
    labels: str | None = None,
    unit: str | None = None,
    offset: str | None = None,
    report_folder: ReportFolder = None,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Try a calibration on another recording.

    It says what the calibration answers there, and with labels how far that is off, beside trivial
    answers of the same calibration.

      skinfield calibrate check cal.toml other.csv other_force.csv --skin palm.toml

    Parameters
    ----------
    calibration : str
        File of `skinfield calibrate force`, `pressure` or `touch`; by touches, what the contacts
        press together is tried, in as many newtons as fit best where forces are relative.
    recording : str
        Of the skin.
    labels_file : str, optional
        Forces or pressures of that recording.
    layout : str, optional
        Layout file, or a generator by name, where columns are found by it.
    labels : str, optional
        Columns of the labels. Default all but the times.
    unit : str, optional
        Of the labels. Default as columns are named, else N or Pa.
    offset : str, optional
        What their sensor reads without load, in their unit, to be taken off.
    """
    from skinfield.calibrate import ForceCalibration, PressureCalibration, load_calibration
    from skinfield.cli.calibration_inputs import forces_of, label_series, together
    from skinfield.cli.calibration_report import sum_up, tried, write_report

    _check_files(None, report_folder, force)
    made, relative = load_calibration(calibration), False
    its = options.patch_of(options.skin_from_text(layout), patch) if layout else None
    log = options.log_of(layout)
    if isinstance(made, ForceCalibration | PressureCalibration):
        skin = _counts_for(made, calibration, recording, its, time, columns, log)
    else:
        skin, relative = _contacts_for(calibration, recording, layout, patch, time or columns)
    name, notes = "Pa" if isinstance(made, PressureCalibration) else "N", skin.notes
    figures: dict[str, Figure] = {}
    if labels_file is None:
        values = skin.values
        of = getattr(made, "force", getattr(made, "pressure", None))
        verdict, result = sum_up(values if of is None else of(values), name, relative)
    else:
        label = label_series(labels_file, labels, unit, name, offset, log)
        values, wanted, notes = together(skin, label)
        if not isinstance(made, PressureCalibration):
            wanted = forces_of(labels_file, wanted)
        verdict, result, figures = tried(made, values, wanted, relative, recording)
    result["verdict"] = verdict
    page = None
    if report_folder:
        said = getattr(made, "verdict", repr(made))
        facts = {"calibration": calibration, "made": said, "recording": recording}
        page = write_report(report_folder, "Calibration, tried", verdict, facts, figures, notes)
    report.say_notes(notes)
    report.finish(as_json, result, (page,), [verdict])


def _counts_for(
    made: "ForceCalibration | PressureCalibration",
    calibration: str,
    recording: str,
    patch: "Patch | None",
    time: str | None,
    columns: str | None,
    log: "LogSettings | None",
) -> "Series":
    """Counts (T, L) of a recording, as many columns as a calibration has taxels."""
    from skinfield.cli.calibration_inputs import skin_series

    if patch is not None and len(patch) != len(made):
        raise InputError(
            f"{calibration} has {len(made)} taxels, expected {len(patch)} of {patch.name!r}"
        )
    skin = skin_series(recording, patch, time, columns, log)
    if skin.values.shape[1] != len(made):
        raise InputError(
            f"{recording} has {skin.values.shape[1]} columns, expected {len(made)} as {calibration}"
            ": give its layout (--skin), or the columns (--columns)"
        )
    return skin


def _contacts_for(
    calibration: str, recording: str, layout: str | None, patch: str | None, columns: str | None
) -> "tuple[Series, bool]":
    """Force (T, 1) of all contacts of a recording by a calibration; whether it is relative."""
    from skinfield.cli.calibration_inputs import Series
    from skinfield.cli.reconstruct_jobs import JobPlan

    if layout is None or columns:
        raise InputError(
            f"{calibration} is by touches or of counts, expected the layout beside it (--skin), "
            "and a recording whose columns need no choice (no --time, no --columns)"
        )
    counts = options.CountSettings(calibration=calibration)
    plan = JobPlan.of(layout, patch, counts, Elastomer(), ModelSettings())
    config, stamps, loads = _loads_of(recording, plan)
    return Series(loads[:, None], stamps / 1e9), config.relative


def _check_files(output: str | None, report_folder: str | None, force: bool) -> None:
    from skinfield.cli.calibration_report import check_folder

    report.check_output("--output", output, force, ".toml", ".npz")
    check_folder(report_folder, force)


def _finish(
    made: "ForceCalibration | PressureCalibration | TouchCalibration | LayerComparison",
    result: dict[str, Any],
    shown: "tuple[str, dict[str, str], dict[str, Figure], tuple[str, ...]]",
    output: str | None,
    report_folder: str | None,
    as_json: bool,
    *tables: Any,
) -> None:
    """Write what is wanted, and say how good it is."""
    from skinfield.calibrate import LayerComparison, save_calibration
    from skinfield.cli.calibration_report import write_report

    page, (title, facts, figures, notes) = None, shown
    if output and not isinstance(made, LayerComparison):
        save_calibration(made, output)
    if report_folder:
        page = write_report(report_folder, title, made.verdict, facts, figures, notes)
    report.finish(as_json, result, (output, page), [*tables, made.verdict])


def _loads_of(
    recording: str, plan: "JobPlan"
) -> "tuple[ReconstructorConfig, NDArray[np.int64], Floats]":
    """What reconstructs a recording, its stamps (T,) ns, and their normal force (T,) N."""
    from skinfield.cli.reconstruct_jobs import parts, place_of, take_in

    with place_of(None) as place:
        results, _ = take_in(recording, plan, place)
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
    low, high = options.times_of("--seconds", seconds)
    time = (stamps - stamps[0]) * 1e-9
    part = (time >= low) & (time <= high)
    if not part.any():
        raise InputError(f"--seconds is {seconds!r}, expected a part of 0 to {time[-1]:.2f} s")
    return np.asarray(part)
