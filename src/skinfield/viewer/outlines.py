"""Borders of contacts whose field is not known: circles on the skin."""

import math
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.layout import Patch

POINTS = 32


def outline_of(patch: Patch, row: Any) -> Floats:
    """Circle of a contact's area around its place, closed, (POINTS + 1, 3) m in the patch's frame.

    Parameters
    ----------
    patch : Patch
    row : record of CONTACT
        With `x`, `y` in the patch's plane, m, and `area`, m².
    """
    area = float(row["area"])
    radius = math.sqrt(max(area, 0.0) / math.pi) if math.isfinite(area) else 0.0
    angle = np.linspace(0.0, 2.0 * math.pi, POINTS + 1)
    plane = np.column_stack([np.cos(angle), np.sin(angle)]) * radius
    plane += np.array([float(row["x"]), float(row["y"])])
    return np.asarray(patch.surface.position_from_plane(plane))
