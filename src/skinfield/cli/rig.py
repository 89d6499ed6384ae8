"""`skinfield rig`: the paper's set-up in software, as many runs as a scenario asks for."""

import os
from collections.abc import Sequence
from pathlib import Path

import click
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from skinfield.campaign import Event, Outcome, Task, run, stored
from skinfield.cli.report import console, plural, say_notes
from skinfield.errors import FileError, InputError


@click.command(
    short_help="Press a simulated skin with a simulated rig; write recordings with their truth.",
    help="""Press a simulated skin with a simulated rig: a patch on positioners for x, y and angle,
an actuator with an indenter and a load cell, and the skin's electronics.

SCENARIO is a TOML file that says what is pressed where and how; --new writes one with all its keys
explained. Each of its indenters, and each repeat, is one run, with a folder of its own:

\b
  recording.npz     counts, as from a real skin         layout.toml       where its taxels are
  load_cell.csv     as from a real force sensor         calibration.toml  the true one
  truth.npz         force, depth, area, pressure, ...   scenario.toml     makes this run again
  run.png           picture                             task.json         summary

A run that is there already, of the very same settings, is not made again: a campaign that was
stopped goes on where it was. What was made can be used like a real rig's:

\b
  skinfield rig --new press.toml
  skinfield rig press.toml -o rig --dry-run
  skinfield rig press.toml -o rig
  skinfield reconstruct rig/rig-sphere6/recording.npz --layout rig/rig-sphere6/layout.toml
  skinfield calibrate scale rig/rig-sphere6/recording.npz rig/rig-sphere6/load_cell.csv \\
    --layout rig/rig-sphere6/layout.toml
""",
)
@click.argument("scenarios", metavar="[SCENARIO]...", nargs=-1)
@click.option("-o", "--output", default="rig", show_default=True, help="Folder of the runs.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=os.cpu_count() or 1,
    show_default="one per core",
    help="Processes at once.",
)
@click.option(
    "--resume/--fresh", default=True, show_default=True, help="Keep runs that are there, or not."
)
@click.option("--dry-run", is_flag=True, help="List the runs, make none.")
@click.option("--new", metavar="FILE", help="Write a scenario with all keys explained.")
def rig(
    scenarios: tuple[str, ...],
    output: str,
    workers: int,
    resume: bool,
    dry_run: bool,
    new: str | None,
) -> None:
    """Make runs, show progress, list them."""
    out = console()
    if new is not None:
        _write_template(Path(new))
        out.print(f"wrote {new}", highlight=False, soft_wrap=True)
    if not scenarios:
        if new is None:
            raise click.UsageError("SCENARIO is missing: --new FILE writes one to start from")
        return
    tasks = _tasks(scenarios)
    if dry_run:
        out.print(_plan(tasks, Path(output)))
        return
    outcomes = _run(tasks, Path(output), workers, not resume)
    out.print(_table(outcomes))
    failed = [outcome for outcome in outcomes if outcome.failure]
    out.print(
        f"{plural(len(outcomes) - len(failed), 'run')} in {output}, "
        f"{sum(outcome.reused for outcome in outcomes)} of them from before",
        highlight=False,
        soft_wrap=True,
    )
    if failed:
        _complain(failed, len(outcomes), Path(output))


def _write_template(path: Path) -> None:
    from skinfield.config import TEMPLATE

    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(TEMPLATE)
    except FileExistsError as error:
        raise FileError(f"{path} is there, expected a new name: nothing was written") from error
    except (OSError, ValueError) as error:
        raise FileError(f"{path} cannot be written: {error}") from error


def _tasks(scenarios: Sequence[str]) -> list[Task]:
    from skinfield.config import load_scenario, rig_tasks

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
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        shown = bar.add_task("rig", total=len(tasks))
        event: Event
        for event in run(tasks, folder, workers=workers, fresh=fresh):
            outcomes[event.outcome.name] = event.outcome
            words = event.outcome.name + (f", {event.failures} failed" if event.failures else "")
            bar.update(shown, completed=event.done, description=words)
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


def _complain(failed: Sequence[Outcome], total: int, folder: Path) -> None:
    """Say what went wrong with each failed run, and end with an error."""
    say_notes(f"{one.name}: {one.failure.strip().splitlines()[-1]}" for one in failed)
    raise InputError(
        f"{len(failed)} of {plural(total, 'run')} failed: "
        f"{', '.join(one.name for one in failed)}; the others are whole, and tracebacks are in "
        f"{folder}/*.failed.txt"
    )
