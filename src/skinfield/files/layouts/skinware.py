"""Skinware's `calibration.cache`: text, metres, one link after the other.

First ``sensors total-neighbours``, then per sensor ``x y z nx ny nz u v radius link neighbours
neighbour...``, with u and v the sensor's place on the flattened skin.
"""

import re
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.layouts.repair import Content, Draft
from skinfield.files.layouts.text import integer, numbers, read_lines, spoilt

NAME = "skinware"
EXTENSIONS = (".cache",)
EXPECTED = "a Skinware cache: 'sensors neighbours', then x y z nx ny nz u v radius link n ..."
FIELDS = 9  # numbers of a sensor before its link
ROW = "x y z nx ny nz u v radius link neighbours neighbour..."


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    head = data[:4096].decode("utf-8", "replace").split("\n", 2)
    return (
        len(head) > 1
        and re.fullmatch(r"\s*\d+\s+\d+\s*", head[0]) is not None
        and re.fullmatch(
            r"\s*([-+.\deE]+\s+){11,}[-+.\deE]+\s*|\s*([-+.\deE]+\s+){10}0\s*", head[1]
        )
        is not None
    )


def parse(path: Path) -> Content:
    """Contents of a file; a patch for each link."""
    words = [(n, word) for n, line in enumerate(read_lines(path), 1) for word in line.split()]
    if len(words) < 2:
        raise spoilt(path, 1, words[0][1] if words else "", "the counts 'sensors neighbours'")
    count = integer(path, *words[0], "the number of sensors", lowest=1)
    integer(path, *words[1], "the total number of neighbours")
    rows, links, at = [], [], 2
    for sensor in range(count):
        beside = 0
        if at + FIELDS + 2 <= len(words):
            rows.append([numbers(path, n, [word], ROW)[0] for n, word in words[at : at + FIELDS]])
            links.append(integer(path, *words[at + FIELDS], "the index of a link"))
            beside = integer(path, *words[at + FIELDS + 1], "the number of neighbours")
        at += FIELDS + 2
        if at + beside > len(words):
            raise FileError(
                f"{path}, line {words[-1][0]}: ends in sensor {sensor} of {count}, expected {ROW}"
            )
        for line, word in words[at : at + beside]:
            if integer(path, line, word, "the index of a sensor") >= count:
                raise spoilt(path, line, word, f"the index of a sensor below {count}")
        at += beside
    if at < len(words):
        raise spoilt(path, *words[at], f"the end, after {count} sensors")
    return Content(path, path.stem, _drafts(np.array(rows), np.array(links), path.stem))


def _drafts(rows: Floats, links: Ints, name: str) -> tuple[Draft, ...]:
    distinct = np.unique(links).tolist()
    drafts = []
    for link in distinct:
        mine = np.flatnonzero(links == link)
        drafts.append(
            Draft(
                rows[mine, :3],
                mine,
                rows[mine, 3:6],
                channel=mine,
                uid=mine.astype(np.uint64),
                n_channels=len(rows),
                pad_diameter=2.0 * float(np.median(rows[mine, 8])) or None,
                name=name if len(distinct) == 1 else f"{name}_link{link}",
                link=f"link{link}",
            )
        )
    return tuple(drafts)
