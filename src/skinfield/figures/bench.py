"""What a reading costs, and how close an answer is by when: two panels of a benchmark."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.figures.style import FAINT, INK, QUIET, add_title, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's: told apart by every kind of colour vision.
COLOURS = ("#d55e00", "#0072b2", "#009e73", "#aa4499", "#56b4e9")
MARKS = ("o", "s", "^", "D", "v")
WIDTH, HEIGHT = 9.6, 4.6  # inches
PANELS = ((0.085, 0.255, 0.37, 0.625), (0.575, 0.255, 0.405, 0.625))
FLOOR = 1e-3  # errors below count as none
BELOW = FLOOR / 2.2  # where they are drawn


@dataclass(frozen=True, eq=False)
class Curve:
    """A line of one method.

    Attributes
    ----------
    method : str
        Its colour and mark; the legend has each once.
    x, y : (N,) arrays
    kind : str
        "solid", "dashed", or "hollow": marks alone.
    low, high : (N,) arrays, optional
        Ends of whiskers.
    """

    method: str
    x: Floats
    y: Floats
    kind: str = "solid"
    low: Floats | None = None
    high: Floats | None = None


@dataclass(frozen=True, eq=False)
class View:
    """One panel: its head, a line on how to read it, its curves and what is up and along.

    Attributes
    ----------
    title, note : str
    curves : tuple of Curve
    x, y : str
        Names of the axes, with their unit where ticks do not tell it.
    x_is, y_is : str
        "time" in s, "share", "length" in m or "nodes": how ticks are written.
    floor : bool
        Whether y below FLOOR is drawn as converged.
    """

    title: str
    note: str
    curves: tuple[Curve, ...]
    x: str
    y: str
    x_is: str = "time"
    y_is: str = "time"
    floor: bool = False


def draw_bench(
    left: View,
    right: View,
    methods: Sequence[str],
    *,
    foot: str = "",
    kinds: Sequence[tuple[str, str]] = (),
) -> "Figure":
    """Two panels on logarithmic axes over one legend.

    Parameters
    ----------
    left, right : View
    methods : sequence of str
        Of all curves, at most five, in the order of the legend: each has its colour.
    foot : str
        A line at the bottom: the machine.
    kinds : sequence of (kind, words)
        What else the legend explains, such as ("dashed", "cold").

    Raises
    ------
    InputError
        If there is no curve, or one of a method that is not in `methods`.
    """
    if not (left.curves and right.curves):
        raise InputError("a panel has no curves, expected one or more: there is nothing to draw")
    strange = {c.method for view in (left, right) for c in view.curves} - set(methods)
    if strange or len(methods) > len(COLOURS):
        raise InputError(
            f"methods are {list(methods)}, expected at most {len(COLOURS)} and all that the curves "
            f"name, also {sorted(strange)}"
        )
    with style():
        figure = new_figure(WIDTH, HEIGHT)
        for view, box, letter in zip((left, right), PANELS, "ab", strict=True):
            axes = figure.add_axes(box)
            _draw_view(axes, view, methods)
            add_title(axes, letter, view.title, view.note)
        _legend(figure, methods, kinds)
        figure.text(0.985, 0.012, foot, ha="right", va="bottom", fontsize=6.5, color=QUIET)
    return figure


def _draw_view(axes: "Axes", view: View, methods: Sequence[str]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for curve in view.curves:
        turn = methods.index(curve.method)
        y = np.where(curve.y < FLOOR, BELOW, curve.y) if view.floor else curve.y
        look = _look(curve.kind, turn)
        if curve.low is not None and curve.high is not None:
            ends = np.array([y - curve.low, curve.high - y])
            axes.errorbar(curve.x, y, ends, fmt="none", ecolor=COLOURS[turn], elinewidth=1.0)
        axes.plot(curve.x, y, **look)
    axes.grid(color=FAINT, lw=0.5, alpha=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set(xlabel=view.x, ylabel=view.y)
    if view.floor:
        _draw_floor(axes, view)
    else:
        _ticks(axes.yaxis, view.y_is)
    if view.x_is == "nodes":
        nodes = sorted({float(value) for curve in view.curves for value in curve.x})
        axes.set_xticks(nodes, [f"{value:g} × {value:g}" for value in nodes])
        axes.xaxis.minorticks_off()
        axes.set_xlim(0.9 * nodes[0], 1.1 * nodes[-1])
    else:
        _ticks(axes.xaxis, view.x_is)


def _draw_floor(axes: "Axes", view: View) -> None:
    """Write decades down to the floor, and "converged" below."""
    highest = max((float(np.max(c.y, initial=0.0)) for c in view.curves), default=1.0)
    top = max(1.0, highest) * 1.6
    decades = 10.0 ** np.arange(np.log10(FLOOR), np.log10(top))
    words = [written(value, view.y_is) for value in decades]
    axes.axhspan(BELOW / 2, FLOOR, color=FAINT, alpha=0.3, lw=0)
    axes.set_yticks([BELOW, *decades], ["converged", *words])
    axes.yaxis.minorticks_off()
    axes.set_ylim(BELOW / 2, top)


def _look(kind: str, turn: int) -> dict[str, Any]:
    """How a curve is drawn."""
    colour, mark = COLOURS[turn], MARKS[turn]
    look: dict[str, Any] = {
        "color": colour, "marker": mark, "markersize": 5.0, "lw": 1.6, "zorder": 3.0,
    }  # fmt: skip
    if kind == "dashed":
        look |= {"ls": (0, (4, 2)), "lw": 1.2, "markersize": 4.0, "markerfacecolor": "white"}
    if kind == "hollow":
        look |= {"ls": "none", "markersize": 8.0, "markerfacecolor": "none", "marker": "*"}
    return look


def _legend(figure: "Figure", methods: Sequence[str], kinds: Sequence[tuple[str, str]]) -> None:
    from matplotlib.lines import Line2D

    handles, names = [], []
    for turn, method in enumerate(methods):
        handles.append(Line2D([], [], **_look("solid", turn)))
        names.append(method)
    for kind, words in kinds:
        plain = _look(kind, 0) | {"color": COLOURS[0] if kind == "hollow" else INK}
        handles.append(Line2D([], [], **plain | ({} if kind == "hollow" else {"marker": ""})))
        names.append(words)
    figure.legend(
        handles,
        names,
        loc="lower center",
        bbox_to_anchor=(0.5, 0.035),
        ncols=min(3, len(names)),
        frameon=False,
        fontsize=8.5,
        handlelength=2.6,
    )


def _ticks(axis: Any, what: str) -> None:
    """Decades in words; 1, 2 and 5 where there are few."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

    low, high = axis.get_view_interval()
    few = high < 60.0 * low
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if few else (1,), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: written(value, what)))
    axis.set_minor_locator(NullLocator() if few else LogLocator(subs=range(2, 10), numticks=12))
    axis.set_minor_formatter(NullFormatter())


def written(value: float, what: str) -> str:
    """Write a number of SI units as a tick: "20 µs", "1 ms", "10 %", "0.5 mm"."""
    if what == "share":
        return f"{100 * value:.6g} %"
    if what == "length":
        return f"{1e3 * value:.6g} mm"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= 0.999 * size:
            return f"{value / size:.6g} {unit}"
    return f"{1e9 * value:.6g} ns"
