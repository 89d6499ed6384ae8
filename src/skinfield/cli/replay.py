"""`skinfield replay`: a recording answered again, bit for bit."""

import json
import time
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn

SHOWN = 5  # differences
BETWEEN = 0.05  # s of a bar

HELP = """Compute the estimates of FILE again from its readings; compare them with the live ones.

The same code works on the same bytes, and where the live engine decided by the clock (how far
to search, on which grid) the recording tells how: so contacts and fields come out the same, bit
for bit, on a processor of the same kind. It starts at a key cycle, of which there is one every
few seconds, once FILE holds all readings that still count. The exit code is 1 if any cycle differs.

With --name other programs see it as a skin that runs: `skinfield status`, `skinfield.connect`.

\b
Examples:
  skinfield replay touch.mcap
  skinfield replay touch.mcap --speed 1 --name demo
"""


@click.command(short_help="Answer a recording again, bit for bit.", help=HELP)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--speed", type=float, help="Times as fast as it was; default as fast as can be.")
@click.option("--name", help="Publish it under this name, as a running skin does.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object at the end.")
def replay(file: Path, speed: float | None, name: str | None, as_json: bool) -> None:
    """Answer a recording again and compare."""
    from skinfield.errors import check_positive
    from skinfield.live.replay import Replay
    from skinfield.live.replayed import Published, paced

    if speed is not None:
        check_positive("--speed", speed, "1 is as fast as it was")
    console = Console(stderr=True)
    source = Replay(file)
    publish = None if name is None else Published(name, source)
    began, found = time.monotonic(), Tally()
    try:
        with Progress(
            SpinnerColumn(), TextColumn("{task.description}"), console=console, transient=True
        ) as bar:
            task, shown = bar.add_task("reading"), began
            for each in source if speed is None else paced(source, speed):
                found.take(each)
                if publish is not None:
                    publish.put(each)
                if time.monotonic() - shown > BETWEEN:
                    shown = time.monotonic()
                    bar.update(task, description=found.line())
    except KeyboardInterrupt:
        console.print("stopped", style="dim")
    finally:
        if publish is not None:
            publish.close()
    found.seconds = time.monotonic() - began
    _tell(found, source, as_json, console)


class Tally:
    """What a replay came to."""

    def __init__(self) -> None:
        self.cycles = self.fresh = self.same = self.touched = 0
        self.tracks: set[int] = set()
        self.differ: list[int] = []
        self.seconds = 0.0

    def take(self, each: Any) -> None:
        """Count one cycle."""
        self.cycles += 1
        self.fresh += each.fresh
        self.same += each.same
        rows = each.slot.used_contacts()
        self.touched += len(rows) > 0
        self.tracks.update(rows["track"].tolist())
        if not each.same and len(self.differ) < SHOWN:
            self.differ.append(each.recorded.number)

    def line(self) -> str:
        """In a line."""
        return (
            f"{self.cycles:,} cycles, {self.fresh:,} with new readings, {self.same:,} the same, "
            f"{len(self.tracks):,} contacts"
        )


def _tell(found: Tally, source: Any, as_json: bool, console: Console) -> None:
    damage = [str(each) for each in source.recording.damage[:SHOWN]]
    plain = {
        "cycles": found.cycles,
        "fresh": found.fresh,
        "identical": found.same,
        "different": found.cycles - found.same,
        "first_different": found.differ,
        "contacts": len(found.tracks),
        "passed": source.passed,
        "gaps": source.gaps,
        "seconds": round(found.seconds, 3),
        "damage": damage,
    }
    if as_json:
        click.echo(json.dumps(plain))
    else:
        out = Console()
        out.print(found.line(), highlight=False)
        if source.passed:
            out.print(
                f"{source.passed:,} cycles could not be answered: before the first key cycle that "
                f"can be, after one of {source.gaps} gaps, or of an engine that was starting",
                style="yellow",
            )
        for each in damage:
            out.print(each, style="yellow")
        if found.differ:
            out.print(
                f"{found.cycles - found.same:,} cycles differ from what was live, the first: "
                f"{', '.join(map(str, found.differ))}",
                style="red",
            )
        elif found.cycles:
            out.print("all the same as it was live, bit for bit", style="green")
    if found.differ or not found.cycles:
        raise SystemExit(1)
