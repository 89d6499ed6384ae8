"""`skinfield status`, `tune` and `tare`: what a running skin does, and changes to it."""

import time
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from rich.console import Console
from rich.text import Text

from skinfield.cli.options import Json, LiveName
from skinfield.cli.report import Shown, finish
from skinfield.errors import InputError, SkinfieldError
from skinfield.settings import Positive

MICRO, MILLI = 1e-6, 1e-3


def status(
    name: LiveName = None,
    /,
    *,
    duration: Annotated[float, Positive("seconds to watch")] = 1.0,
    watch: bool = False,
    as_json: Json = False,
) -> None:
    """Tell what a running skin does: times, losses, contacts, sources, what the system granted.

    NAME is the one that `skinfield run --name` was given; without it the only one that runs.

    Times are told for the last second and since the start: how late the engine wakes, how long
    after that its estimate is ready, and how old the newest reading is by then.

      skinfield status
      skinfield status left_arm --watch
      skinfield status --json | jq .since_start.latency_us

    Parameters
    ----------
    duration : float, s
        Seconds to watch, for what is recent.
    watch : bool
        Go on until Ctrl-C.
    """
    from skinfield.loop.client import Live, chosen
    from skinfield.loop.status import Observer

    console = Console()
    with Live(chosen(name)) as live:
        observer = Observer(live.reader)
        if watch:
            _watch(console, observer, duration)
            return
        time.sleep(duration)
        newest = observer.look()
    finish(as_json, newest.as_dict(), lines=_lines(newest, console.width))


def _lines(newest: Any, width: int) -> Iterator[Shown]:
    """The table, and what is to be said beside it."""
    from skinfield.cli.status_table import status_table

    yield status_table(newest, width)
    sentences = notes_of(newest.notes) + newest.sentences
    supervisor = newest.sidecars.get("supervisor") or {}
    for time_ns, what, text in supervisor.get("events", []):
        stamp = time.strftime("%H:%M:%S", time.localtime(time_ns * 1e-9))
        sentences.append(f"{stamp} {what}: {text}")
    sentences += supervisor.get("traceback", "").splitlines()
    yield from (Text(f" {sentence}", style="dim") for sentence in sentences)


def _watch(console: Console, observer: Any, seconds: float) -> None:
    from rich.live import Live as Screen

    from skinfield.cli.status_table import draw

    try:
        with Screen(console=console, auto_refresh=False, vertical_overflow="crop") as screen:
            while True:
                time.sleep(max(seconds, 0.1))
                draw(screen, observer.look())
    except KeyboardInterrupt:
        return
    except SkinfieldError as error:
        console.print(str(error))


def notes_of(notes: dict[str, object]) -> list[str]:
    """What an engine says in words, as sentences."""
    from skinfield.loop.realtime import RealTimeStatus

    granted = notes.get("granted")
    sentences: list[str] = []
    if isinstance(granted, dict):
        sentences += RealTimeStatus.from_dict(granted).sentences()
    for name in ("tare", "sources"):
        texts = notes.get(name)
        sentences += map(str, texts) if isinstance(texts, list) else []
    sentences += [str(notes["failed"])] if "failed" in notes else []
    return sentences


def tare(name: LiveName = None, /, *, as_json: Json = False) -> None:
    """Take the baseline of a running skin anew: nothing may touch it meanwhile.

    NAME is the one that `skinfield run --name` was given; without it the only one that runs.

      skinfield tare
      skinfield tare left_arm
    """
    from skinfield.loop.client import Live, chosen

    with Live(chosen(name)) as live:
        live.tare()
        text = f"{live.name} takes its baseline anew: leave the skin untouched"
        finish(as_json, {"name": live.name}, lines=[text])


def tune(
    name: LiveName = None,
    /,
    *,
    deadline_us: float | None = None,
    resolution: int | Literal["auto"] | None = None,
    threshold_n: float | None = None,
    smoothing_ms: float | None = None,
    focus: str | None = None,
    as_json: Json = False,
) -> None:
    """Change how a running skin answers, without a stop; with no option, tell what is in force.

    NAME is the one that `skinfield run --name` was given; without it the only one that runs.

    A finer grid or a longer deadline is used as far as it goes: what does not fit into the time of
    a cycle is answered on a coarser grid, and says so. A focus is a window of a patch, in mm of its
    plane: what presses there is answered first, and on the finest grid whatever --resolution says.
    Recordings say what was in force when.

      skinfield tune
      skinfield tune --resolution 20 --deadline-us 200
      skinfield tune left_arm --threshold-n 0.2 --smoothing-ms 20
      skinfield tune --focus hexagon72:-5,0,5,10
      skinfield tune --resolution auto --focus none

    Parameters
    ----------
    deadline_us : float, µs, optional
        Time for the reconstruction in each cycle, µs.
    resolution : int or "auto", optional
        Nodes on a side of the finest grid that is used, or auto.
    threshold_n : float, N, optional
        Contacts of a smaller force are not published, N.
    smoothing_ms : float, ms, optional
        Time constant of a low-pass, ms; 0: none.
    focus : str, optional
        A window of a patch, PATCH:X0,Y0,X1,Y1 in mm; or none.
    """
    from skinfield.loop.client import Live, chosen

    wanted = {
        "deadline": None if deadline_us is None else deadline_us * MICRO,
        "threshold": threshold_n,
        "smoothing": None if smoothing_ms is None else smoothing_ms * MILLI,
        "resolution": resolution,
    }
    changes: dict[str, Any] = {key: value for key, value in wanted.items() if value is not None}
    with Live(chosen(name)) as live:
        if focus is not None:
            changes["focus"] = focus_from_text(focus, [patch.name for patch in live.skin])
        if changes:
            live.tune(**changes)
        plain = live.limits.as_dict(live.tuning)
    finish(as_json, plain, lines=lines_of(plain))


def focus_from_text(text: str, patches: list[str]) -> Any:
    """`Focus` of the command's text, or None; of a skin of one patch its name may be left out."""
    from skinfield.loop.runtime_parameters import Focus

    if text == "none":
        return None
    patch, _, corners = text.rpartition(":")
    try:
        x0, y0, x1, y1 = (float(each) * MILLI for each in corners.split(","))
    except ValueError:
        raise InputError(
            f"--focus is {text!r}, expected PATCH:X0,Y0,X1,Y1 in mm, such as "
            f"{patches[0]}:-5,0,5,10, or none"
        ) from None
    return Focus(patch=patch or patches[0], low=(x0, y0), high=(x1, y1))


def lines_of(plain: dict[str, Any]) -> list[str]:
    """What is in force, and what it may be, for people."""
    resolution, deadline = plain["resolution"], plain["deadline"]
    options = ", ".join(map(str, resolution["options"]))
    focus = plain["focus"]["value"]
    window = "none"
    if focus is not None:
        numbers = (f"{each / MILLI:g}" for each in (*focus["low"], *focus["high"]))
        window = f"{focus['patch']}:{','.join(numbers)} mm"
    least, most = (each / MICRO for each in deadline["range"])
    lines = [
        f"resolution  {resolution['value']}  ({options})",
        f"deadline    {deadline['value'] / MICRO:g} µs  ({least:g} to {most:g})",
        f"threshold   {plain['threshold']['value']:g} N",
        f"smoothing   {plain['smoothing']['value'] / MILLI:g} ms",
        f"focus       {window}",
    ]
    return [*lines, *sorted({f"cannot be changed: {why}" for why in plain["off"].values()})]
