"""`skinfield experiments`: the paper's campaign as one command."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skinfield.cli.report import console, progress
from skinfield.errors import SkinfieldError

if TYPE_CHECKING:
    from rich.table import Table

    from skinfield.experiments.section import Verdict

SIZES = ("smoke", "short", "full")


def _options(function: Any) -> Any:
    for option in (
        click.option(
            "--data",
            envvar="SKINFIELD_SHARED_DATA",
            type=click.Path(file_okay=False),
            help="Folder of recordings by others, for the sections on real data; default "
            "$SKINFIELD_SHARED_DATA.",
        ),
        click.option(
            "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the noise."
        ),
        click.option(
            "--workers",
            type=click.IntRange(min=1),
            default=os.cpu_count() or 1,
            show_default="one per core",
            help="Processes at once.",
        ),
        click.option(
            "--only", metavar="NAMES", default="", help="Such as fig3,fig6: these parts alone."
        ),
        click.option(
            "--size",
            type=click.Choice(SIZES),
            default="short",
            show_default=True,
            help="How much is computed.",
        ),
        click.option(
            "-o",
            "--output",
            type=click.Path(file_okay=False),
            default="experiments",
            show_default=True,
            help="Folder of the report.",
        ),
    ):
        function = option(function)
    return function


@click.command(
    short_help="Make the paper's figures anew, against a simulated truth.",
    help="""Make every figure of the paper anew, with its method and with ours, on the half-space
and on the layer, against a simulated truth; write one HTML page that needs nothing else, and PNG,
CSV and JSON files of each part beside it.

Parts that an earlier run with the same settings left in the folder are taken as they are: a run
that was stopped goes on where it was.

\b
  skinfield experiments -o report
  skinfield experiments --size smoke --only fig3,fig6
""",
)
@_options
def experiments(
    output: str, size: str, only: str, workers: int, seed: int, data: str | None
) -> None:
    """Run, show progress, say where the report is."""
    from skinfield.experiments.run import chosen, run
    from skinfield.experiments.settings import Settings, size_by_name

    wanted = chosen(only.split(","))
    settings = Settings(size=size_by_name(size), seed=seed, data=data or "")
    with progress() as bar:
        task = bar.add_task("experiments", total=len(wanted))

        def show(name: str, done: int, of: int) -> None:
            bar.update(task, completed=done, total=of, description=name or "experiments")

        finished = run(wanted, settings, Path(output), workers, show)
    if finished.verdicts:
        console().print(_table(finished.verdicts))
    console().print(f"wrote {finished.page}", highlight=False, soft_wrap=True)
    if finished.failures:
        named = ", ".join(f"{name} (see {file})" for name, file in finished.failures)
        raise SkinfieldError(f"the report lacks what failed: {named}")


def _table(verdicts: Sequence["Verdict"]) -> "Table":
    from rich.table import Table

    table = Table("figure", "the paper says", "measured here", "verdict", show_lines=True)
    for verdict in verdicts:
        table.add_row(verdict.figure, verdict.claim, verdict.measured, verdict.verdict)
    return table
