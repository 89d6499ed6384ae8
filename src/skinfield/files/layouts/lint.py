"""Lint of layouts: what is wrong, what it means, and what reading does about it."""

from pathlib import Path

import numpy as np

from skinfield.files.layouts import read_layout
from skinfield.files.layouts.repair import Content, Draft, mend
from skinfield.files.layouts.repair import Finding as Finding
from skinfield.skin.patch import Patch, Skin

ORDER = ("error", "warning", "info")


def lint(path: str | Path) -> list[Finding]:
    """Everything found in a layout file, errors first.

    Reading the file makes exactly the repairs that the messages name: the same code runs.

    Raises
    ------
    FileError
        When the file cannot be read at all, so that `load_layout` fails too.
    """
    return _sorted(read_layout(Path(path))[1])


def lint_skin(skin: Skin) -> list[Finding]:
    """Everything found in a skin made by a program, errors first; nothing is changed."""
    drafts = tuple(_draft(patch) for patch in skin)
    return _sorted(mend(Content(Path(skin.name), skin.name, drafts))[1])


def _sorted(findings: tuple[Finding, ...]) -> list[Finding]:
    return sorted(findings, key=lambda found: ORDER.index(found.severity))


def _draft(patch: Patch) -> Draft:
    return Draft(
        patch.positions,
        np.arange(len(patch)),
        patch.normals,
        uid=patch.uid,
        pad_diameter=patch.pad_diameter,
        name=patch.name,
        stated=True,
    )
