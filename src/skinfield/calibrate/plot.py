"""Figures of calibrations: errors of taxels, gains on the patch."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.calibrate.by_pressure import PressureCalibration
from skinfield.errors import Floats
from skinfield.plot import (
    BLUE,
    INK,
    ORANGE,
    QUIET,
    Place,
    add_title,
    axes_for,
    new_figure,
    open_axes,
    plural,
    style,
)
from skinfield.skin import Patch
from skinfield.skin.maps import MM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from skinfield.calibrate.layer_comparison import LayerComparison


def draw_errors(made: PressureCalibration) -> "Figure":
    """Figure of the error of each taxel that answers, sorted, beside those of lines."""
    with style():
        figure = new_figure(8.0, 4.2)
        axes = figure.add_axes((0.09, 0.14, 0.88, 0.74))
        for rmse, colour, words in (
            (made.one_gain_rmse, QUIET, "one line for all"),
            (made.line_rmse, BLUE, "a line each"),
            (made.rmse, ORANGE, "with memory"),
        ):
            axes.plot(np.sort(rmse[made.usable]) * 1e-3, color=colour, lw=1.6, label=words)
        axes.set_xlabel("taxels, by their error")
        axes.set_ylabel("error, foretold (kPa rms)")
        axes.set_ylim(bottom=0.0)
        axes.set_title("Pressure of each taxel", loc="left", fontsize=11, fontweight="bold")
        axes.legend(frameon=False, fontsize=8.5)
        open_axes(axes)
    return figure


def draw_trivial(rmse: float, trivial: Mapping[str, float]) -> "Figure":
    """Figure of an error, N, beside those of trivial answers."""
    names, errors = ["this calibration", *trivial], [rmse, *trivial.values()]
    with style():
        figure = new_figure(8.0, 2.6)
        axes = figure.add_axes((0.3, 0.22, 0.66, 0.72))
        axes.barh(names, errors, color=[ORANGE, *[QUIET] * len(trivial)], height=0.6)
        for row, error in enumerate(errors):
            axes.text(error, row, f" {error:.3g}", va="center", fontsize=9)
        axes.set_xlim(0.0, 1.12 * max(errors))
        axes.invert_yaxis()
        axes.set_axisbelow(True)
        axes.set_xlabel("error (N rms)")
        open_axes(axes)
    return figure


def draw_gains(patch: Patch, gain: Floats, label: str) -> "Figure":
    """Figure of a value (L,) of each taxel, at its place in the patch's plane."""
    with style():
        figure = new_figure(7.2, 5.6)
        axes = figure.add_axes((0.1, 0.11, 0.72, 0.8))
        most = float(np.nanmax(np.abs(gain))) or 1.0
        low = -most if np.nanmin(gain) < 0.0 else 0.0
        x, y = patch.plane.T * MM
        dots = axes.scatter(
            x, y, c=gain, s=60, cmap="RdBu_r" if low else "viridis", vmin=low, vmax=most,
            edgecolors=INK, linewidths=0.4, clip_on=False,
        )  # fmt: skip
        axes.margins(0.06)
        axes.set_aspect("equal")
        axes.set_xlabel("x (mm)")
        axes.set_ylabel("y (mm)")
        bar = figure.colorbar(dots, cax=figure.add_axes((0.85, 0.11, 0.03, 0.8)))
        bar.set_label(label)
        open_axes(axes)
    return figure


def draw_layers(made: "LayerComparison") -> "Figure":
    """Figure of the probability of each layer."""
    figure = new_figure()
    plot_layers(made, figure)
    return figure


def plot_layers(made: "LayerComparison", ax: Place = None) -> Any:
    """Draw the probability of each layer; see `LayerComparison.plot`."""
    names, probability = [model.name for model in made.models], made.probability
    likely = [model in made.likely for model in made.models]
    with style():
        axes = axes_for(ax, (4.2, 0.32 * len(names)), (2.6, 0.55, 0.5, 0.6))
        colours = [ORANGE if one else QUIET for one in likely]
        axes.barh(names, probability, color=colours, height=0.6)
        for row, share in enumerate(probability.tolist()):
            axes.text(share, row, f" {share:.2f}", va="center", fontsize=9)
        axes.set_xlim(0.0, 1.0)
        axes.invert_yaxis()
        axes.set_axisbelow(True)
        axes.set_xlabel("probability")
        open_axes(axes)
        touches = plural(len(made.place), "touch", "touches")
        add_title(axes, "", "Which layer the skin has", f"by {touches}")
    return axes
