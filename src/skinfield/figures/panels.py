"""Small multiples of curves under one legend: rates, times and errors of several methods."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.figures.style import FAINT, INK, QUIET, add_title, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette without its yellow, which is faint on white.
COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#1b1b1f")
MARKS = ("o", "s", "^", "D", "v", "P", "X")
WIDTH, PANEL_HEIGHT, HEAD = 9.6, 2.55, 0.62  # inches
LEGEND_LINE = 0.24  # inches
FEW = 300.0  # ratio of the ends of an axis of few decades


@dataclass(frozen=True, eq=False)
class Line:
    """A curve with its name; `low` and `high` are the ends of its interval, where it has one."""

    name: str
    x: Floats
    y: Floats
    low: Floats | None = None
    high: Floats | None = None


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over one pair of axes."""

    title: str
    note: str
    lines: tuple[Line, ...]


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
    marks: bool = True


def columns_of(rows: Sequence[Sequence[object]]) -> int:
    """Panels in each of the rows.

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns = len(rows[0]) if rows else 0
    if not columns or any(len(row) != columns for row in rows):
        raise InputError(
            f"rows of panels have lengths {[len(row) for row in rows]}, expected equal ones "
            "above 0: panels stand in a rectangle"
        )
    return columns


def draw_panels(panels: Sequence[Panel], scale: Scale, *, columns: int = 3) -> "Figure":
    """Figure of panels side by side; a curve of one name has one colour in all of them.

    Parameters
    ----------
    panels : sequence of Panel
    scale : Scale
        Shared by all panels.
    columns : int
        Panels in a row.

    Raises
    ------
    InputError
        If there is no panel.
    """
    if not panels:
        raise InputError("panels is empty, expected at least one: there is nothing to draw")
    names = list(dict.fromkeys(line.name for panel in panels for line in panel.lines))
    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    per_line = 2 if max(map(len, names)) > 30 else 3
    legend = LEGEND_LINE * -(-len(names) // per_line) + 0.1
    with style():
        height = rows * (PANEL_HEIGHT + HEAD) + 0.22 + legend
        figure = new_figure(WIDTH, height)
        width = (WIDTH - 0.7 - 0.2) / columns
        handles: dict[str, Any] = {}
        for index, panel in enumerate(panels):
            row, column = divmod(index, columns)
            low = height - (row + 1) * (PANEL_HEIGHT + HEAD)
            box = ((0.7 + column * width) / WIDTH, (low + 0.25) / height)
            size = ((width - 0.45) / WIDTH, (PANEL_HEIGHT - 0.25) / height)
            axes = figure.add_axes((*box, *size))
            last = index + columns >= len(panels)
            _draw_panel(axes, panel, scale, names, handles, x=last, y=column == 0)
            letter = "abcdefghijklmnop"[index] if len(panels) > 1 else ""
            add_title(axes, letter, panel.title, panel.note)
        figure.legend(
            handles.values(),
            handles.keys(),
            loc="lower center",
            ncols=min(per_line, len(names)),
            frameon=False,
            fontsize=8.5,
            handlelength=2.6,
        )
    return figure


def _draw_panel(
    axes: "Axes",
    panel: Panel,
    scale: Scale,
    names: list[str],
    handles: dict[str, Any],
    *,
    x: bool,
    y: bool,
) -> None:
    axes.set_xscale("log" if scale.log_x else "linear")
    axes.set_yscale("log" if scale.log_y else "linear")
    for line in panel.lines:
        turn = names.index(line.name)
        colour, dash = COLOURS[turn % len(COLOURS)], ("-", "--")[turn // len(COLOURS) % 2]
        if line.low is not None and line.high is not None:
            axes.fill_between(line.x, line.low, line.high, color=colour, alpha=0.16, lw=0)
        (handle,) = axes.plot(line.x, line.y, dash, color=colour, lw=1.5)
        if scale.marks:
            handle.set(marker=MARKS[turn % len(MARKS)], markersize=4.5, markeredgewidth=0)
        handles.setdefault(line.name, handle)
    axes.grid(color=FAINT, lw=0.5, alpha=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set(
        xlim=scale.x_limits or (None, None),
        ylim=scale.y_limits or (None, None),
        xlabel=scale.x if x else "",
        ylabel=scale.y if y else "",
    )
    if scale.x_ticks is not None:
        axes.set_xticks(scale.x_ticks, [f"{tick:g}" for tick in scale.x_ticks])
        axes.xaxis.minorticks_off()
    if scale.log_y:
        _plain_decades(axes)


def _plain_decades(axes: "Axes") -> None:
    """Number a logarithmic y axis in plain words, at 1, 2 and 5 if it spans few decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axes.get_ylim()
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < FEW * low else (1,)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def draw_bars(
    groups: Sequence[str],
    series: Sequence[tuple[str, Floats]],
    *,
    label: str,
    title: str,
    note: str = "",
    line: tuple[float, str] | None = None,
) -> "Figure":
    """Figure of bars side by side: one group per name, one bar in each per series.

    Parameters
    ----------
    groups : sequence of str
        Under the bars.
    series : sequence of (name, (G,) array)
        NaN leaves its place empty.
    label : str
        Of the heights, with their unit.
    line : (height, name), optional
        A level across all.
    """
    with style():
        figure = new_figure(WIDTH, 4.2)
        axes = figure.add_axes((0.08, 0.2, 0.9, 0.63))
        place, width = np.arange(len(groups)), 0.8 / len(series)
        for index, (name, heights) in enumerate(series):
            shift = (index - (len(series) - 1) / 2) * width
            colour = COLOURS[index % len(COLOURS)]
            axes.bar(place + shift, heights, 0.92 * width, color=colour, label=name)
        if line is not None:
            axes.axhline(line[0], color=INK, lw=1.0, ls="--", label=line[1])
        axes.axhline(0.0, color=QUIET, lw=0.7)
        axes.set_xticks(place, groups)
        axes.set(ylabel=label)
        axes.grid(axis="y", color=FAINT, lw=0.5, alpha=0.7)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="lower center", ncols=4, frameon=False, fontsize=8.5)
        add_title(axes, "", title, note)
    return figure
