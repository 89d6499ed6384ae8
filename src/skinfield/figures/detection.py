"""Shares of touches that are found, as small multiples with the limit dashed in ink."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from skinfield.errors import Floats
from skinfield.figures.panels import columns_of
from skinfield.figures.style import FAINT, INK, QUIET, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito without yellow: told apart by every kind of colour vision.
COLOURS = ("#d55e00", "#009e73", "#56b4e9", "#0072b2", "#e69f00", "#cc79a7")
WIDTH, PANEL, HEAD, FOOT, LEGEND_LINE = 10.0, 2.15, 0.35, 0.62, 0.22  # inches


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve with its name.

    Parameters
    ----------
    name : str
    x, y : (N,) arrays
    low, high : (N,) arrays, optional
        Ends of the interval of y.
    reference : bool
        Whether it is a limit: dashed, in ink.
    """

    name: str
    x: Floats
    y: Floats
    low: Floats | None = None
    high: Floats | None = None
    reference: bool = False


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """Curves over one pair of axes.

    Parameters
    ----------
    title, note : str
        Above, at the left and the right.
    curves : tuple of Curve
    marked : float, optional
        An x, by a dotted line.
    """

    title: str
    note: str
    curves: tuple[Curve, ...]
    marked: float | None = None


def draw_curves(
    rows: Sequence[Sequence[CurvePanel]],
    *,
    x: str,
    y: str,
    log_x: bool = True,
    x_limits: tuple[float, float] | None = None,
    x_ticks: tuple[float, ...] | None = None,
) -> "Figure":
    """Figure of panels in rows, all with the same axes and one legend.

    Parameters
    ----------
    rows : sequence of rows of CurvePanel
        As many in each row; a curve of one name has one colour in all of them.
    x, y : str
        Names of the axes with their units; y is a share, from 0 to 1.
    log_x : bool
    x_limits, x_ticks : tuples, optional

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns = columns_of(rows)
    names = list(dict.fromkeys(c.name for row in rows for panel in row for c in panel.curves))
    high = len(rows) * (PANEL + HEAD) + FOOT + LEGEND_LINE * -(-len(names) // 3)
    with style():
        figure = new_figure(WIDTH, high)
        grid: Any = figure.subplots(len(rows), columns, squeeze=False, sharex=True, sharey=True)
        figure.subplots_adjust(
            left=0.06, right=0.985, top=1 - 0.35 / high,
            bottom=(FOOT + LEGEND_LINE * -(-len(names) // 3)) / high, wspace=0.1, hspace=0.22,
        )  # fmt: skip
        handles: dict[str, Any] = {}
        for row, line in enumerate(rows):
            for column, panel in enumerate(line):
                axes = grid[row][column]
                _draw(axes, panel, names, handles)
                _scale(axes, log_x, x_limits, x_ticks)
                if row == len(rows) - 1:
                    axes.set_xlabel(x)
            grid[row][0].set_ylabel(y)
        figure.legend(
            handles.values(), handles.keys(), loc="lower center", frameon=False, fontsize=8.5,
            ncols=min(3, len(names)), handlelength=2.6,
        )  # fmt: skip
    return figure


def _scale(
    axes: "Axes",
    log_x: bool,
    limits: tuple[float, float] | None,
    ticks: tuple[float, ...] | None,
) -> None:
    axes.set_xscale("log" if log_x else "linear")
    axes.set(xlim=limits or (None, None), ylim=(-0.03, 1.03))
    if ticks is not None:
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.xaxis.minorticks_off()


def _draw(axes: "Axes", panel: CurvePanel, names: list[str], handles: dict[str, Any]) -> None:
    if panel.marked is not None:
        axes.axvline(panel.marked, color=QUIET, lw=0.8, ls=":")
    for curve in panel.curves:
        colour = INK if curve.reference else COLOURS[names.index(curve.name) % len(COLOURS)]
        if curve.low is not None and curve.high is not None and not curve.reference:
            axes.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.16, lw=0)
        width, dash = (1.1, "--") if curve.reference else (1.6, "-")
        (handle,) = axes.plot(curve.x, curve.y, dash, color=colour, lw=width)
        handles.setdefault(curve.name, handle)
    axes.grid(color=FAINT, lw=0.5, alpha=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(panel.title, fontsize=9.0, fontweight="bold", loc="left", pad=5)
    axes.set_title(panel.note, fontsize=7.5, color=QUIET, loc="right", pad=5)
