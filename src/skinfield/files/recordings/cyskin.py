"""CySkin recordings as text, of two kinds.

Of a session: a line of uids, then `sample time value value ...`, one value per uid. Of
SkinRecorder: the number of devices and of taxels on a line each, then
`sample time n uid value uid value ...`; the columns are those of the first reading, by uid, and a
line that has the same uids in another order is put in order.

Times are seconds; whole numbers that step by 5 or more are taken as milliseconds, and noted. The
uid is module << 4 | sensor. Sensor 0 of a module is its temperature: it stays a column here, and
falls away when the columns are matched with a layout, which has no such taxel.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats
from skinfield.files.recordings.head import Magic, is_number, is_whole, usual_decimals, usual_width
from skinfield.files.recordings.lines import RecordingStream

MILLISECONDS = "times are whole numbers far apart: taken as milliseconds"
Uids = NDArray[np.uint64]


def text(head: Magic) -> RecordingStream | None:
    """What a session's recording holds; None of another file."""
    lines = head.numbered()
    tokens = lines[0][1].split() if lines else []
    if not tokens or not all(map(is_whole, tokens)):
        return None
    line, width = lines[0][0], len(tokens) + 2
    rows = head.rows(line, None)
    if not rows:  # nothing but uids, unless it is a log of two numbers and less
        fits = len(tokens) > 3
    else:
        is_cut = len(rows) == 1 and 3 < width > len(rows[0])  # a recording of one short line
        fits = all(map(is_number, rows[0][:3])) and (is_cut or usual_width(rows) == width)
    if not fits:
        return None
    uid = _uids(head, line, tokens)
    return RecordingStream(
        path=head.path,
        width=width,
        expected=f"a sample number, a time and {len(uid)} values, one per uid of line {line}",
        keep=2 + np.arange(len(uid)),
        skip=line,
        **_known(head, rows, uid),
    )


def recorder(head: Magic) -> RecordingStream | None:
    """What a recording of SkinRecorder holds; None of another file."""
    lines = head.numbered()
    tokens = [line.split() for _, line in lines[:2]]
    if len(tokens) < 2 or not all(len(each) == 1 and is_whole(each[0]) for each in tokens):
        return None
    skip, taxels = lines[1]
    rows = head.rows(skip, None)
    width = usual_width(rows)
    count = (width - 3) // 2
    if count < 1 or width != 3 + 2 * int(taxels[:9]):
        raise FileError(
            f"{head.path}:{skip}: {taxels[:24]} taxels are announced, but lines hold {width} "
            "numbers, expected 3 + 2 per taxel: sample, time, n, then uid and value of each"
        )
    first = next(k for k, row in enumerate(rows) if len(row) == width)
    uid = _uids(head, lines[2 + first][0], rows[first][3::2])
    return RecordingStream(
        path=head.path,
        width=width,
        expected=f"sample, time, {count}, then uid and value of {count} taxels",
        keep=4 + 2 * np.arange(count),
        skip=skip,
        check=_ordered_like(uid),
        **_known(head, rows, uid),
    )


def _known(head: Magic, rows: list[list[str]], uid: Uids) -> dict[str, Any]:
    """What both kinds say of their columns and times."""
    slow, notes = _are_milliseconds(rows), _repeats(uid)
    return {
        "scale": 10**6 if slow else 10**9,
        "decimals": usual_decimals(rows),
        "uid": uid,
        "source": str(head.path),
        "notes": (*notes, MILLISECONDS) if slow else notes,
    }


def _are_milliseconds(rows: list[list[str]]) -> bool:
    """Whether the times are whole numbers that mostly step by 5 or more.

    Recorders that write a time in whole milliseconds do not say so; no skin is read that slowly.
    """
    times = np.array([row[1] for row in rows if is_number("".join(row[1:2]))], np.float64)
    if len(times) < 2 or not np.isfinite(times).all() or (times % 1).any():
        return False
    return 2 * int(np.count_nonzero(np.diff(times) < 5)) < len(times) - 1


def _uids(head: Magic, line: int, tokens: list[str]) -> Uids:
    """Uids (C,) from their digits; raises FileError for one of more than 64 bits."""
    for token in tokens:
        if not is_whole(token) or len(token) > 20 or int(token) >= 2**64:
            raise FileError(
                f"{head.path}:{line}: uid {token[:24]!r} is not a whole number below 2**64, "
                "expected module << 4 | sensor"
            )
    return np.array([int(token) for token in tokens], np.uint64)


def _repeats(uid: Uids) -> tuple[str, ...]:
    """A sentence on uids that more than one column has."""
    values, count = np.unique(uid, return_counts=True)
    twice = values[count > 1]
    if not len(twice):
        return ()
    shown = ", ".join(map(str, twice[:3].tolist()))
    return (f"{len(twice)} uids stand over more than one column ({shown}): the first counts",)


def _ordered_like(uid: Uids) -> Callable[[Floats], NDArray[np.bool_]]:
    """Check that brings the values of every line into the order of `uid`, if it has the same."""
    wanted: Floats = uid.astype(np.float64)  # as the lines are read; exact below 2**53
    order = np.argsort(wanted, kind="stable")

    def check(table: Floats) -> NDArray[np.bool_]:
        same = np.asarray(table[:, 2] == len(uid))
        for row in np.flatnonzero(same & (table[:, 3::2] != wanted).any(axis=1)):
            other = np.argsort(table[row, 3::2], kind="stable")
            same[row] = (table[row, 3::2][other] == wanted[order]).all()
            table[row, 4 + 2 * order] = table[row, 4::2][other]
        return same

    return check
