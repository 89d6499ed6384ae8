"""Robots' XML, read with care: no entities, no other files, a limit of size, lines for errors.

Comments are cut out first, up to the nearest ``-->``: files of real robots have comments within
comments, which XML forbids and the robots' own parser accepts.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from skinfield.errors import FileError

LARGEST = 1 << 20  # bytes; the largest of those seen has 10 kB
DEEPEST = 32  # elements within each other


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
