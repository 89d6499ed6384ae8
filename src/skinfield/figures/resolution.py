"""Point spread, cross-talk and the measures of a solver's resolution."""

from typing import TYPE_CHECKING

import numpy as np

from skinfield.figures.maps import MM, draw_cells, hatch_uncovered, outline_pads
from skinfield.figures.style import INK, TITLE, add_title, new_figure, style
from skinfield.resolution import ResolutionMatrix, SpreadMetrics

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_spread(resolution: ResolutionMatrix, node: int, *, title: str = "") -> "Figure":
    """Figure of a node's point spread and of its cross-talk, side by side.

    Parameters
    ----------
    resolution : ResolutionMatrix
    node : int
    title : str
    """
    grid = resolution.grid
    place = grid.plane[node] * MM
    head = title or f"Resolution at ({place[0]:.1f}, {place[1]:.1f}) mm of {grid.patch.name}"
    panels = (
        (resolution.point_spread(node), "Point spread", "what 1 Pa on the marked cell looks like"),
        (resolution.cross_talk(node), "Cross-talk", "which loads leak into the marked cell"),
    )
    with style():
        figure = new_figure(10.4, 5.0)
        figure.text(0.02, 0.94, head, **TITLE)
        for index, (values, name, note) in enumerate(panels):
            axes = figure.add_axes((0.065 + 0.49 * index, 0.11, 0.36, 0.68))
            draw_cells(axes, grid, values, "Pa / Pa")
            outline_pads(axes, grid.patch)
            axes.plot(*place, marker="+", ms=9, mew=1.4, color=INK)
            add_title(axes, "ab"[index], name, note)
    return figure


def draw_spread_metrics(
    metrics: SpreadMetrics, *, title: str = "Resolution of a solver"
) -> "Figure":
    """Figure of the measures of all nodes as maps; hatched where nothing is measured.

    Parameters
    ----------
    metrics : SpreadMetrics
    title : str
    """
    panels = (
        (metrics.peak_error * MM, "distance (mm)", "Peak", "from the node to the largest value"),
        (metrics.centre_error * MM, "distance (mm)", "Centre of gravity", "from the node to it"),
        (metrics.dispersion * MM, "distance (mm)", "Dispersion", "root of the mean square"),
        (metrics.recovered, "N / N", "Sum", "of a point spread: the force found of 1 N"),
    )
    grid = metrics.grid
    with style():
        figure = new_figure(10.4, 9.2)
        figure.text(0.02, 0.965, title, **TITLE)
        for index, (values, label, name, note) in enumerate(panels):
            row, column = divmod(index, 2)
            box = (0.065 + 0.49 * column, 0.535 - 0.475 * row, 0.36, 0.365)
            axes = figure.add_axes(box)
            draw_cells(axes, grid, np.where(np.isfinite(values), values, np.nan), label)
            hatch_uncovered(axes, grid)
            outline_pads(axes, grid.patch)
            add_title(axes, "abcd"[index], name, note)
    return figure
