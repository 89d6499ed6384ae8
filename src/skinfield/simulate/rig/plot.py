"""Figure of a virtual rig's recording: pressing, the load cell, and the taxels over time."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.plot import BLUE, INK, ORANGE, QUIET, add_title, new_figure, number, open_axes, style
from skinfield.simulate.rig import RigRun
from skinfield.skin.maps import MM, draw_circles, extent_of_pads, frame_axes
from skinfield.skin.plot import COLOURS, draw_channels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TAXELS = 4
LEGEND: dict[str, Any] = {
    "frameon": False, "fontsize": 7.5, "loc": "lower right", "bbox_to_anchor": (1.0, 0.985),
    "borderaxespad": 0.1, "columnspacing": 1.0, "handlelength": 1.4,
}  # fmt: skip


def draw_rig_run(run: RigRun) -> "Figure":
    """Figure of a rig's recording: force, position and counts over time, and places on the patch.

    Parameters
    ----------
    run : RigRun

    Returns
    -------
    matplotlib Figure
    """
    with style():
        figure = new_figure(10.8, 7.2)
        rows = [figure.add_axes((0.075, low, 0.55, 0.215)) for low in (0.715, 0.395, 0.075)]
        for axes in rows[:2]:
            axes.sharex(rows[2])
            axes.tick_params(labelbottom=False)
        most = np.abs(run.truth.reading_change).max(axis=0)
        near = np.argsort(-most, kind="stable")[:TAXELS].astype(np.int64)  # the liveliest first
        _draw_force(rows[0], run)
        _draw_height(rows[1], run)
        _draw_counts(rows[2], run, near)
        for axes in rows:
            open_axes(axes)
        rows[2].set_xlabel("time (s)")
        _draw_places(figure.add_axes((0.70, 0.30, 0.285, 0.47)), run, near)
        tool = run.scenario.tools[0]
        truth, presses = run.truth, len(run.truth.press_load)
        words = (
            f"{presses} press{'' if presses == 1 else 'es'}, {number(float(truth.time_s[-1]))} s, "
            f"{len(run.recording)} readings\nup to {number(float(truth.force_N.max()))} N, "
            f"{number(float(truth.depth_m.max() * MM), 2)} mm deep in "
            f"{number(run.scenario.layer.thickness * MM)} mm"
        )
        figure.text(0.70, 0.945, f"{run.scenario.name}: {tool.name}", weight="bold", fontsize=12)
        figure.text(0.70, 0.92, words, color=QUIET, fontsize=8, va="top")
    return figure


def _draw_force(axes: "Axes", run: RigRun) -> None:
    truth, cell = run.truth, run.load_cell
    axes.plot(cell.stamp_ns * 1e-9, cell.force, color="#9ecae8", lw=3.2, label="load cell")
    axes.plot(truth.time_s, truth.force_N, color=INK, lw=0.9, label="true force")
    axes.plot(
        truth.time_s,
        _by_place(run, truth.effective_force_N),
        color=ORANGE,
        lw=0.9,
        ls="--",
        label="elastic force of that deformation",
    )
    full = cell.saturated
    if full.any():
        axes.plot(
            cell.stamp_ns[full] * 1e-9, cell.force[full], ".", ms=2.5, color=BLUE,
            label="at the cell's end",
        )  # fmt: skip
    axes.set_ylabel("force (N)")
    axes.legend(ncols=4, **LEGEND)
    add_title(axes, "A", "Force")


def _by_place(run: RigRun, series: Floats) -> Floats:
    """Series with a gap wherever the indenter goes on to another place."""
    truth, out = run.truth, series.copy()
    places = np.column_stack([truth.press_x_m, truth.press_y_m, truth.press_angle_rad])
    moved = np.flatnonzero((places[1:] != places[:-1]).any(axis=1)) + 1
    out[np.searchsorted(truth.time_s, truth.press_start_s[moved])] = np.nan
    return out


def _draw_height(axes: "Axes", run: RigRun) -> None:
    truth = run.truth
    axes.axhline(0.0, color=QUIET, lw=0.7)
    axes.plot(
        truth.time_s, truth.height_m * 1e3, color=INK, lw=1.0, label="indenter's lowest point"
    )
    skin = _by_place(run, -truth.depth_m * 1e3)
    axes.plot(truth.time_s, skin, color=BLUE, lw=1.0, label="skin below it")
    axes.set_yscale("symlog", linthresh=1.0)
    deepest = float(truth.depth_m.max() * 1e3)
    top = max(run.scenario.profile.clearance * 1e3, 1.0)
    axes.set_ylim(-1.25 * deepest, 1.3 * top)
    ticks = [tick for tick in (-2, -1, -0.5, 0, 0.5, 1, 2, 5, 10) if -1.2 * deepest < tick <= top]
    axes.set_yticks(ticks, [f"{tick:g}".replace("-", "−") for tick in ticks])
    axes.minorticks_off()
    axes.set_ylabel("height (mm)")
    axes.legend(ncols=2, **LEGEND)
    add_title(axes, "B", "Position", "linear within 1 mm, logarithmic beyond")


def _draw_counts(axes: "Axes", run: RigRun, near: Ints) -> None:
    draw_channels(axes, run.recording, near.tolist(), "taxel")
    axes.legend(ncols=4, reverse=True, **LEGEND)
    add_title(axes, "C", "What the skin sends", "the liveliest taxels")


def _draw_places(axes: "Axes", run: RigRun, near: Ints) -> None:
    truth, patch = run.truth, run.scenario.patch
    colours = ["none"] * len(patch)
    for row, colour in zip(near, COLOURS, strict=False):
        colours[int(row)] = colour
    draw_circles(axes, patch, facecolors=colours, edgecolors=QUIET, linewidths=0.6)
    places = np.column_stack([truth.press_x_m, truth.press_y_m])
    axes.plot(*places.T * MM, "+", color=INK, ms=8, mew=1.3)
    extent = extent_of_pads(patch)
    low, high = np.minimum(extent[0], places.min(axis=0)), np.maximum(extent[1], places.max(axis=0))
    frame_axes(axes, patch, np.array([low, high]))
    add_title(axes, "D", "Places", f"+ pressed; colours as in C; {patch.name}")
