"""`skinfield tune`: change a running engine, or tell how it is tuned."""

import json
from typing import Any, Literal

import click
from rich.console import Console

from skinfield.errors import InputError

HELP = """Change how a running skin answers, without a stop; with no option, tell what is in force.

NAME is the one that `skinfield run --name` was given; without it the only one that runs.

A finer grid or a longer deadline is used as far as it goes: what does not fit into the time of
a cycle is answered on a coarser grid, and says so. A focus is a window of a patch, in mm of its
plane: what presses there is answered first, and on the finest grid whatever --resolution says.
Recordings hold all of it, and are answered again the same.

\b
Examples:
  skinfield tune
  skinfield tune --resolution 20 --deadline-us 200
  skinfield tune left_arm --threshold-n 0.2 --smoothing-ms 20
  skinfield tune --focus hexagon72:-5,0,5,10
  skinfield tune --resolution auto --focus none
"""
MICRO, MILLI = 1e-6, 1e-3


@click.command(short_help="Change how a running skin answers.", help=HELP)
@click.argument("name", required=False)
@click.option("--deadline-us", type=float, help="For the reconstruction in each cycle, µs.")
@click.option("--resolution", help="Nodes on a side of the finest grid that is used, or auto.")
@click.option("--threshold-n", type=float, help="Contacts of a smaller force are not told, N.")
@click.option("--smoothing-ms", type=float, help="Time constant of a low-pass, ms; 0: none.")
@click.option("--focus", metavar="PATCH:X0,Y0,X1,Y1", help="A window of a patch, mm; or none.")
@click.option("--json", "as_json", is_flag=True, help="What is in force, as one JSON object in SI.")
def tune(name: str | None, as_json: bool, **given: Any) -> None:
    """Change a running engine."""
    from skinfield.live.client import Live, chosen

    with Live(chosen(name)) as live:
        changes = changes_of(given, [patch.name for patch in live.skin])
        if changes:
            live.tune(**changes)
        plain = live.limits.as_dict(live.tuning)
    if as_json:
        click.echo(json.dumps(plain))
        return
    console = Console()
    for line in lines_of(plain):
        console.print(line, highlight=False)


def changes_of(given: dict[str, Any], patches: list[str]) -> dict[str, Any]:
    """Arguments of `Live.tune` from those of the command."""
    changes: dict[str, Any] = {}
    if given["resolution"] is not None:
        changes["resolution"] = resolution_from(given["resolution"])
    for option, name, unit in (
        ("deadline_us", "deadline", MICRO),
        ("threshold_n", "threshold", 1.0),
        ("smoothing_ms", "smoothing", MILLI),
    ):
        if given[option] is not None:
            changes[name] = given[option] * unit
    if given["focus"] is not None:
        changes["focus"] = focus_from(given["focus"], patches)
    return changes


def resolution_from(text: str) -> int | Literal["auto"]:
    """Of the command's text."""
    if text == "auto":
        return "auto"
    if text.isdecimal():
        return int(text)
    raise InputError(f"--resolution is {text!r}, expected auto or nodes on a side, such as 20")


def focus_from(text: str, patches: list[str]) -> Any:
    """`Focus` of the command's text, or None; of a skin of one patch its name may be left out."""
    from skinfield.live.tuning import Focus

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
