"""CySkin text recordings: a line of uids, then `sample time value value ...`, one value per uid.

Times are seconds; whole numbers that step by 5 or more are taken as milliseconds, and noted. The
uid is module << 4 | sensor. Sensor 0 of a module is its temperature: it stays a column here, and
falls away when the columns are matched with a layout, which has no such taxel.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError
from skinfield.files.recordings.head import (
    Head,
    chosen,
    is_number,
    is_whole,
    usual_decimals,
    usual_width,
)
from skinfield.files.recordings.lines import Grammar
from skinfield.files.recordings.stream import Contents


def matches(head: Head) -> bool:
    """Whether whole numbers stand above lines of two numbers more."""
    lines = head.numbered()
    first = lines[0][1].split() if lines else []
    if not first or not all(map(is_whole, first)):
        return False
    if len(lines) == 1:  # nothing but uids, unless it is a log of two numbers and less
        return len(first) > 3
    rows = head.rows(lines[0][0], None)
    if not all(map(is_number, rows[0][:3])):
        return False
    is_cut = len(rows) == 1 and 3 < len(first) + 2 > len(rows[0])  # a recording of one short line
    return is_cut or usual_width(rows) == len(first) + 2


def contents(head: Head, columns: Sequence[int | str] | None) -> Contents:
    """What a recording holds whose head `matches`."""
    line, text = head.numbered()[0]
    uid = uids_from_text(head, line, text.split())
    width = len(uid) + 2
    grammar = Grammar(
        width=width,
        stamp=1,
        expected=f"a sample number, a time and {len(uid)} values, one per uid of line {line}",
        decimals=usual_decimals(head.rows(line, None)),
        skip=line,
    )
    keep = chosen(columns, len(uid), head.path)
    return Contents(
        path=head.path, grammar=grammar, keep=2 + keep, uid=uid[keep], source=str(head.path),
        notes=repeats(uid), clock_is_stated=False,
    )  # fmt: skip


def uids_from_text(head: Head, line: int, tokens: list[str]) -> NDArray[np.uint64]:
    """Uids (C,) from their digits; raises FileError for one of more than 64 bits."""
    for token in tokens:
        if not is_whole(token) or len(token) > 20 or int(token) >= 2**64:
            raise FileError(
                f"{head.path}:{line}: uid {token[:24]!r} is not a whole number below 2**64, "
                "expected module << 4 | sensor"
            )
    return np.array([int(token) for token in tokens], np.uint64)


def repeats(uid: NDArray[np.uint64]) -> tuple[str, ...]:
    """A sentence on uids that more than one column has."""
    values, count = np.unique(uid, return_counts=True)
    twice = values[count > 1]
    if not len(twice):
        return ()
    shown = ", ".join(map(str, twice[:3].tolist()))
    return (f"{len(twice)} uids stand over more than one column ({shown}): the first counts",)
