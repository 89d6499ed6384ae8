"""Fields on several grids side by side, as the paper shows them, with the true press marked."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats
from skinfield.figures.maps import MM, extent_of, frame_axes, outline_pads
from skinfield.figures.panels import columns_of
from skinfield.figures.style import INK, new_figure, signed_colours, style
from skinfield.layout import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, SIDE_GAP, BAR = 9.6, 0.16, 0.62  # inches: page, between panels, a colour bar's room
LEFT, HEAD, FOOT = 0.62, 0.42, 0.5


@dataclass(frozen=True, eq=False)
class FieldPanel:
    """One field.

    Parameters
    ----------
    title : str
    grid : Grid
    values : (K,) array
        In the unit of the figure.
    presses : sequence of (x, y, radius), m
        True contacts in the plane.
    """

    title: str
    grid: Grid
    values: Floats
    presses: Sequence[tuple[float, float, float]] = ()


def draw_fields(
    panels: Sequence[Sequence[FieldPanel]], label: str, *, window: Floats | None = None
) -> "Figure":
    """Figure of fields in rows; each panel has its own scale, and a circle at each true contact.

    Parameters
    ----------
    panels : sequence of rows of FieldPanel
        As many in each row.
    label : str
        Of the values, with their unit.
    window : (2, 2) array, m, optional
        Low and high corner of what is shown. Default all pads and cells.

    Raises
    ------
    InputError
        If there is no panel, or rows differ in length.
    """
    columns = columns_of(panels)
    room = (WIDTH - LEFT) / columns
    side = room - BAR - SIDE_GAP
    each = np.array([extent_of(panel.grid) for line in panels for panel in line])
    whole = np.array([each[:, 0].min(axis=0), each[:, 1].max(axis=0)])
    span = whole if window is None else window
    width, height = np.ptp(span, axis=0)
    high = side * float(height / width)
    page = len(panels) * (high + HEAD) + FOOT + 0.1
    with style():
        figure = new_figure(WIDTH, page)
        for row, line in enumerate(panels):
            bottom = page - 0.1 - (row + 1) * (high + HEAD)
            for column, panel in enumerate(line):
                left = LEFT + column * room
                box = (left / WIDTH, bottom / page, side / WIDTH, high / page)
                axes = figure.add_axes(box)
                _draw_field(axes, panel, span, label if column == columns - 1 else "")
                if row < len(panels) - 1:
                    axes.set(xlabel="", xticklabels=[])
                if column:
                    axes.set(ylabel="", yticklabels=[])
    return figure


def _draw_field(axes: "Axes", panel: FieldPanel, span: Floats, label: str) -> None:
    from matplotlib.patches import Circle

    grid = panel.grid
    colours, scale = signed_colours(panel.values)
    low = (grid.origin - grid.pitch / 2) * MM
    high = low + np.array(grid.shape[::-1]) * grid.pitch * MM
    image = axes.imshow(
        panel.values.reshape(grid.shape),
        origin="lower",
        extent=(low[0], high[0], low[1], high[1]),
        cmap=colours,
        norm=scale,
    )
    outline_pads(axes, grid.patch)
    for x, y, radius in panel.presses:
        circle = Circle((x * MM, y * MM), radius * MM, fill=False, ec=INK, lw=1.3, zorder=4)
        axes.add_patch(circle)
    frame_axes(axes, grid.patch, span)
    axes.set_title(panel.title, fontsize=9, fontweight="bold", loc="left", pad=4)
    bar = axes.figure.colorbar(image, cax=axes.inset_axes((1.03, 0.0, 0.045, 1.0)))
    bar.outline.set_linewidth(0.5)
    bar.set_label(label, fontsize=8)
    bar.ax.tick_params(labelsize=7)
    ends = [tick for tick in bar.get_ticks() if scale.vmin <= tick <= scale.vmax]
    bar.set_ticks(ends, labels=[f"{tick:g}".replace("-", "−") for tick in ends])
