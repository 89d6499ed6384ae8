"""Figure of a skin's taxels: pads, modules and normals of each patch."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.plot import FAINT, INK, QUIET, TITLE, add_title, new_figure, number, plural, style
from skinfield.skin import Patch, Skin
from skinfield.skin.geometry import facing_from_positions
from skinfield.skin.maps import MM, draw_circles, draw_modules, extent_of_pads, frame_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours, lightened: told apart by every kind of colour vision.
HUES = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"]
WIDTH, LEFT, RIGHT, ABOVE, BELOW, HEAD = 6.4, 0.75, 0.25, 0.6, 0.55, 0.35  # of a panel, inches
MOST_NUMBERED = 40  # modules; more of them cannot be read


def draw_layout(skin: Skin) -> "Figure":
    """Figure of the patches of a skin, one panel each.

    A flat patch is drawn in its plane, pads to scale in the colours of their modules, over the
    triangulation; a curved one in 3D, its normals as short arrows.

    Parameters
    ----------
    skin : Skin
    """
    columns = int(np.ceil(np.sqrt(len(skin))))
    rows = int(np.ceil(len(skin) / columns))
    flat = [facing_from_positions(patch.positions).is_flat for patch in skin]
    height = max(_height(patch) if f else WIDTH * 0.8 for patch, f in zip(skin, flat, strict=True))
    top = HEAD if len(skin) > 1 else 0.0
    size = np.array([WIDTH * columns, height * rows + top])
    with style():
        figure = new_figure(*size)
        if top:
            words, x, y = skin.name, 0.2 / size[0], 1 - 0.12 / size[1]
            figure.text(x, y, words, ha="left", va="top", **TITLE)
        for index, patch in enumerate(skin):
            row, column = divmod(index, columns)
            corner = np.array([column * WIDTH, (rows - 1 - row) * height])
            inner = np.array([WIDTH, height]) - [LEFT + RIGHT, BELOW + ABOVE]
            box = np.concatenate([(corner + np.array([LEFT, BELOW])) / size, inner / size])
            if flat[index]:
                _draw_flat(figure.add_axes(tuple(box)), patch)
            else:
                _draw_curved(figure, corner / size, np.array([WIDTH, height]) / size, patch)
    return figure


def _height(patch: Patch) -> float:
    """Height of a flat patch's panel, inches."""
    width, height = np.ptp(patch.plane, axis=0) + 3 * patch.pad_diameter
    inner = (WIDTH - LEFT - RIGHT) * float(height / width)
    return float(np.clip(inner, 1.2, 6.0)) + BELOW + ABOVE


def _note(patch: Patch) -> str:
    modules = plural(len(np.unique(patch.module)), "module")
    pitch = f", pitch {number(patch.pitch * MM)} mm" if len(patch) > 1 else ""
    pads = f"pads {number(patch.pad_diameter * MM)} mm"
    on = f", on {patch.link}" if patch.link else ""
    return f"{plural(len(patch), 'taxel')}, {modules}{pitch}, {pads}{on}"


def _fill(patch: Patch) -> Floats:
    """Colour of each pad (L, 3): that of its module, in turn."""
    from matplotlib.colors import to_rgb

    hues = np.array([to_rgb(hue) for hue in HUES]) * 0.75 + 0.25
    row = np.unique(patch.module, return_inverse=True)[1]
    return np.asarray(hues[row % len(HUES)])


def _draw_flat(axes: "Axes", patch: Patch) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.patheffects import withStroke

    plane, modules = patch.plane * MM, np.unique(patch.module)
    axes.add_collection(
        LineCollection(list(plane[patch.neighbours]), colors=FAINT, linewidths=0.6, zorder=0.7)
    )
    if len(modules) > 1:
        draw_modules(axes, patch)
    draw_circles(axes, patch, facecolors=_fill(patch), edgecolors=QUIET, linewidths=0.4)
    halo = [withStroke(linewidth=2.2, foreground="white")]
    look: dict[str, Any] = {"path_effects": halo, "fontsize": 7, "ha": "center", "va": "center"}
    for module in modules if 1 < len(modules) <= MOST_NUMBERED else ():
        x, y = plane[patch.module == module].mean(axis=0)
        axes.text(x, y, str(module), color=INK, **look)
    frame_axes(axes, patch, extent_of_pads(patch))
    add_title(axes, "", patch.name, f"{_note(patch)}, flat, seen from outside")


def _draw_curved(figure: "Figure", corner: Floats, size: Floats, patch: Patch) -> None:
    box = (*corner, size[0], size[1] * 0.93)
    axes: Any = figure.add_axes(box, projection="3d")
    axes.set_proj_type("ortho")
    towards = patch.normals.mean(axis=0)
    axes.view_init(
        elev=np.degrees(np.arctan2(towards[2], np.hypot(*towards[:2]))) * 0.6 + 15.0,
        azim=np.degrees(np.arctan2(towards[1], towards[0])) + 25.0,
    )
    places, normals = patch.positions * MM, patch.normals
    reach = patch.pitch * MM
    axes.scatter(*places.T, c=_fill(patch), s=24, edgecolors=QUIET, linewidths=0.4)
    axes.quiver(*places.T, *normals.T, length=reach, colors=INK, linewidths=0.6)
    tips = np.concatenate([places, places + reach * normals])
    low, high = tips.min(axis=0), tips.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=0.86)
    axes.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)")
    for axis, share in zip("xyz", (high - low) / (high - low).max(), strict=True):
        axes.locator_params(axis=axis, nbins=max(1, round(5 * share)))  # short sides overlap
    x, y = corner + size * [0.2 / WIDTH, 0.98]
    figure.text(x, y, patch.name, fontsize=10, fontweight="bold", va="top")
    note = f"{_note(patch)}, curved; lines are normals"
    figure.text(x, y - 0.042 * size[1], note, fontsize=7.5, color=QUIET, va="top")
