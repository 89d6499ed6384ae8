"""Robot descriptions of yarprobotinterface: XML with lines, and the runs of ports in them.

Comments are cut out first, up to the nearest ``-->``: files of real robots have comments within
comments, which XML forbids and the robots' own parser accepts.

In a ``*-skin_wrapper.xml`` each ``elem`` of ``ports`` holds four numbers: first and last channel of
the devices, then first and last channel of the port.

``*-skinSpec.xml`` holds the settings of boards and triangles, ``*-skin.xml`` the addresses of the
boards. XIncludes are not followed: each file is handed in, and what one includes is told.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from skinfield.errors import FileError
from skinfield.wire.icub.commands import BOARDS, TRIANGLES, SetBoard, TriangleState

LARGEST = 1 << 20  # bytes; the largest of those seen has 10 kB
DEEPEST = 32  # elements within each other
YES, NO = ("true", "1"), ("false", "0")


@dataclass(eq=False)
class Node:
    """One element.

    Attributes
    ----------
    tag, name, text : str
        Name of the element; its attribute `name`, empty if absent; its text, stripped.
    line : int
        From 1.
    attributes : dict
    children : list of Node
    """

    tag: str
    line: int
    attributes: dict[str, str]
    text: str = ""
    children: list["Node"] = field(default_factory=list)

    @property
    def name(self) -> str:
        """See above."""
        return self.attributes.get("name", "")

    def walk(self) -> Iterator["Node"]:
        """Elements of the file from here inwards, in its order."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(node.children))

    def find(self, tag: str, name: str) -> "Node | None":
        """First element within of such tag and name."""
        return next((node for node in self.walk() if node.tag == tag and node.name == name), None)


def read_tree(path: Path) -> Node:
    """Root element of a file.

    Raises
    ------
    FileError
        If it cannot be read, is larger than 1 MiB, is no XML, or declares entities.
    """
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"{path}: cannot be read: {reason}") from error
    return tree_of(data, str(path))


def tree_of(data: bytes, name: str) -> Node:
    """Root element of a file's bytes; `name` is for errors.

    Raises
    ------
    FileError
        See `read_tree`.
    """
    if len(data) > LARGEST:
        raise FileError(f"{name}: larger than {LARGEST} bytes, expected a robot's XML file")
    builder = _Builder(name)
    try:
        builder.parser.Parse(without_comments(data), True)
    except expat.ExpatError as error:
        raise FileError(
            f"{name}:{error.lineno}: {expat.ErrorString(error.code)}, expected well-formed XML"
        ) from error
    except (LookupError, ValueError) as error:  # an encoding that does not exist
        if isinstance(error, FileError):
            raise
        raise FileError(f"{name}: {error}, expected XML in UTF-8") from error
    if builder.root is None:
        raise FileError(f"{name}: has no element, expected a robot's XML file")
    return builder.root


def without_comments(data: bytes) -> bytes:
    """The bytes with only the line ends left of comments; what is not closed stays."""
    parts: list[bytes] = []
    at = 0
    while True:
        start = data.find(b"<!--", at)
        stop = data.find(b"-->", start + 4) if start >= 0 else -1
        if stop < 0:
            return b"".join([*parts, data[at:]])
        parts += [data[at:start], b"\n" * data.count(b"\n", start, stop)]
        at = stop + 3


class _Builder:
    """Makes nodes of what expat says."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.root: Node | None = None
        self._open: list[Node] = []
        self.parser = parser = expat.ParserCreate()
        parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.EntityDeclHandler = self._entity

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= DEEPEST:
            raise FileError(
                f"{self.name}:{self.parser.CurrentLineNumber}: more than {DEEPEST} elements within "
                "each other, expected a robot's XML file"
            )
        node = Node(tag, self.parser.CurrentLineNumber, attributes)
        if self._open:
            self._open[-1].children.append(node)
        else:
            self.root = node
        self._open.append(node)

    def _end(self, tag: str) -> None:
        node = self._open.pop()
        node.text = node.text.strip()

    def _characters(self, text: str) -> None:
        self._open[-1].text += text

    def _entity(self, name: str, *_: object) -> None:
        raise FileError(
            f"{self.name}:{self.parser.CurrentLineNumber}: declares the entity {name!r}, expected "
            "none: robots' files need none, and such files can fill the memory; take it out"
        )


def words(text: str) -> list[str]:
    """Words of a list, which YARP may put in brackets and quotes."""
    return text.translate(str.maketrans("()\"'", "    ")).split()


def spoilt(path: str, node: Node, text: str, expected: str) -> FileError:
    """Error about an element."""
    excerpt = text if len(text) <= 60 else f"{text[:57]}..."
    return FileError(
        f"{path}:{node.line}: {node.name or node.tag} is {excerpt!r}, expected {expected}"
    )


def whole(path: str, node: Node, text: str, low: int, high: int, what: str) -> int:
    """Whole number, decimal or with 0x."""
    expected = f"{what}, a whole number from {low} to {high}"
    try:
        value = int(text, 16 if text.lower().startswith("0x") else 10) if len(text) < 20 else None
    except ValueError:
        value = None
    if value is None or not text.isascii() or not low <= value <= high:
        raise spoilt(path, node, text, expected)
    return value


def yes(path: str, node: Node, text: str) -> bool:
    """Whether true."""
    if text.lower() not in YES + NO:
        raise spoilt(path, node, text, "true or false")
    return text.lower() in YES


def param(path: str, group: Node, name: str) -> Node:
    """Parameter of a group, with one word at least.

    Raises
    ------
    FileError
        If there is none, or it is empty.
    """
    found = [node for node in group.children if node.tag == "param" and node.name == name]
    if not found:
        raise FileError(
            f"{path}:{group.line}: {group.name or group.tag} has no param {name!r}, expected one"
        )
    if not words(found[0].text):
        raise spoilt(path, found[0], found[0].text, "a value")
    return found[0]


def one(path: str, group: Node, name: str, low: int, high: int, what: str) -> int:
    """Whole number of a parameter."""
    node = param(path, group, name)
    return whole(path, node, node.text.strip("\"' "), low, high, what)


def many(path: str, node: Node, low: int, high: int, what: str) -> tuple[int, ...]:
    """Whole numbers of a parameter."""
    return tuple(whole(path, node, word, low, high, what) for word in words(node.text))


HIGHEST_CHANNEL = 1 << 20
SETS_OF_ROBOTS = 20  # special settings of triangles that the robots' own software reads
TELLING = {  # parameters of devices that carry the addresses themselves
    "canDeviceNum": "a CAN device",
    "skinCanIds": "an address",
}


@dataclass(frozen=True)
class PortRun:
    """Run of a device's channels that goes to a port.

    Parameters
    ----------
    port : str
    first, count : int
        Of the device's channels; with several devices, of all of them one after the other.
    port_first : int
        Channel of the port that the first one becomes.
    """

    port: str
    first: int
    count: int
    port_first: int


@dataclass(frozen=True)
class SkinWrapper:
    """What a ``skin_wrapper`` file says.

    Parameters
    ----------
    name : str
    ports : tuple of PortRun
    devices : tuple of str
        Names of the skins whose channels it passes on, in this order.
    total : int
        Channels that it counts on; 0 if it does not say.
    """

    name: str
    ports: tuple[PortRun, ...]
    devices: tuple[str, ...]
    total: int = 0


def wrapper_from(path: str, root: Node) -> SkinWrapper | None:
    """Ports; None if the file has none.

    Raises
    ------
    FileError
        If a value is missing or cannot be used.
    """
    ports, networks = root.find("paramlist", "ports"), root.find("paramlist", "networks")
    if ports is None:
        return None
    runs = [_port_run(path, node) for node in ports.children if node.tag == "elem"]
    if not runs:
        raise FileError(f"{path}:{ports.line}: ports has no elem, expected one for each port")
    total = root.find("param", "total_taxels")
    return SkinWrapper(
        root.name,
        tuple(runs),
        tuple(
            word
            for node in (networks.children if networks else [])
            if node.tag == "elem"
            for word in words(node.text)
        ),
        whole(path, total, total.text, 0, HIGHEST_CHANNEL, "channels") if total else 0,
    )


def _port_run(path: str, node: Node) -> PortRun:
    row = many(path, node, 0, HIGHEST_CHANNEL, "channels")
    expected = "first and last channel of the devices, first and last of the port, as many"
    if not node.name or len(row) != 4 or row[1] < row[0] or row[1] - row[0] != row[3] - row[2]:
        raise spoilt(path, node, node.text, expected)
    return PortRun(node.name, row[0], row[1] - row[0] + 1, row[2])


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
