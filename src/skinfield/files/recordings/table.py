"""CSV recordings of one's own: comments, a line of names, then one line per reading.

    # unit = dC/C0
    # source = left hand, trial 3
    time_s,taxel_0,taxel_1,taxel_2
    0.000,0.0012,0.0100,

The time is `time_s` (seconds), `time_ms` (milliseconds) or `stamp_ns` (nanoseconds). Values stand
under `taxel_<channel>`, or under `uid_<uid>` or the bare uid, decimal or 0x; channels without a
column are missing. Columns named `reading`, `sample`, `index` or not at all are left out.
Delimiters are `,` `;` tab or spaces. An empty place is a missing value. The unit is one of
`skinfield.skin.reading.UNITS`, "count" if no comment says it.
"""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError
from skinfield.files.recordings.head import Magic, is_number, usual_decimals
from skinfield.files.recordings.lines import RecordingStream
from skinfield.skin.reading import UNITS

TIMES = {"time_s": 10**9, "time_ms": 10**6, "stamp_ns": 1}  # ns in the unit
IGNORED = {"", "reading", "sample", "index", "seq", "unnamed: 0"}
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")  # of a force/torque sensor; three do, too
CHANNELS = 1 << 20  # more than any robot has: a typing error, not a port
LAYOUT = "a line of names such as time_s,taxel_0,taxel_1 above lines of numbers"


def contents(head: Magic) -> RecordingStream | None:
    """What a table holds; None of a file whose first line that is no comment names no time."""
    lines = head.numbered()
    line, text = lines[0] if lines else (1, "")
    delimiter = next((d for d in (",", ";", "\t") if d in text), None)
    names = tuple(name.strip().strip("\"'").strip() for name in text.split(delimiter))
    if not set(names) & set(TIMES):
        return None
    time = next(name for name in TIMES if name in names)
    at, uid, channel = _columns(f"{head.path}:{line}", names)
    unit, source, notes = _comments(head, line)
    if _is_wrench([names[place] for place in at]):
        unit, notes = "N, N m", ()
    in_order = channel is None or np.array_equal(channel, np.arange(len(channel)))
    return RecordingStream(
        path=head.path,
        width=len(names),
        stamp=names.index(time),
        scale=TIMES[time],
        expected=f"{len(names)} numbers, as line {line} names them",
        delimiter=delimiter,
        decimals=usual_decimals(head.rows(line, delimiter)),
        skip=line,
        keep=at,
        uid=uid,
        channel=None if in_order else channel,
        unit=unit,
        source=source,
        notes=notes,
    )


def _columns(
    where: str, names: tuple[str, ...]
) -> tuple[NDArray[np.int64], NDArray[np.uint64] | None, NDArray[np.int64] | None]:
    """Places of the value columns, and their uids or their channels."""
    for name in names:
        if name.lower() not in IGNORED and names.count(name) > 1:
            raise FileError(f"{where}: column {name!r} stands there twice, expected each name once")
    values = [n for n in names if n.lower() not in IGNORED and n not in TIMES]
    if not values:
        raise FileError(f"{where}: no column of values, expected {LAYOUT}")
    at = np.array([names.index(name) for name in values], np.int64)
    if _is_wrench(values):
        return at, None, None
    channels, uids = [_channel(name) for name in values], [_uid(name) for name in values]
    if None not in channels:
        rows = np.array(channels, np.int64)
        if len(np.unique(rows)) < len(rows) or rows.max() >= CHANNELS:
            raise FileError(f"{where}: channels up to {rows.max()}, expected each once below 2**20")
        return at, None, rows
    if None not in uids:
        return at, np.array(uids, np.uint64), None
    odd = next((n for n in values if _channel(n) is None and _uid(n) is None), values[0])
    odd = odd if len(odd) <= 40 else odd[:40] + "..."
    raise FileError(
        f"{where}: column {odd!r} is not a time, taxel_<channel> or uid_<uid>, expected {LAYOUT}, "
        "or time_s,fx,fy,fz of a force sensor"
    )


def _is_wrench(values: Sequence[str]) -> bool:
    return tuple(name.lower() for name in values) in (WRENCH, WRENCH[:3])


def _channel(name: str) -> int | None:
    match = re.fullmatch(r"taxel_(\d{1,9})", name, re.ASCII)
    return int(match.group(1)) if match else None


def _uid(name: str) -> int | None:
    match = re.fullmatch(r"(?:uid_)?(?:0x([0-9a-fA-F]{1,16})|(\d{1,20}))", name, re.ASCII)
    if not match:
        return None
    uid = int(match.group(1), 16) if match.group(1) else int(match.group(2))
    return uid if uid < 2**64 else None


def _comments(head: Magic, header_line: int) -> tuple[str, str, tuple[str, ...]]:
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


def looks_like_numbers(head: Magic) -> bool:
    """Whether the first line holds numbers with a delimiter: a table that lacks its names."""
    lines = head.numbered()
    tokens = re.split(r"[,;\t]", lines[0][1]) if lines else []
    return len(tokens) > 1 and all(is_number(token) for token in tokens)
