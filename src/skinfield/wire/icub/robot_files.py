"""Parser of robot descriptions of yarprobotinterface: skin boards, their settings, runs of ports.

Comments are cut out first, up to the nearest ``-->``: files of real robots have comments within
comments, which XML forbids and the robots' own parser accepts.

In a ``*-skin_wrapper.xml`` each ``elem`` of ``ports`` holds four numbers: first and last channel of
the devices, then first and last channel of the port.

``*-skinSpec.xml`` holds the settings of boards and triangles, ``*-skin.xml`` the addresses of the
boards. XIncludes are not followed: each file is handed in.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from skinfield.errors import FileError
from skinfield.wire.icub.commands import BOARDS, TRIANGLES, SetBoard, TriangleState

LARGEST = 1 << 20  # bytes; the largest of those seen has 10 kB
WHERE = " where"  # attribute, which no file can have, with the file and line of each element
YES, NO = ("true", "1"), ("false", "0")
HIGHEST_CHANNEL = 1 << 20


def read_tree(path: Path, largest: int = LARGEST) -> Element:
    """Root element of a file of at most so many bytes, its elements with their `WHERE`.

    Raises
    ------
    FileError
        If it cannot be read, is larger, is no XML, or declares entities.
    """
    name = str(path)
    try:
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"{name}: cannot be read: {reason}") from error
    if len(data) > largest:
        raise FileError(f"{name}: larger than {largest} bytes, expected a robot's XML file")
    builder, parser = TreeBuilder(), expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        builder.start(tag, {**attributes, WHERE: f"{name}:{parser.CurrentLineNumber}"})

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


def spoilt(node: Element, text: str, expected: str) -> FileError:
    """Error about a value of an element."""
    excerpt = text if len(text) <= 60 else f"{text[:57]}..."
    return FileError(f"{node.get(WHERE)}: {name_of(node)} is {excerpt!r}, expected {expected}")


def whole(node: Element, text: str, low: int, high: int, what: str) -> int:
    """Whole number, decimal or with 0x."""
    base = 16 if text.lower().startswith("0x") else 10
    try:
        value = int(text, base) if len(text) < 20 and text.isascii() else None
    except ValueError:
        value = None
    if value is None or not low <= value <= high:
        raise spoilt(node, text, f"{what}, a whole number from {low} to {high}")
    return value


def many(node: Element, low: int, high: int, what: str) -> tuple[int, ...]:
    """Whole numbers of an element."""
    return tuple(whole(node, word, low, high, what) for word in words(text_of(node)))


def one(node: Element, low: int, high: int, what: str) -> int:
    """The only whole number of an element."""
    numbers = many(node, low, high, what)
    if len(numbers) != 1:
        raise spoilt(node, text_of(node), "one number")
    return numbers[0]


def named(root: Element, tag: str, name: str) -> Element | None:
    """First element of such tag and name."""
    return next((node for node in root.iter(tag) if node.get("name") == name), None)


def needed(root: Element, tag: str, name: str, expected: str = "one") -> Element:
    """First element of such tag and name, which has to be there."""
    node = named(root, tag, name)
    if node is None:
        raise FileError(
            f"{root.get(WHERE)}: {name_of(root)} has no {tag} {name!r}, expected {expected}"
        )
    return node


def param(group: Element, name: str) -> tuple[Element, str]:
    """Parameter of a group, and its text, which has one word at least."""
    node = needed(group, "param", name)
    if not words(text_of(node)):
        raise spoilt(node, text_of(node), "a value")
    return node, text_of(node)


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


def ports_of(root: Element) -> tuple[PortRun, ...]:
    """Ports of a ``skin_wrapper`` file."""
    ports, runs = needed(root, "paramlist", "ports"), []
    for node in ports.findall("elem"):
        row = many(node, 0, HIGHEST_CHANNEL, "channels")
        port = node.get("name")
        if not port or len(row) != 4 or row[1] < row[0] or row[1] - row[0] != row[3] - row[2]:
            expected = "first and last channel of the devices, first and last of the port, as many"
            raise spoilt(node, text_of(node), expected)
        runs.append(PortRun(port, row[0], row[1] - row[0] + 1, row[2]))
    if not runs:
        raise spoilt(ports, "empty", "an elem for each port")
    return tuple(runs)


def patches_of(root: Element) -> dict[int, tuple[int, ...]]:
    """Addresses of the boards of a ``skin`` file, by the numbers of their patches.

    Patches 1 and 2 are the two CAN buses of an Ethernet board. Where the file has `skinCanIds`, the
    only one is the CAN device.
    """
    patches, lists = named(root, "group", "patches"), list[tuple[int, Element]]()
    if patches is None:
        device = needed(root, "param", "canDeviceNum", "a CAN device")
        lists.append((one(device, 0, 255, "a CAN device"), needed(root, "param", "skinCanIds")))
    else:
        for node in patches.findall("param"):
            prefix, _, text = (node.get("name") or "").partition("Patch")
            if prefix == "skinCanAddrs":
                what = "skinCanAddrsPatch and its number"
                lists.append((whole(node, text, 0, 255, what), node))
        if len({number for number, _ in lists}) < max(len(lists), 1):
            raise spoilt(patches, f"{len(lists)} lists", "skinCanAddrsPatch1, 2, each once")
    found = {}
    for number, node in sorted(lists, key=lambda pair: pair[0]):
        found[number] = many(node, 0, BOARDS - 1, "addresses of boards")
        if not 0 < len(found[number]) == len(set(found[number])):
            raise spoilt(node, text_of(node), "addresses of boards, each once")
    return found


Settings = dict[tuple[int, int], tuple[SetBoard, list[TriangleState]]]  # by patch and address


def settings_of(root: Element, patches: Mapping[int, tuple[int, ...]]) -> Settings:
    """Settings of all boards and their triangles, of a ``skinSpec`` file."""
    default = [
        needed(root, "group", name, "it and its pair")
        for name in ("defaultCfgBoard", "defaultCfgTriangle")
    ]
    board = _board([param(default[0], name) for name in ("period", "skinType", "noLoad")])
    triangle = _triangle([param(default[1], name) for name in ("enabled", "shift", "cdcOffset")])
    settings: Settings = {
        (patch, address): (board, [triangle] * TRIANGLES)
        for patch, addresses in patches.items()
        for address in addresses
    }

    def place(node: Element, patch: int, address: int) -> tuple[int, int]:
        if (patch, address) not in settings:
            there = "; ".join(f"{n}: {' '.join(map(str, all_))}" for n, all_ in patches.items())
            raise FileError(
                f"{node.get(WHERE)}: sets board {address} of patch {patch}, expected one of {there}"
            )
        return patch, address

    for node, patch, row in _specials(root, "specialCfgBoards", "boardSetCfg", 6):
        addresses = _run(node, row[:2], BOARDS, "address")
        board = _board([(node, word) for word in row[2:]])
        for address in addresses:
            settings[patch, address] = board, settings[place(node, patch, address)][1]
    for node, patch, row in _specials(root, "specialCfgTriangles", "triangleSetCfg", 7):
        address = whole(node, row[0], 0, BOARDS - 1, "address of the board")
        triangles = _run(node, row[1:3], TRIANGLES, "triangle")
        triangle = _triangle([(node, word) for word in row[3:]])
        for number in triangles:
            settings[place(node, patch, address)][1][number] = triangle
    return settings


def _specials(
    root: Element, group_name: str, prefix: str, length: int
) -> Iterator[tuple[Element, int, list[str]]]:
    """Patches and further words of special settings, `length` numbers each."""
    group = named(root, "group", group_name)
    if group is None or group.find("param") is None:
        return
    count = one(param(group, "numOfSets")[0], 0, 1024, f"how many {prefix} follow")
    for number in range(1, count + 1):
        node, text = param(group, f"{prefix}{number}")
        row = words(text)
        if len(row) != length:
            raise spoilt(node, text, f"{length} numbers")
        yield node, whole(node, row[0], 0, 255, "number of the patch"), row[1:]


def _run(node: Element, words: list[str], count: int, what: str) -> range:
    last = whole(node, words[1], 0, count - 1, f"last {what}")
    first = whole(node, words[0], 0, last, f"first {what}, not behind the last")
    return range(first, last + 1)


def _board(words: list[tuple[Element, str]]) -> SetBoard:
    """Settings of period, kind and rest."""
    return SetBoard(
        period_ms=whole(*words[0], 1, 255, "milliseconds"),
        kind=whole(*words[1], 0, 255, "kind of skin"),
        no_load=whole(*words[2], 0, 255, "the byte of an unloaded taxel"),
    )


def _triangle(words: list[tuple[Element, str]]) -> TriangleState:
    """Settings of whether it is on, shift and offset."""
    enabled = words[0][1].lower()
    if enabled not in YES + NO:
        raise spoilt(*words[0], "true or false")
    return TriangleState(
        enabled=enabled in YES,
        shift=whole(*words[1], 0, 15, "bits that the board drops"),
        cdc_offset=whole(*words[2], 0, 0xFFFF, "offset of the converters"),
    )
