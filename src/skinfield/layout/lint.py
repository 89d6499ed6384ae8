"""What is wrong with a layout file, what it means, and what reading it does about it."""

from pathlib import Path

from skinfield.layout.finding import Finding as Finding
from skinfield.layout.formats import read_layout


def lint(path: str | Path) -> list[Finding]:
    """Everything found in a layout file, errors first.

    Reading the file makes exactly the repairs that the messages name: the same code runs.

    Raises
    ------
    FileError
        When the file cannot be read at all, so that `load_layout` fails too.
    """
    order = ("error", "warning", "info")
    return sorted(read_layout(Path(path))[1], key=lambda found: order.index(found.severity))
