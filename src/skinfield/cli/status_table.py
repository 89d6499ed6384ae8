"""A running skin as a table in the terminal: 80 columns are enough, and nothing jumps."""

import time
from typing import Any, NamedTuple

from rich.console import Group
from rich.text import Text

from skinfield.loop.realtime import Quantiles
from skinfield.loop.status import Status
from skinfield.loop.status_text import start_in_words

NARROW = 80  # columns, for which the widths below are made
STYLES = {"running": "green", "calibrating": "yellow", "starting": "yellow"}
FEWEST = 3  # rows of a table, however low the screen
TROUBLES = ("lost", "overflowed", "malformed", "foreign", "duplicated", "swapped")
RECENT = 60.0  # s that the end of an engine is told
LONG = 4000  # rows, where nothing limits them


class Column(NamedTuple):
    """Of a table: two lines of heading, and its width."""

    name: str
    unit: str
    width: int
    left: bool = False

    def cell(self, text: str) -> str:
        """Text as wide as the column; a name that is too long for it loses its middle."""
        width = self.width
        return shortened(text, width).ljust(width) if self.left else text.rjust(width)


TIMES = (
    Column("", "", 20, left=True),
    *(Column("", each, 8) for each in ("p50", "p99", "p99.9", "max")),
    Column("since start", "p99.9", 12),
    Column("", "max", 8),
)
PATCH = Column("", "patch", 11, left=True)
CONTACTS = (
    Column("", "no.", 6),
    PATCH,
    Column("force" + " " * 8, "N ±     N", 13),
    Column("place mm", "x      y      z", 20),
    Column("area", "mm²", 5),
    Column("peak", "kPa", 6),
    Column("age", "s", 6),
)
PATCHES = (
    PATCH,
    Column("", "answer", 8, left=True),
    Column("force", "N", 8),
    Column("", "contacts", 8),
    Column("grid", "nodes", 7),
    Column("taxels", "left out", 8),
    Column("newest reading", "ms ago", 14),
)


def status_table(status: Status, width: int = NARROW, height: int | None = None) -> Group:
    """Everything, in so many columns and, if given, lines of the screen.

    Patches' names are cut in the middle where the width is too little; contacts and patches that
    do not fit into the height are counted instead.
    """
    head, foot = _headline(status) + _times(status), _events(status) + _sources(status)
    room = LONG if height is None else height - len(head) - len(foot) - 6  # headings, counts
    told = [each for each in status.patches if _worth_a_row(status, each)]
    below = min(len(told), max(room - len(status.contacts), room // 2, FEWEST))
    above = _contacts(status, width, max(room - below, FEWEST))
    parts = [head, above, _patches(status, told, width, below), foot]
    used = sum(map(len, parts))
    between = [_line()] if height is None or used + len(parts) <= height else []
    return Group(*(line for part in parts for line in [*part, *between]))


def shortened(text: str, width: int) -> str:
    """Text of at most so many letters: both ends, which tell patches of one robot apart."""
    if len(text) <= width:
        return text
    end = width // 2
    return f"{text[: width - end - 1]}~{text[-end:]}"


def _line(text: str = "", style: str = "") -> Text:
    return Text(text, style, no_wrap=True, overflow="crop")


def _row(columns: tuple[Column, ...], cells: list[str], style: str = "", gap: str = "  ") -> Text:
    parts = (column.cell(cell) for column, cell in zip(columns, cells, strict=True))
    return _line(" " + gap.join(parts), style)


def _heading(columns: tuple[Column, ...], gap: str = "  ") -> list[Text]:
    return [
        _row(columns, [each.name for each in columns], "bold", gap),
        _row(columns, [each.unit for each in columns], "bold", gap),
    ]


def _fitted(columns: tuple[Column, ...], names: list[str], width: int) -> tuple[Column, ...]:
    """Columns with as much room for the patches' names as there is and they need."""
    longest = max(map(len, names), default=0)
    spare = max(width - NARROW, 0)
    wide = PATCH._replace(width=min(max(longest, PATCH.width), PATCH.width + spare))
    return tuple(wide if each is PATCH else each for each in columns)


def _headline(status: Status) -> list[Text]:
    text = _line()
    text.append(f" {status.name} ", "bold")
    text.append(status.state, STYLES.get(status.state, "red bold"))
    if status.state in STYLES and (start := start_in_words(status.notes)):
        text.append(f": {start}", "yellow")
    text.append(f"  {status.rate:,.0f} cycles/s")
    if status.pid:  # a replay has no process
        text.append(f"  process {status.pid}")
    if status.generation > 1:
        text.append(f"  started {status.generation} times", "yellow")
    return [text]


def _times(status: Status) -> list[Text]:
    columns = (TIMES[0]._replace(unit=f"µs, last {status.seconds:.1f} s"), *TIMES[1:])
    lines = _heading(columns, " ")
    for name, label in (
        ("wake", "woken late by"),
        ("ready", "ready after waking"),
        ("latency", "reading to estimate"),
    ):
        four = _micros(getattr(status.lately, name), ("p50", "p99", "p999", "max"))
        two = _micros(getattr(status.since, name), ("p999", "max"))
        lines.append(_row(columns, [label, *four, *two], gap=" "))
    return lines


def _micros(found: Quantiles | None, names: tuple[str, ...]) -> list[str]:
    values = [None if found is None else getattr(found, name) for name in names]
    return ["-" if value is None else _micro(value) for value in values]


def _micro(seconds: float) -> str:
    return f"{seconds * 1e6:,.0f}" if seconds < 0.9999995 else f"{seconds:.1f} s"


def _contacts(status: Status, width: int, room: int) -> list[Text]:
    """Contacts by falling force."""
    rows = sorted(status.contacts, key=lambda row: -row["normal_force"])
    columns = _fitted(CONTACTS, [each["name"] for each in status.patches], width)
    lines = _heading(columns)
    old = {each["name"] for each in status.patches if _bad(status, each)}
    for row in rows[:room]:
        style = "red" if row["patch"] in old else ""
        lines.append(_row(columns, _contact(row), style))
    if len(rows) > room:
        force = sum(row["normal_force"] for row in rows[room:])
        lines.append(_line(f"        {len(rows) - room} more, {force:.2f} N in all", "bold"))
    if not rows:
        known = any(each["answer"] != "missing" for each in status.patches)
        said = "nothing touches the skin" if known else "not known: no patch has an answer"
        lines.append(_line(f"      -  {said}", "dim"))
    return lines


def _contact(row: dict[str, Any]) -> list[str]:
    std = " " * 7 if row["force_std"] is None else f"± {_three(row['force_std']):>5}"
    return [
        str(row["track"]),
        row["patch"],
        f"{_three(row['normal_force'])} {std}",
        " ".join(f"{each * 1e3:6.1f}" for each in row["position"]),
        f"{row['area'] * 1e6:.0f}",
        _three(row["peak_pressure"] * 1e-3, 1),
        _three(row["age"], 1),
    ]


def _three(value: float, decimals: int = 2) -> str:
    """A number in five letters: fewer decimals as it grows."""
    most = 2 if value < 99.995 else 1 if value < 999.95 else 0
    return f"{value:.{min(decimals, most)}f}"


def _bad(status: Status, patch: dict[str, Any]) -> bool:
    """Whether what is told of a patch is not what is there now."""
    return status.state != "running" or patch["answer"] == "missing" or patch["stale"]


def _worth_a_row(status: Status, patch: dict[str, Any]) -> bool:
    if len(status.patches) == 1:
        return True
    return patch["answer"] not in ("idle", "missing") or _gone(status, patch)


def _gone(status: Status, patch: dict[str, Any]) -> bool:
    """Whether its readings stay away although the engine runs."""
    return status.state == "running" and (patch["answer"] == "missing" or patch["stale"])


def _patches(status: Status, told: list[dict[str, Any]], width: int, room: int) -> list[Text]:
    """Patches that are touched or missing, those that are missing first; the others counted."""
    columns = _fitted(PATCHES, [each["name"] for each in status.patches], width)
    told = sorted(told, key=lambda row: (not _gone(status, row), -row["force"]))
    lines = _heading(columns) if told else []
    for row in told[:room]:
        style = "red" if _bad(status, row) and status.state in ("running", "failed") else ""
        lines.append(_row(columns, _patch(row), style))
    answers = [each["answer"] for each in status.patches]
    missing = answers.count("missing")
    text = _line(f" {len(answers)} patches" if len(answers) != 1 else " 1 patch")
    text.append(f": {len(answers) - missing - answers.count('idle')} touched, ")
    text.append(f"{answers.count('idle')} idle, ")
    text.append(f"{missing} missing", "red" if missing and status.state == "running" else "")
    if len(told) > room:
        text.append(f"; {len(told) - room} not shown")
    return [*lines, text]


def _patch(row: dict[str, Any]) -> list[str]:
    known = row["answer"] != "missing"
    return [
        row["name"],
        row["answer"],
        _three(row["force"]) if known else "-",
        str(row["contacts"]) if known else "-",
        f"{row['rung']}×{row['rung']}" if row["rung"] else "-",
        str(row["invalid"]),
        "never" if row["age"] is None else f"{row['age'] * 1e3:,.0f}",
    ]


def _events(status: Status) -> list[Text]:
    """The last end of an engine, if that was not long ago."""
    told = (status.sidecars.get("supervisor") or {}).get("events", [])
    ends = [each for each in told if each[1] in ("failed", "hung")]
    if not ends or time.time_ns() - ends[-1][0] > RECENT * 1e9:
        return []
    stamp = time.strftime("%H:%M:%S", time.localtime(ends[-1][0] * 1e-9))
    return [_line(f" {stamp} engine {ends[-1][1]}: {ends[-1][2]}", "yellow")]


def _sources(status: Status) -> list[Text]:
    lines = [_source(status, name, counts) for name, counts in status.sources.items()]
    text = _line(f" {status.since.cycles:,} cycles, ")
    text.append(f"{status.since.late:,} late, ", "yellow" if status.since.late else "")
    text.append(f"{status.lost:,} messages lost", "yellow" if status.lost else "")
    recorder = status.sidecars.get("recorder")
    return [*lines, text] + ([_recorder(recorder)] if recorder else [])


def _source(status: Status, name: str, counts: dict[str, int]) -> Text:
    text = _line(f" {name}: ")
    lately = status.sources_lately[name]["received"]
    if lately:
        text.append(f"{lately / status.seconds:,.0f} messages/s")
    else:
        text.append("silent", "red bold" if status.state == "running" else "")
    text.append(f", {counts['received']:,} in all")
    for what in TROUBLES:
        if counts[what]:
            text.append(f", {counts[what]:,} {what}", "yellow")
    if counts["reopened"] or counts["down_ns"]:
        down = counts["down_ns"] * 1e-9
        text.append(f", back {counts['reopened']} times, away {down:.1f} s", "yellow")
    return text


def _recorder(told: dict[str, Any]) -> Text:
    text = _line(f" recording {told['bytes_written'] / 1e6:,.1f} MB")
    if told.get("dropped_bytes") or told.get("failing"):
        text.append(f", {told.get('dropped_bytes', 0):,} bytes dropped", "red")
        text.append(f" {told.get('failure', '')}", "red")
    text.append(f" into {told['path']}")
    return text
