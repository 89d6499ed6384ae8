"""Positions of the taxels of iCub's fingertip, `3Dtaxelpositions.txt`.

``TAXEL n``, then three lines ``normal position`` for x, y and z; positions in millimetres, in the
frame at the axis of the fingertip's support. The file counts from 1 and backwards: TAXEL n of N is
pad N - n of the board's map, which is the order of its readings.
"""

import re
from pathlib import Path

import numpy as np

from skinfield.errors import FileError
from skinfield.files.layouts.repair import Content, Draft, Finding
from skinfield.files.layouts.text import integer, numbers, read_lines, spoilt

NAME = "fingertip"
EXTENSIONS = (".txt",)
EXPECTED = "fingertip positions: 'TAXEL n', then three lines 'normal position' (mm)"
AXIS = "two numbers: a component of the normal and one of the position in mm"
MM = 1e-3


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return re.match(rb"\s*TAXEL\s+\d+\s*[\r\n]", data) is not None


def parse(path: Path) -> Content:
    """Contents of a file: one patch."""
    lines = [(i, line.split()) for i, line in enumerate(read_lines(path), 1) if line.strip()]
    taxels: list[int] = []
    rows: list[list[float]] = []
    for line, words in lines:
        if words[0] == "TAXEL" and len(words) == 2:
            if len(rows) != 3 * len(taxels):
                raise spoilt(path, line, " ".join(words), f"three lines after TAXEL {taxels[-1]}")
            taxels.append(integer(path, line, words[1], "the number of a taxel"))
        elif not taxels or len(words) != 2 or len(rows) == 3 * len(taxels):
            raise spoilt(path, line, " ".join(words), AXIS if taxels else "'TAXEL n'")
        else:
            rows.append(numbers(path, line, words, AXIS))
    count = len(taxels)
    if not count or len(rows) != 3 * count:
        raise spoilt(path, lines[-1][0] if lines else 1, "the end", AXIS)
    if sorted(taxels) != list(range(1, count + 1)):
        raise FileError(f"{path}: taxels are {taxels}, expected each of 1 to {count} once")
    table = np.array(rows).reshape(count, 3, 2)
    channel = count - np.array(taxels)
    text = f"TAXEL 1 to {count} are pads {count - 1} to 0, the order of the board's readings"
    draft = Draft(
        table[:, :, 1] * MM,
        np.arange(count),
        table[:, :, 0],
        uid=channel.astype(np.uint64),
        channel=channel,
        n_channels=count,
        name="fingertip",
    )
    return Content(path, path.stem, (draft,), (Finding("taxel-order", "info", text),))
