"""Reading and writing layouts; the formats are loaded when a file is."""

from pathlib import Path
from typing import TYPE_CHECKING

from skinfield.layout.patch import Patch
from skinfield.layout.skin import Skin

if TYPE_CHECKING:
    from skinfield.layout.formats import Format


def load_layout(path: str | Path) -> Skin:
    """Read a layout file of any known format; what was repaired stands in the skin's notes.

    Parameters
    ----------
    path : str or Path
        Of a file; or of a folder whose files are the parts of one robot: their patches become one
        skin, in the order of the files' names. Files of no known format are left out and noted.

    Raises
    ------
    FileError
        When the file cannot be read, is of no known format, or holds no usable skin; when a folder
        holds no layout file, or any of them cannot be used.
    """
    from skinfield.layout.formats import read_layout

    return read_layout(Path(path))[0]


def save_layout(
    skin: Skin | Patch, path: str | Path, form: "Format | None" = None
) -> tuple[str, ...]:
    """Write a skin to a file; return what the format cannot hold, in sentences.

    Parameters
    ----------
    skin : Skin or Patch
    path : str or Path
    form : a module of `skinfield.layout.formats`, optional
        By default the usual format of the file's extension.

    Raises
    ------
    InputError
        When the extension is of no format, or the format cannot hold the skin.
    FileError
        When the file cannot be written.
    """
    from skinfield.layout.formats import format_by_extension

    path = Path(path)
    if isinstance(skin, Patch):
        skin = Skin((skin,), name=skin.name)
    return (form or format_by_extension(path)).write(skin, path)
