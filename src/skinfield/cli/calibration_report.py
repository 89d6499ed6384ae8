"""Report of a calibration, and trials of it on other recordings, held against labels."""

import warnings
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.cli.report import check_output
from skinfield.errors import FileError, Floats
from skinfield.estimate.contact_table import RELATIVE
from skinfield.plot import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from skinfield.calibrate import ForceCalibration, PressureCalibration, TouchCalibration

    Tried = tuple[str, dict[str, Any], dict[str, Figure]]  # verdict, numbers, figures

PAGE = "report.html"
LOOK = """body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto;
padding: 0 1rem; color: #1b1b1f; background: #fff } img { max-width: 100% }
table { border-collapse: collapse } td { padding: .2rem 1.2rem .2rem 0; vertical-align: top }
.verdict { font-size: 1.15rem; border-left: 4px solid #e24d34; padding-left: 1rem }
caption, figcaption, .quiet { color: #5c5c66; text-align: left }"""


def check_folder(folder: str | None, force: bool) -> None:
    """Raise InputError unless a report can be written into a folder."""
    if folder is not None:
        check_output("--report", Path(folder) / PAGE if Path(folder).is_dir() else folder, force)


def write_report(
    folder: str,
    title: str,
    verdict: str,
    facts: Mapping[str, str],
    figures: Mapping[str, "Figure"],
    notes: Iterable[str] = (),
) -> str:
    """Write the page and its figures (PNG) into a folder; name of the page.

    Raises
    ------
    FileError
        If they cannot be written.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        pictures = []
        for words, figure in figures.items():
            name = "-".join(words.lower().split()) + ".png"
            save(figure, path / name)
            caption = f"<figcaption>{escape(words)}</figcaption>"
            pictures.append(f'<figure><img src="{name}" alt="{escape(words)}">{caption}</figure>')
        rows = "".join(
            f"<tr><td class=quiet>{escape(name)}</td><td>{escape(value)}</td></tr>"
            for name, value in facts.items()
        )
        said = "".join(f"<li>{escape(note)}</li>" for note in notes)
        said = f"<h2>Notes</h2><ul>{said}</ul>" if said else ""
        page = (
            f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
            f"</title><style>{LOOK}</style></head>\n<body><h1>{escape(title)}</h1>\n"
            f"<p class=verdict>{escape(verdict)}</p>\n<table>{rows}</table>\n"
            f"{''.join(pictures)}\n{said}</body></html>\n"
        )
        (path / PAGE).write_text(page, encoding="utf-8")
    except OSError as error:
        raise FileError(f"{folder} cannot be written: {error.strerror or error}") from error
    return str(path / PAGE)


def tried(made: object, values: Floats, wanted: Floats, relative: bool, recording: str) -> "Tried":
    """How far what a calibration answers of values (T, L) is off labels (T, W)."""
    from skinfield.calibrate import ForceCalibration, PressureCalibration

    if isinstance(made, PressureCalibration):
        return try_pressure(made, values, wanted[:, 0], recording)
    if isinstance(made, ForceCalibration):
        return try_force(made, values, wanted, recording)
    return try_contacts(values[:, 0], wanted, relative, recording)


def try_force(made: "ForceCalibration", counts: Floats, labels: Floats, recording: str) -> "Tried":
    """How far a calibration by force, and trivial answers of it, are off labels."""
    from skinfield.calibrate.by_force import compared
    from skinfield.calibrate.plot import draw_trivial

    wanted, answer = made.label(labels), made.force(counts)
    heard = np.isfinite(answer)
    off = (answer - wanted)[heard]
    rmse = float(np.sqrt(np.mean(np.square(off))))
    trivial = {
        name: float(np.sqrt(np.mean(np.square((its - wanted)[heard]))))
        for name, its in made.trivial(counts).items()
    }
    within = float(np.mean(np.abs(off) < made.residual_std))
    mean = float(off.mean())
    result = {"rmse_N": rmse, "mean_off_N": mean, "within_one_std": within} | dict(
        zip(("constant_rmse_N", "sum_rmse_N", "ridge_rmse_N"), trivial.values(), strict=True)
    )
    share = f"{mean:+.3g} N in the mean, {within:.0%} within ± {made.residual_std:.3g} N"
    verdict = f"{compared(rmse, trivial)}; {share}"
    if made.sign_is_sure and float((wanted - wanted.mean())[heard] @ answer[heard]) < 0.0:
        verdict += "; labels fall as the answers rise: is their sign that of the calibration's?"
    figures = {
        "Over the readings": draw_answers(answer, wanted, Path(recording).name),
        "Error beside trivial answers": draw_trivial(rmse, trivial),
    }
    return verdict, result, figures


def try_pressure(
    made: "PressureCalibration", counts: Floats, wanted: Floats, recording: str
) -> "Tried":
    """How far a calibration by pressure is off labels, median over the taxels."""
    from skinfield.calibrate.by_pressure import check_pressure

    check_pressure(wanted)
    answer = made.pressure(counts)
    with warnings.catch_warnings(action="ignore"):  # of taxels that are broken
        errors = np.sqrt(np.nanmean(np.square(answer - wanted[:, None]), axis=0))
        rmse, shown = float(np.nanmedian(errors)), np.nanmedian(answer, axis=1)
    there = np.isfinite(answer).mean(axis=0)  # of the readings
    alive, constant = there[there > 0.0], float(wanted.std())
    better = "" if rmse < constant else "; a constant is better"
    result = {"rmse_Pa": rmse, "constant_rmse_Pa": constant, "usable": len(alive)}
    result["answered_share"] = float(alive.mean()) if len(alive) else 0.0
    verdict = (
        f"{rmse:.4g} Pa off (rms, median of {len(alive)} of {len(made)} taxels, which answer "
        f"{result['answered_share']:.2%} of their readings), a constant {constant:.4g}{better}"
    )
    figures = {"Over the readings": draw_answers(shown, wanted, Path(recording).name, "Pa")}
    return verdict, result, figures


def try_contacts(answer: Floats, labels: Floats, relative: bool, recording: str) -> "Tried":
    """How far forces of contacts (T,) are off labels; up to one factor where they are relative."""
    wanted = labels if labels.ndim == 1 else labels[:, int(np.argmax(labels.std(axis=0)))]
    wanted = wanted * (1.0 if float((answer - answer.mean()) @ wanted) >= 0.0 else -1.0)
    factor = float(answer @ wanted) / float(answer @ answer) if relative and answer.any() else 1.0
    answer = factor * answer
    rmse, constant = float(np.sqrt(np.mean(np.square(answer - wanted)))), float(wanted.std())
    result = {"rmse_N": rmse, "constant_rmse_N": constant, "relative": relative, "factor": factor}
    of = f"relative: one is {factor:.4g} N by these labels; then " if relative else ""
    better = "" if rmse < constant else "; a constant is better"
    verdict = f"{of}{rmse:.4g} N off (rms), a constant {constant:.4g}{better}"
    return (
        verdict,
        result,
        {"Over the readings": draw_answers(answer, wanted, Path(recording).name)},
    )


def sum_up(answer: Floats, unit: str, relative: bool) -> tuple[str, dict[str, Any]]:
    """What is answered where no label is known, in words and numbers."""
    low, middle, high = np.nanpercentile(answer, [1.0, 50.0, 99.0])
    shown = RELATIVE if relative else unit
    verdict = f"answers {low:.4g} to {high:.4g} {shown} (1 to 99 %), median {middle:.4g}"
    return verdict, {f"low_{unit}": low, f"high_{unit}": high, "relative": relative}


def draw_answers(answer: Floats, wanted: Floats, title: str, unit: str = "N") -> "Figure":
    """Answers and labels (T,) over the readings, and their difference."""
    from skinfield.signal.plot import draw_timeline

    label = "skin" if unit == "N" else "skin, median of taxels"
    figure = draw_timeline(
        np.arange(len(answer)), answer, wanted,
        label=label, reference_label="label", title=title, unit=unit,
    )  # fmt: skip
    figure.axes[0].set_ylabel("force (N)" if unit == "N" else f"pressure ({unit})")
    figure.axes[1].set_ylabel(f"difference ({unit})")
    figure.axes[1].set_xlabel("reading")
    return figure


def facts_of_touches(
    made: "TouchCalibration", recordings: tuple[str, ...]
) -> tuple[dict[str, str], dict[str, Any]]:
    """What a page and a program are told of a calibration by touches."""
    facts = {
        "recording": ", ".join(recordings), "presses": f"{made.presses}, {made.left_out} left out",
        "thickness": f"{made.thickness * 1e3:.3f} ± {made.thickness_std * 1e3:.3f} mm",
        "Poisson's ratio": f"{made.poisson_ratio:.4f} ± {made.poisson_std:.4f}",
        "cover": "yes" if made.covered else "no", "model error": f"{made.model_error:.1%}",
        "forces": "relative" if made.relative else "newtons",
    }  # fmt: skip
    creep = made.relaxation
    if creep is not None:
        facts["creep"] = f"{1.0 - creep.relaxed_fraction:.1%} within {creep.time_constant:.3g} s"
    return facts, {
        "thickness_mm": made.thickness * 1e3, "poisson": made.poisson_ratio,
        "covered": made.covered, "modulus_kpa": made.young_modulus * 1e-3,
        "relative": made.relative, "presses": made.presses, "verdict": made.verdict,
        "relaxed_fraction": made.relaxed_fraction, "relaxation_s": made.relaxation_time,
    }  # fmt: skip
