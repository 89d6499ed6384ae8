"""How errors are distributed, method by method, beside what the noise allows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.figures.panels import columns_of
from skinfield.figures.style import BLUE, FAINT, INK, ORANGE, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, PANEL, HEAD, FOOT = 9.6, 2.2, 0.6, 0.72  # inches
COLOURS = (ORANGE, BLUE, "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
DASHES = (":", (0, (6, 2)))


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of one method.

    Parameters
    ----------
    name : str
    values : (N,) array
        NaN where there is no error to tell, as nothing was found: it counts among the N.
    limit : bool
        Whether it is a bound, drawn in black and without marks.
    """

    name: str
    values: Floats
    limit: bool = False


@dataclass(frozen=True, eq=False)
class DistributionPanel:
    """Distributions of one kind of error.

    Parameters
    ----------
    title : str
    label : str
        Of the error, with its unit.
    errors : sequence of Errors
    """

    title: str
    label: str
    errors: Sequence[Errors]


def draw_distributions(
    panels: Sequence[Sequence[DistributionPanel]], limits: Sequence[tuple[float, float]]
) -> "Figure":
    """Figure of the share of readings whose error is below a value, on a logarithmic scale.

    Parameters
    ----------
    panels : sequence of rows of DistributionPanel
        As many in each row; a method's colour goes by its place among the methods of its panel.
    limits : sequence of (low, high)
        Of the errors shown in each row.

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns = columns_of(panels)
    high = len(panels) * (PANEL + HEAD) + FOOT
    with style():
        figure = new_figure(WIDTH, high)
        grid: Any = figure.subplots(len(panels), columns, squeeze=False, sharey=True, sharex="row")
        figure.subplots_adjust(
            left=0.065, right=0.99, top=1 - 0.3 / high, bottom=(FOOT + 0.25) / high,
            wspace=0.08, hspace=(HEAD + 0.05) / PANEL,
        )  # fmt: skip
        for row, (line, ends) in enumerate(zip(panels, limits, strict=True)):
            for column, panel in enumerate(line):
                _draw_panel(grid[row][column], panel, ends)
            grid[row][0].set_ylabel("share of readings")
        known: dict[str, Any] = {}
        for axes in grid.ravel():
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                known.setdefault(label, handle)
        figure.legend(
            known.values(), known.keys(), loc="lower center", ncols=len(known), frameon=False,
            fontsize=8.5, handlelength=2.6,
        )  # fmt: skip
    return figure


def _draw_panel(axes: "Axes", panel: DistributionPanel, ends: tuple[float, float]) -> None:
    from matplotlib.ticker import FuncFormatter, NullLocator

    colours, dashes = iter(COLOURS), iter(DASHES)
    for errors in panel.errors:
        known = np.sort(errors.values[np.isfinite(errors.values)])
        share = np.arange(1, len(known) + 1) / max(len(errors.values), 1)
        x = np.concatenate([[ends[0] / 10], known, [ends[1] * 10]])
        y = np.concatenate([[0.0], share, share[-1:] if len(share) else [0.0]])
        look = {"color": INK, "ls": next(dashes)} if errors.limit else {"color": next(colours)}
        axes.plot(x, y, drawstyle="steps-post", lw=1.5, label=errors.name, **look)
    axes.axhline(0.5, color=FAINT, lw=0.8, zorder=0)
    axes.set_xscale("log")
    axes.set(xlim=ends, ylim=(0.0, 1.02), xlabel=panel.label)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_title(panel.title, fontsize=9.5, fontweight="bold", loc="left", pad=4)
    axes.grid(color=FAINT, lw=0.5, alpha=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
