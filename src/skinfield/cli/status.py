"""`skinfield status`: what runs, and how well."""

import json
import time

import click
from rich.console import Console

from skinfield.errors import SkinfieldError

HELP = """Tell what a running skin does: times, losses, contacts, sources, what the system granted.

NAME is the one that `skinfield run --name` was given; without it the only one that runs.

Times are told for the last second and since the start: how late the engine wakes, how long
after that its estimate is ready, and how old the newest reading is by then.

\b
Examples:
  skinfield status
  skinfield status left_arm --watch
  skinfield status --json | jq .since_start.latency_us
"""


@click.command(short_help="What runs, and how well it keeps its time.", help=HELP)
@click.argument("name", required=False)
@click.option("--seconds", default=1.0, show_default=True, help="To watch, for what is recent.")
@click.option("--watch", is_flag=True, help="Go on until Ctrl-C.")
@click.option("--json", "as_json", is_flag=True, help="As one JSON object, times in µs.")
def status(name: str | None, seconds: float, watch: bool, as_json: bool) -> None:
    """Tell what a running skin does."""
    from skinfield.live.client import Live, chosen
    from skinfield.live.status import Observer

    console = Console()
    with Live(chosen(name)) as live:
        observer = Observer(live.reader)
        if watch:
            _watch(console, observer, seconds)
            return
        time.sleep(max(seconds, 0.0))
        found = observer.look()
    if as_json:
        click.echo(json.dumps(found.as_dict()))
        return
    from skinfield.cli.run_table import shown

    console.print(shown(found, console.width))
    for sentence in notes_of(found.notes):
        console.print(f" {sentence}", style="dim", highlight=False)
    for event in (found.beside.get("supervisor") or {}).get("events", []):
        stamp = time.strftime("%H:%M:%S", time.localtime(event[0] * 1e-9))
        console.print(f" {stamp} {event[1]}: {event[2]}", style="dim", highlight=False)


def _watch(console: Console, observer: object, seconds: float) -> None:
    from rich.live import Live as Screen

    from skinfield.cli.run_table import shown
    from skinfield.live.status import Observer

    assert isinstance(observer, Observer)  # for the type checker: the import is late
    try:
        with Screen(console=console, refresh_per_second=4, vertical_overflow="crop") as screen:
            while True:
                time.sleep(max(seconds, 0.1))
                screen.update(shown(observer.look(), console.width, console.height))
    except KeyboardInterrupt:
        return
    except SkinfieldError as error:
        console.print(str(error))


def notes_of(notes: dict[str, object]) -> list[str]:
    """What an engine says in words, as sentences."""
    from skinfield.realtime import Granted

    said: list[str] = []
    granted = notes.get("granted")
    if isinstance(granted, dict):
        said += Granted.from_dict(granted).sentences()
    for name in ("tare", "sources"):
        told = notes.get(name)
        if isinstance(told, list):
            said += [str(each) for each in told]
    return said
