"""`skinfield rig`: the paper's set-up in software, as many runs as a scenario asks for."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from rich.table import Table

from skinfield.cli.options import OUTPUT, Json
from skinfield.cli.report import console, plural, print_json, progress, say, say_notes
from skinfield.errors import FileError, InputError, check_count
from skinfield.files.pending import write_bytes
from skinfield.lab.runner import Outcome, Task, run, stored
from skinfield.lab.scenarios import load_scenario, rig_tasks, template


def rig(
    *scenario: str,
    output: Annotated[str, OUTPUT] = "rig",
    workers: int | None = None,
    resume: bool = True,
    dry_run: bool = False,
    new: str | None = None,
    as_json: Json = False,
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
      skinfield calibrate scale rig/rig-sphere6/recording.npz rig/rig-sphere6/load_cell.csv \\
        --skin rig/rig-sphere6/layout.toml

    Parameters
    ----------
    scenario : str
        Scenario files (.toml).
    output : str
        DIR of the runs.
    workers : int, optional
        Processes at once. Default one for each core.
    resume : bool
        Keep runs that are there, or make them again.
    dry_run : bool
        List the runs, make none.
    new : str, optional
        Write a scenario with all keys explained.
    as_json : bool
        What came of each run, as a list of objects.
    """
    if workers is not None:
        check_count("--workers", workers, 1, 1 << 12, "processes at once")
    out = console()
    if new is not None:
        _write_template(Path(new))
        say(f"wrote {new}")
    if not scenario:
        if new is None:
            raise InputError("SCENARIO is missing, expected a file: --new FILE writes one")
        return
    tasks = _tasks(scenario)
    if dry_run:
        out.print(_plan(tasks, Path(output)))
        return
    outcomes = _run(tasks, Path(output), workers or os.cpu_count() or 1, not resume)
    for path in scenario:
        write_bytes(Path(output) / Path(path).name, Path(path).read_bytes())
    if as_json:
        print_json([{"run": one.name, "seconds": one.seconds, **(one.result or {}),
                     "failure": one.failure or None} for one in outcomes])  # fmt: skip
    else:
        out.print(_table(outcomes))
    failed = [outcome for outcome in outcomes if outcome.failure]
    if not as_json:
        say(
            f"{plural(len(outcomes) - len(failed), 'run')} in {output}, "
            f"{sum(outcome.reused for outcome in outcomes)} of them from before"
        )
    if failed:
        _fail(failed, len(outcomes), Path(output))


def _write_template(path: Path) -> None:
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(template())
    except FileExistsError as error:
        raise FileError(f"{path} is there, expected a new name: nothing was written") from error
    except (OSError, ValueError) as error:
        raise FileError(f"{path} cannot be written: {error}") from error


def _tasks(scenarios: Sequence[str]) -> list[Task]:
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


def _plan(tasks: Sequence[Task], folder: Path) -> Table:
    table = Table(title=f"{plural(len(tasks), 'run')}", title_justify="left")
    for column in ("run", "indenter", "presses", "seconds", "state"):
        table.add_column(column, justify="right" if column in ("presses", "seconds") else "left")
    for task in tasks:
        (scenario,) = task.arguments
        presses = scenario.presses
        table.add_row(
            task.name,
            scenario.tools[0].indenter.kind,
            str(presses),
            f"{scenario.profile.duration(presses):.1f}",
            "there" if stored(task, folder) else "to do",
        )
    return table


def _run(tasks: Sequence[Task], folder: Path, workers: int, fresh: bool) -> list[Outcome]:
    outcomes: dict[str, Outcome] = {}
    with progress() as bar:
        task = bar.add_task("rig", total=len(tasks))
        for outcome in run(tasks, folder, workers=workers, fresh=fresh):
            outcomes[outcome.name] = outcome
            failures = sum(bool(one.failure) for one in outcomes.values())
            words = outcome.name + (f", {failures} failed" if failures else "")
            bar.update(task, completed=len(outcomes), description=words)
    return [outcomes[task.name] for task in tasks]


def _table(outcomes: Sequence[Outcome]) -> Table:
    table = Table(title="Runs", title_justify="left")
    table.add_column("run", overflow="fold")
    for column in (
        "presses", "readings", "N", "depth mm", "area mm²", "ΔC/C₀", "cell full", "took s",
    ):  # fmt: skip
        table.add_column(column, justify="right")
    for outcome in outcomes:
        if outcome.failure:
            table.add_row(outcome.name, *["–"] * 7, f"{outcome.seconds:.1f}")
            continue
        found = outcome.result
        table.add_row(
            outcome.name,
            str(found["presses"]),
            str(found["readings"]),
            f"{found['highest_force_N']:.2f}",
            f"{found['deepest_mm']:.3f}",
            f"{found['widest_area_mm2']:.1f}",
            f"{found['highest_change']:.3f}",
            str(found["saturated"]),
            f"{outcome.seconds:.1f}",
        )
    return table


def _fail(failed: Sequence[Outcome], total: int, folder: Path) -> None:
    """Say what went wrong with each failed run, and end with an error."""
    say_notes(f"{one.name}: {one.failure.strip().splitlines()[-1]}" for one in failed)
    raise InputError(
        f"{len(failed)} of {plural(total, 'run')} failed: "
        f"{', '.join(one.name for one in failed)}; the others are whole, and tracebacks are in "
        f"{folder}/*.failed.txt"
    )
