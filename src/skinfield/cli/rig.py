"""`skinfield rig`: the paper's set-up in software, as many runs as a scenario asks for."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.errors import InputError
from skinfield.plot import plural

if TYPE_CHECKING:
    from skinfield.lab.runner import Task, TaskOutcome

PLANNED = (
    Column("run", "run"), Column("indenter", "indenter"), Column("presses", "presses", decimals=0),
    Column("seconds", "seconds", decimals=1), Column("state", "state"),
)  # fmt: skip
MADE = (
    Column("run", "run"), Column("presses", "presses", decimals=0),
    Column("readings", "readings", decimals=0), Column("N", "highest_force_N", decimals=2),
    Column("depth mm", "deepest_mm", decimals=3), Column("area mm²", "widest_area_mm2", decimals=1),
    Column("ΔC/C₀", "highest_change", decimals=3), Column("cell full", "saturated", decimals=0),
    Column("took s", "seconds", decimals=1),
)  # fmt: skip


def rig(
    *scenario: str,
    output: Annotated[str, options.OUTPUT] = "rig",
    workers: options.Workers = None,
    dry_run: bool = False,
    new: str | None = None,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    r"""Press a simulated skin with a simulated rig; write recordings with their truth.

    It is a patch on positioners for x, y and angle, an actuator with an indenter and a load cell,
    and the skin's electronics.

    SCENARIO is a TOML file that says what is pressed where and how; --new writes one with all its
    keys explained. Each of its indenters, and each repeat, is one run, with a folder of its own:

      recording.npz     counts, as from a real skin         layout.toml       where its taxels are
      load_cell.csv     as from a real force sensor         calibration.toml  the true one
      truth.npz         force, depth, area, pressure, ...   run.png           picture
      task.json         summary

    The scenario itself is copied beside them. A run that is there already, of the very same
    settings, is not made again: a campaign that was stopped goes on where it was. What was made can
    be used like a real rig's:

      skinfield rig --new press.toml
      skinfield rig press.toml -o rig --dry-run
      skinfield rig press.toml -o rig
      skinfield reconstruct rig/rig-sphere6/recording.npz --skin rig/rig-sphere6/layout.toml
      skinfield calibrate scale rig/rig-sphere6/recording.npz rig/rig-sphere6/load_cell.csv \
        --skin rig/rig-sphere6/layout.toml

    Parameters
    ----------
    scenario : str
        Scenario files (.toml).
    output : str
        DIR of the runs.
    dry_run : bool
        List the runs, make none.
    new : str, optional
        Write a scenario with all keys explained.
    """
    from skinfield.files.pending import write_bytes

    number = options.processes(workers)
    if new is not None:
        from skinfield.lab.scenarios import template

        report.check_output("--new", new, force)
        write_bytes(new, template().encode())
        if not (as_json and scenario):  # one object is printed
            report.finish(as_json, {"scenario": new}, [new])
    if not scenario:
        if new is None:
            raise InputError("SCENARIO is missing, expected a file: --new FILE writes one")
        return
    tasks = _tasks(scenario)
    if dry_run:
        planned = _planned(tasks, Path(output))
        lines = [report.table_of(plural(len(tasks), "run"), planned, PLANNED)]
        report.finish(as_json, planned, lines=lines)
        return
    outcomes = _run(tasks, Path(output), number)
    for path in scenario:
        write_bytes(Path(output) / Path(path).name, Path(path).read_bytes())
    failed = [outcome for outcome in outcomes if outcome.failure]
    rows = [
        {"run": one.name, "seconds": one.seconds, "failure": one.failure or None}
        | (one.result or {})
        for one in outcomes
    ]
    reused = sum(outcome.reused for outcome in outcomes)
    made = plural(len(outcomes) - len(failed), "run")
    count = f"{made} in {output}, {reused} of them from before"
    report.finish(as_json, rows, lines=[report.table_of("Runs", rows, MADE), count])
    if failed:
        report.say_notes(f"{one.name}: {one.failure.strip().splitlines()[-1]}" for one in failed)
        raise InputError(
            f"{len(failed)} of {plural(len(outcomes), 'run')} failed: "
            f"{', '.join(one.name for one in failed)}; the others are whole, and tracebacks are in "
            f"{output}/*.failed.txt"
        )


def _tasks(scenarios: Sequence[str]) -> "list[Task]":
    from skinfield.lab.scenarios import load_scenario, rig_tasks

    tasks: dict[str, tuple[str, Task]] = {}
    for path in scenarios:
        for task in rig_tasks(load_scenario(path)):
            if task.name in tasks:
                raise InputError(
                    f"{path} and {tasks[task.name][0]} both have a run {task.name}, expected "
                    "scenarios of different names: each run is a folder"
                )
            tasks[task.name] = (path, task)
    return [task for _, task in tasks.values()]


def _planned(tasks: "Sequence[Task]", folder: Path) -> list[dict[str, Any]]:
    """A row for each run: what it presses, and whether it is there."""
    from skinfield.lab.runner import stored

    return [
        {
            "run": task.name,
            "indenter": scenario.tools[0].indenter.kind,
            "presses": scenario.presses,
            "seconds": scenario.profile.duration(scenario.presses),
            "state": "there" if stored(task, folder) else "to do",
        }
        for task in tasks
        for scenario in task.arguments
    ]


def _run(tasks: "Sequence[Task]", folder: Path, workers: int) -> "list[TaskOutcome]":
    from skinfield.lab.runner import run

    outcomes: dict[str, TaskOutcome] = {}
    with report.progress("rig", len(tasks)) as step:
        for outcome in run(tasks, folder, workers=workers):
            outcomes[outcome.name] = outcome
            failures = sum(bool(one.failure) for one in outcomes.values())
            words = outcome.name + (f", {failures} failed" if failures else "")
            step(len(outcomes), what=words)
    return [outcomes[task.name] for task in tasks]
