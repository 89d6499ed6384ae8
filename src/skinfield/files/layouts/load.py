"""Layouts: files of taxel positions in the formats of others, read, repaired and written.

A format is a module with NAME, EXTENSIONS, EXPECTED, ``sniff(data)``, whether the bytes look like
it, and ``parse(path)``, the `Content` that a file states; FileError names the line or key that
cannot be used. A further one is a file of its own and its name in `FORMATS`. skinfield's own are
written, too.
"""

from dataclasses import replace
from pathlib import Path
from types import ModuleType

from skinfield.errors import FileError, InputError
from skinfield.files.layouts import (
    cyskin,
    fingertip,
    icub_positions,
    own_npz,
    own_toml,
    pcd,
    skingui,
    skinware,
)
from skinfield.files.layouts.repair import Finding, mend
from skinfield.files.layouts.text import listed, many, read_bytes
from skinfield.settings import nearest
from skinfield.skin.generators import GENERATORS, by_name
from skinfield.skin.patch import Patch, Skin

ORDER = ("error", "warning", "info")
FORMATS: tuple[ModuleType, ...] = (
    own_toml, own_npz, cyskin, icub_positions, skingui, pcd, skinware, fingertip,
)  # fmt: skip


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
    return read_layout(Path(path))[0]


def lint(path: str | Path) -> list[Finding]:
    """Everything found in a layout file, errors first.

    Reading the file makes exactly the repairs that the messages name: the same code runs.

    Raises
    ------
    FileError
        When the file cannot be read at all, so that `load_layout` fails too.
    """
    findings = read_layout(Path(path))[1]
    return sorted(findings, key=lambda found: ORDER.index(found.severity))


def read_layout(path: Path) -> tuple[Skin, tuple[Finding, ...]]:
    """Skin of a layout file or of a folder of them, and all findings; raises as `load_layout`."""
    return _read_folder(path) if path.is_dir() else mend(format_of(path).parse(path))


def format_of(path: Path) -> ModuleType:
    """Format of a file, told by its content; the extension decides between several.

    Raises
    ------
    FileError
        When the file cannot be read or is of no known format.
    """
    data = read_bytes(path)
    fitting = fitting_formats(data)
    if not fitting:
        tried = "; ".join(f"{form.NAME} ({form.EXPECTED})" for form in FORMATS)
        what = "is empty" if not data.strip() else "is of no known format"
        raise FileError(f"{path}: {what}, expected a layout file; tried {tried}")
    return min(fitting, key=lambda form: path.suffix.lower() not in form.EXTENSIONS)


def fitting_formats(data: bytes) -> list[ModuleType]:
    """Formats that a file with these bytes may be of."""
    return [form for form in FORMATS if form.sniff(data)]


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
    name = text.strip().partition(":")[0]
    if name in GENERATORS and not Path(text).is_file():
        patch = by_name(text)
        return Skin((patch,), name=patch.name)
    if not Path(text).exists():
        raise FileError(
            f"{text}: no such file, and no generator, expected the path of a layout file or one "
            f"of {', '.join(GENERATORS)}{nearest(name, GENERATORS)}"
        )
    return load_layout(text)


def layout_format(text: str) -> str:
    """Name of a layout file's format, which its makers write; "generator", or "" of neither."""
    path = Path(text)
    try:
        if path.is_file():
            return str(format_of(path).NAME)
    except FileError:  # who reads it says why
        return ""
    return "generator" if text.partition(":")[0] in GENERATORS and not path.exists() else ""


def _read_folder(path: Path) -> tuple[Skin, tuple[Finding, ...]]:
    """Skin of all layout files of a folder, in the order of their names.

    Patches keep their names where each is there once; else those of the files stand before them.
    """
    try:
        files = sorted(f for f in path.iterdir() if f.is_file() and not f.name.startswith("."))
    except OSError as error:
        raise FileError(
            f"{path}: {error.strerror}, expected a folder that can be listed"
        ) from error
    layouts = [file for file in files if fitting_formats(read_bytes(file))]
    if not layouts:
        raise FileError(
            f"{path}: none of its {many(len(files), 'file')} is a layout, expected a directory "
            "with a layout file for each part of the robot; those in it are not searched"
        )
    found = [(file, *read_layout(file)) for file in layouts]
    name = path.resolve().name  # of ".", too
    findings = [each for _, _, its in found for each in its]
    notes = [note for _, skin, _ in found for note in skin.notes]
    name = path.name if path.name not in ("", "..") else path.resolve().name or "skin"
    others = [file.name for file in files if file not in layouts]
    if others:
        count = f"{many(len(others), 'file')} ({listed(others)})"
        text = f"{name}: {count} of no layout format; left out"
        findings.append(Finding("no-layout", "info", text))
        notes.append(text)
    patches = _distinct([(file.stem, patch) for file, skin, _ in found for patch in skin])
    return Skin(patches, name=name, notes=tuple(notes)), tuple(findings)


def _distinct(patches: list[tuple[str, Patch]]) -> tuple[Patch, ...]:
    """Patches under names that are there once."""
    if len({patch.name for _, patch in patches}) == len(patches):
        return tuple(patch for _, patch in patches)
    names = [f"{stem}/{patch.name}" for stem, patch in patches]
    if len(set(names)) < len(names):  # one stem, two extensions
        names = [f"{name} ({place})" for place, name in enumerate(names)]
    return tuple(replace(patch, name=name) for name, (_, patch) in zip(names, patches, strict=True))
