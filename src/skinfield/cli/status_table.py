"""Table of a running skin in the terminal: 80 columns are enough, and nothing jumps."""

import time
from typing import Any

from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from skinfield.cli.report import NONE, Column, in_scale, table, table_of
from skinfield.loop.realtime import Quantiles
from skinfield.loop.status import LiveStatus
from skinfield.loop.status_text import start_in_words
from skinfield.plot import duration

NARROW, NAME = 80, 15  # columns of a terminal, and of them for a patch's name
STYLES = {"running": "green", "calibrating": "yellow", "starting": "yellow"}
TROUBLES = ("lost", "overflowed", "malformed", "foreign", "duplicated", "swapped")
RECENT = 60.0  # s that the end of an engine is reported
FRAME = 15  # lines around contacts, patches, events and sources
LOOK: dict[str, Any] = {"box": None, "padding": (0, 0, 0, 1)}
CONTACT = (
    Column("force N", "normal_force", decimals=2, width=7),
    Column("± N", "force_std", decimals=2, width=5),
    Column("x mm", "x", 1e3, 1, width=6), Column("y mm", "y", 1e3, 1, width=6),
    Column("z mm", "z", 1e3, 1, width=6), Column("mm²", "area", 1e6, 0, width=5),
    Column("shape", "what", width=8), Column("age s", "age", 1.0, 1, width=7),
)  # fmt: skip
PATCH = (
    Column("answer", "answer", width=8), Column("force N", "force", decimals=2, width=7),
    Column("contacts", "contacts", decimals=0, width=8),
    Column("nodes", "rung", decimals=0, width=5),
    Column("left out", "invalid", decimals=0, width=8),
    Column("mean of", "readings", decimals=0, width=7), Column("age ms", "age", 1e3, 0, width=8),
)  # fmt: skip


def status_table(status: LiveStatus, width: int = NARROW, height: int | None = None) -> Group:
    """Everything, in so many columns and, if given, lines of the screen.

    Patches' names are cut in the middle where the width is too little; contacts and patches that
    do not fit into the height are counted instead.
    """
    foot = _events(status) + _sources(status)
    contacts = sorted(status.contacts, key=lambda row: -row["normal_force"])
    patches = [each for each in status.patches if _has_row(status, each)]
    patches.sort(key=lambda row: (not _is_gone(status, row), -row["force"]))
    above, below = len(contacts), len(patches)
    if height is not None:
        room = height - FRAME - len(foot)
        below = min(below, max(room - above, room // 2))
        above = min(above, room - below)
    longest = max((len(each["name"]) for each in status.patches), default=0)
    letters = min(max(longest, 5), NAME + max(width - NARROW, 0))
    parts = (
        [_headline(status), _times(status)],
        _contacts(status, contacts, above, letters),
        _patches(status, patches, below, letters),
        foot,
    )
    return Group(*(line for part in parts for line in [*part, _line()]))


def draw(screen: Live, status: LiveStatus) -> None:
    """Show a skin on the whole of a screen."""
    size = screen.console.size
    screen.update(status_table(status, size.width, size.height), refresh=True)


def _line(text: str = "", style: str = "") -> Text:
    return Text(text, style, no_wrap=True, overflow="crop")


def _headline(status: LiveStatus) -> Text:
    text = _line()
    text.append(f" {status.name} ", "bold")
    text.append(status.state, STYLES.get(status.state, "red bold"))
    if status.state in STYLES and (start := start_in_words(status.notes)):
        text.append(f": {start}", "yellow")
    text.append(f"  {status.rate:,.0f} cycles/s")
    if status.relative:
        text.append("  forces relative", "yellow")
    if status.pid:  # a replay has no process
        text.append(f"  process {status.pid}")
    if status.generation > 1:
        text.append(f"  started {status.generation} times", "yellow")
    return text


def _times(status: LiveStatus) -> Table:
    heads = ("p50", "p99", "p99.9", "max", "since start\np99.9", "max")
    made = table(None, (f"in the last {status.seconds:.1f} s",), heads, **LOOK)
    for column in made.columns:
        column.min_width, column.no_wrap = 8, True
    for name, label in (
        ("wake", "woken late by"),
        ("ready", "ready after waking"),
        ("latency", "reading to estimate"),
    ):
        four = _durations(getattr(status.lately, name), ("p50", "p99", "p999", "max"))
        two = _durations(getattr(status.since, name), ("p999", "max"))
        made.add_row(label, *four, *two)
    return made


def _durations(times: Quantiles | None, names: tuple[str, ...]) -> list[str]:
    return [NONE if times is None else duration(getattr(times, name)) for name in names]


def _contacts(
    status: LiveStatus, contacts: list[dict[str, Any]], room: int, letters: int
) -> list[Table | Text]:
    """The strongest contacts; the others counted."""
    old = {each["name"] for each in status.patches if _is_old(status, each)}
    rows = [
        row
        | dict(zip("xyz", row["position"], strict=True))
        | {"style": "red" if row["patch"] in old else ""}
        | {"what": ("one?" if row["maybe"] == 1 else "two?") if row["maybe"] else row["shape"]}
        for row in contacts[:room]
    ]
    columns: tuple[Column, ...] = (
        Column("no.", "track", decimals=0, width=5),
        Column("patch", "patch", width=letters),
    )
    columns = (*columns, *in_scale(CONTACT, status.relative))
    lines: list[Table | Text] = [table_of(None, rows, columns, **LOOK)]
    if rest := contacts[room:]:
        force = sum(row["normal_force"] for row in rest)
        unit = "(relative)" if status.relative else "N"
        lines.append(_line(f" {len(rest)} more, {force:.2f} {unit} in all", "bold"))
    if not contacts:
        known = any(each["answer"] != "missing" for each in status.patches)
        words = "nothing touches the skin" if known else "not known: no patch has an answer"
        lines.append(_line(f" {words}", "dim"))
    return lines


def _is_old(status: LiveStatus, patch: dict[str, Any]) -> bool:
    """Whether what was published of a patch is not what is there now."""
    return status.state != "running" or patch["answer"] == "missing" or patch["stale"]


def _is_gone(status: LiveStatus, patch: dict[str, Any]) -> bool:
    """Whether its readings stay away although the engine runs."""
    return status.state == "running" and _is_old(status, patch)


def _has_row(status: LiveStatus, patch: dict[str, Any]) -> bool:
    if len(status.patches) == 1:
        return True
    return patch["answer"] not in ("idle", "missing") or _is_gone(status, patch)


def _patches(
    status: LiveStatus, patches: list[dict[str, Any]], room: int, letters: int
) -> list[Table | Text]:
    """Patches that are touched or missing; all of them counted."""
    lines: list[Table | Text] = []
    if patches:
        bad = status.state in ("running", "failed")
        nothing = dict.fromkeys(("force", "contacts", "rung", "readings"))
        rows = [
            row
            | (nothing if row["answer"] == "missing" else {})
            | {"style": "red" if bad and _is_old(status, row) else ""}
            for row in patches[:room]
        ]
        its = in_scale(PATCH, status.relative)
        columns = (Column("patch", "name", width=letters), *its)
        lines.append(table_of(None, rows, columns, **LOOK))
    answers = [each["answer"] for each in status.patches]
    missing, idle = answers.count("missing"), answers.count("idle")
    count = "1 patch" if len(answers) == 1 else f"{len(answers)} patches"
    text = _line(f" {count}: {len(answers) - missing - idle} touched, {idle} idle, ")
    text.append(f"{missing} missing", "red" if missing and status.state == "running" else "")
    if len(patches) > room:
        text.append(f"; {len(patches) - room} not shown")
    return [*lines, text]


def _events(status: LiveStatus) -> list[Text]:
    """The last end of an engine, if that was not long ago."""
    events = (status.sidecars.get("supervisor") or {}).get("events", [])
    ends = [each for each in events if each[1] in ("failed", "hung")]
    if not ends or time.time_ns() - ends[-1][0] > RECENT * 1e9:
        return []
    stamp = time.strftime("%H:%M:%S", time.localtime(ends[-1][0] * 1e-9))
    return [_line(f" {stamp} engine {ends[-1][1]}: {ends[-1][2]}", "yellow")]


def _sources(status: LiveStatus) -> list[Text]:
    lines = [_source(status, name, counts) for name, counts in status.sources.items()]
    text = _line(f" {status.since.cycles:,} cycles, ")
    text.append(f"{status.since.late:,} late, ", "yellow" if status.since.late else "")
    text.append(f"{status.lost:,} messages lost", "yellow" if status.lost else "")
    recorder = status.sidecars.get("recorder")
    return [*lines, text] + ([_recorder(recorder)] if recorder else [])


def _source(status: LiveStatus, name: str, counts: dict[str, int]) -> Text:
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


def _recorder(state: dict[str, Any]) -> Text:
    text = _line(f" recording {state['bytes_written'] / 1e6:,.1f} MB")
    if state.get("dropped_bytes") or state.get("failing"):
        text.append(f", {state.get('dropped_bytes', 0):,} bytes dropped", "red")
        text.append(f" {state.get('failure', '')}", "red")
    text.append(f" into {state['path']}")
    return text
