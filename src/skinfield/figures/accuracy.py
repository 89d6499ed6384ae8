"""Errors against load, solver by solver, above the least that noise allows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.figures.panels import columns_of
from skinfield.figures.style import BLUE, FAINT, INK, ORANGE, QUIET, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, PANEL, HEAD, FOOT = 9.6, 2.2, 0.75, 0.95  # inches
# Okabe and Ito: told apart by every kind of colour vision; markers tell them apart in grey.
COLOURS = (ORANGE, "#e69f00", "#009e73", BLUE, "#cc79a7", "#56b4e9")
MARKERS = ("o", "s", "^", "D", "v", "P")
DODGE = 0.018  # decades between the bars of neighbouring curves
DECADES = 3.5  # below the top of a panel; a bound further down leaves through the floor


@dataclass(frozen=True, eq=False)
class Curve:
    """Median error with its interval at each load.

    Parameters
    ----------
    name : str
    loads : (N,) array, N
    medians, lows, highs : (N,) arrays
        NaN where nothing was found.
    dashed : bool
    """

    name: str
    loads: Floats
    medians: Floats
    lows: Floats
    highs: Floats
    dashed: bool = False


@dataclass(frozen=True, eq=False)
class ErrorPanel:
    """Curves of one quantity.

    Parameters
    ----------
    title : str
    label : str
        Of the error, with its unit.
    curves : sequence of Curve
    bound_loads, bound : (N,) arrays, N and the error's unit
        The least that an unbiased estimator can do; empty where there is no such bound.
    share : bool
        Shares, from 0 to 1 on an even scale; else errors on a logarithmic one.
    """

    title: str
    label: str
    curves: Sequence[Curve]
    bound_loads: Floats
    bound: Floats
    share: bool = False


def draw_errors(panels: Sequence[Sequence[ErrorPanel]], note: str = "") -> "Figure":
    """Figure of errors against load in rows of panels; the panels of a row share their scale.

    Parameters
    ----------
    panels : sequence of rows of ErrorPanel
        As many in each row; a curve's colour goes by its place in its panel.
    note : str
        Under the figure: what all panels share.

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns = columns_of(panels)
    high = len(panels) * PANEL + HEAD + FOOT
    with style():
        figure = new_figure(WIDTH, high)
        grid: Any = figure.subplots(len(panels), columns, squeeze=False, sharex=True, sharey="row")
        figure.subplots_adjust(
            left=0.085, right=0.985, top=1 - 0.38 / high, bottom=(FOOT + 0.3) / high,
            wspace=0.06, hspace=0.1,
        )  # fmt: skip
        for row, line in enumerate(panels):
            for column, panel in enumerate(line):
                _draw_panel(grid[row][column], panel)
                if row == 0:
                    grid[row][column].set_title(
                        panel.title, fontsize=10, fontweight="bold", loc="left", pad=5
                    )
            grid[row][0].set_ylabel(line[0].label)
            _fit(grid[row][0], line)
        for axes in grid[-1]:
            axes.set_xlabel("load (N)")
        _label(figure, grid[0][0], note, high)
    return figure


def _draw_panel(axes: "Axes", panel: ErrorPanel) -> None:
    middle = (len(panel.curves) - 1) / 2
    for index, curve in enumerate(panel.curves):
        colour, marker = COLOURS[index % len(COLOURS)], MARKERS[index % len(MARKERS)]
        loads = curve.loads * 10 ** (DODGE * (index - middle))
        bars = np.stack([curve.medians - curve.lows, curve.highs - curve.medians])
        axes.errorbar(
            loads, curve.medians, np.maximum(bars, 0.0), label=curve.name, color=colour,
            marker=marker, ms=4.5, lw=1.3, elinewidth=0.9, capsize=2,
            ls="--" if curve.dashed else "-",
        )  # fmt: skip
    if len(panel.bound):
        axes.plot(
            panel.bound_loads,
            panel.bound,
            color=INK,
            lw=1.6,
            ls=":",
            label="Cramér-Rao bound (rms)",
        )
    axes.set_xscale("log")
    known = sorted({float(load) for curve in panel.curves for load in curve.loads})
    axes.set_xticks(known, [f"{load:g}" for load in known])
    axes.minorticks_off()
    axes.grid(True, axis="y", color=FAINT, lw=0.5)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _fit(axes: "Axes", line: Sequence[ErrorPanel]) -> None:
    """Limits that show every curve, and the bound as far as it stays within a few decades."""
    from matplotlib.ticker import FuncFormatter

    if line[0].share:
        axes.set_ylim(-0.03, 1.03)
        return
    axes.set_yscale("log")
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    tops = [curve.highs for panel in line for curve in panel.curves]
    lows = [curve.lows for panel in line for curve in panel.curves]
    top = float(np.nanmax(np.concatenate([*tops, *(panel.bound for panel in line)])))
    low = float(np.nanmin(np.concatenate([*lows, *(panel.bound for panel in line)])))
    axes.set_ylim(max(low, top * 10**-DECADES) / 1.4, top * 1.4)


def _label(figure: "Figure", axes: "Axes", note: str, high: float) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="lower center", ncols=3, frameon=False, fontsize=8,
        bbox_to_anchor=(0.5, 0.22 / high),
    )  # fmt: skip
    figure.text(0.5, 0.08 / high, note, ha="center", fontsize=7.5, color=QUIET)
