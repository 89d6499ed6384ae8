"""Maps in the plane of a patch: pads, cells, and what no taxel covers."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.plot import FAINT, INK, QUIET, signed_colours
from skinfield.skin import Grid, Patch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import EllipseCollection
    from matplotlib.image import AxesImage


MM = 1e3
RIM = 0.62  # from the centre of a pad to the outline of its module, in diameters


def extent_of(grid: Grid, *, measured: bool = False) -> Floats:
    """Low and high corner (2, 2) m of all pads and cells; `measured`: of cells among taxels only.

    A square grid over a long patch is mostly cells where nothing is measured: pictures of an
    estimate leave them out.
    """
    patch = grid.patch
    cells = grid.plane[grid.covered] if measured and grid.covered.any() else grid.plane
    half_cell, half_pad = grid.pitch / 2, patch.pad_diameter * RIM
    low = np.minimum(cells.min(axis=0) - half_cell, patch.plane.min(axis=0) - half_pad)
    high = np.maximum(cells.max(axis=0) + half_cell, patch.plane.max(axis=0) + half_pad)
    return np.array([low, high])


def frame_axes(axes: "Axes", patch: Patch, extent: Floats) -> None:
    """Set limits that hold `extent` (2, 2) m, equal scales, and labels in mm."""
    margin = 0.02 * float((extent[1] - extent[0]).max())
    low, high = (extent[0] - margin) * MM, (extent[1] + margin) * MM
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal", adjustable="box", anchor="NW")
    first, second = axis_names(patch)
    axes.set(xlabel=f"{first} (mm)", ylabel=f"{second} (mm)")


def axis_names(patch: Patch) -> tuple[str, str]:
    """Names of the axes of a patch's plane: x and y where they are the patch's own."""
    frame = patch.surface.frame_from_plane(np.zeros((1, 2)))[0]
    if patch.surface.is_flat and np.allclose(frame, np.eye(3), atol=1e-9):
        return "x", "y"
    where = "in its plane" if patch.surface.is_flat else "along the skin"
    return f"u {where}", f"v {where}"


def draw_pads(axes: "Axes", patch: Patch, values: Floats) -> "EllipseCollection":
    """Draw pads to scale, coloured by `values` (L,); where NaN, hollow and crossed."""
    from matplotlib.collections import LineCollection

    draw_modules(axes, patch)
    known = np.isfinite(values)
    colours, scale = signed_colours(values)
    pads = draw_circles(axes, patch, known, edgecolors=QUIET, linewidths=0.4)
    pads.set(array=values[known], cmap=colours, norm=scale)
    if not known.all():
        draw_circles(axes, patch, ~known, facecolors="none", edgecolors=INK, lw=0.7)
        reach = patch.pad_diameter / 2 * np.sqrt(0.5) * MM
        arms = np.array([[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]]) * reach
        crosses = (patch.plane[~known] * MM)[:, None, None, :] + arms
        axes.add_collection(LineCollection(list(crosses.reshape(-1, 2, 2)), colors=INK, lw=0.7))
    return pads


def outline_pads(axes: "Axes", patch: Patch) -> None:
    """Draw the rims of the pads alone, over another picture."""
    draw_circles(axes, patch, facecolors="none", edgecolors=QUIET, lw=0.5)


def draw_circles(
    axes: "Axes", patch: Patch, rows: NDArray[np.bool_] | None = None, **look: Any
) -> "EllipseCollection":
    """Draw pads to scale, all or those of some rows (L,)."""
    from matplotlib.collections import EllipseCollection

    places = (patch.plane if rows is None else patch.plane[rows]) * MM
    width = np.full(len(places), patch.pad_diameter * MM)
    angle, to = np.zeros_like(width), axes.transData
    look |= {"units": "xy", "offsets": places, "offset_transform": to}
    pads = EllipseCollection(width, width, angle, **look)
    axes.add_collection(pads)
    return pads


def extent_of_pads(patch: Patch) -> Floats:
    """Low and high corner (2, 2) m of the pads, with some room around."""
    rim = patch.pad_diameter
    return np.array([patch.plane.min(axis=0) - rim, patch.plane.max(axis=0) + rim])


def draw_modules(axes: "Axes", patch: Patch) -> None:
    """Outline each module: the convex hull of its pads, lightly."""
    from matplotlib.collections import PolyCollection
    from scipy.spatial import ConvexHull

    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    rim = np.column_stack([np.cos(turn), np.sin(turn)]) * patch.pad_diameter * RIM
    hulls = []
    for module in np.unique(patch.module):
        points = (patch.plane[patch.module == module][:, None] + rim).reshape(-1, 2) * MM
        hulls.append(points[ConvexHull(points).vertices])
    axes.add_collection(
        PolyCollection(hulls, facecolors="#f5f5f8", edgecolors=FAINT, linewidths=0.8, zorder=0.5)
    )


def draw_cells(axes: "Axes", grid: Grid, values: Floats, **look: Any) -> "AxesImage":
    """Draw values (K,) or a picture (rows, columns) on the cells; signed colours by default."""
    if not look:
        colours, scale = signed_colours(values)
        look = {"cmap": colours, "norm": scale}
    low = (grid.origin - grid.pitch / 2) * MM
    high = low + np.array(grid.shape[::-1]) * grid.pitch * MM
    picture = values.reshape(grid.shape)
    return axes.imshow(picture, origin="lower", extent=(low[0], high[0], low[1], high[1]), **look)


def hatch_uncovered(axes: "Axes", grid: Grid) -> None:
    """Dim and hatch the cells outside the hull of the taxels: nothing is measured there."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    bare = np.pad(~grid.covered.reshape(grid.shape), ((0, 0), (1, 1))).astype(int)
    change = np.diff(bare, axis=1)  # each row is a few runs of cells: one rectangle a run
    row, start = np.nonzero(change == 1)
    stop = np.nonzero(change == -1)[1]
    if not len(row):
        return
    left, right, bottom = start - 0.5, stop - 0.5, row - 0.5
    corners = [(left, bottom), (right, bottom), (right, bottom + 1), (left, bottom + 1)]
    boxes = [np.column_stack(corner) for corner in [*corners, corners[0]]]
    vertices = (grid.origin + np.stack(boxes, axis=1) * grid.pitch) * MM
    codes = np.tile([Path.MOVETO, *[Path.LINETO] * 3, Path.CLOSEPOLY], len(row))
    outside = Path(vertices.reshape(-1, 2), codes)
    axes.add_patch(PathPatch(outside, facecolor="white", alpha=0.6, lw=0.0, zorder=1.5))
    axes.add_patch(
        PathPatch(outside, facecolor="none", edgecolor=FAINT, hatch="/////", lw=0.0, zorder=1.6)
    )
