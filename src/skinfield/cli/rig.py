"""`skinfield rig`: the paper's set-up in software, as many runs as a scenario asks for."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from skinfield.cli.options import OUTPUT, Force, Json, processes
from skinfield.cli.report import (
    NONE,
    check_output,
    console,
    finish,
    plural,
    print_json,
    progress,
    say,
    say_notes,
    table,
)
from skinfield.errors import InputError
from skinfield.lab.runner import Outcome, Task, run, stored
from skinfield.lab.scenarios import load_scenario, rig_tasks, template


def rig(
    *scenario: str,
    output: Annotated[str, OUTPUT] = "rig",
    workers: int | None = None,
    dry_run: bool = False,
    new: str | None = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    r"""Press a simulated skin with a simulated rig; write recordings with their truth.

    It is a patch on positioners for x, y and angle, an actuator with an indenter and a load cell,
    and the skin's electronics.

    SCENARIO is a TOML file that says what is pressed where and how; --new writes one with all its
    keys explained. Each of its indenters, and each repeat, is one run, with a folder of its own:

      recording.npz     counts, as from a real skin         layout.toml       where its taxels are
      load_cell.csv     as from a real force sensor         calibration.toml  the true one
      truth.npz         force, depth, area, pressure, ...   scenario.toml     makes this run again
      run.png           picture                             task.json         summary

    A run that is there already, of the very same settings, is not made again: a campaign that was
    stopped goes on where it was. What was made can be used like a real rig's:

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
    dry_run : bool
        List the runs, make none.
    new : str, optional
        Write a scenario with all keys explained.
    as_json : bool
        What came of each run, as a list of objects.
    """
    number = processes(workers)
    if new is not None:
        from skinfield.files.pending import write_bytes

        check_output("--new", new, force)
        write_bytes(new, template().encode())
        finish(as_json and not scenario, {"scenario": new}, [new])
    if not scenario:
        if new is None:
            raise InputError("SCENARIO is missing, expected a file: --new FILE writes one")
        return
    tasks = _tasks(scenario)
    if dry_run:
        _show_plan(tasks, Path(output), as_json)
        return
    outcomes = _run(tasks, Path(output), number)
    failed = [outcome for outcome in outcomes if outcome.failure]
    if as_json:
        print_json([{"run": one.name, "seconds": one.seconds, **(one.result or {}),
                     "failure": one.failure or None} for one in outcomes])  # fmt: skip
    else:
        _show(outcomes)
        say(
            f"{plural(len(outcomes) - len(failed), 'run')} in {output}, "
            f"{sum(outcome.reused for outcome in outcomes)} of them from before"
        )
    if failed:
        _fail(failed, len(outcomes), Path(output))


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


def _show_plan(tasks: Sequence[Task], folder: Path, as_json: bool) -> None:
    shown = table(plural(len(tasks), "run"), ("run", "indenter", "state"), ("presses", "seconds"))
    plain = []
    for task in tasks:
        (scenario,) = task.arguments
        kind, presses = scenario.tools[0].indenter.kind, scenario.presses
        seconds, there = scenario.profile.duration(presses), bool(stored(task, folder))
        state = "there" if there else "to do"
        shown.add_row(task.name, kind, state, str(presses), f"{seconds:.1f}")
        plain.append({"run": task.name, "indenter": kind, "presses": presses, "seconds": seconds,
                      "state": state})  # fmt: skip
    if as_json:
        print_json(plain)
    else:
        console().print(shown)


def _run(tasks: Sequence[Task], folder: Path, workers: int) -> list[Outcome]:
    outcomes: dict[str, Outcome] = {}
    with progress("rig", len(tasks)) as step:
        for outcome in run(tasks, folder, workers=workers):
            outcomes[outcome.name] = outcome
            failures = sum(bool(one.failure) for one in outcomes.values())
            words = outcome.name + (f", {failures} failed" if failures else "")
            step(len(outcomes), what=words)
    return [outcomes[task.name] for task in tasks]


def _show(outcomes: Sequence[Outcome]) -> None:
    columns = {"presses": "presses", "readings": "readings", "N": "highest_force_N",
               "depth mm": "deepest_mm", "area mm²": "widest_area_mm2",
               "ΔC/C₀": "highest_change", "cell full": "saturated"}  # fmt: skip
    formats = ("", "", ".2f", ".3f", ".1f", ".3f", "")
    shown = table("Runs", ("run",), (*columns, "took s"))
    for outcome in outcomes:
        cells = [NONE] * len(columns)
        if not outcome.failure:
            values = (outcome.result[key] for key in columns.values())
            cells = [f"{each:{how}}" for each, how in zip(values, formats, strict=True)]
        shown.add_row(outcome.name, *cells, f"{outcome.seconds:.1f}")
    console().print(shown)


def _fail(failed: Sequence[Outcome], total: int, folder: Path) -> None:
    """Say what went wrong with each failed run, and end with an error."""
    say_notes(f"{one.name}: {one.failure.strip().splitlines()[-1]}" for one in failed)
    raise InputError(
        f"{len(failed)} of {plural(total, 'run')} failed: "
        f"{', '.join(one.name for one in failed)}; the others are whole, and tracebacks are in "
        f"{folder}/*.failed.txt"
    )
