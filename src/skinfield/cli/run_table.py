"""A running skin as a table in the terminal."""

from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from skinfield.live.status import Status
from skinfield.realtime import Quantiles, Timing

MOST_PATCHES = 16
STYLES = {"running": "green", "calibrating": "yellow", "starting": "yellow"}


def shown(status: Status) -> Group:
    """Everything that fits on a screen."""
    parts = [_headline(status), _times(status), _contacts(status.contacts), _patches(status)]
    return Group(*(part for part in parts if part is not None), _sources(status))


def _headline(status: Status) -> Text:
    text = Text()
    text.append(f" {status.name} ", "bold")
    text.append(status.state, STYLES.get(status.state, "red"))
    phase = status.notes.get("phase", "")
    if phase and phase != status.state:
        text.append(f" ({phase})")
    text.append(f"  {status.rate:,.0f} cycles/s  process {status.pid}")
    if status.generation > 1:
        text.append(f"  started {status.generation} times", "yellow")
    return text


def _times(status: Status) -> Table:
    table = Table(box=None, padding=(0, 2), title_justify="left")
    for column in ("µs", "p50", "p99", "p99.9", "max", "since start p99.9", "max"):
        table.add_column(column, justify="left" if column == "µs" else "right")
    for name, label in (
        ("wake", "woken late by"),
        ("ready", "ready after waking"),
        ("latency", "reading to estimate"),
    ):
        table.add_row(label, *_four(getattr(status.lately, name)), *_two(status.since, name))
    return table


def _four(found: Quantiles | None) -> list[str]:
    if found is None:
        return ["-"] * 4
    return [_micro(each) for each in (found.p50, found.p99, found.p999, found.max)]


def _two(timing: Timing, name: str) -> list[str]:
    found: Quantiles | None = getattr(timing, name)
    return ["-", "-"] if found is None else [_micro(found.p999), _micro(found.max)]


def _micro(seconds: float) -> str:
    return f"{seconds * 1e6:,.0f}"


def _contacts(rows: list[dict[str, Any]]) -> Table:
    table = Table(box=None, padding=(0, 2))
    heads = ("contact", "patch", "force N", "x mm", "y mm", "z mm", "area mm²", "peak kPa", "age s")
    for column in heads:
        table.add_column(column, justify="left" if column == "patch" else "right")
    for row in rows[:12]:
        force = f"{row['normal_force']:.2f}"
        if row["force_std"] is not None:
            force += f" ± {row['force_std']:.2f}"
        place = [f"{each * 1e3:.1f}" for each in row["position"]]
        table.add_row(
            str(row["track"]),
            row["patch"],
            force,
            *place,
            f"{row['area'] * 1e6:.0f}",
            f"{row['peak_pressure'] * 1e-3:.1f}",
            f"{row['age']:.1f}",
        )
    if not rows:
        table.add_row("-", "nothing touches the skin")
    return table


def _patches(status: Status) -> Table | None:
    told = [each for each in status.patches if each["answer"] != "idle"]
    if len(status.patches) == 1 and not (told and told[0]["answer"] == "missing"):
        told = status.patches
    if not told:
        return None
    table = Table(box=None, padding=(0, 2))
    for column in ("patch", "answer", "nodes a side", "taxels left out", "newest reading"):
        table.add_column(column, justify="left" if column in ("patch", "answer") else "right")
    for row in told[:MOST_PATCHES]:
        age = "never" if row["age"] is None else f"{row['age'] * 1e3:,.0f} ms ago"
        style = "red" if row["answer"] == "missing" else ""
        rung, left_out = str(row["rung"] or "-"), str(row["invalid"])
        table.add_row(row["name"], row["answer"], rung, left_out, age, style=style)
    return table


def _sources(status: Status) -> Text:
    text = Text()
    for name, counts in status.sources.items():
        text.append(f" {name}: {counts['received']:,} messages, {counts['readings']:,} readings")
        for what in ("lost", "overflowed", "malformed", "foreign", "duplicated", "swapped"):
            if counts[what]:
                text.append(f", {counts[what]:,} {what}", "yellow")
        if counts["reopened"] or counts["down_ns"]:
            down = counts["down_ns"] * 1e-9
            text.append(f", came back {counts['reopened']} times, away {down:.1f} s", "yellow")
        text.append("\n")
    text.append(f" {status.since.cycles:,} cycles, {status.since.late:,} late, ")
    text.append(f"{status.lost:,} messages lost", "" if not status.lost else "yellow")
    recorder = status.beside.get("recorder")
    if recorder:
        text.append(f"\n recording {recorder['path']}: {recorder['bytes_written'] / 1e6:,.1f} MB")
        if recorder.get("dropped_bytes") or recorder.get("failing"):
            text.append(f"  {recorder['dropped_bytes']:,} bytes dropped", "red")
    return text
