"""`skinfield replay` and `view`: the page of a recording, or of skins elsewhere."""

import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from dataclasses import replace as with_other
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter
from rich.console import Console

from skinfield.bridges.settings import ZenohAddresses
from skinfield.bridges.zenoh.source import ZenohSource
from skinfield.cli.options import Duration, Json, McapFile, Page, part
from skinfield.cli.report import note, print_json, say, show_address, signals_end
from skinfield.errors import InputError
from skinfield.page.controller import Controller
from skinfield.page.settings import PageSettings
from skinfield.page.source import DataSource, EngineView
from skinfield.settings import Positive

if TYPE_CHECKING:
    from skinfield.bridges.zenoh.discovery import ZenohSources

REFRESH = 0.25  # s between pictures of the table
DAMAGE = 3  # places that are named


def replay(
    file: McapFile,
    /,
    *,
    speed: Annotated[float | None, Positive("1 is as fast as it was")] = None,
    headless: bool = False,
    as_json: Annotated[Json, Parameter(help="A line of JSON for each cycle; no page.")] = False,
    name: str | None = None,
    duration: Duration = None,
    page: Page = PageSettings(),
) -> None:
    """Show what FILE holds, as it was: readings, contacts and fields of a live skin.

    FILE is what `skinfield record`, or `run --record`, wrote. It plays on the page in the browser
    and as a table in the terminal, at any pace and from any time on. Nothing is computed anew:
    `skinfield reconstruct FILE` does that, with whatever solver and settings it is given.

    With --headless nothing is shown until the end; with --json each cycle with new readings is a
    line of JSON: its number, its time, and its contacts. With --name other programs see it as a
    skin that runs: `skinfield status`, `skinfield.connect`.

      skinfield replay touch.mcap
      skinfield replay touch.mcap --speed 0.1
      skinfield replay touch.mcap --headless --json | jq .contacts
      skinfield replay touch.mcap --name demo

    Parameters
    ----------
    speed : float, optional
        Times its own pace, on the page 0.1 to 10. Default 1; headless as fast as can be.
    headless : bool
        Neither page nor table: for scripts.
    name : str, optional
        No page, but a running skin of this name, for other programs.
    """
    console = Console(stderr=True)
    if headless or as_json or name:
        _headless(file, speed, name, duration, as_json, console)
    else:
        show_page(opened(file, console, speed), page, duration, console, look=True)


def view(
    file: str | None = None,
    /,
    *,
    duration: Duration = None,
    page: Page = PageSettings(),
    zenoh: Annotated[ZenohAddresses, part("Skins elsewhere")] = ZenohAddresses(),
) -> None:
    """Show a recording, or skins that run elsewhere, in the browser.

    FILE is what `skinfield record`, or `run --record`, wrote. It is shown as it was, at any pace
    and from any time on; files that were cut short are shown as far as they go.

    With --zenoh the page shows all skins whose estimates can be reached, side by side as one: see
    `skinfield run --zenoh`.

      skinfield view touch.mcap
      skinfield view touch.mcap --port 8800 --no-browser
      skinfield view --zenoh
      skinfield view --zenoh --zenoh-connect tcp/robot:7447
      skinfield view --zenoh --host 0.0.0.0 --token A-LONG-SECRET

    Recordings of counts alone, such as CSV or a yarpdatadumper log: `skinfield reconstruct`.

    Parameters
    ----------
    file : str, optional
        Recording (.mcap).
    """
    if (file is None) == (not zenoh.zenoh):
        what = "neither was given" if file is None else "both were given"
        raise InputError(
            f"{what}, expected a recording (skinfield view FILE.mcap) or --zenoh; a skin on this "
            "machine has its page where `skinfield run` says"
        )
    if file is not None and zenoh.addressed:
        raise InputError("addresses of zenoh were given with a recording, expected --zenoh alone")
    console = Console(stderr=True)
    shown = _elsewhere(zenoh) if file is None else opened(file, console)
    show_page(shown, page, duration, console)


def show_page(
    shown: AbstractContextManager[tuple[Any, Any]],
    page: PageSettings,
    duration: float | None,
    console: Console,
    *,
    look: bool = False,
) -> None:
    """Serve a page until the time is over, Ctrl-C, or the page fails.

    With `look` a replay is shown as a table, too, where somebody looks at the terminal.
    """
    from rich.live import Live

    from skinfield.cli.status_table import draw
    from skinfield.page.server import serve_page

    end = float("inf") if duration is None else time.monotonic() + duration
    screen = Live(console=console, auto_refresh=False, vertical_overflow="crop")
    try:
        with (
            signals_end(),
            shown as (sources, controller),
            serve_page(page, sources, controller) as served,
        ):
            show_address(served.address, console, browser=page.browser)
            if look and console.is_terminal:
                screen.start()
            while time.monotonic() < end:
                served.check()
                if screen.is_started:
                    draw(screen, with_other(controller.shared.look(), state="running"))
                time.sleep(max(min(REFRESH, end - time.monotonic()), 0.0))
    except KeyboardInterrupt:
        note("stopping", where=console)
    finally:
        screen.stop()


@contextmanager
def opened(file: str, console: Console, speed: float | None = None) -> Iterator[tuple[Any, Any]]:
    """Sources and controller of a recording, for the page."""
    from skinfield.page.controller import Controller
    from skinfield.page.replay import RecordingSource

    with console.status(f"looking through {file}"):
        source = RecordingSource(Path(file), playing=True)
    for begin, end in source.gaps:
        note(f"from {begin:.2f} s to {end:.2f} s cycles are missing", "yellow", console)
    _report_damage(source.replay.recording, console)
    controller = Controller(source)
    if speed is not None:
        controller.shared.set_speed(speed)
    try:
        yield (lambda: (source,)), controller
    finally:
        source.close()


@contextmanager
def _elsewhere(zenoh: ZenohAddresses) -> Iterator[tuple[Any, Any]]:
    """Sources and controller of skins that are reached over zenoh."""
    from skinfield.bridges.launch import zenoh_sources

    with zenoh_sources(zenoh) as elsewhere:
        yield elsewhere.sources, RemoteController(elsewhere)


def _report_damage(recording: Any, console: Console) -> None:
    for each in recording.damage[:DAMAGE]:
        note(f"damaged at byte {each.byte}: {each.why}", "yellow", console)


def _headless(
    file: str,
    speed: float | None,
    name: str | None,
    duration: float | None,
    as_json: bool,
    console: Console,
) -> None:
    """Play as a running skin, as lines of JSON, or to the end alone."""
    from skinfield.record.replay import Published, Replay, paced

    source = Replay(Path(file))
    speed = 1.0 if speed is None and name else speed
    end = float("inf") if duration is None else time.monotonic() + duration
    patches, tracks, count, fresh = [each.name for each in source.model_config.skin], set(), 0, 0
    try:
        with (
            signals_end(),
            nullcontext() if name is None else closing(Published(name, source)) as publish,
        ):
            for each in source if speed is None else paced(source, speed):
                count, fresh = count + 1, fresh + each.fresh
                tracks.update(each.cycle.contacts["track"].tolist())
                if publish is not None:
                    publish.put(each)
                if as_json and each.fresh:
                    print_json(_line(each.cycle, source.index.first_ns, patches))
                if time.monotonic() >= end:
                    break
    except KeyboardInterrupt:
        note("stopped", where=console)
    _report_damage(source.recording, console)
    if not as_json:
        gaps = f", {len(source.index.gaps)} gaps" if source.index.gaps else ""
        say(f"{count:,} cycles, {fresh:,} with new readings, {len(tracks):,} contacts{gaps}")


def _line(cycle: Any, first_ns: int, patches: list[str]) -> dict[str, Any]:
    """A cycle as plain values."""
    from skinfield.loop.status import plain_contacts

    return {
        "cycle": cycle.number,
        "wall_ns": cycle.wall_ns,
        "time_s": round((cycle.wall_ns - first_ns) * 1e-9, 6),
        "force": float(cycle.patches["force"].sum()),
        "contacts": plain_contacts(patches, cycle.contacts),
    }


NOBODY = "no skin was heard of yet: does one run with --zenoh, where this machine reaches it?"


class RemoteController(Controller):
    """See `Controller`."""

    def __init__(self, found: "ZenohSources") -> None:
        super().__init__()
        self._found = found
        self._noted: dict[str, str] = {}

    def notices(self) -> list[tuple[str, str]]:
        """See `Controller`; and why an engine that can be seen is not shown, once."""
        notes = dict(self._found.notes)
        for name, why in notes.items():
            if self._noted.get(name) != why:
                self.say("warn", f"{name} is not shown: {why}")
        self._noted = notes
        return super().notices()

    def controls(self) -> dict[str, Any]:
        """See `Controller`; why nothing is shown is told as long as that is so."""
        fields = super().controls()
        if not self._found.sources():
            notes = dict(self._found.notes)
            whys = [f"{name} is not shown: {why}" for name, why in notes.items()]
            fields["busy"] = "; ".join(whys) or NOBODY
        return fields

    def views(self, sources: Sequence[DataSource]) -> list[EngineView]:
        """See `Controller`."""
        return [
            EngineView(source.latest(), isinstance(source, ZenohSource) and source.gone, True)
            for source in sources
        ]
