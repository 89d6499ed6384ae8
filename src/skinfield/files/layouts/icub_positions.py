"""iCub's `positions/*.txt`: one row per channel of the part's port.

A header (``name``, ``spatial_sampling``, ``taxel2Repr``), then ``[calibration]`` and a row
``x y z nx ny nz`` (m, in the frame of the link) for each channel; zeros where there is no taxel.
``taxel2Repr`` holds, per channel, the channel that stands for it, -1 where there is no taxel, and
-2 where there is a thermal pad.
"""

import re
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.layouts.repair import Content, Draft, Finding, finding_of_rows
from skinfield.files.layouts.text import integer, numbers, read_lines, spoilt

NAME = "icub-positions"
EXTENSIONS = (".txt",)
EXPECTED = "iCub taxel positions: a header with taxel2Repr, [calibration], rows x y z nx ny nz"
ROW = "six numbers x y z nx ny nz"
PADS = 12  # channels of a board
ABSENT, THERMAL = -1, -2


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return re.search(rb"^\s*\[calibration\]", data, re.IGNORECASE | re.MULTILINE) is not None


def parse(path: Path) -> Content:
    """Contents of a file: one patch."""
    lines = read_lines(path)
    heads = (i for i, line in enumerate(lines) if line.strip().lower().startswith("[calibration]"))
    start = next(heads, len(lines))
    header = "\n".join(re.split("//|#", line)[0] for line in lines[:start])
    rows = []
    for i, line in enumerate(lines[start + 1 :], start + 2):
        if words := line.split():
            if len(words) != 6:
                raise spoilt(path, i, line.strip(), ROW)
            rows.append(numbers(path, i, words, ROW))
    if not rows:
        raise spoilt(path, len(lines), "the end", f"[calibration] and rows of {ROW}")
    table = np.array(rows)
    stated = _taxel2repr(path, header)
    name = re.search(r"^\s*name\s+(\S+)", header, re.MULTILINE)
    part = name[1] if name else path.stem
    keep, findings = _taxels(part, table, stated)
    if not len(keep):
        raise FileError(f"{path}: no row has a pose, expected one or more taxels: {EXPECTED}")
    draft = Draft(
        table[keep, :3],
        keep,
        table[keep, 3:],
        module=keep // PADS,
        uid=keep.astype(np.uint64),
        channel=keep,
        n_channels=len(table),
        name=part,
        link=part,
    )
    return Content(path, path.stem, (draft,), tuple(findings))


def _taxel2repr(path: Path, header: str) -> Ints | None:
    found = re.search(r"taxel2Repr\s*\(([^)]*)(\)?)", header)
    if found is None:
        return None
    line = header[: found.start()].count("\n") + 1
    if not found[2]:
        raise spoilt(path, line, "taxel2Repr (...", "a closing bracket after its numbers")
    words = found[1].split()
    return np.array([integer(path, line, word, "a channel, -1 or -2", -2) for word in words])


def _taxels(name: str, table: Floats, stated: Ints | None) -> tuple[Ints, list[Finding]]:
    """Rows that are taxels, and what the header and the rows say about the others."""
    rows, posed = len(table), table.any(axis=1)
    findings = []
    if stated is None:
        text = f"{name}: no taxel2Repr: absent and thermal channels are told by their zeros alone"
        findings.append(Finding("no-taxel2repr", "warning", text))
        stated = np.empty(0, np.int64)
    elif len(stated) != rows:
        more = f"from row {len(stated)} on, a row with a place is taken as a taxel"
        more = "entries beyond the rows are left out" if len(stated) > rows else more
        text = f"{name}: taxel2Repr has {len(stated)} entries for {rows} rows; {more}"
        findings.append(Finding("taxel2repr-length", "warning", text))
    role = np.zeros(rows, np.int64)
    role[: len(stated)] = stated[:rows]
    there = (role >= 0) & ~posed & (np.arange(rows) < len(stated))
    findings += finding_of_rows(
        "thermal", "info", role == THERMAL, name, "channel",
        "marked as thermal pads, no taxels; left out",
    )  # fmt: skip
    findings += finding_of_rows(
        "absent", "info", (role == ABSENT) & posed, name, "channel",
        "with a place where taxel2Repr says that there is no taxel (-1); left out",
    )  # fmt: skip
    findings += finding_of_rows(
        "no-pose", "warning", there, name, "channel",
        "without a place (zeros) where taxel2Repr says that there is a taxel; left out",
    )  # fmt: skip
    keep = np.flatnonzero(posed & (role >= 0))
    text = f"{name}: {posed.sum()} of {rows} channels have a place, {len(keep)} of them are taxels"
    return keep, [*findings, Finding("channels", "info", text)]
