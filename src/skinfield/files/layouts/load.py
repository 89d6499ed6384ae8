"""Reading and writing layouts; the formats are loaded when a file is."""

from pathlib import Path

from skinfield.errors import FileError, InputError
from skinfield.skin.patch import Patch, Skin


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
    from skinfield.files.layouts import read_layout

    return read_layout(Path(path))[0]


def save_layout(skin: Skin | Patch, path: str | Path) -> None:
    """Write a skin to a file of skinfield's own, from which all of it is read again.

    Parameters
    ----------
    skin : Skin or Patch
    path : str or Path
        Ends in .toml or .npz.

    Raises
    ------
    InputError
        When it ends otherwise.
    FileError
        When the file cannot be written.
    """
    from skinfield.files.layouts import own_npz, own_toml

    path = Path(path)
    form = {".toml": own_toml, ".npz": own_npz}.get(path.suffix.lower())
    if form is None:
        raise InputError(
            f"{path}: the extension {path.suffix!r} is of no layout format that is written, "
            "expected .toml or .npz, skinfield's own"
        )
    form.write(Skin((skin,), name=skin.name) if isinstance(skin, Patch) else skin, path)


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
    from skinfield.skin.generators import GENERATORS, by_name

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


def layout_format(text: str) -> str:
    """Name of a layout file's format, which its makers write; "generator", or "" of neither."""
    from skinfield.files.layouts import format_of
    from skinfield.skin.generators import GENERATORS

    path = Path(text)
    try:
        if path.is_file():
            return format_of(path).NAME
    except FileError:  # who reads it says why
        return ""
    return "generator" if text.partition(":")[0] in GENERATORS and not path.exists() else ""
