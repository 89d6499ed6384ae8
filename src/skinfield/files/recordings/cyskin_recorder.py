"""CySkin recordings of SkinRecorder: `sample time n uid value uid value ...` below two counts.

The first two lines are the number of devices and of taxels. The columns are those of the first
reading, by uid; a line that has the same uids in another order is put in order. Times are seconds;
whole numbers that step by 5 or more are taken as milliseconds, and noted.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats
from skinfield.files.recordings.cyskin_text import repeats, uids_from_text
from skinfield.files.recordings.head import Head, chosen, is_whole, usual_decimals, usual_width
from skinfield.files.recordings.lines import Block, Grammar, Tally
from skinfield.files.recordings.stream import Check, Contents


def matches(head: Head) -> bool:
    """Whether two lines of one whole number stand at the top."""
    tokens = [line.split() for _, line in head.numbered()[:2]]
    return len(tokens) == 2 and all(len(t) == 1 and is_whole(t[0]) for t in tokens)


def contents(head: Head, columns: Sequence[int | str] | None) -> Contents:
    """What a recording holds whose head `matches`."""
    lines = head.numbered()
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
    uid = uids_from_text(head, lines[2 + first][0], rows[first][3::2])
    grammar = Grammar(
        width=width,
        stamp=1,
        expected=f"sample, time, {count}, then uid and value of {count} taxels",
        decimals=usual_decimals(rows),
        skip=skip,
    )
    keep = chosen(columns, count, head.path)
    return Contents(
        path=head.path, grammar=grammar, keep=4 + 2 * keep, check=_ordered_like(uid),
        uid=uid[keep], source=str(head.path), notes=repeats(uid), clock_is_stated=False,
    )  # fmt: skip


def _ordered_like(uid: NDArray[np.uint64]) -> Check:
    """Check that brings the values of every line into the order of `uid`, or skips the line."""
    wanted: Floats = uid.astype(np.float64)  # as the lines are read; exact below 2**53
    order = np.argsort(wanted, kind="stable")

    def check(block: Block, tally: Tally) -> Block:
        table, good = block.table, np.ones(len(block.line), bool)
        wrong = (table[:, 3::2] != wanted).any(axis=1) | (table[:, 2] != len(uid))
        for row in np.flatnonzero(wrong):
            other = np.argsort(table[row, 3::2], kind="stable")
            if table[row, 2] != len(uid) or (table[row, 3::2][other] != wanted[order]).any():
                tally.skip(int(block.line[row]), "holds other uids than the first line")
                good[row] = False
                continue
            values = np.empty(len(uid))
            values[order] = table[row, 4::2][other]
            table[row, 4::2] = values
        if good.all():
            return block
        return replace(
            block, line=block.line[good], stamp_ns=block.stamp_ns[good], table=table[good]
        )

    return check
