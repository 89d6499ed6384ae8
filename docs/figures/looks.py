"""Looks of curves and fields that the figures of several pages share."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

import skinfield as sf
from skinfield.errors import Floats
from skinfield.plot import INK
from skinfield.skin.maps import outline_pads

DASHES = ((0, (6, 2)), ":")


def dashed(figure: Figure, *names: str) -> None:
    """Draw curves of what cannot be surpassed dashed in ink, in all panels and in the legend."""
    lines = [(line.get_label(), line) for axes in figure.axes for line in axes.lines]
    for legend in figure.legends:
        words = [text.get_text() for text in legend.get_texts()]
        lines += zip(words, legend.get_lines(), strict=True)
    for turn, name in enumerate(names):
        for word, line in lines:
            if word == name:
                line.set(color=INK, ls=DASHES[turn % 2], lw=1.2)


def draw_field(axes: Any, patch: sf.Patch, grid: sf.Grid, field: Floats, **look: Any) -> Any:
    """Draw values (K,) on a grid, in mm, with the pads of the patch over them; the image."""
    low = (grid.origin - grid.pitch / 2) * 1e3
    high = low + np.array(grid.shape[::-1]) * grid.pitch * 1e3
    extent = low[0], high[0], low[1], high[1]
    image = axes.imshow(field.reshape(grid.shape), origin="lower", extent=extent, **look)
    outline_pads(axes, patch)
    return image
