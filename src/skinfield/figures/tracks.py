"""Contacts through time: what moved, what each reading saw, and the tracks with their numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from skinfield.errors import Floats
from skinfield.figures.panels import columns_of
from skinfield.figures.style import FAINT, INK, QUIET, add_title, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
WIDTH, PANEL, HEAD, FOOT = 9.6, 3.0, 0.85, 0.75  # inches


@dataclass(frozen=True, eq=False)
class Way:
    """A line with its number: x and y (N,) in the panel's units."""

    number: int
    x: Floats
    y: Floats


@dataclass(frozen=True, eq=False)
class TrackPanel:
    """Tracks over one pair of axes.

    Parameters
    ----------
    title, note, x, y : str
        The last two name the axes with their units.
    truth : sequence of Way
    raw : (N, 2) array
        What single readings saw.
    tracks : sequence of Way
    equal : bool
        Whether both axes are lengths, to the same scale.
    """

    title: str
    note: str
    x: str
    y: str
    truth: Sequence[Way]
    raw: Floats
    tracks: Sequence[Way]
    equal: bool = False


def draw_tracks(rows: Sequence[Sequence[TrackPanel]]) -> "Figure":
    """Figure of panels in rows.

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns, high = columns_of(rows), len(rows) * (PANEL + HEAD) + FOOT
    with style():
        figure = new_figure(WIDTH, high)
        grid: Any = figure.subplots(len(rows), columns, squeeze=False)
        figure.subplots_adjust(
            left=0.075, right=0.985, top=1 - 0.5 / high, bottom=FOOT * 1.25 / high, wspace=0.2,
            hspace=(HEAD + 0.1) / PANEL,
        )  # fmt: skip
        known: dict[str, Any] = {}
        for row, line in enumerate(rows):
            for column, panel in enumerate(line):
                _draw(grid[row][column], panel, known)
                letter = "abcdefghijklmnop"[row * columns + column]
                add_title(grid[row][column], letter, panel.title, panel.note)
        figure.legend(
            known.values(), known.keys(), loc="lower center", ncols=len(known), frameon=False,
            fontsize=8.5, handlelength=2.4,
        )  # fmt: skip
    return figure


def _draw(axes: "Axes", panel: TrackPanel, known: dict[str, Any]) -> None:
    for way in panel.truth:
        (handle,) = axes.plot(way.x, way.y, color=FAINT, lw=5.0, solid_capstyle="round", zorder=1)
        known.setdefault("truth", handle)
    if len(panel.raw):
        (handle,) = axes.plot(*panel.raw.T, ".", color=QUIET, ms=3.5, mew=0, alpha=0.8, zorder=2)
        known.setdefault("single readings", handle)
    for index, way in enumerate(panel.tracks):
        colour = COLOURS[index % len(COLOURS)]
        (handle,) = axes.plot(way.x, way.y, color=colour, lw=1.5, zorder=3)
        known.setdefault("tracks, with their numbers", handle)
        axes.annotate(
            str(way.number), (way.x[0], way.y[0]), xytext=(-6, 6), textcoords="offset points",
            color=colour, fontsize=9, fontweight="bold", ha="right", zorder=4,
        )  # fmt: skip
    axes.set(xlabel=panel.x, ylabel=panel.y)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.grid(color=FAINT, lw=0.5, alpha=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK)
    axes.spines[["top", "right"]].set_visible(False)
