"""What recorded data say: words, rows and a picture, each from numbers that were computed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from skinfield.errors import InputError

Value = str | float | int | None


@dataclass(frozen=True, eq=False)
class Finding:
    """One recording or table beside what skinfield makes of it.

    Parameters
    ----------
    name : str
        Of its files.
    title : str
    source : str
        Whose data it is, under which licence.
    sentences : tuple of str
    rows : tuple of mappings
        Of a table: column with its unit, such as "force (N)", to value. All have the same columns.
    figure : function, optional
        Draws it, as a PNG file.
    caption : str
        Of the figure.
    """

    name: str
    title: str
    source: str
    sentences: tuple[str, ...]
    rows: tuple[Mapping[str, Value], ...] = ()
    figure: Callable[[], bytes] | None = None
    caption: str = ""

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if list(row) != list(self.rows[0]):
                raise InputError(
                    f"row {number} of {self.name!r} has columns {list(row)}, expected "
                    f"{list(self.rows[0])}: those of the first"
                )


class AbsentData(InputError):
    """A file that somebody else recorded is not in the folder: says which."""


def needed(folder: Path, *parts: str) -> Path:
    """Path of a file or folder below `folder`, or AbsentData."""
    path = folder.joinpath(*parts)
    if not path.exists():
        raise AbsentData(
            f"{Path(*parts)} is not in {folder}, expected the data that others recorded there: "
            "what needs them is left out"
        )
    return path
