"""Deformed surface in three dimensions, with rulers."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate import Estimate
from skinfield.plot import QUIET, signed_colours
from skinfield.skin import Grid, Patch
from skinfield.skin.maps import MM, axis_names, extent_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FACES = 90  # along one side: more are finer than the page, and a burden in a PDF
LEVELS = (1, 2, 5)
ZOOM = 1.0  # of the surface in the panel: there is room for the numbers around it


def draw_deformation(figure: "Figure", axes: Any, estimate: Estimate) -> float:
    """Draw the displaced surface on 3D axes; return by how much the indentation is exaggerated.

    A flat patch keeps its plane, with the indentation in mm downwards on an axis of its own scale;
    a curved one is drawn in space, moved along its normals.
    """
    grid = estimate.grid
    nodes, plane = _sheet(grid)
    depth = np.nan_to_num(estimate.indentation)[nodes]
    flat = grid.patch.surface.is_flat
    extent = float(np.ptp(plane.reshape(-1, 2), axis=0).max())
    factor = _exaggeration(0.15 * extent, float(np.abs(depth).max()))
    if flat:
        place = np.dstack([plane, -depth]) * MM
    else:
        position = grid.patch.surface.position_from_plane(plane.reshape(-1, 2))
        moved = position - factor * depth.reshape(-1, 1) * grid.normals[nodes.ravel()]
        place = moved.reshape(*nodes.shape, 3) * MM
    _scale(axes, place, factor if flat else 1.0, grid.patch)
    _draw_sheet(figure, axes, place, nodes, np.asarray(estimate.indentation) * MM)
    return factor


def _sheet(grid: Grid) -> tuple[NDArray[np.int64], Floats]:
    """Nodes to draw (R, C) with their plane (R, C, 2) m; a single row is widened to its cell."""
    low, high = (extent_of(grid, measured=True) - grid.origin) / grid.pitch

    def along(axis: int, count: int) -> tuple[NDArray[np.int64], Floats]:
        index = np.arange(count)
        index = index[(index > low[axis]) & (index < high[axis])]
        if len(index) == 1:
            return index.repeat(2), index + np.array([-0.5, 0.5])
        if len(index) > FACES:
            index = index[np.linspace(0, len(index) - 1, FACES).round().astype(np.int64)]
        return index, index.astype(np.float64)

    column, column_place = along(0, grid.shape[1])
    row, row_place = along(1, grid.shape[0])
    x, y = np.meshgrid(column_place, row_place)
    plane = np.asarray(grid.origin + np.dstack([x, y]) * grid.pitch)
    return row[:, None] * grid.shape[1] + column, plane


def _exaggeration(wanted: float, depth: float) -> float:
    """Largest of 1, 2, 5, 10, 20, ... that makes `depth` no deeper than `wanted`."""
    if not depth > 0:
        return 1.0
    steps = [level * 10.0**power for power in range(7) for level in LEVELS]
    return max((step for step in steps if step * depth <= wanted), default=1.0)


def _draw_sheet(
    figure: "Figure", axes: Any, place: Floats, nodes: NDArray[np.int64], depth: Floats
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LightSource

    colours, scale = signed_colours(depth)
    corners = depth[nodes]
    face = (corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:]) / 4
    axes.plot_surface(
        *np.moveaxis(place, -1, 0),
        facecolors=colours(scale(face)),
        rstride=1,
        cstride=1,
        edgecolor=(0.25, 0.25, 0.3, 0.25),
        linewidth=10.0 / max(nodes.shape[0], 40),
        lightsource=LightSource(azdeg=315, altdeg=55),
        antialiased=True,
        clip_on=False,
    )
    box = axes.get_position(original=True)
    beside = (box.x1 + 0.015, box.y0 + 0.1 * box.height, 0.012, 0.8 * box.height)
    bar = figure.colorbar(ScalarMappable(scale, colours), cax=figure.add_axes(beside))
    bar.set_label("indentation (mm)")
    bar.outline.set_linewidth(0.5)


def _scale(axes: Any, place: Floats, factor: float, patch: Patch) -> None:
    """Scale the axes alike, the depth of a flat patch by `factor`, and number them in mm."""
    from matplotlib.ticker import MaxNLocator

    flat = patch.surface.is_flat
    low, high = place.reshape(-1, 3).min(axis=0), place.reshape(-1, 3).max(axis=0)
    if flat:  # a flat sheet at rest still needs a box of some height
        thin = 0.02 * float((high - low)[:2].max()) / factor
        low[2], high[2] = min(low[2], -thin), max(high[2], thin)
    size = (high - low) * (1.0, 1.0, factor)
    size = np.maximum(size, 0.02 * size.max())
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_proj_type("ortho")
    axes.view_init(elev=46, azim=-62)
    axes.set_box_aspect(size, zoom=ZOOM)
    names = (*axis_names(patch), "") if flat else ("x", "y", "z")
    for axis, name, share in zip((axes.xaxis, axes.yaxis, axes.zaxis), names, size, strict=True):
        axis.pane.set_visible(False)
        axis.line.set(color=QUIET, linewidth=0.8)
        axis.set_tick_params(labelsize=7.5, pad=-2.0)
        if name:
            axis.labelpad = 14.0 if size[1] < 0.4 * size[0] else 8.0  # a wide sheet lies flatter
            axis.set_label_text(f"{name} (mm)")
            axis.set_major_locator(MaxNLocator(max(round(5 * share / size.max()), 1)))
        else:  # the depth of a flat patch is read from the colour
            axis.set_ticks([])
            axis.line.set_visible(False)
    axes.grid(False)
