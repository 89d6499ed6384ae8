"""Logs of yarpdatadumper: `sequence time [time received] value value ...` of any port of numbers.

A log is a folder that holds `data.log` and `info.log`. The time is the sender's where both are
there. Brackets of nested lists are taken as spaces. Logs of skin ports are raw counts; a port of
six numbers named `analog:o` is a force and torque. Logs of contact lists (`skin_events:o`) are told
apart here and read by `skinfield.wire.yarp`.
"""

import re

import numpy as np

from skinfield.errors import FileError
from skinfield.files.recordings.head import Magic, is_number, is_whole, usual_decimals, usual_width
from skinfield.files.recordings.lines import RecordingStream

BRACKETS = "()"
WRENCH = "N, N m"
LEAD = r"\d+\s+\d+\.\d+(\s+\d+\.\d+)?"  # number and times of a message
NO_CONTACT = re.compile(LEAD + r"(\s*\(\s*\))?")
SOME_CONTACT = re.compile(LEAD + r"\s+\(+\s*-?\d+(\s+-?\d+){3}\s*\)\s*\(")  # four, a place, ...


def contents(head: Magic) -> RecordingStream | None:
    """What a log holds.

    None of a file where not most lines begin with a whole number and a time, and hold a value.
    """
    if is_contact_list(head):
        raise FileError(
            f"{head.path} holds lists of contacts (skin_events), expected readings of taxels: "
            "`skinfield reconstruct` follows its contacts, skinfield.wire.yarp.open_contact_log "
            "reads them"
        )
    skip = preamble_of(head)
    rows = head.rows(skip, None, BRACKETS)
    width = usual_width(rows)
    good = [r for r in rows if len(r) == width and is_whole(r[0]) and all(map(is_number, r[1:4]))]
    if width < 3 or 2 * len(good) <= len(rows):
        return None
    port, kind = info_of(head)
    if kind and not kind.startswith(("bottle", "vector")):
        raise FileError(
            f"{head.path} is a yarpdatadumper log of type {kind!r}, expected Bottle: "
            "a recording holds numbers, not pictures"
        )
    lead = 3 if _has_both_times(rows) else 2
    _check_first(head, rows[0], width)
    is_wrench = port.endswith("analog:o") and width - lead == 6
    return RecordingStream(
        path=head.path,
        width=width,
        expected=f"a sequence number, {lead - 1} time(s) and {width - lead} values",
        keep=np.arange(lead, width),
        blank=BRACKETS.encode(),
        decimals=usual_decimals(rows),
        skip=skip,
        unit=WRENCH if is_wrench else "count",
        source=f"{head.path} (port {port})" if port else str(head.path),
        sequenced=True,
    )


def is_contact_list(head: Magic) -> bool:
    """Whether a log is of skinDynLib's lists of contacts: lists, or nothing, behind the times."""
    lines = [line for _, line in head.numbered(preamble_of(head))]
    some = sum(SOME_CONTACT.match(line) is not None for line in lines)
    none = sum(NO_CONTACT.fullmatch(line) is not None for line in lines)
    if not some and "skin_events" not in info_of(head)[0]:
        return False
    return 2 * (some + none) > len(lines)


def preamble_of(head: Magic) -> int:
    """Lines before the data: old versions wrote what is now `info.log` at the top of the log."""
    known = ("Type:", "Source:", "Stamp:")
    return next((k for k, line in enumerate(head.lines) if not line.startswith(known)), 0)


def info_of(head: Magic) -> tuple[str, str]:
    """Port and type from the `info.log` beside the log; empty where it does not say."""
    try:
        text = head.path.with_name("info.log").read_bytes()[:4096].decode("latin-1")
    except OSError:
        text = "\n".join(head.lines[: preamble_of(head)])
    port = re.search(r"(/\S+)\s+\[connected\]", text)
    kind = re.search(r"^Type:\s*([^;\s]+)", text, re.MULTILINE)
    return port.group(1) if port else "", kind.group(1).lower() if kind else ""


def _has_both_times(rows: list[list[str]]) -> bool:
    """Whether the third number is a second time of day, close to the first."""
    pairs = [row[1:3] for row in rows if len(row) > 3 and all(map(is_number, row[1:3]))]
    times = np.array(pairs, np.float64).reshape(-1, 2)
    since_2001 = (times > 1e9).all(axis=1)  # s; no count is that large
    return len(times) > 0 and bool((since_2001 & (np.abs(np.ptp(times, axis=1)) < 60)).all())


def _check_first(head: Magic, first: list[str], width: int) -> None:
    """Uids cannot be mistaken for a bad line: without them the columns have no meaning."""
    if len(first) != width and len(first) > 2 and all(map(is_whole, first)):
        raise FileError(
            f"{head.path}:{head.numbered()[0][0]}: {len(first)} whole numbers stand above lines of "
            f"{width}, expected {width - 2} uids (one per value, as CySkin writes them) "
            f"or {width} numbers"
        )
