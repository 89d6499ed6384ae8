"""Figure of an elastomer layer: its cross-section over pads."""

from typing import Any

from skinfield.elastic.elastomer import Layer
from skinfield.errors import check_positive
from skinfield.plot import INK, ORANGE, QUIET, Place, add_title, axes_for, number, style

PADS = 3
BASE = 0.4  # mm: of the board that is drawn


def plot_layer(layer: Layer, ax: Place = None, pad_diameter: float = 4e-3) -> Any:
    """Draw a cross-section to scale; see `Layer.plot`."""
    check_positive("pad_diameter", pad_diameter, "in metres, 4 mm is 4e-3")
    high, pad = layer.thickness * 1e3, pad_diameter * 1e3
    half = PADS * pad
    with style():
        axes = axes_for(ax, (4.4, 4.4 * (high + 4.0 * BASE) / (2.0 * half)), (0.75, 0.55, 0.3, 0.6))
        axes.axhspan(0.0, high, color="#f0d8b7", lw=0.0)
        axes.axhspan(-2.0 * BASE, 0.0, color="#c9c9d1", lw=0.0)
        for place in range(PADS):
            middle = 2.0 * pad * (place - (PADS - 1) / 2)
            axes.plot([middle - pad / 2, middle + pad / 2], [0.0, 0.0], color=ORANGE, lw=3.0)
        axes.plot([-half, half], [high, high], color=INK, lw=1.0)
        look = {"arrowstyle": "<->", "color": QUIET, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (0.9 * half, 0.0), (0.9 * half, high), arrowprops=look)
        words = f"{number(high)} mm"
        axes.text(0.87 * half, high / 2, words, ha="right", va="center", fontsize=8)
        axes.set(xlim=(-half, half), ylim=(-2.0 * BASE, high + 2.0 * BASE))
        axes.set(xlabel="x (mm)", ylabel="height (mm)")
        axes.set_aspect("equal", adjustable="box", anchor="NW")
        note = f"elastomer over pads of {number(pad)} mm on their board, to scale"
        add_title(axes, "", repr(layer), note)
    return axes
