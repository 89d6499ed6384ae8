"""`skinfield run`: a robot's skin, alive."""

import json
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from skinfield.cli.bridge_options import bridge_options
from skinfield.cli.bridge_parts import check_bridges
from skinfield.cli.endings import end_undisturbed, told_to_end
from skinfield.cli.page_options import page_options, tell_page
from skinfield.cli.run_checks import check_given
from skinfield.cli.run_options import (
    NotYet,
    answer_options,
    extra_settings,
    settings_from,
    source_options,
    system_options,
)

REFRESH = 0.25  # s
SILENT = 5.0  # s without a message until it is told
RECENT = 1.0  # s that the table calls the last
STARTS = 180.0  # s: kernels may have to be compiled first, and presses be solved

HELP = """Run the live engine: readings in, contacts out, in newtons, cycle after cycle on time.

The page of the skin opens in the browser: it shows what touches, and lets you press.

With nothing attached a virtual skin is started, which speaks the bytes of iCub's boards. The
engine works in a process of its own, at real-time priority where the system grants it; what is
not granted is told by `skinfield status`, with the remedy. It starts with a baseline: leave the
skin untouched for the first second or two.

\b
Examples:
  skinfield run
  skinfield run --port 8700 --no-browser
  skinfield run --skin cylinder --scene slide
  skinfield run --record touch.mcap --duration 60
  skinfield run --hardware icub --bus socketcan --channel can0 --skin right_foot.txt
  skinfield run --hardware packet --bus udp --channel 0.0.0.0:9870 --skin my_skin.toml
  skinfield run --duration 10 --headless --json

Other programs get the estimates with `skinfield.connect()`, see docs/live.md; other machines
with --zenoh, --ros2 and --yarp. Ctrl-C ends all.
"""


@click.command(short_help="Bring a robot's skin alive: contacts in newtons, on time.", help=HELP)
@source_options
@answer_options
@system_options
@click.option("--record", type=click.Path(path_type=Path), help="Into this MCAP file.")
@page_options
@bridge_options
@click.option(
    "--fit/--no-fit",
    default=True,
    show_default=True,
    help="Fit contacts beside the engine: surer places and forces, some 10 ms later.",
)
@click.option("--duration", type=float, help="Seconds; default until Ctrl-C.")
@click.option("--headless", is_flag=True, help="No table: for services and scripts.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object at the end.")
@click.option("--scene", default="press", show_default=True, help="Of the virtual skin.")
@click.option("--virtual-rate", default=100.0, show_default=True, help="Its readings per second.")
@click.option("--seed", default=0, show_default=True, help="Of its noise.")
def run(**given: Any) -> None:
    """Run the live engine until Ctrl-C."""
    console = Console(stderr=True)
    check_given(given)
    check_bridges(given)
    with told_to_end(), ExitStack() as parts:
        try:
            summary = _run(given, parts, console)
        finally:
            end_undisturbed()
    if given["as_json"]:
        click.echo(json.dumps(summary))


def _run(given: dict[str, Any], parts: ExitStack, console: Console) -> dict[str, Any]:
    """Start everything, show it until the end, and sum it up."""
    from skinfield.cli.bridge_parts import bridges
    from skinfield.cli.fit_part import start_fit
    from skinfield.cli.inputs import skin_from_text
    from skinfield.cli.run_page import page_of
    from skinfield.cli.run_parts import recorder, virtual_extra, virtual_skin
    from skinfield.live.client import Live
    from skinfield.live.supervisor import Supervisor
    from skinfield.ring import State
    from skinfield.sources.live.spec import skin_for, source_from_options

    skin = skin_from_text(given["skin_text"])
    hardware, bus, channels = given["hardware"], given["bus"], given["channel"]
    handle = None
    with console.status("starting"):
        if hardware is None:
            settings_from(given, skin, NotYet())  # refuses what it must before anything starts
            handle = parts.enter_context(virtual_skin(given))
            hardware, bus, channels = "icub", bus or "udp", tuple(handle.channels)
            given["extra"] = (*virtual_extra(given["virtual_rate"]), *given["extra"])
        skin, extra = skin_for(hardware, skin), extra_settings(given["extra"])
        if given["no_load"] is not None:  # the boards are told as well
            extra.setdefault("no_load", str(given["no_load"]))
        source = source_from_options(hardware, bus or "", channels, skin, extra)
        settings = settings_from(given, skin, source)
        supervisor = parts.enter_context(Supervisor(settings))
        fit = parts.enter_context(start_fit(settings.name, given["fit"]))
        supervisor.wait(STARTS, State.STARTING).close()
        parts.enter_context(recorder(settings.name, given["record"]))
        live = parts.enter_context(Live(settings.name))
        page = parts.enter_context(page_of(given, settings.name, supervisor, handle))
        bridged = parts.enter_context(bridges(given, settings.name))
    tell_page(given, page.address, console)
    begin = (lambda: page.desk.begin(given["scene"])) if handle is not None else None

    def check() -> None:
        page.check()
        for text in (*(fit.notices() if fit is not None else ()), *bridged.notices()):
            page.desk.say("warn", text)
            console.print(text, style="yellow")

    return _watch(given, supervisor, live, console, begin, check)


def _watch(
    given: dict[str, Any],
    supervisor: Any,
    live: Any,
    console: Console,
    begin: Callable[[], None] | None,
    check: Callable[[], None],
) -> dict[str, Any]:
    """Show the skin until its time is over, or Ctrl-C.

    `begin` is called when it answers; `check` again and again: it raises what ends it, and tells
    what failed.
    """
    from skinfield.live.seen import Watch
    from skinfield.live.status import Observer

    watch = Watch([patch.name for patch in live.skin])
    observer = Observer(live.reader, window=RECENT)
    screen = None if given["headless"] else _screen(console)
    try:
        began = _wait_running(supervisor, observer, screen, console)
        if begin is not None:
            begin()
        end = None if given["duration"] is None else began + given["duration"]
        shown = began
        while end is None or time.monotonic() < end:
            left = REFRESH if end is None else min(REFRESH, max(end - time.monotonic(), 0.0))
            found = live.next(left)
            now = time.monotonic()
            check()
            if found is not None:
                watch.take(found.contacts, now - began)
            if screen is not None and now - shown > REFRESH:
                shown = now
                _show(screen, observer)
    except KeyboardInterrupt:
        console.print("stopping", style="dim")
    finally:
        if screen is not None:
            screen.stop()
    return summary_of(observer.look(), supervisor, watch.contacts)


def _screen(console: Console) -> Any:
    from rich.live import Live as Screen

    screen = Screen(console=console, refresh_per_second=8, vertical_overflow="crop")
    screen.start()
    return screen


def _show(screen: Any, observer: Any) -> None:
    from skinfield.cli.run_table import shown

    size = screen.console.size
    screen.update(shown(observer.look(), size.width, size.height))


def _wait_running(supervisor: Any, observer: Any, screen: Any, console: Console) -> float:
    """Wait until the engine answers, showing what it does meanwhile; the time then."""
    from skinfield.live.supervisor import EngineFailed

    end, told = time.monotonic() + STARTS, time.monotonic() + SILENT
    while True:
        if time.monotonic() > told:
            told = end + 1.0
            _tell_silent(observer.look().sources, console)
        try:
            supervisor.wait(REFRESH).close()
            return time.monotonic()
        except EngineFailed:
            if time.monotonic() > end or supervisor.hopeless:
                raise
        if screen is not None:
            _show(screen, observer)


def _tell_silent(sources: dict[str, dict[str, int]], console: Console) -> None:
    """Say which sources nothing has come from: they may be plugged in late, or misspelt."""
    silent = [name for name, counts in sources.items() if not counts["received"]]
    if silent:
        console.print(
            f"nothing has come from {', '.join(silent)} yet, waiting: is it connected and on, and "
            "is --channel right?",
            style="yellow",
        )


def summary_of(status: Any, supervisor: Any, contacts: list[dict[str, Any]]) -> dict[str, Any]:
    """What `--json` prints; times in µs since the engine's start."""
    since = status.since

    def micros(found: Any) -> dict[str, float] | None:
        if found is None:
            return None
        return {key: value for key, value in found.as_micros().items() if key != "count"}

    return {
        "cycles": since.cycles,
        "late": since.late,
        "overrun": since.overrun,
        "skipped": since.skipped,
        "lost": status.lost,
        "latency_us": micros(since.latency),
        "wake_us": micros(since.wake),
        "ready_us": micros(since.ready),
        "contacts": contacts,
        "sources": status.sources,
        "restarts": supervisor.restarts,
        "granted": status.notes.get("granted"),
        "events": [[each.time_ns, each.what, each.text] for each in supervisor.events],
    }
