"""Drawings of iCub's skinGui, `.ini`: boards placed in a plane."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skinfield.errors import FileError
from skinfield.files.layouts.repair import Content, Draft, Finding
from skinfield.files.layouts.text import integer, listed, many, numbers, read_lines, spoilt
from skinfield.skin.generators import ICUB_TRIANGLE, TEN_PAD_TRIANGLE, ModuleTemplate

PADS = 12  # channels of a board, thermal ones included


@dataclass(frozen=True)
class TriangleType:
    """One type of triangle.

    Parameters
    ----------
    name : str
        Of the type in a drawing.
    template : ModuleTemplate
        As drawn, a drawing unit taken as 1 mm; turned, after it is mirrored in x.
    built : float
        Size of the real board over the drawn one.
    lattice : float, mm per drawing unit
        Of the places of boards in a drawing.
    """

    name: str
    template: ModuleTemplate
    built: float
    lattice: float


# Drawn in millimetres: 30 mm sides, pads 5.0 mm apart.
TRIANGLE = TriangleType("triangle", ICUB_TRIANGLE, built=1.0, lattice=1.0)
# Drawn too small: on a built foot, pads are 6.533 mm apart (drawn 6.430), and neighbouring boards
# 19.32 mm (drawn 18.475, a lattice of 32 units of side).
TRIANGLE_10PAD = TriangleType("triangle_10pad", TEN_PAD_TRIANGLE, built=1.016, lattice=1.0457)

BOARDS = {board.name: board for board in (TRIANGLE, TRIANGLE_10PAD)}


NAME = "skingui"
EXTENSIONS = (".ini",)
EXPECTED = "a skinGui drawing: [SENSORS], then lines 'type number x y th gain mirror [layout]'"
LINE = "type number x y th gain mirror [layout]"
MM = 1e-3
BOARDS_PER_CARD = 16  # triangles on one address of the bus; `cardid` lists the port's addresses


@dataclass(frozen=True)
class _Placed:
    """One line of a drawing; the angle in rad."""

    line: int
    kind: str
    number: int
    x: float
    y: float
    angle: float
    mirrored: bool
    backwards: bool


def sniff(data: bytes) -> bool:
    """Whether the bytes look like this format."""
    return re.search(rb"^\s*\[SENSORS\]", data, re.IGNORECASE | re.MULTILINE) is not None


def parse(path: Path) -> Content:
    """Contents of a file: one patch, or two when some boards are drawn from behind."""
    lines = read_lines(path)
    first: dict[int, _Placed] = {}
    again, findings = [], []
    for item in _sensors(path, lines):
        if first.setdefault(item.number, item) is not item:
            again.append(item)
    if again:
        text = (
            f"boards {listed(sorted({item.number for item in again}))} are placed more than once "
            f"(lines {listed([item.line for item in again])}): one board has one set of channels; "
            "the first place is taken, as skinGui does"
        )
        findings.append(Finding("repeated-triangle", "error", text))
    boards = [item for item in first.values() if item.kind in BOARDS]
    if not boards:
        raise FileError(f"{path}: no triangle or triangle_10pad, expected one or more: {LINE}")
    if others := [item for item in first.values() if item.kind not in BOARDS]:
        text = (
            f"{many(len(others), 'sensor')} of other types than triangles "
            f"({listed(sorted({item.kind for item in others}))}), whose pads do not lie in the "
            f"drawing's plane; left out (lines {listed([item.line for item in others])})"
        )
        findings.append(Finding("not-a-triangle", "warning", text))
    findings += _remarks(boards)
    part = " ".join(_header(lines, "robotPart")) or path.stem
    port = BOARDS_PER_CARD * PADS * len(_header(lines, "cardid"))
    mirrored = boards[0].mirrored
    drafts = [
        replace(
            _draft(group, side),
            name=part if side == mirrored else f"{part}_other_side",
            n_channels=max(port, PADS * (max(item.number for item in boards) + 1)),
        )
        for side in (mirrored, not mirrored)
        if (group := [item for item in boards if item.mirrored == side])
    ]
    return Content(path, path.stem, tuple(drafts), tuple(findings))


def _header(lines: list[str], key: str) -> list[str]:
    return next((line.split()[1:] for line in lines if line.split()[:1] == [key]), [])


def _sensors(path: Path, lines: list[str]) -> Iterator[_Placed]:
    """What the lines of [SENSORS] place."""
    inside = False
    for line, row in enumerate(lines, 1):
        text = re.split("#|//", row)[0].strip()
        if text.startswith("["):
            if inside:
                return
            inside = text.upper().startswith("[SENSORS]")
        elif inside and text:
            words = text.split()
            if not 5 <= len(words) <= 8:
                raise spoilt(path, line, text, LINE)
            number = integer(path, line, words[1], "the number of a board, 0 to 999")
            if number > 999:
                raise spoilt(path, line, words[1], "the number of a board, 0 to 999")
            values = numbers(path, line, words[2:], LINE)
            x, y, angle, _, mirror, layout = [*values, *[0.0] * (6 - len(values))]
            if mirror not in (0.0, 1.0) or layout not in (0.0, 1.0):
                raise spoilt(path, line, text, "mirror 0 or 1, and layout 0 or 1")
            turn = float(np.radians(angle))
            yield _Placed(line, words[0], number, x, y, turn, mirror == 1.0, layout == 1.0)


def _remarks(boards: list[_Placed]) -> list[Finding]:
    types = sorted({item.kind for item in boards})
    said = " and ".join(f"{BOARDS[name].lattice:g} mm ({name})" for name in types)
    text = (
        f"a drawing unit is taken as {said} between boards, and the boards have the size that "
        "they are built with; a drawing is flat, whatever the part is"
    )
    findings = [Finding("drawing-units", "info", text)]
    if len({item.mirrored for item in boards}) > 1:
        text = (
            "some boards are drawn from behind (mirror 1) and some from the front: they face "
            "opposite ways, and become two patches"
        )
        findings.append(Finding("two-sides", "warning", text))
    if thermal := 2 * sum(item.kind == "triangle_10pad" for item in boards):
        text = f"{thermal} thermal pads (6 and 10 of each 10-pad board) are left out"
        findings.append(Finding("thermal", "info", text))
    return findings


def _draft(boards: list[_Placed], mirrored: bool) -> Draft:
    places, channels = [], []
    for item in boards:
        board, cos, sin = BOARDS[item.kind], np.cos(item.angle), np.sin(item.angle)
        pads = np.array(board.template.taxels) * board.built * [-1.0 if mirrored else 1.0, 1.0]
        centre = board.lattice * MM * np.array([item.x, item.y])
        places.append(pads @ np.array([[cos, sin], [-sin, cos]]) + centre)
        its = np.array(board.template.channels)
        channels.append(PADS * item.number + (PADS - 1 - its if item.backwards else its))
    plane, channel = np.vstack(places), np.concatenate(channels)
    count, first = len(plane), BOARDS[boards[0].kind]
    return Draft(
        np.column_stack([plane, np.zeros(count)]),
        np.arange(count),
        np.tile([0.0, 0.0, -1.0 if mirrored else 1.0], (count, 1)),
        module=channel // PADS,
        uid=channel.astype(np.uint64),
        channel=channel,
        pad_diameter=first.template.pad_diameter * first.built,
    )
