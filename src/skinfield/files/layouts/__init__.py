"""Layouts: files of taxel positions in the formats of others, read, repaired and written.

A format is a module with NAME, EXTENSIONS, EXPECTED, ``sniff(data)`` and ``parse(path)``; a further
one is a file of its own and its name in `FORMATS`. skinfield's own are written, too.
"""

from dataclasses import replace
from pathlib import Path
from typing import Protocol, cast

from skinfield.errors import FileError
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
from skinfield.files.layouts.repair import Content, Finding, mend
from skinfield.files.layouts.text import listed, many, read_bytes
from skinfield.skin.patch import Patch, Skin

ORDER = ("error", "warning", "info")


class Format(Protocol):
    """What a module of a format offers."""

    NAME: str
    EXTENSIONS: tuple[str, ...]
    EXPECTED: str

    def sniff(self, data: bytes) -> bool:
        """Whether the bytes look like this format."""
        ...

    def parse(self, path: Path) -> Content:
        """Contents of a file, as it states them."""
        ...


FORMATS = cast(
    tuple[Format, ...],
    (own_toml, own_npz, cyskin, icub_positions, skingui, pcd, skinware, fingertip),
)
"""All known formats."""


def read_layout(path: Path) -> tuple[Skin, tuple[Finding, ...]]:
    """Skin of a layout file or of a folder of them, and everything that was found on the way.

    Raises
    ------
    FileError
        As `load_layout`.
    """
    if path.is_dir():
        return _read_folder(path)
    return mend(format_of(path).parse(path))


def format_of(path: Path) -> Format:
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
    extension = path.suffix.lower()
    return min(fitting, key=lambda form: extension not in form.EXTENSIONS)


def fitting_formats(data: bytes) -> list[Format]:
    """Formats that a file with these bytes may be of."""
    return [form for form in FORMATS if form.sniff(data)]


def _read_folder(path: Path) -> tuple[Skin, tuple[Finding, ...]]:
    """Skin of all layout files of a folder, in the order of their names.

    Notes
    -----
    Patches keep their names where each is there once; else those of the files stand before them.

    Raises
    ------
    FileError
        When the folder cannot be listed or holds no layout file, or one of them cannot be used.
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
    findings = [each for _, _, its in found for each in its]
    notes = [note for _, skin, _ in found for note in skin.notes]
    others = [file.name for file in files if file not in layouts]
    if others:
        count = f"{many(len(others), 'file')} ({listed(others)})"
        text = f"{path.name}: {count} of no layout format; left out"
        findings.append(Finding("no-layout", "info", text))
        notes.append(text)
    patches = _distinct([(file.stem, patch) for file, skin, _ in found for patch in skin])
    return Skin(patches, name=path.name, notes=tuple(notes)), tuple(findings)


def _distinct(patches: list[tuple[str, Patch]]) -> tuple[Patch, ...]:
    """Patches under names that are there once."""
    if len({patch.name for _, patch in patches}) == len(patches):
        return tuple(patch for _, patch in patches)
    names = [f"{stem}/{patch.name}" for stem, patch in patches]
    if len(set(names)) < len(names):  # one stem, two extensions
        names = [f"{name} ({place})" for place, name in enumerate(names)]
    return tuple(replace(patch, name=name) for name, (_, patch) in zip(names, patches, strict=True))


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
