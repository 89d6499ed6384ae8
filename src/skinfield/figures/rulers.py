"""Rulers along the edges of a 3D picture, laid out on the page so that no number is covered."""

from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.figures.style import QUIET

TICK, NUMBER, NAME = 3.0, 12.0, 27.0  # points from the edge: ends of ticks, middles of words


def project(axes: Any, points: Floats) -> Floats:
    """Points (N, 3) of 3D axes in their picture plane (N, 2)."""
    seen = np.column_stack([points, np.ones(len(points))]) @ axes.get_proj().T
    return np.asarray(seen[:, :2] / seen[:, 3:])


def draw_ruler(axes: Any, start: Floats, end: Floats, inside: Floats, name: str, n: int) -> None:
    """Draw an edge with about `n` numbers and its name, on the side away from `inside`.

    `start` and `end` (3,) differ in one coordinate, which the numbers tell.
    """
    from matplotlib.lines import Line2D
    from matplotlib.ticker import MaxNLocator

    along = int(np.abs(end - start).argmax())
    values = MaxNLocator(n).tick_values(start[along], end[along])
    values = values[(values >= start[along]) & (values <= end[along])]
    share = (values - start[along]) / (end[along] - start[along])
    places = project(axes, start + share[:, None] * (end - start))
    first, last, middle = project(axes, np.array([start, end, inside]))
    way = last - first
    outward = np.array([-way[1], way[0]]) / np.hypot(*way)
    outward *= np.sign(outward @ (first - middle))
    edge = np.array([first, last])
    axes.add_line(Line2D(*edge.T, color=QUIET, lw=0.8, clip_on=False))
    for place, value in zip(places, values, strict=True):
        _tick(axes, place, TICK * outward)
        _write(axes, place, NUMBER * outward, f"{value:g}".replace("-", "−"), 7.5, 0.0)
    turn = (
        np.degrees(np.arctan2(way[1], way[0])) + 89.0
    ) % 180.0 - 89.0  # read from the right if upright
    _write(axes, (first + last) / 2, NAME * outward, name, 9.0, turn)


def _tick(axes: Any, place: Floats, shift: Floats) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.transforms import ScaledTranslation

    inches = axes.figure.dpi_scale_trans + ScaledTranslation(place[0], place[1], axes.transData)
    ends = np.array([[0.0, 0.0], shift / 72.0])
    axes.add_line(Line2D(*ends.T, transform=inches, color=QUIET, lw=0.8, clip_on=False))


def _write(axes: Any, place: Floats, shift: Floats, words: str, size: float, turn: float) -> None:
    from matplotlib.transforms import ScaledTranslation

    x, y = shift / 72.0
    moved = axes.transData + ScaledTranslation(x, y, axes.figure.dpi_scale_trans)
    axes.text2D(
        *place,
        words,
        transform=moved,
        fontsize=size,
        rotation=turn,
        ha="center",
        va="center",
        rotation_mode="anchor",
    )
