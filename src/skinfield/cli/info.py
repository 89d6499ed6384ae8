"""`skinfield info`: what a recording holds."""

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from skinfield.cli.report import console, progress

MOST_EVENTS = 12


@click.command(
    short_help="Say what a recording of a live skin holds.",
    help="""Say what FILE holds, a recording that 'skinfield record' or 'run --record' made.

Which skin, how long, how many readings and cycles, how late, what was lost and why, how many
contacts, what happened, and how large its parts are. A file that was not finished is read as
far as it goes.

\b
  skinfield info touch.mcap
  skinfield info touch.mcap --json | jq .lost
""",
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="All of it as one JSON object.")
def info(file: Path, as_json: bool) -> None:
    """Run the command."""
    from skinfield.sources.recordings.mcap_live import LiveRecording
    from skinfield.sources.recordings.mcap_summary import summary_of

    with progress() as bar:
        task = bar.add_task("reading", total=None)
        found = summary_of(
            LiveRecording.open(file),
            lambda done, total: bar.update(task, completed=done, total=total),
        )
    if as_json:
        click.echo(json.dumps(found))
    else:
        _show(found)


def _show(found: dict[str, Any]) -> None:
    out = console()
    table = Table.grid(padding=(0, 2))
    for name, text in _lines(found):
        table.add_row(name, text)
    out.print(table, highlight=False, markup=False)
    if found["patches"]:
        out.print(_patches(found["patches"]))
    for event in found["last_events"][-MOST_EVENTS:]:
        when = (event.get("wall_ns", 0) - (found["began_ns"] or 0)) * 1e-9
        out.print(f"{when:10.3f} s  {event.get('text')}", highlight=False, markup=False)
    for damage in found["damage"][:MOST_EVENTS]:
        out.print(f"byte {damage['byte']}: {damage['why']}", style="yellow", markup=False)


def _lines(found: dict[str, Any]) -> list[tuple[str, str]]:
    began = found["began_ns"]
    when = (
        datetime.fromtimestamp(began * 1e-9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
        if began
        else "never"
    )
    chunks, lost, contacts, fit = (found[each] for each in ("chunks", "lost", "contacts", "fit"))
    ratio = chunks["unpacked_bytes"] / max(chunks["packed_bytes"], 1)
    whole = "" if found["finished"] else "; not finished: skinfield recover makes a whole file"
    enclosed = ", ".join(f"{name} ({size:,} bytes)" for name, size in found["attachments"].items())
    return [
        ("file", f"{found['path']}, {found['bytes'] / 1e6:.1f} MB{whole}"),
        ("recorded", f"{when}, {found['seconds']:.3f} s"),
        ("skin", f"{found['skin'] or 'layout not enclosed'}, {found['taxels'] or '?'} taxels"),
        ("readings", f"{found['readings']['bytes'] / 1e6:.1f} MB of blocks, "
                     f"{found['readings']['missing_bytes']:,} bytes missing in between"),
        ("cycles", f"{found['cycles']:,} ({_number(found['cycle_rate'])}/s), "
                   f"{found['cycles_missing']:,} missing, {found['late']:,} late, "
                   f"{found['key_cycles']:,} to start a replay from, {found['restarts']} restarts"),
        ("woke late by", _quantiles(found["wake_us"])),
        ("answered after", _quantiles(found["ready_us"])),
        ("contacts", f"{contacts['tracks']:,} tracks in {contacts['cycles']:,} cycles, at most "
                     f"{contacts['most_at_once']} at once"),
        ("contact fit", f"{fit['answers']:,} answers, {fit['bytes'] / 1e6:.2f} MB"),
        ("lost", f"{lost['messages']:,} messages before the host; in the ring "
                 f"{lost['overrun_bytes']:,} bytes, {lost['overrun_cycles']:,} cycles; for the "
                 f"disk {lost['dropped_bytes']:,} bytes, {lost['dropped_cycles']:,} cycles"),
        ("chunks", f"{chunks['count']:,}, {chunks['compression'] or 'none'}, {ratio:.2f} to 1"),
        ("enclosed", enclosed or "nothing"),
    ]  # fmt: skip


def _patches(patches: list[dict[str, Any]]) -> Table:
    table = Table("patch")
    for title in ("taxels", "readings", "per second"):
        table.add_column(title, justify="right")
    for each in patches:
        table.add_row(
            each["name"], f"{each['taxels']:,}", f"{each['readings']:,}", _number(each["rate"])
        )
    return table


def _quantiles(micros: dict[str, float] | None) -> str:
    if micros is None:
        return "not known"
    return ", ".join(f"{name} {value:,.0f} µs" for name, value in micros.items())


def _number(value: float | None) -> str:
    return "?" if value is None else f"{value:,.1f}"
