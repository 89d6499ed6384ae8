"""Flat skins of triangular boards, as skinGui draws them."""

from pathlib import Path

import numpy as np

from skinfield.errors import Floats, InputError, Ints
from skinfield.layout.formats.text import write_bytes
from skinfield.layout.formats.triangles import BOARDS, PADS, Board
from skinfield.layout.normals import facing_from_positions
from skinfield.layout.patch import Patch
from skinfield.layout.skin import Skin

CHANNELS_OF_CARD = 192
NEAR = 0.25e-3  # m, between a pad and its place on the board
HEAD = """cardid {cards}
robotPart {part}
width 640
height 640

[SENSORS]
# type number x y th gain mirror layout; x and y in drawing units, th in degrees
"""


def write_drawing(skin: Skin, path: Path) -> tuple[str, ...]:
    """Write a flat skin of triangular boards; return what the format cannot hold, in sentences."""
    lines, moved = [], 0.0
    for patch in skin:
        plane, mirrored = _drawing(patch)
        numbers = patch.channel // PADS
        for number in np.unique(numbers).tolist():
            mine = numbers == number
            board, centre, angle, off = _fit(
                patch, number, plane[mine], patch.channel[mine], mirrored
            )
            moved = max(moved, off)
            x, y = centre / board.lattice * 1e3
            place = np.round([x, y, np.degrees(angle)], 4) + 0.0
            words = " ".join(f"{value:.4f}" for value in place)
            lines.append(f"{board.name} {number} {words} 5 {int(mirrored)} 0")
    if len({line.split()[1] for line in lines}) < len(lines):
        raise InputError(
            f"skin {skin.name!r} has {len(lines)} boards on the channels of fewer, expected 12 "
            "channels of its own for each: write each patch to a file of its own"
        )
    ports = -(-max(patch.n_channels for patch in skin) // CHANNELS_OF_CARD)
    cards = " ".join(map(str, range(ports)))
    part = "_".join(skin[0].name.split()) or "skin"
    write_bytes(path, (HEAD.format(part=part, cards=cards) + "\n".join([*lines, ""])).encode())
    return (
        "a drawing is flat: the place and the pose of the patch in its link, links, uids and "
        "modules (now channel // 12) are lost",
        f"boards have the pads of their type: pads move by up to {moved * 1e3:.3f} mm, and their "
        "diameter is lost",
    )


def _drawing(patch: Patch) -> tuple[Floats, bool]:
    """Taxels in the drawing's plane, (L, 2) m, and whether they are seen from behind."""
    facing = facing_from_positions(patch.positions)
    if len(patch) > 2 and not facing.is_flat:
        raise InputError(
            f"patch {patch.name!r} is curved, expected a flat one: a skinGui drawing has no depth"
        )
    first = patch.normals[0]
    if abs(abs(first[2]) - 1.0) < 1e-9 and np.abs(patch.normals - first).max() < 1e-9:
        return patch.positions[:, :2], bool(first[2] < 0)  # lies like a drawing: keep its axes
    return patch.plane, False


def _fit(
    patch: Patch,
    number: int,
    places: Floats,
    channel: Ints,
    mirrored: bool,
) -> tuple[Board, Floats, float, float]:
    """Board, centre (m) and angle (rad) that put its pads on the taxels, and how far off (m)."""
    reasons = []
    for board in BOARDS.values():
        pads = board.pads.tolist()
        if sorted(channel - PADS * number) != pads:
            reasons.append(f"its channels are not pads {pads} of a {board.name}")
            continue
        order = np.argsort(channel)
        template = board.drawn(0.0, mirrored)
        there = places[order] - places.mean(axis=0)
        here = template - template.mean(axis=0)
        turned = (here[:, 0] - 1j * here[:, 1]) @ (there[:, 0] + 1j * there[:, 1])
        angle = float(np.angle(turned))
        made = board.drawn(angle, mirrored)
        centre = places.mean(axis=0) - made.mean(axis=0)
        off = float(np.linalg.norm(made + centre - places[order], axis=1).max())
        if off <= NEAR:
            return board, centre, angle, off
        reasons.append(f"a pad is {off * 1e3:.2f} mm off its place on a {board.name}")
    raise InputError(
        f"patch {patch.name!r}, board {number}: {'; '.join(reasons)}; expected a board that "
        "skinGui draws: this layout needs another format"
    )
