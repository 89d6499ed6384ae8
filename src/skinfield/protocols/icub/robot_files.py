"""The files of robotology/robots-configuration that say how a skin's boards are set up.

``*-skinSpec.xml`` holds the settings of boards and triangles, ``*-skin.xml`` the addresses of the
boards. XIncludes are not followed: each file is handed in, and what one includes is told.
"""

from dataclasses import dataclass

from skinfield.errors import FileError
from skinfield.protocols.icub.board import TriangleState
from skinfield.protocols.icub.commands import SetBoard
from skinfield.protocols.icub.numbers import BOARDS, TRIANGLES
from skinfield.protocols.icub.xml_tree import Node
from skinfield.protocols.icub.xml_values import many, one, param, spoilt, whole, words, yes

SETS_OF_ROBOTS = 20  # special settings of triangles that the robots' own software reads
TELLING = {  # parameters of devices that carry the addresses themselves
    "canDeviceNum": "a CAN device",
    "skinCanIds": "an address",
}


@dataclass(frozen=True)
class BoardSet:
    """Settings of a run of boards of one patch.

    Parameters
    ----------
    patch, first, last : int
        Number of the patch, or of the CAN device; addresses, both within.
    settings : SetBoard
    line : int
        Of its file.
    """

    patch: int
    first: int
    last: int
    settings: SetBoard
    line: int


@dataclass(frozen=True)
class TriangleSet:
    """Settings of a run of triangles of one board; see `BoardSet`."""

    patch: int
    board: int
    first: int
    last: int
    settings: TriangleState
    line: int


@dataclass(frozen=True)
class SkinSpec:
    """What a ``skinSpec`` file says."""

    board: SetBoard
    triangle: TriangleState
    diagnostic: bool
    boards: tuple[BoardSet, ...] = ()
    triangles: tuple[TriangleSet, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class SkinDevice:
    """What a ``skin`` file says.

    Parameters
    ----------
    name, kind : str
        Of the device; `embObjSkin` behind an Ethernet board, `canBusSkin` on CAN itself.
    patches : tuple of (patch, addresses)
        By rising number: 1 and 2 are the two CAN buses of an Ethernet board; else the CAN device.
    includes : tuple of str
        Other files that it names.
    """

    name: str
    kind: str
    patches: tuple[tuple[int, tuple[int, ...]], ...]
    includes: tuple[str, ...] = ()


def spec_from(path: str, root: Node) -> SkinSpec | None:
    """Settings of boards and triangles; None if the file has none.

    Raises
    ------
    FileError
        If a value is missing or cannot be used.
    """
    board, triangle = (
        root.find("group", "defaultCfgBoard"),
        root.find("group", "defaultCfgTriangle"),
    )
    if board is None and triangle is None:
        return None
    if board is None or triangle is None:
        missing = "defaultCfgBoard" if board is None else "defaultCfgTriangle"
        raise FileError(f"{path}:{root.line}: has no group {missing!r}, expected it and its pair")
    diagnostic, enabled = param(path, board, "diagnostic"), param(path, triangle, "enabled")
    rows = _sets(path, root, "specialCfgTriangles", "triangleSetCfg", 7)
    notes: tuple[str, ...] = ()
    if len(rows) > SETS_OF_ROBOTS:
        notes = (
            f"{path}: {len(rows)} sets of triangles are in force; the robots' own software reads "
            f"the first {SETS_OF_ROBOTS} only",
        )
    return SkinSpec(
        _board(path, [_word(path, board, name) for name in ("period", "skinType", "noLoad")]),
        TriangleState(
            yes(path, enabled, enabled.text),
            one(path, triangle, "shift", 0, 15, "bits that boards drop"),
            one(path, triangle, "cdcOffset", 0, 0xFFFF, "offset of the converters"),
        ),
        yes(path, diagnostic, diagnostic.text),
        tuple(
            _board_set(path, node, row)
            for node, row in _sets(path, root, "specialCfgBoards", "boardSetCfg", 6)
        ),
        tuple(_triangle_set(path, node, row) for node, row in rows),
        notes,
    )


def device_from(path: str, root: Node) -> SkinDevice | None:
    """Addresses of boards; None if the file has none.

    Raises
    ------
    FileError
        If a value is missing or cannot be used.
    """
    patches = root.find("group", "patches")
    device = next((node for node in root.walk() if node.tag == "device"), root)
    includes = tuple(
        node.attributes["href"]
        for node in root.walk()
        if node.tag == "xi:include" and "href" in node.attributes
    )
    if patches is not None:
        found = _patches(path, patches)
    elif root.find("param", "skinCanIds") is not None:
        found = _can_device(path, root)
    else:
        return None
    for node, _, addresses in found:
        if not addresses or len(set(addresses)) < len(addresses):
            raise spoilt(path, node, node.text, "addresses of boards, each once")
    rising = tuple(sorted((number, addresses) for _, number, addresses in found))
    return SkinDevice(device.name, device.attributes.get("type", ""), rising, includes)


def _patches(path: str, group: Node) -> list[tuple[Node, int, tuple[int, ...]]]:
    found = []
    for node in group.children:
        prefix, _, number = node.name.partition("Patch")
        if node.tag == "param" and prefix == "skinCanAddrs":
            patch = whole(path, node, number, 0, 255, "skinCanAddrsPatch and its number")
            found.append((node, patch, many(path, node, 0, BOARDS - 1, "addresses of boards")))
    if len({number for _, number, _ in found}) < max(len(found), 1):
        raise spoilt(path, group, f"{len(found)} lists", "skinCanAddrsPatch1, 2, each once")
    return found


def _can_device(path: str, root: Node) -> list[tuple[Node, int, tuple[int, ...]]]:
    numbers = {}
    for name, what in TELLING.items():
        node = root.find("param", name)
        if node is None:
            raise FileError(f"{path}:{root.line}: has no param {name!r}, expected {what}")
        numbers[name] = node, many(path, node, 0, 255 if name == "canDeviceNum" else 15, what)
    node, addresses = numbers["skinCanIds"]
    bus, device = numbers["canDeviceNum"]
    if len(device) != 1:
        raise spoilt(path, bus, bus.text, "one number")
    return [(node, device[0], addresses)]


def _sets(
    path: str, root: Node, group_name: str, prefix: str, length: int
) -> list[tuple[Node, list[str]]]:
    group = root.find("group", group_name)
    if group is None or not any(node.tag == "param" for node in group.children):
        return []
    count = one(path, group, "numOfSets", 0, 1024, f"how many {prefix} follow")
    rows = []
    for number in range(1, count + 1):
        node = param(path, group, f"{prefix}{number}")
        row = words(node.text)
        if len(row) != length:
            raise spoilt(path, node, node.text, f"{length} numbers")
        rows.append((node, row))
    return rows


def _word(path: str, group: Node, name: str) -> tuple[Node, str]:
    node = param(path, group, name)
    return node, node.text


def _board(path: str, words: list[tuple[Node, str]]) -> SetBoard:
    """Settings of period, kind and rest."""
    return SetBoard(
        period_ms=whole(path, *words[0], 1, 255, "milliseconds"),
        kind=whole(path, *words[1], 0, 255, "kind of skin"),
        no_load=whole(path, *words[2], 0, 255, "the byte of an unloaded taxel"),
    )


def _board_set(path: str, node: Node, row: list[str]) -> BoardSet:
    patch = whole(path, node, row[0], 0, 255, "number of the patch")
    last = whole(path, node, row[2], 0, BOARDS - 1, "last address")
    first = whole(path, node, row[1], 0, last, "first address, not behind the last")
    return BoardSet(patch, first, last, _board(path, [(node, word) for word in row[3:]]), node.line)


def _triangle_set(path: str, node: Node, row: list[str]) -> TriangleSet:
    last = whole(path, node, row[3], 0, TRIANGLES - 1, "last triangle")
    return TriangleSet(
        whole(path, node, row[0], 0, 255, "number of the patch"),
        whole(path, node, row[1], 0, BOARDS - 1, "address of the board"),
        whole(path, node, row[2], 0, last, "first triangle, not behind the last"),
        last,
        TriangleState(
            yes(path, node, row[4]),
            whole(path, node, row[5], 0, 15, "bits that the board drops"),
            whole(path, node, row[6], 0, 0xFFFF, "offset of the converters"),
        ),
        node.line,
    )
