"""`skinfield view`: the page of a recording, or of skins elsewhere."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from skinfield.cli.bridge_options import zenoh_options
from skinfield.cli.endings import told_to_end
from skinfield.cli.page_options import page_options, page_settings, tell_page

LOOKS = 0.25  # s between looks whether the page is still served

HELP = """Show a recording, or skins that run elsewhere, in the browser.

FILE is what `skinfield record`, or `run --record`, wrote. Its readings are answered again, bit
for bit, at any pace and from any time on; files that were cut short or have gaps are shown where
that can be done, and the page says where not.

With --zenoh the page shows all skins whose estimates can be reached, side by side as one: see
`skinfield run --zenoh`.

\b
Examples:
  skinfield view touch.mcap
  skinfield view touch.mcap --port 8800 --no-browser
  skinfield view --zenoh
  skinfield view --zenoh --zenoh-connect tcp/robot:7447
  skinfield view --zenoh --host 0.0.0.0 --token A-LONG-SECRET

Recordings of counts alone, such as CSV or a yarpdatadumper log: `skinfield reconstruct`.
"""


@click.command(short_help="Show a recording, or skins elsewhere, in the browser.", help=HELP)
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option("--zenoh", is_flag=True, help="Skins elsewhere, see docs/zenoh.md.")
@zenoh_options
@page_options
@click.option("--paused", is_flag=True, help="Do not play FILE at once.")
@click.option("--duration", type=float, help="Seconds; default until Ctrl-C.")
def view(**given: Any) -> None:
    """Serve the page until Ctrl-C."""
    from skinfield.viewer import serve_page

    _check(given)
    console = Console(stderr=True)
    settings = page_settings(given)
    source = _recording(given, console) if given["file"] is not None else _elsewhere(given)
    try:
        with told_to_end(), source as (feeds, desk), serve_page(settings, feeds, desk) as page:
            tell_page(given, page.address, console)
            _wait(page, given["duration"])
    except KeyboardInterrupt:
        console.print("stopping", style="dim")


def _check(given: dict[str, Any]) -> None:
    """Raise InputError unless it is clear what to show."""
    from skinfield.errors import InputError, check_positive

    if (given["file"] is None) == (not given["zenoh"]):
        what = "neither was given" if given["file"] is None else "both were given"
        raise InputError(
            f"{what}, expected a recording (skinfield view FILE.mcap) or --zenoh; a skin on this "
            "machine has its page where `skinfield run` says"
        )
    if given["file"] is not None and any(
        given[f"zenoh_{name}"] for name in ("listen", "connect", "config")
    ):
        raise InputError("addresses of zenoh were given with a recording, expected --zenoh alone")
    if given["duration"] is not None:
        check_positive("--duration", given["duration"], "s")


@contextmanager
def _recording(given: dict[str, Any], console: Console) -> Iterator[tuple[Any, Any]]:
    """Feeds and desk of a recording."""
    from skinfield.viewer.replay_desk import ReplayDesk
    from skinfield.viewer.replay_feed import ReplayFeed

    with console.status(f"looking through {given['file']}"):
        feed = ReplayFeed(given["file"], playing=not given["paused"])
    for begin, end in feed.holes:
        console.print(
            f"from {begin:.2f} s to {end:.2f} s nothing can be answered again: readings are "
            "missing there, or the engine was starting",
            style="yellow",
        )
    for each in feed.replay.recording.damage[:3]:
        console.print(
            f"damaged at byte {each.byte}: {each.why}",
            style="yellow",
            markup=False,
            highlight=False,
        )
    try:
        yield (lambda: (feed,)), ReplayDesk(feed)
    finally:
        feed.close()


@contextmanager
def _elsewhere(given: dict[str, Any]) -> Iterator[tuple[Any, Any]]:
    """Feeds and desk of skins that are reached over zenoh."""
    from skinfield.cli.bridge_parts import zenoh_feeds
    from skinfield.cli.remote_desk import RemoteDesk

    with zenoh_feeds(given) as found:
        yield found.feeds, RemoteDesk(found)


def _wait(page: Any, duration: float | None) -> None:
    """Until the time is over, Ctrl-C, or the page fails."""
    end = None if duration is None else time.monotonic() + duration
    while end is None or time.monotonic() < end:
        page.check()
        time.sleep(LOOKS if end is None else max(min(LOOKS, end - time.monotonic()), 0.0))
