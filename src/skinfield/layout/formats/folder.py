"""A folder of layout files: the parts of one robot, each in a file of its own."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from skinfield.errors import FileError
from skinfield.layout.finding import Finding
from skinfield.layout.formats.text import listed, many
from skinfield.layout.patch import Patch
from skinfield.layout.skin import Skin

Found = tuple[Skin, tuple[Finding, ...]]


def read_folder(
    path: Path, is_layout: Callable[[Path], bool], read: Callable[[Path], Found]
) -> Found:
    """Skin of all layout files of a folder, in the order of their names.

    Parameters
    ----------
    path : Path
    is_layout : function of a Path
        Whether a file is of a known format; others are left out, which a finding tells.
    read : function of a Path
        Skin and findings of one file.

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
    layouts = [file for file in files if is_layout(file)]
    if not layouts:
        raise FileError(
            f"{path}: none of its {many(len(files), 'file')} is a layout, expected a directory "
            "with a layout file for each part of the robot; those in it are not searched"
        )
    found = [(file, *read(file)) for file in layouts]
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
