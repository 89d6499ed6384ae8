"""Small multiples: panels of curves under one legend, and fields on several grids side by side."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.plot import FAINT, INK, QUIET, add_colour_bar, add_title, new_figure, style
from skinfield.skin import Grid
from skinfield.skin.maps import MM, draw_cells, extent_of, frame_axes, outline_pads

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette without its yellow, which is faint on white.
COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#1b1b1f")
MARKS = ("o", "s", "^", "D", "v", "P", "X")
WIDTH, PANEL, HEAD, LEGEND_LINE = 9.6, 2.4, 0.72, 0.24  # inches
FEW = 300.0  # ratio of the ends of an axis of few decades


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve with its name; of one name, it has one colour in all panels of a figure.

    Parameters
    ----------
    name : str
    x, y : (N,) arrays
    low, high : (N,) arrays, optional
        Ends of the interval of y.
    """

    name: str
    x: Floats
    y: Floats
    low: Floats | None = None
    high: Floats | None = None


@dataclass(frozen=True, kw_only=True)
class Scale:
    """Names of the axes with their units, and how they are divided."""

    x: str
    y: str
    log_x: bool = False
    log_y: bool = False
    x_limits: tuple[float, float] | None = None
    y_limits: tuple[float | None, float | None] | None = None
    x_ticks: tuple[float, ...] | None = None
    marks: bool = False


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over one pair of axes; `marked` is an x with a dotted line."""

    title: str
    note: str
    curves: tuple[Curve, ...]
    scale: Scale
    marked: float | None = None


@dataclass(frozen=True, eq=False)
class FieldPanel:
    """One field.

    Parameters
    ----------
    title : str
    grid : Grid
    values : (K,) array
        In the unit of the figure.
    presses : sequence of (x, y, radius), m
        True contacts in the plane.
    """

    title: str
    grid: Grid
    values: Floats
    presses: Sequence[tuple[float, float, float]] = ()


def draw_panels(
    rows: Sequence[Sequence[Panel]], panel_height: float = PANEL, foot: str = ""
) -> "Figure":
    """Figure of panels in rows over one legend.

    Parameters
    ----------
    rows : sequence of rows of Panel
        As many in each row.
    panel_height : float, inches
    foot : str
        A line above the legend.
    """
    columns = len(rows[0])
    curves = [curve for row in rows for panel in row for curve in panel.curves]
    names = list(dict.fromkeys(curve.name for curve in curves))
    per_line = min(2 if max(map(len, names)) > 30 else 3, len(names))
    lines = -(-len(names) // per_line) + bool(foot)
    height = len(rows) * (panel_height + HEAD) + LEGEND_LINE * (lines + 2)
    looks = _looks(names)
    with style():
        figure = new_figure(WIDTH, height)
        figure.set_layout_engine("constrained")
        every = figure.subplots(len(rows), columns, squeeze=False)
        handles: dict[str, Any] = {}
        for index, panel in enumerate(panel for row in rows for panel in row):
            row, column = divmod(index, columns)
            axes = every[row, column]
            _draw_panel(axes, panel, looks, handles)
            if row < len(rows) - 1 and rows[row + 1][column].scale.x == panel.scale.x:
                axes.set_xlabel("")
            if column and rows[row][column - 1].scale.y == panel.scale.y:
                axes.set_ylabel("")
            letter = "abcdefghijklmnop"[index] if len(rows) * columns > 1 else ""
            add_title(axes, letter, panel.title, panel.note)
        figure.legend(
            handles.values(),
            handles.keys(),
            title=foot or None,
            title_fontsize=6.5,
            loc="outside lower center",
            ncols=per_line,
            frameon=False,
            fontsize=8.5,
            handlelength=2.6,
        )
    return figure


def _looks(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Colour, dashes and mark of each name."""
    looks: dict[str, dict[str, Any]] = {}
    for turn, name in enumerate(names):
        dash = ("-", "--")[turn // len(COLOURS) % 2]
        colour, mark = COLOURS[turn % len(COLOURS)], MARKS[turn % len(MARKS)]
        looks[name] = {"color": colour, "ls": dash, "lw": 1.5, "marker": mark}
    return looks


def _draw_panel(
    axes: "Axes", panel: Panel, looks: dict[str, dict[str, Any]], handles: dict[str, Any]
) -> None:
    scale = panel.scale
    axes.set_xscale("log" if scale.log_x else "linear")
    axes.set_yscale("log" if scale.log_y else "linear")
    if panel.marked is not None:
        axes.axvline(panel.marked, color=QUIET, lw=0.8, ls=":")
    for curve in panel.curves:
        look = looks[curve.name] | (
            {"markersize": 4.5, "mew": 0} if scale.marks else {"marker": ""}
        )
        if curve.low is not None and curve.high is not None:
            axes.fill_between(curve.x, curve.low, curve.high, color=look["color"], alpha=0.16, lw=0)
        (handle,) = axes.plot(curve.x, curve.y, label=curve.name, **look)
        handles.setdefault(curve.name, handle)
    _divide(axes, scale)


def _divide(axes: "Axes", scale: Scale) -> None:
    axes.grid(color=FAINT, lw=0.5, alpha=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set(xlabel=scale.x, ylabel=scale.y)
    if scale.x_limits is not None:
        axes.set_xlim(scale.x_limits)
    if scale.y_limits is not None:
        axes.set_ylim(*scale.y_limits)
    if scale.x_ticks is not None:
        axes.set_xticks(scale.x_ticks, [f"{tick:g}" for tick in scale.x_ticks])
        axes.xaxis.minorticks_off()
    elif scale.log_x:
        _plain_decades(axes.xaxis, *axes.get_xlim())
    if scale.log_y:
        _plain_decades(axes.yaxis, *axes.get_ylim())


def _plain_decades(axis: Any, low: float, high: float) -> None:
    """Number a logarithmic axis in plain words, at 1, 2 and 5 if it spans few decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < FEW * low else (1,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def draw_fields(
    panels: Sequence[Sequence[FieldPanel]], label: str, *, window: Floats | None = None
) -> "Figure":
    """Figure of fields in rows; each panel has its own scale, and a circle at each true contact.

    Parameters
    ----------
    panels : sequence of rows of FieldPanel
        As many in each row.
    label : str
        Of the values, with their unit.
    window : (2, 2) array, m, optional
        Low and high corner of what is shown. Default all pads and cells.
    """
    columns = len(panels[0])
    each = np.array([extent_of(panel.grid) for line in panels for panel in line])
    whole = np.array([each[:, 0].min(axis=0), each[:, 1].max(axis=0)])
    span = whole if window is None else window
    width, height = np.ptp(span, axis=0)
    high = (WIDTH / columns - 1.0) * float(height / width)
    with style():
        figure = new_figure(WIDTH, len(panels) * (high + HEAD))
        figure.set_layout_engine("constrained")
        every = figure.subplots(len(panels), columns, squeeze=False)
        for row, line in enumerate(panels):
            for column, panel in enumerate(line):
                axes = every[row, column]
                _draw_field(axes, panel, span, label if column == columns - 1 else "")
                if row < len(panels) - 1:
                    axes.set(xlabel="", xticklabels=[])
                if column:
                    axes.set(ylabel="", yticklabels=[])
    return figure


def _draw_field(axes: "Axes", panel: FieldPanel, span: Floats, label: str) -> None:
    from matplotlib.patches import Circle

    grid = panel.grid
    image = draw_cells(axes, grid, panel.values)
    outline_pads(axes, grid.patch)
    for x, y, radius in panel.presses:
        circle = Circle((x * MM, y * MM), radius * MM, fill=False, ec=INK, lw=1.3, zorder=4)
        axes.add_patch(circle)
    frame_axes(axes, grid.patch, span)
    axes.set_title(panel.title, fontsize=9, fontweight="bold", loc="left", pad=4)
    add_colour_bar(axes, image, label)
