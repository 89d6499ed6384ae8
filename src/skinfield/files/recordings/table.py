"""CSV recordings of one's own: comments, a line of names, then one line per reading.

    # unit = dC/C0
    # source = left hand, trial 3
    time_s,taxel_0,taxel_1,taxel_2
    0.000,0.0012,0.0100,

The time is `time_s` (seconds) or `stamp_ns` (nanoseconds). Values stand under `taxel_<channel>`, or
under `uid_<uid>` or the bare uid, decimal or 0x; channels without a column are missing. Columns
named `reading`, `sample`, `index` or not at all are left out. Delimiters are `,` `;` tab or spaces.
An empty place is a missing value. The unit is one of `skinfield.skin.reading.UNITS`, "count" if no
comment says it.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, InputError
from skinfield.files.recordings.head import Head, is_number, usual_decimals
from skinfield.files.recordings.lines import Contents
from skinfield.skin.reading import UNITS

TIMES = {"time_s": 10**9, "stamp_ns": 1}  # ns in the unit
IGNORED = {"", "reading", "sample", "index", "seq", "unnamed: 0"}
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")  # of a force/torque sensor; three do, too
CHANNELS = 1 << 20  # more than any robot has: a typing error, not a port
LAYOUT = "a line of names such as time_s,taxel_0,taxel_1 above lines of numbers"


@dataclass(frozen=True)
class Names:
    """The line of names: its line number, the delimiter, and the names without quotes."""

    line: int
    delimiter: str | None
    names: tuple[str, ...]


def names_of(head: Head) -> Names | None:
    """The line of names, if the first data line holds a time's name."""
    lines = head.numbered()
    if not lines:
        return None
    number, text = lines[0]
    delimiter = next((d for d in (",", ";", "\t") if d in text), None)
    names = tuple(name.strip().strip("\"'").strip() for name in text.split(delimiter))
    return Names(number, delimiter, names) if set(names) & set(TIMES) else None


def contents(head: Head, columns: Sequence[int | str] | None) -> Contents | None:
    """What a table holds; None of a file whose first line that is no comment names no time."""
    header = names_of(head)
    if header is None:
        return None
    time = next(name for name in TIMES if name in header.names)
    at, uid, channel = _columns(head, header, columns)
    unit, source, notes = _comments(head, header.line)
    if _is_wrench([header.names[place] for place in at]):
        unit, notes = "N, N m", ()
    in_order = channel is None or np.array_equal(channel, np.arange(len(channel)))
    return Contents(
        path=head.path,
        width=len(header.names),
        stamp=header.names.index(time),
        scale=TIMES[time],
        expected=f"{len(header.names)} numbers, as line {header.line} names them",
        delimiter=header.delimiter,
        decimals=usual_decimals(head.rows(header.line, header.delimiter)),
        skip=header.line,
        keep=at,
        uid=uid,
        channel=None if in_order else channel,
        unit=unit,
        source=source,
        notes=notes,
    )


def _columns(
    head: Head, header: Names, columns: Sequence[int | str] | None
) -> tuple[NDArray[np.int64], NDArray[np.uint64] | None, NDArray[np.int64] | None]:
    """Places of the value columns, and their uids or their channels."""
    where = f"{head.path}:{header.line}"
    for name in header.names:
        if name.lower() not in IGNORED and header.names.count(name) > 1:
            raise FileError(f"{where}: column {name!r} stands there twice, expected each name once")
    values = [n for n in header.names if n.lower() not in IGNORED and n not in TIMES]
    if columns is not None:
        names = [_named(column, values, where) for column in columns]
        return np.array([header.names.index(n) for n in names], np.int64), _all_uids(names), None
    if not values:
        raise FileError(f"{where}: no column of values, expected {LAYOUT}")
    at = np.array([header.names.index(name) for name in values], np.int64)
    if _is_wrench(values):
        return at, None, None
    channels = [_channel(name) for name in values]
    if all(channel is not None for channel in channels):
        rows = np.array(channels, np.int64)
        if len(np.unique(rows)) < len(rows) or rows.max() >= CHANNELS:
            raise FileError(f"{where}: channels up to {rows.max()}, expected each once below 2**20")
        return at, None, rows
    uid = _all_uids(values)
    if uid is None:
        odd = next(n for n in values if _channel(n) is None and _uid(n) is None)
        odd = odd if len(odd) <= 40 else odd[:40] + "..."
        raise FileError(
            f"{where}: column {odd!r} is not a time, taxel_<channel> or uid_<uid>, expected "
            f"{LAYOUT}, or time_s,fx,fy,fz of a force sensor; "
            "to read other columns name them: columns=[...]"
        )
    return at, uid, None


def _is_wrench(values: Sequence[str]) -> bool:
    return tuple(name.lower() for name in values) in (WRENCH, WRENCH[:3])


def _named(column: int | str, values: list[str], where: str) -> str:
    if isinstance(column, str) and column in values:
        return column
    if not isinstance(column, str) and 0 <= int(column) < len(values):
        return values[int(column)]
    shown = ", ".join(values[:8]) + (", ..." if len(values) > 8 else "")
    raise InputError(
        f"columns holds {column!r}, expected names or places of value columns of {where}: {shown}"
    )


def _channel(name: str) -> int | None:
    match = re.fullmatch(r"taxel_(\d{1,9})", name, re.ASCII)
    return int(match.group(1)) if match else None


def _uid(name: str) -> int | None:
    match = re.fullmatch(r"(?:uid_)?(?:0x([0-9a-fA-F]{1,16})|(\d{1,20}))", name, re.ASCII)
    if not match:
        return None
    uid = int(match.group(1), 16) if match.group(1) else int(match.group(2))
    return uid if uid < 2**64 else None


def _all_uids(names: list[str]) -> NDArray[np.uint64] | None:
    uids = [uid for name in names if (uid := _uid(name)) is not None]
    return np.array(uids, np.uint64) if len(uids) == len(names) else None


def _comments(head: Head, header_line: int) -> tuple[str, str, tuple[str, ...]]:
    """Unit, source and a note where no unit is declared."""
    said = {}
    for number, line in enumerate(head.lines[: header_line - 1], 1):
        if match := re.match(r"#\s*(unit|source)\s*[:=]\s*(.*)", line):
            said[match.group(1)] = (number, match.group(2).strip())
    source = f"{head.path} ({said['source'][1]})" if "source" in said else str(head.path)
    if "unit" not in said:
        return "count", source, ("no comment `# unit = ...` is there: taken as count",)
    number, unit = said["unit"]
    if unit not in UNITS:
        raise FileError(
            f"{head.path}:{number}: unit {unit[:20]!r} is not known, expected one of "
            f"{', '.join(UNITS)}"
        )
    return unit, source, ()


def looks_like_numbers(head: Head) -> bool:
    """Whether the first line holds numbers with a delimiter: a table that lacks its names."""
    lines = head.numbered()
    tokens = re.split(r"[,;\t]", lines[0][1]) if lines else []
    return len(tokens) > 1 and all(is_number(token) for token in tokens)
