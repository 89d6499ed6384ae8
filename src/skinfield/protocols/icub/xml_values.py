"""Values in robots' XML: numbers as YARP writes them, with errors that name file and line."""

from skinfield.errors import FileError
from skinfield.protocols.icub.xml_tree import Node

YES, NO = ("true", "1"), ("false", "0")


def words(text: str) -> list[str]:
    """Words of a list, which YARP may put in brackets and quotes."""
    return text.translate(str.maketrans("()\"'", "    ")).split()


def spoilt(path: str, node: Node, found: str, expected: str) -> FileError:
    """Error about an element."""
    shown = found if len(found) <= 60 else f"{found[:57]}..."
    return FileError(
        f"{path}:{node.line}: {node.name or node.tag} is {shown!r}, expected {expected}"
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
