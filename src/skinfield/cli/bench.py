"""`skinfield bench`: what a reading costs on this machine, and error against time."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skinfield.cli.report import console, progress, say_notes

if TYPE_CHECKING:
    from skinfield.experiments.bench.run import Bench
    from skinfield.experiments.bench.settings import BenchSettings

SIZES = ("smoke", "short", "full")
NUMBERS, PICTURE, TRUTH = "bench.json", "bench.png", "bench-truth.png"


@click.command(
    short_help="Time the solvers on this machine: cost, and error against time.",
    help="""Measure on this machine what a reading costs: the paper's algorithm with all its work
for each reading, as in its Figure 9, the operator that is prepared once, the non-negative field to
a certified gap, and the contact fit. Then the any-time curve: two simulated fingers move over the
patch, and each solver answers within deadlines from 20 µs to 50 ms; how far is it from its
converged answer, and from the truth?

Prints tables and writes bench.json, bench.png and bench-truth.png. It takes seconds (smoke), some
two to three minutes (short) or about half an hour (full), on one core. Let nothing else run
meanwhile; what ran anyway is reported.

With --jitter it measures the live loop instead: how late the engine's process wakes, and when its
estimates are ready, on the paper's hexagon with 40 x 40 nodes, while a virtual skin sends what iCub
boards would and other processes keep all processors busy. Where cyclictest of rt-tests is
installed, it runs in the same seconds on the same processor, half a period apart and one step
higher in priority, so that neither waits for the other; it does nothing but sleep, and how late it
wakes is the system's doing. The ratio is the loop's own.

\b
  skinfield bench
  skinfield bench --size full -o bench
  skinfield bench --size smoke --json
  skinfield bench --jitter
  skinfield bench --jitter --seconds 60 --rate 1000 --busy 2 --json
""",
)
@click.option(
    "--size",
    type=click.Choice(SIZES),
    default="short",
    show_default=True,
    help="How much is measured.",
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of noise and order."
)
@click.option(
    "-o",
    "--output",
    type=click.Path(file_okay=False),
    default="bench",
    show_default=True,
    help="Folder of numbers and pictures.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON, not as tables.")
@click.option("--jitter", is_flag=True, help="Measure how late the live loop wakes instead.")
@click.option("--seconds", type=float, help="For --jitter: how long.  [default: 20]")
@click.option("--rate", type=float, help="For --jitter: cycles per second.  [default: 1000]")
@click.option("--busy", type=int, help="For --jitter: busy processes beside it.  [default: 2]")
@click.option(
    "--load",
    type=click.Choice(("skin", "engine", "none")),
    help="For --jitter: a virtual skin over UDP, readings made before, or none: the loop wakes "
    "only.  [default: skin]",
)
@click.option(
    "--solver",
    type=click.Choice(("nonnegative", "gaussian")),
    help="For --jitter: of the engine.  [default: nonnegative]",
)
@click.option(
    "--pair",
    type=click.Choice(("same", "other")),
    help="For --jitter: on which CPU cyclictest runs.  [default: same]",
)
@click.option(
    "--priority",
    type=click.IntRange(0, 98),
    help="For --jitter: of SCHED_FIFO; 0 for ordinary scheduling.  [default: 80]",
)
def bench(
    size: str, seed: int, output: str, as_json: bool, jitter: bool, **of_jitter: float | str | None
) -> None:
    """Measure, print and draw."""
    given = {name: value for name, value in of_jitter.items() if value is not None}
    if _jitter(jitter, given):
        from skinfield.cli.bench_jitter import jitter_settings, measure_jitter

        measure_jitter(jitter_settings(given), as_json)
        return
    from skinfield.experiments.bench.files import bench_as_json
    from skinfield.experiments.bench.settings import BenchSettings, bench_size

    folder = _folder(output)
    found = _measured(BenchSettings(size=bench_size(size), seed=seed))
    _write(found, folder)
    say_notes(found.warnings)
    if as_json:
        click.echo(json.dumps(bench_as_json(found), allow_nan=False))
        return
    from skinfield.cli.bench_tables import tables
    from skinfield.experiments.bench.picture import machine_line

    console().print(machine_line(found), highlight=False)
    for table in tables(found):
        console().print(table)
    for name in (NUMBERS, PICTURE, TRUTH):
        console().print(f"wrote {folder / name}", highlight=False, soft_wrap=True)


def _jitter(asked: bool, given: Mapping[str, object]) -> bool:
    """Whether it was asked for; its options mean nothing otherwise."""
    if given and not asked:
        raise click.UsageError(f"--{next(iter(given))} belongs to --jitter: give both")
    return asked


def _measured(settings: "BenchSettings") -> "Bench":
    from skinfield.experiments.bench.run import run_bench

    with progress() as bar:
        task = bar.add_task("bench", total=1)

        def show(what: str, done: int, of: int) -> None:
            bar.update(task, description=what, completed=done, total=of)

        return run_bench(settings, show)


def _write(found: "Bench", folder: Path) -> None:
    from skinfield.experiments.bench.files import write_bench
    from skinfield.experiments.bench.picture import picture, picture_of_truth
    from skinfield.figures import save

    write_bench(found, folder / NUMBERS)
    save(picture(found), folder / PICTURE)
    save(picture_of_truth(found), folder / TRUTH)


def _folder(name: str) -> Path:
    """Make the folder before anything is measured."""
    from skinfield.errors import FileError

    folder = Path(name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{name} cannot be made: {error}; expected the name of a folder") from error
    return folder
