"""What a skin cannot see, as a map and along a line."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_shape
from skinfield.figures.maps import MM, axis_names, draw_cells, outline_pads
from skinfield.figures.style import (
    BLUE,
    FAINT,
    ORANGE,
    QUIET,
    TITLE,
    add_title,
    new_figure,
    number,
    style,
)
from skinfield.layout import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SAMPLES = 600


def draw_blindness(
    grid: Grid,
    values: ArrayLike,
    *,
    label: str = "response to 1 N",
    unit: str = "",
    line: ArrayLike | None = None,
    floor: float | None = None,
    floor_label: str = "noise",
    title: str = "What the skin can and cannot see",
) -> "Figure":
    """Figure of a sensitivity over the patch, and its profile along a line across the pads.

    Parameters
    ----------
    grid : Grid
        With two nodes or more along either side.
    values : (K,) array
        Sensitivity at each node in `unit`: the largest response of a taxel to a unit force there,
        or the norm of the node's column of the observation.
    label, unit : str
        Of the sensitivity.
    line : (2, 2) array, m, optional
        Start and end of the profile in the patch's plane; by default level through the least
        sensitive node among the taxels.
    floor : float, optional
        A level in `unit` below which nothing is told from noise.
    floor_label : str
        What that level is.
    title : str

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    InputError
        If `values` is not one finite number per node, or the line leaves the grid.
    """
    values = as_floats("values", values)
    check_shape("values", values, (len(grid),), "one per node of the grid")
    check_finite("values", values, "a sensitivity is known at every node")
    ends = _default_line(grid, values) if line is None else as_floats("line", line)
    check_shape("line", ends, (2, 2), "start and end in the patch's plane, m")
    along, profile, points = _profile(grid, values, ends)
    worded = f"{label} ({unit})" if unit else label
    with style():
        figure = new_figure(10.0, 4.6)
        figure.text(0.02, 0.95, title, va="center", **TITLE)
        axes = figure.add_axes((0.065, 0.12, 0.37, 0.66))
        draw_cells(axes, grid, values, worded)
        outline_pads(axes, grid.patch)
        axes.plot(*(ends * MM).T, color=BLUE, lw=1.3, ls=(0, (4, 2)))
        add_title(axes, "a", "Over the patch", "circles: pads; white: blind; dashed: line of b")
        beside = figure.add_axes((0.59, 0.135, 0.385, 0.645))
        _draw_profile(beside, along, profile, _over_pads(grid, points), worded)
        if floor is not None:
            beside.axhline(
                floor, color=ORANGE, lw=1.1, label=f"{floor_label} {number(floor, 2)} {unit}"
            )
            beside.legend(frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1, 1))
        add_title(beside, "b", "Along the line", "grey: the line is over a pad")
    return figure


def _default_line(grid: Grid, values: Floats) -> Floats:
    candidates = np.flatnonzero(grid.covered) if grid.covered.any() else np.arange(len(grid))
    level = grid.plane[candidates[values[candidates].argmin()], 1]
    span = grid.plane[:, 0]
    return np.array([[span.min(), level], [span.max(), level]])


def _profile(grid: Grid, values: Floats, ends: Floats) -> tuple[Floats, Floats, Floats]:
    """Distance along the line (N,) m, values there (bilinear), and its points (N, 2) m."""
    from scipy.ndimage import map_coordinates

    length = float(np.linalg.norm(ends[1] - ends[0]))
    share = np.linspace(0.0, 1.0, SAMPLES)
    points = ends[0] + share[:, None] * (ends[1] - ends[0])
    cells = (points - grid.origin) / grid.pitch
    limit = np.array(grid.shape[::-1]) - 1
    if not (length > 0 and (cells >= -0.5 - 1e-9).all() and (cells <= limit + 0.5 + 1e-9).all()):
        first, second = axis_names(grid.patch)
        low, high = grid.origin * MM, (grid.origin + limit * grid.pitch) * MM
        raise InputError(
            f"line is {ends.tolist()} m, expected two points inside the grid: {first} from "
            f"{low[0]:.1f} to {high[0]:.1f} mm and {second} from {low[1]:.1f} to {high[1]:.1f} mm"
        )
    picture = values.reshape(grid.shape)
    profile = map_coordinates(picture, cells[:, ::-1].T, order=1, mode="nearest")
    return share * length, np.asarray(profile, dtype=np.float64), points


def _over_pads(grid: Grid, points: Floats) -> NDArray[np.bool_]:
    from scipy.spatial import cKDTree

    distance = np.asarray(cKDTree(grid.patch.plane).query(points)[0])
    return np.asarray(distance <= grid.patch.pad_diameter / 2)


def _draw_profile(
    axes: "Axes", along: Floats, profile: Floats, over: NDArray[np.bool_], label: str
) -> None:
    top = max(float(profile.max()) * 1.12, 1e-300)
    axes.fill_between(along * MM, 0, top, where=over.tolist(), color=FAINT, alpha=0.5, lw=0)
    axes.plot(along * MM, profile, color=BLUE)
    axes.set(xlim=(0, along[-1] * MM), ylim=(min(0.0, float(profile.min())), top))
    axes.set(xlabel="distance along the line (mm)", ylabel=label)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(color=QUIET)
