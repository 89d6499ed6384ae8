"""Pictures of recorded data beside curves: a tensile test, and counts against force."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats
from skinfield.figures.style import BLUE, FAINT, INK, ORANGE, add_title, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LAWS = (ORANGE, BLUE)


def draw_tension(
    strain: ArrayLike, stress: ArrayLike, at: ArrayLike, laws: Mapping[str, Floats]
) -> "Figure":
    """Figure of a tensile test with laws beside it, and of what they are off.

    Parameters
    ----------
    strain, stress : (N,) arrays
        Engineering strain, and stress in Pa, of the test.
    at : (M,) array
        Strains at which the laws are given.
    laws : mapping of name to (M,) array, Pa
        Two at most.
    """
    x, y, grid = as_floats("strain", strain), as_floats("stress", stress) / 1e3, as_floats("at", at)
    ends = (0.5, float(grid.max()))
    with style():
        figure = new_figure(9.6, 3.6)
        for index, end in enumerate(ends):
            axes = figure.add_axes((0.075 + 0.5 * index, 0.16, 0.4, 0.62))
            shown, part = x <= end, grid <= end
            axes.plot(x[shown], y[shown], ".", color=INK, ms=3.5, label="test")
            for colour, (name, law) in zip(LAWS, laws.items(), strict=False):
                axes.plot(grid[part], law[part] / 1e3, color=colour, label=name)
            top = 1.15 * float(np.max(y[shown]))
            axes.set(xlabel="engineering strain", ylabel="engineering stress (kPa)", xlim=(0, end))
            axes.set_ylim(min(0.0, float(y.min())), top)
            _dress(axes)
            title = "Small strains" if index == 0 else f"Strains up to {end:g}"
            add_title(axes, "ab"[index], title, "one modulus, fitted to strains up to 0.5")
            if index == 0:
                axes.legend(frameon=False, fontsize=8.5, loc="upper left")
    return figure


def draw_curves(runs: Mapping[str, tuple[Floats, Floats, Floats, Floats]]) -> "Figure":
    """Figure of force against counts, one panel per run.

    Parameters
    ----------
    runs : mapping of title to (counts, force, counts of the curve, force of the curve)
        Forces in N.
    """
    with style():
        figure = new_figure(9.6, 3.6)
        wide = 0.92 / len(runs)
        for index, (title, (counts, force, level, curve)) in enumerate(runs.items()):
            axes = figure.add_axes((0.07 + wide * index, 0.16, wide - 0.08, 0.62))
            axes.plot(counts, force, ".", color=INK, ms=2.5, alpha=0.5, label="reading")
            axes.plot(level, curve, color=ORANGE, label="falling curve")
            axes.set(xlabel="converter's count", ylabel="force (N)", ylim=(0, None))
            _dress(axes)
            add_title(axes, "abcdef"[index], title, "the width of the cloud is what no curve tells")
            if index == 0:
                axes.legend(frameon=False, fontsize=8.5)
    return figure


def _dress(axes: "Axes") -> None:
    axes.grid(color=FAINT, lw=0.5, alpha=0.6)
    axes.spines[["top", "right"]].set_visible(False)
