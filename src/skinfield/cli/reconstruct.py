"""`skinfield reconstruct`: a recording becomes fields and contacts."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import click
import numpy as np

from skinfield.cli.inputs import LAYOUT_HELP, skin_from_text
from skinfield.cli.options import (
    OF_UNIT,
    QUANTITIES,
    conditioning_from_options,
    conditioning_options,
    layer_from_options,
    model_options,
    patch_of,
    reconstructor_from_options,
)
from skinfield.cli.report import console, plural, progress, say_notes, table_of_contacts
from skinfield.errors import InputError
from skinfield.fields import Estimate
from skinfield.pipeline import Reconstructor
from skinfield.pipeline.conditioned import Conditioned, condition, without_empty

CHUNK = 64  # readings per step of the progress bar; bounds the memory of the fields


@click.command(
    short_help="Turn a recording into contacts, fields and a picture.",
    help=f"""Turn a recording of a skin into force, deformation and contacts.

RECORDING is a yarpdatadumper log or its folder, a CySkin text recording, or a CSV or NPZ file of
your own. {LAYOUT_HELP}

Counts become ΔC/C₀ through the board's convention and a gain, or a calibration file; without one
the gain is a guess and forces are true up to one factor, which 'skinfield calibrate scale' finds.
What was assumed, skipped or left out is said in notes.

\b
  skinfield reconstruct right_foot/data.log --layout right_foot.txt -o contacts.csv --plot foot.png
  skinfield reconstruct press.csv --layout hexagon72 --grid 40 --fields press.zarr
""",
)
@click.argument("recording")
@click.option("--layout", "layout", required=True, help="Layout file, or generator by name.")
@click.option("--patch", help="Which patch, where the layout has several.")
@click.option("-o", "--output", help="Contacts of every reading: .csv or .parquet.")
@click.option("--fields", "fields_path", help="Pressure and displacement: .npz or .zarr.")
@click.option("--summary", "summary_path", help="Summary of the run: .json.")
@click.option("--plot", help="Figure of the reading with the highest load: .png, .pdf or .svg.")
@click.option("--reading", type=int, help="Draw and list this reading (from 0) instead.")
@model_options(grid=20)
@conditioning_options
def reconstruct(recording: str, layout: str, patch: str | None, **options: Any) -> None:
    """Reconstruct a recording."""
    from skinfield.figures import check_name

    if options["plot"]:
        check_name(options["plot"])
    job = prepare(recording, layout, patch, **options)
    say_notes(job.conditioned.notes)
    with ExitStack() as files:
        from skinfield.sinks import open_contacts, open_fields

        sinks: list[Any] = []
        if options["output"]:
            sinks.append(files.enter_context(open_contacts(options["output"])))
        if options["fields_path"]:
            sinks.append(files.enter_context(open_fields(options["fields_path"])))
        run = _run(job, sinks, options["reading"])
    _report(job, run, options)


@dataclass(frozen=True, eq=False)
class Job:
    """A recording and what reconstructs it."""

    reconstructor: Reconstructor
    conditioned: Conditioned
    quantity: str

    def __len__(self) -> int:
        return len(self.conditioned.values)

    def estimates(self) -> Iterator[tuple[int, Estimate]]:
        """Batches of estimates, each with the index of its first reading."""
        stamps = self.conditioned.recording.stamp_ns
        for first in range(0, len(self), CHUNK):
            part = slice(first, first + CHUNK)
            yield first, self.reconstructor(self.conditioned.values[part], stamp_ns=stamps[part])


def prepare(recording: str, layout: str, patch_name: str | None, **options: Any) -> Job:
    """Open, condition and prepare."""
    from skinfield.sources import open_recording, readings_for

    skin = skin_from_text(layout)
    patch = patch_of(skin, patch_name)
    layer = layer_from_options(options["thickness_mm"], options["modulus_kpa"], options["poisson"])
    how = conditioning_from_options(
        patch,
        **{key: options[key] for key in ("board", "no_load", "gain", "calibration", "smooth_ms",
                                         "noise")},
    )  # fmt: skip
    with progress() as bar:
        task = bar.add_task("reading", total=None)
        opened = open_recording(
            recording, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    readings = readings_for(opened, patch)
    name = OF_UNIT[readings.unit] if options["quantity"] == "auto" else options["quantity"]
    quantity = QUANTITIES[name]()
    conditioned = without_empty(condition(readings, patch, layer, quantity, how))
    reconstructor = reconstructor_from_options(
        patch, layer, quantity, conditioned.noise_std, options
    )
    return Job(reconstructor, conditioned, name)


@dataclass
class Run:
    """What a run over a recording leaves."""

    load: list[float] = field(default_factory=list)
    force: list[float] = field(default_factory=list)
    contacts: list[int] = field(default_factory=list)
    latency: float = 0.0
    shown: Estimate | None = None
    shown_index: int = -1


def _run(job: Job, sinks: list[Any], reading: int | None) -> Run:
    if reading is not None and not 0 <= reading < len(job):
        raise InputError(f"--reading is {reading}, expected 0 to {len(job) - 1}")
    run = Run()
    with progress() as bar:
        task = bar.add_task("reconstructing", total=len(job))
        for first, batch in job.estimates():
            for sink in sinks:
                sink.write(batch)
            load = [sum(c.normal_force for c in contacts) for contacts in batch.contacts]
            best = int(np.argmax(load)) if reading is None else reading - first
            if (reading is None and load[best] > max(run.load, default=-np.inf)) or (
                reading is not None and 0 <= best < len(batch)
            ):
                run.shown, run.shown_index = batch[best], first + best
            run.load += load
            run.force += np.asarray(batch.normal_force).tolist()
            run.contacts += [len(contacts) for contacts in batch.contacts]
            run.latency += batch.latency
            bar.update(task, advance=len(batch))
    return run


def _report(job: Job, run: Run, options: dict[str, Any]) -> None:
    recording, patch = job.conditioned.recording, job.reconstructor.patch
    shown, index = run.shown, run.shown_index
    assert shown is not None  # there is at least one reading
    out = console()
    seconds = float(recording.time[-1])
    dead = int((~job.conditioned.valid.any(axis=0)).sum())
    out.print(
        f"{recording.source}: {plural(len(job), 'reading')} in {seconds:.2f} s, "
        f"{len(patch)} taxels of {patch.name} ({dead} left out), "
        f"{recording.skipped} lines skipped; {run.latency / len(job) * 1e3:.2f} ms per reading",
        highlight=False,
        soft_wrap=True,
    )
    when = float(recording.time[index])
    found = plural(len(shown.contacts), "contact")
    title = f"reading {index} at {when:.2f} s: {run.load[index]:.2f} N in {found}"
    out.print(table_of_contacts(shown.contacts, title))
    say_notes(doubts(job.reconstructor, shown))
    if options["summary_path"]:
        from skinfield.sinks import write_summary

        write_summary(options["summary_path"], _summary(job, run, options))
    if options["plot"]:
        _plot(job, run, options["plot"])
    for name in ("output", "fields_path", "summary_path", "plot"):
        if options[name]:
            out.print(f"wrote {options[name]}", highlight=False, soft_wrap=True)


def doubts(reconstructor: Reconstructor, shown: Estimate) -> list[str]:
    """What about an estimate cannot be, and what to try."""
    found, grid, layer = [], shown.grid, reconstructor.layer
    if grid.pitch > reconstructor.patch.pitch:
        found.append(
            f"cells of {grid.pitch * 1e3:.1f} mm are wider than the taxels' distance of "
            f"{reconstructor.patch.pitch * 1e3:.1f} mm: a finer --grid gives other forces"
        )
    deepest = float(shown.indentation.max()) / layer.thickness
    if deepest > 0.8:
        found.append(
            f"an indentation of {deepest:.1f} times the thickness is beyond a linear model: the "
            "gain, the modulus or Poisson's ratio does not fit this skin"
        )
    if shown.pressure.min() < -0.5 * shown.pressure.max():
        foam = ": if the elastomer is a foam or a fabric, try --poisson 0.3"
        found.append(
            f"pressure falls to {shown.pressure.min() / 1e3:.0f} kPa beside "
            f"{shown.pressure.max() / 1e3:.0f} kPa, and nothing pulls"
            f"{foam if layer.poisson_ratio > 0.45 else '; linear solvers do not know that'}"
        )
    return found


def _summary(job: Job, run: Run, options: dict[str, Any]) -> dict[str, Any]:
    recording = job.conditioned.recording
    return {
        "recording": recording.source,
        "readings": len(job),
        "duration_s": float(recording.time[-1]),
        "skipped_lines": recording.skipped,
        "patch": job.reconstructor.patch.name,
        "taxels": len(job.reconstructor.patch),
        "taxels_left_out": int((~job.conditioned.valid.any(axis=0)).sum()),
        "quantity": job.quantity,
        "options": {key: value for key, value in options.items() if value is not None},
        "contact_force_N": {"mean": np.mean(run.load), "highest": np.max(run.load)},
        "field_force_N": {"mean": np.mean(run.force), "highest": np.max(run.force)},
        "contacts_per_reading": np.mean(run.contacts),
        "highest_load_reading": run.shown_index,
        "latency_ms_per_reading": run.latency / len(job) * 1e3,
        "notes": list(job.conditioned.notes),
    }


def _plot(job: Job, run: Run, path: str) -> None:
    from skinfield.figures import draw_estimate, save

    quantity = job.reconstructor.quantity
    unit = {"1": "%", "Pa": "kPa"}[quantity.unit]
    assert run.shown is not None
    figure = draw_estimate(
        run.shown,
        job.conditioned.values[run.shown_index],
        quantity_name=quantity.symbol,
        quantity_unit=unit,
    )
    save(figure, path)
