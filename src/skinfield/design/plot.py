"""Maps of a layout's resolution, judged before it is made."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.design import Judgement, Places
from skinfield.design.judgement import part_of
from skinfield.errors import Floats
from skinfield.plot import ABOVE, INK, TITLE, add_colour_bar, add_title, new_figure, style
from skinfield.skin.maps import MM, draw_cells, frame_axes, outline_pads

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL = 3.3  # inches: side of the square in which a map is drawn
GAP, LEFT, HEAD, FOOT, OVER = 1.15, 0.6, 0.9, 0.5, 0.55
MOST_PADS = 1500  # outlines beyond this are a grey mass
NOTHING = "#d8d8de"  # no finite value
LOWEST, HIGHEST = 0.02, 0.98  # shares of the places between which colours differ


def draw_judgement(judgement: Judgement) -> "Figure":
    """Figure of all maps of a layout; in each, dark is bad, and grey is nowhere near.

    Parameters
    ----------
    judgement : Judgement
    """
    detectable, accuracy, pairs = judgement.detectable, judgement.accuracy, judgement.two_points
    places, few = detectable.places, pairs.places
    force = f"{judgement.touch.force:g} N"
    false = f"{detectable.false_alarm_rate:g} false alarms a reading"
    rates = f"{detectable.detection_rate:.0%} found, {false}"
    error = f"{pairs.error_rate:.0%} errors, two of {force} each; grey: never told"
    panels = (
        (places, judgement.blind.response * 100, "response (% of the best place)",
         "Blind spots", f"a light touch; outlined: below {judgement.blind.threshold:.0%}"),
        (places, detectable.unknown_place, "force (N)", "Smallest force found", rates),
        (places, accuracy.place_std * MM, "standard deviation (mm)",
         f"Place of {force}", "at best, from one reading; size unknown"),
        (places, accuracy.force_std, "standard deviation (N)",
         f"Force of {force}", "at best, from one reading; size unknown"),
        (few, pairs.typical * MM, "distance (mm)", "Two touches: typical direction", error),
        (few, pairs.worst * MM, "distance (mm)", "Two touches: worst direction", error),
    )  # fmt: skip
    design = judgement.design
    noise, unit = float(np.median(design.noise)), design.quantity.unit
    title = (
        f"{design.patch.name}, {len(design.patch)} taxels: h = {design.layer.thickness * MM:g} mm, "
        f"{design.quantity.symbol} with noise {noise:.3g}{'' if unit == '1' else f' {unit}'}"
    )
    half = places.grid.pitch / 2
    extent = np.array([places.plane.min(axis=0) - half, places.plane.max(axis=0) + half])
    with style():
        figure, boxes = _page(extent)
        size = figure.get_size_inches()
        figure.text(0.2 / size[0], 1 - 0.32 / size[1], title, **TITLE)
        figure.text(0.2 / size[0], 1 - 0.56 / size[1], judgement.verdict(), fontsize=8.5)
        for index, (box, panel) in enumerate(zip(boxes, panels, strict=True)):
            where, values, label, head, note = panel
            axes = figure.add_axes(box)
            _draw_places(axes, where, values, label, extent, falling=index == 0)
            if index % 3:
                axes.set_ylabel("")
            if index < 3:
                axes.set_xlabel("")
            add_title(axes, "abcdef"[index], head, note)
            if index == 0:
                _outline_blind(axes, judgement)
    return figure


def _page(extent: Floats) -> tuple["Figure", list[tuple[float, float, float, float]]]:
    """Empty figure, and boxes of two rows of three panels in the patch's proportions."""
    sides = extent[1] - extent[0]
    width, height = np.clip(sides / sides.max(), 0.25, 1) * PANEL
    width = max(width, 0.75 * PANEL)  # room for a head of words
    size = np.array([3 * (width + GAP) + LEFT - 0.3, HEAD + 2 * (height + OVER + FOOT) - 0.2])
    boxes = []
    for row in (1, 0):
        for column in range(3):
            left = LEFT + column * (width + GAP)
            bottom = FOOT + row * (height + OVER + FOOT)
            boxes.append((left / size[0], bottom / size[1], width / size[0], height / size[1]))
    return new_figure(float(size[0]), float(size[1])), boxes


def _draw_places(
    axes: "Axes", places: Places, values: Floats, label: str, extent: Floats, *, falling: bool
) -> None:
    """Map on a logarithmic scale: skins differ by factors. Dark is bad: low, if `falling`."""
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    ramp = ABOVE[::-1] if falling else ABOVE
    colours = LinearSegmentedColormap.from_list("skinfield", ramp, N=256)
    low, high = _limits(values)
    picture = places.picture(values)
    grid = places.grid
    finite = np.where(np.isfinite(picture), picture, np.nan)
    image = draw_cells(axes, grid, finite, cmap=colours, norm=LogNorm(low, high))
    if np.isposinf(picture).any():
        grey = LinearSegmentedColormap.from_list("nothing", [NOTHING, NOTHING])
        draw_cells(axes, grid, np.where(np.isposinf(picture), 1.0, np.nan), cmap=grey)
    frame_axes(axes, grid.patch, extent)
    if len(grid.patch) <= MOST_PADS:
        outline_pads(axes, grid.patch)
    _add_log_bar(axes, image, label, values)


def _limits(values: Floats) -> tuple[float, float]:
    """Ends of the colours: all but the extreme places, and never a flat scale."""
    finite = values[np.isfinite(values) & (values > 0)]
    if not len(finite):
        return 1.0, 2.0
    low, high = part_of(finite, LOWEST), part_of(finite, HIGHEST)
    middle = np.sqrt(low * high)
    return min(low, middle / 1.2), max(high, middle * 1.2)


def _add_log_bar(axes: "Axes", image: Any, label: str, values: Floats) -> None:
    """Colour bar with round numbers; its arrows say that some places are beyond its ends."""
    low, high = image.get_clim()
    finite = values[np.isfinite(values)]
    extend = ("neither", "min", "max", "both")
    beyond = (finite < low * 0.999).any() + 2 * (finite > high * 1.001).any()
    bar = add_colour_bar(axes, image, label, extend=extend[beyond], extendfrac=0.03)
    ticks = np.geomspace(low, high, 5)
    bar.set_ticks(list(ticks), labels=[f"{tick:.2g}" for tick in ticks])
    bar.ax.minorticks_off()


def _outline_blind(axes: "Axes", judgement: Judgement) -> None:
    """Draw the rim of the holes."""
    blind = judgement.blind
    if not blind.blind.any() or blind.blind.all():
        return
    picture = np.nan_to_num(blind.places.picture(blind.blind.astype(np.float64)), nan=0.0)
    grid = blind.places.grid
    x = (grid.origin[0] + np.arange(grid.shape[1]) * grid.pitch) * MM
    y = (grid.origin[1] + np.arange(grid.shape[0]) * grid.pitch) * MM
    if min(picture.shape) > 1:
        axes.contour(x, y, picture, levels=[0.5], colors=[INK], linewidths=0.9)
