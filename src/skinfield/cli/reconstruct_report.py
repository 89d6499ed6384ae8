"""What `skinfield reconstruct` says of a run, on the screen, in a summary and in a picture."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.cli.report import console, plural, say_notes, table_of_contacts
from skinfield.fields import Estimate
from skinfield.observation import BaseStress, Capacitance, Quantity
from skinfield.pipeline import Reconstructor
from skinfield.pipeline.batch_results import LazyResults


@dataclass
class Run:
    """What a run over a recording leaves: sums and the highest, whatever its length."""

    readings: range
    shown: int = -1
    load: float = 0.0
    highest_load: float = -np.inf
    force: float = 0.0
    highest_force: float = -np.inf
    contacts: int = 0
    seconds: float = float("nan")
    dead: NDArray[np.bool_] | None = None

    def add(self, part: Any) -> None:
        """Count a part in."""
        best = int(np.argmax(part.load))
        if part.load[best] > self.highest_load:
            self.highest_load, self.shown = float(part.load[best]), part.first + best
        self.load += float(part.load.sum())
        self.force += float(part.force.sum())
        self.highest_force = max(self.highest_force, float(part.force.max()))
        self.contacts += int(part.contacts.sum())
        self.seconds = part.seconds + (0.0 if np.isnan(self.seconds) else self.seconds)
        self.dead = part.dead if self.dead is None else self.dead & part.dead


def report(results: LazyResults, run: Run, shown: Estimate, options: dict[str, Any]) -> None:
    """Print what was found, and write the summary and the picture that are asked for."""
    out, patch = console(), results.patch
    stamps = [int(results.stamp_ns[k]) for k in (run.readings.start, run.readings.stop - 1)]
    took = shown.latency if np.isnan(run.seconds) else run.seconds / len(run.readings)
    dead = 0 if run.dead is None else int(run.dead.sum())
    out.print(
        f"{results.source}: {plural(len(run.readings), 'reading')} in "
        f"{(stamps[1] - stamps[0]) * 1e-9:.2f} s, "
        f"{len(patch)} taxels of {patch.name} ({dead} left out), "
        f"{options['skipped']} lines skipped; {took * 1e3:.3g} ms per reading",
        highlight=False,
        soft_wrap=True,
    )
    when = (int(results.stamp_ns[run.shown]) - int(results.stamp_ns[0])) * 1e-9
    load = sum(contact.normal_force for contact in shown.contacts)
    found = plural(len(shown.contacts), "contact")
    title = f"reading {run.shown} at {when:.2f} s: {load:.2f} N in {found}"
    out.print(table_of_contacts(shown.contacts, title))
    say_notes(doubts(results.reconstructor, shown))
    if options["summary_path"]:
        from skinfield.sinks import write_summary

        write_summary(options["summary_path"], _summary(results, run, options))
    if options["plot"]:
        _plot(results, run.shown, shown, options["plot"])
    for name in (
        *options["output"],
        *(options[k] for k in ("fields_path", "summary_path", "plot")),
    ):
        if name:
            out.print(f"wrote {name}", highlight=False, soft_wrap=True)


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


def _summary(results: LazyResults, run: Run, options: dict[str, Any]) -> dict[str, Any]:
    count, stamps = len(run.readings), results.stamp_ns
    said = {key: value for key, value in options.items() if value is not None and key != "skipped"}
    return {
        "recording": results.source,
        "readings": count,
        "duration_s": int(stamps[run.readings.stop - 1] - stamps[run.readings.start]) * 1e-9,
        "skipped_lines": options["skipped"],
        "patch": results.patch.name,
        "taxels": len(results.patch),
        "taxels_left_out": 0 if run.dead is None else int(run.dead.sum()),
        "quantity": _name_of(results.recipe.quantity),
        "solver": repr(results.recipe.solver),
        "layer": repr(results.recipe.layer),
        "grid": list(results.grid.shape),
        "options": said,
        "contact_force_N": {"mean": run.load / count, "highest": run.highest_load},
        "field_force_N": {"mean": run.force / count, "highest": run.highest_force},
        "contacts_per_reading": run.contacts / count,
        "highest_load_reading": run.shown,
        "latency_ms_per_reading": run.seconds / count * 1e3,
        "notes": list(results.notes),
    }


def _plot(results: LazyResults, index: int, shown: Estimate, path: str) -> None:
    from skinfield.figures import draw_estimate, save

    quantity = results.recipe.quantity
    unit = {"1": "%", "Pa": "kPa"}[quantity.unit]
    figure = draw_estimate(
        shown, results.readings[index], quantity_name=quantity.symbol, quantity_unit=unit
    )
    save(figure, path)


def _name_of(quantity: Quantity) -> str:
    """As `--quantity` has it."""
    if isinstance(quantity, Capacitance):
        return "capacitance"
    return "stress" if isinstance(quantity, BaseStress) else "gap"
