"""Parser of robot descriptions of yarprobotinterface: skin boards, their settings, runs of ports.

Comments are cut out first, up to the nearest ``-->``: files of real robots have comments within
comments, which XML forbids and the robots' own parser accepts.

In a ``*-skin_wrapper.xml`` each ``elem`` of ``ports`` holds four numbers: first and last channel of
the devices, then first and last channel of the port.

``*-skinSpec.xml`` holds the settings of boards and triangles, ``*-skin.xml`` the addresses of the
boards. XIncludes are not followed: each file is handed in.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from skinfield.errors import FileError
from skinfield.wire.icub.commands import BOARDS, TRIANGLES, SetBoard, TriangleState

LARGEST = 1 << 20  # bytes; the largest of those seen has 10 kB
LINE = " line"  # attribute, which no file can have, with the line of each element
YES, NO = ("true", "1"), ("false", "0")
HIGHEST_CHANNEL = 1 << 20


def read_tree(path: Path) -> Element:
    """Root element of a file, its elements with their `LINE`.

    Raises
    ------
    FileError
        If it cannot be read, is larger than 1 MiB, is no XML, or declares entities.
    """
    name = str(path)
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"{name}: cannot be read: {reason}") from error
    if len(data) > LARGEST:
        raise FileError(f"{name}: larger than {LARGEST} bytes, expected a robot's XML file")
    builder, parser = TreeBuilder(), expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        builder.start(tag, {**attributes, LINE: str(parser.CurrentLineNumber)})

    def entity(entity: str, *_: object) -> None:
        raise FileError(
            f"{name}:{parser.CurrentLineNumber}: declares the entity {entity!r}, expected "
            "none: robots' files need none, and such files can fill the memory; take it out"
        )

    parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
    parser.StartElementHandler, parser.EndElementHandler = start, builder.end
    parser.CharacterDataHandler, parser.EntityDeclHandler = builder.data, entity
    try:
        parser.Parse(without_comments(data), True)
        return builder.close()
    except expat.ExpatError as error:
        raise FileError(
            f"{name}:{error.lineno}: {expat.ErrorString(error.code)}, expected well-formed XML"
        ) from error
    except (LookupError, ValueError) as error:  # an encoding that does not exist
        if isinstance(error, FileError):
            raise
        raise FileError(f"{name}: {error}, expected XML in UTF-8") from error


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


def name_of(node: Element) -> str:
    """Attribute `name` of an element, or its tag."""
    return node.get("name") or node.tag


def text_of(node: Element) -> str:
    """All text directly within an element, stripped."""
    return "".join([node.text or "", *(child.tail or "" for child in node)]).strip()


def words(text: str) -> list[str]:
    """Words of a list, which YARP may put in brackets and quotes."""
    return text.translate(str.maketrans("()\"'", "    ")).split()


@dataclass(frozen=True)
class Values:
    """Reader of the values of one file, of that path; all raise FileError with the line."""

    path: str

    def spoilt(self, node: Element, text: str, expected: str) -> FileError:
        """Error about an element."""
        excerpt = text if len(text) <= 60 else f"{text[:57]}..."
        return self.missing(node, f"is {excerpt!r}, expected {expected}")

    def missing(self, node: Element, what: str) -> FileError:
        """Error about an element that lacks something."""
        return FileError(f"{self.path}:{node.get(LINE)}: {name_of(node)} {what}")

    def whole(self, node: Element, text: str, low: int, high: int, what: str) -> int:
        """Whole number, decimal or with 0x."""
        base = 16 if text.lower().startswith("0x") else 10
        try:
            value = int(text, base) if len(text) < 20 and text.isascii() else None
        except ValueError:
            value = None
        if value is None or not low <= value <= high:
            raise self.spoilt(node, text, f"{what}, a whole number from {low} to {high}")
        return value

    def yes(self, node: Element, text: str) -> bool:
        """Whether true."""
        if text.lower() not in YES + NO:
            raise self.spoilt(node, text, "true or false")
        return text.lower() in YES

    def param(self, group: Element, name: str) -> tuple[Element, str]:
        """Parameter of a group, and its text, which has one word at least."""
        node = next((each for each in group.findall("param") if each.get("name") == name), None)
        if node is None:
            raise self.missing(group, f"has no param {name!r}, expected one")
        if not words(text_of(node)):
            raise self.spoilt(node, text_of(node), "a value")
        return node, text_of(node)

    def one(self, group: Element, name: str, low: int, high: int, what: str) -> int:
        """Whole number of a parameter."""
        node, text = self.param(group, name)
        return self.whole(node, text.strip("\"' "), low, high, what)

    def many(self, node: Element, low: int, high: int, what: str) -> tuple[int, ...]:
        """Whole numbers of a parameter."""
        return tuple(self.whole(node, word, low, high, what) for word in words(text_of(node)))


def named(root: Element, tag: str, name: str) -> Element | None:
    """First element of such tag and name."""
    return next((node for node in root.iter(tag) if node.get("name") == name), None)


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


def wrapper_from(path: str, root: Element) -> tuple[PortRun, ...] | None:
    """Ports of a ``skin_wrapper`` file; None if the file has none."""
    values, ports = Values(path), named(root, "paramlist", "ports")
    if ports is None:
        return None
    runs = []
    for node in ports.findall("elem"):
        row = values.many(node, 0, HIGHEST_CHANNEL, "channels")
        port = node.get("name")
        if not port or len(row) != 4 or row[1] < row[0] or row[1] - row[0] != row[3] - row[2]:
            expected = "first and last channel of the devices, first and last of the port, as many"
            raise values.spoilt(node, text_of(node), expected)
        runs.append(PortRun(port, row[0], row[1] - row[0] + 1, row[2]))
    if not runs:
        raise values.missing(ports, "has no elem, expected one for each port")
    return tuple(runs)


@dataclass(frozen=True)
class Special:
    """Settings of some boards of one patch, or of some triangles of one board.

    Parameters
    ----------
    patch : int
        Number of the patch, or of the CAN device.
    boards : range
        Addresses.
    settings : SetBoard or TriangleState
    line : str
        Of its file.
    triangles : range
        Of the board; without meaning for a `SetBoard`.
    """

    patch: int
    boards: range
    settings: SetBoard | TriangleState
    line: str
    triangles: range = range(TRIANGLES)


@dataclass(frozen=True)
class SkinSpec:
    """What a ``skinSpec`` file says: the settings of most boards and triangles, and the others."""

    board: SetBoard
    triangle: TriangleState
    specials: tuple[Special, ...] = ()


@dataclass(frozen=True)
class SkinDevice:
    """What a ``skin`` file says.

    Parameters
    ----------
    name : str
        Of the device.
    patches : tuple of (patch, addresses)
        By rising number: 1 and 2 are the two CAN buses of an Ethernet board; else the CAN device.
    """

    name: str
    patches: tuple[tuple[int, tuple[int, ...]], ...]


def spec_from(path: str, root: Element) -> SkinSpec | None:
    """Settings of boards and triangles; None if the file has none."""
    values = Values(path)
    groups = {
        name: named(root, "group", name) for name in ("defaultCfgBoard", "defaultCfgTriangle")
    }
    board, triangle = groups.values()
    if board is None and triangle is None:
        return None
    if board is None or triangle is None:
        absent = next(name for name, group in groups.items() if group is None)
        raise values.missing(root, f"has no group {absent!r}, expected it and its pair")
    return SkinSpec(
        _board(values, [values.param(board, name) for name in ("period", "skinType", "noLoad")]),
        _triangle(values, [values.param(triangle, n) for n in ("enabled", "shift", "cdcOffset")]),
        (
            *_specials(values, root, "specialCfgBoards", "boardSetCfg", 6),
            *_specials(values, root, "specialCfgTriangles", "triangleSetCfg", 7),
        ),
    )


def device_from(path: str, root: Element) -> SkinDevice | None:
    """Addresses of boards; None if the file has none."""
    values, patches = Values(path), named(root, "group", "patches")
    ids = named(root, "param", "skinCanIds")
    lists: list[tuple[Element, int]] = []
    if patches is not None:
        for node in patches.findall("param"):
            prefix, _, text = (node.get("name") or "").partition("Patch")
            if prefix == "skinCanAddrs":
                what = "skinCanAddrsPatch and its number"
                lists.append((node, values.whole(node, text, 0, 255, what)))
        if len({number for _, number in lists}) < max(len(lists), 1):
            what = "skinCanAddrsPatch1, 2, each once"
            raise values.spoilt(patches, f"{len(lists)} lists", what)
    elif ids is not None:
        bus = named(root, "param", "canDeviceNum")
        if bus is None:
            raise values.missing(root, "has no param 'canDeviceNum', expected a CAN device")
        numbers = values.many(bus, 0, 255, "a CAN device")
        if len(numbers) != 1:
            raise values.spoilt(bus, text_of(bus), "one number")
        lists.append((ids, numbers[0]))
    else:
        return None
    found = []
    for node, number in lists:
        addresses = values.many(node, 0, BOARDS - 1, "addresses of boards")
        if not addresses or len(set(addresses)) < len(addresses):
            raise values.spoilt(node, text_of(node), "addresses of boards, each once")
        found.append((number, addresses))
    device = next(root.iter("device"), root)
    return SkinDevice(device.get("name", ""), tuple(sorted(found)))


def _specials(
    values: Values, root: Element, group_name: str, prefix: str, length: int
) -> Iterator[Special]:
    """Special settings of boards, 6 numbers each, or of triangles of one board, 7."""
    group = named(root, "group", group_name)
    if group is None or group.find("param") is None:
        return
    count = values.one(group, "numOfSets", 0, 1024, f"how many {prefix} follow")
    for number in range(1, count + 1):
        node, text = values.param(group, f"{prefix}{number}")
        row = words(text)
        if len(row) != length:
            raise values.spoilt(node, text, f"{length} numbers")
        line, patch = node.get(LINE, ""), values.whole(node, row[0], 0, 255, "number of the patch")
        if length == 6:
            boards = _run(values, node, row[1:3], BOARDS, "address")
            settings = _board(values, [(node, word) for word in row[3:]])
            yield Special(patch, boards, settings, line)
        else:
            board = values.whole(node, row[1], 0, BOARDS - 1, "address of the board")
            triangles = _run(values, node, row[2:4], TRIANGLES, "triangle")
            state = _triangle(values, [(node, word) for word in row[4:]])
            yield Special(patch, range(board, board + 1), state, line, triangles)


def _run(values: Values, node: Element, words: list[str], count: int, what: str) -> range:
    last = values.whole(node, words[1], 0, count - 1, f"last {what}")
    first = values.whole(node, words[0], 0, last, f"first {what}, not behind the last")
    return range(first, last + 1)


def _board(values: Values, words: list[tuple[Element, str]]) -> SetBoard:
    """Settings of period, kind and rest."""
    return SetBoard(
        period_ms=values.whole(*words[0], 1, 255, "milliseconds"),
        kind=values.whole(*words[1], 0, 255, "kind of skin"),
        no_load=values.whole(*words[2], 0, 255, "the byte of an unloaded taxel"),
    )


def _triangle(values: Values, words: list[tuple[Element, str]]) -> TriangleState:
    """Settings of whether it is on, shift and offset."""
    return TriangleState(
        enabled=values.yes(*words[0]),
        shift=values.whole(*words[1], 0, 15, "bits that the board drops"),
        cdc_offset=values.whole(*words[2], 0, 0xFFFF, "offset of the converters"),
    )
