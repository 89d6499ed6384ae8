"""Skins from the words of a command."""

from pathlib import Path

from skinfield.errors import FileError
from skinfield.layout.files import load_layout
from skinfield.layout.skin import Skin


def skin_from_text(text: str) -> Skin:
    """Skin from a layout file or, where no such file exists, from a generator by name.

    Parameters
    ----------
    text : str
        Such as ``"right_foot.txt"``, ``"hexagon72"`` or ``"rectangular:rows=8,columns=8"``.

    Raises
    ------
    FileError
        When it is neither a file nor the name of a generator, or the file cannot be used.
    InputError
        When an argument of the generator cannot be used.
    """
    from skinfield.layout.generators import by_name
    from skinfield.layout.generators.names import GENERATORS

    name = text.strip().partition(":")[0]
    if name in GENERATORS and not Path(text).is_file():
        patch = by_name(text)
        return Skin((patch,), name=patch.name)
    if not Path(text).exists():
        raise FileError(
            f"{text}: no such file, and no generator, expected the path of a layout file or one "
            f"of {', '.join(GENERATORS)}"
        )
    return load_layout(text)
