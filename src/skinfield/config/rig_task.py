"""One recording of a scenario as a task of a campaign."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.campaign import Task
from skinfield.config.scenario_text import in_folder, toml_from_scenario
from skinfield.errors import FileError
from skinfield.figures import save
from skinfield.figures.rig import draw_rig_run
from skinfield.simulate.rig import Scenario, run_rig
from skinfield.sinks.pending import write_bytes
from skinfield.sinks.rig import LAYOUT, save_rig_run

SCENARIO, PICTURE = "scenario.toml", "run.png"
VERSION = "1"  # raise it when the same scenario makes other files


def rig_tasks(scenario: Scenario) -> list[Task]:
    """A task for each recording of a scenario."""
    return [Task(name, make_run, (one,), VERSION) for name, one in scenario.runs()]


def make_run(folder: Path, scenario: Scenario) -> dict[str, Any]:
    """Run a scenario of one recording and write its files; returns what a table shows.

    Raises
    ------
    FileError
        If a file cannot be written, or the shape's file has gone.
    """
    done = run_rig(scenario)
    save_rig_run(done, folder)
    save(draw_rig_run(done), folder / PICTURE)
    beside, copies = in_folder(scenario, LAYOUT)
    for source, name in copies:
        try:
            shutil.copyfile(source, folder / name)
        except OSError as error:
            raise FileError(f"{source} cannot be copied: {error.strerror or error}") from error
    write_bytes(folder / SCENARIO, toml_from_scenario(beside).encode())
    truth = done.truth
    return {
        "indenter": scenario.tools[0].name,
        "presses": len(truth.press_load),
        "readings": len(done.recording),
        "duration_s": float(truth.time_s[-1]),
        "highest_force_N": float(truth.force_N.max()),
        "deepest_mm": float(truth.depth_m.max() * 1e3),
        "widest_area_mm2": float(truth.contact_area_m2.max() * 1e6),
        "highest_change": float(truth.reading_change.max()),
        "saturated": int(np.count_nonzero(done.load_cell.saturated)),
    }
