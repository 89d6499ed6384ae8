"""Reliability: how often intervals hold the truth, against how often they say so."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.figures.panels import COLOURS, MARKS, columns_of
from skinfield.figures.style import FAINT, INK, QUIET, add_title, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, PANEL, HEAD, FOOT = 9.6, 2.6, 0.62, 1.0  # inches
NEAR = 5.0  # % by which an interval may be off and still be called honest
DODGE = 0.7  # % between neighbouring curves, so that their bars do not hide each other


@dataclass(frozen=True, eq=False)
class Held:
    """Shares of one solver's truths inside its intervals.

    Parameters
    ----------
    name : str
    shares, low, high : (N,) arrays
        One per level, with the ends of their intervals.
    """

    name: str
    shares: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class ReliabilityPanel:
    """Solvers under one title."""

    title: str
    note: str
    held: Sequence[Held]


def draw_reliability(
    panels: Sequence[Sequence[ReliabilityPanel]], levels: Sequence[float]
) -> "Figure":
    """Figure of observed against nominal shares in rows of panels; on the diagonal is honest.

    Parameters
    ----------
    panels : sequence of rows of ReliabilityPanel
        As many in each row; a solver has one colour in all of them.
    levels : (N,) floats
        Nominal shares, 0 to 1.

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns = columns_of(panels)
    height = len(panels) * (PANEL + HEAD) + FOOT
    nominal = 100 * np.asarray(levels, dtype=np.float64)
    names = list(dict.fromkeys(h.name for line in panels for panel in line for h in panel.held))
    handles: dict[str, Any] = {}
    with style():
        figure = new_figure(WIDTH, height)
        width = (WIDTH - 0.75 - 0.15) / columns
        for row, line in enumerate(panels):
            low = height - (row + 1) * (PANEL + HEAD)
            for column, panel in enumerate(line):
                left = (0.75 + column * width) / WIDTH
                size = ((width - 0.3) / WIDTH, PANEL / height)
                axes = figure.add_axes((left, low / height, *size))
                _draw_panel(axes, panel, nominal, names, handles)
                letter = "abcdefghijklmnop"[row * columns + column]
                add_title(axes, letter, panel.title, panel.note)
                if column:
                    axes.tick_params(labelleft=False)
                else:
                    axes.set_ylabel("truths inside (%)")
                if row == len(panels) - 1:
                    axes.set_xlabel("stated level (%)")
                else:
                    axes.tick_params(labelbottom=False)
        words = sorted(handles, key=names.index)
        figure.legend(
            [handles[word] for word in words],
            words,
            loc="lower center",
            ncols=3,
            frameon=False,
            fontsize=8.5,
        )
    return figure


def _draw_panel(
    axes: "Axes",
    panel: ReliabilityPanel,
    nominal: Floats,
    names: list[str],
    handles: dict[str, Any],
) -> None:
    ends = np.array([nominal[0] - 5.0, 100.0])
    axes.fill_between(ends, ends - NEAR, ends + NEAR, color=FAINT, alpha=0.45, lw=0)
    axes.plot(ends, ends, color=INK, lw=0.8)
    middle = (len(names) - 1) / 2
    for held in panel.held:
        index = names.index(held.name)
        bars: Any = 100 * np.stack([held.shares - held.low, held.high - held.shares])
        handles[held.name] = axes.errorbar(
            nominal + DODGE * (index - middle),
            100 * held.shares,
            np.maximum(bars, 0.0),
            color=COLOURS[index % len(COLOURS)],
            marker=MARKS[index % len(MARKS)],
            ms=4.2,
            lw=1.1,
            elinewidth=0.8,
        )
    axes.set_xlim(*ends)
    axes.set_ylim(0.0, 103.0)
    axes.set_xticks(nominal, [f"{level:g}" for level in nominal])
    axes.set_yticks([0, 25, 50, 75, 90, 100])
    axes.grid(True, color=FAINT, lw=0.4)
    axes.set_axisbelow(True)
    axes.tick_params(color=QUIET)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
