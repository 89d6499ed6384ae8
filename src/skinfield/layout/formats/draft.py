"""A layout as its file states it, before any repair."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.layout.finding import Finding


@dataclass(frozen=True, eq=False)
class Draft:
    """One patch as a file states it; what the file does not state is None.

    Parameters
    ----------
    positions, normals : (N, 3) arrays
        m and unitless, as written: the file may have meant millimetres, or left normals empty.
    rows : (N,) int array
        Where each taxel stands in the file's own table, from 0.
    stated : bool
        Whether the format states units and directions on purpose: then nothing is changed.
    """

    positions: Floats
    rows: Ints
    normals: Floats | None = None
    module: Ints | None = None
    uid: NDArray[np.uint64] | None = None
    channel: Ints | None = None
    n_channels: int = 0
    pad_diameter: float | None = None
    name: str = "patch"
    link: str = ""
    link_from_patch: Floats | None = None
    stated: bool = False


@dataclass(frozen=True, eq=False)
class Content:
    """All that one file holds.

    Parameters
    ----------
    path : Path
        Of the file.
    name : str
        Of the skin.
    drafts : tuple of Draft
    findings : tuple of Finding
        What reading the file brought up: rows left out, lines that say two things.
    notes : tuple of str
        Sentences that the file itself carries.
    """

    path: Path
    name: str
    drafts: tuple[Draft, ...]
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = field(default=())
