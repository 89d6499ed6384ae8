"""Figure of a skin's taxels: pads, modules and normals of each patch."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.plot.maps import MM, circles, draw_modules, frame_axes
from skinfield.plot.style import (
    FAINT,
    INK,
    QUIET,
    TITLE,
    add_title,
    new_figure,
    number,
    plural,
    style,
)
from skinfield.skin import Patch, Skin
from skinfield.skin.geometry import facing_from_positions, nearest_distance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours, lightened: told apart by every kind of colour vision.
HUES = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"]
WIDTH, LEFT, RIGHT, ABOVE, BELOW, HEAD = 6.4, 0.75, 0.25, 0.6, 0.55, 0.35  # of a panel, inches
CORNERS = 18  # of a pad drawn in 3D
MOST_NUMBERED = 40  # modules; more of them cannot be read


def draw_layout(skin: Skin) -> "Figure":
    """Figure of the patches of a skin, one panel each.

    A flat patch is drawn in its plane, pads to scale in the colours of their modules, over the
    triangulation; a curved one in 3D from outside, its normals as short arrows.

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
    distance = nearest_distance(patch.positions)
    pitch = f", pitch {number(np.median(distance) * MM)} mm" if np.isfinite(distance).all() else ""
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

    plane = patch.plane * MM
    axes.add_collection(
        LineCollection(list(plane[patch.neighbours]), colors=FAINT, linewidths=0.6, zorder=0.7)
    )
    if len(np.unique(patch.module)) > 1:
        draw_modules(axes, patch)
    everything = np.ones(len(patch), np.bool_)
    axes.add_collection(
        circles(axes, patch, everything, facecolors=_fill(patch), edgecolors=QUIET, linewidths=0.4)
    )
    _number_modules(axes, patch)
    rim = patch.pad_diameter
    frame_axes(axes, patch, np.array([patch.plane.min(0) - rim, patch.plane.max(0) + rim]))
    add_title(axes, "", patch.name, f"{_note(patch)}, flat, seen from outside")


def _number_modules(axes: "Axes", patch: Patch) -> None:
    modules = np.unique(patch.module)
    if not 1 < len(modules) <= MOST_NUMBERED:
        return
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.2, foreground="white")]
    for module in modules:
        x, y = patch.plane[patch.module == module].mean(axis=0) * MM
        axes.text(
            x, y, str(module), ha="center", va="center", fontsize=7, color=INK, path_effects=halo
        )


def _draw_curved(figure: "Figure", corner: Floats, size: Floats, patch: Patch) -> None:
    from mpl_toolkits.mplot3d.art3d import (  # type: ignore[import-untyped]
        Line3DCollection,
        Poly3DCollection,
    )

    box = (*corner, size[0], size[1] * 0.93)
    axes: Any = figure.add_axes(box, projection="3d", computed_zorder=False)
    axes.set_proj_type("ortho")
    towards = _view(patch)
    axes.view_init(
        elev=np.degrees(np.arcsin(np.clip(towards[2], -1, 1))),
        azim=np.degrees(np.arctan2(towards[1], towards[0])),
    )
    front = (patch.normals @ towards)[:, None]
    fill = np.where(front > 0, _fill(patch), 0.35 * _fill(patch) + 0.65)  # the far side is pale
    order = np.argsort(patch.positions @ towards)
    axes.add_collection3d(
        Poly3DCollection(
            list(_discs(patch)[order] * MM),
            facecolors=fill[order],
            edgecolors=np.where(front > 0, 0.45, 0.8)[order].repeat(3, axis=1),
            linewidths=0.4,
            zsort="average",
        )
    )
    reach = float(np.median(nearest_distance(patch.positions)))
    seen = front[:, 0] > 0
    arrows = np.stack([patch.positions, patch.positions + reach * patch.normals], axis=1) * MM
    colours = np.where(seen, INK, FAINT).tolist()
    axes.add_collection3d(Line3DCollection(list(arrows), colors=colours, linewidths=0.6))
    low, high = arrows.min(axis=(0, 1)), arrows.max(axis=(0, 1))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=0.86)
    axes.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)")
    for axis, share in zip("xyz", (high - low) / (high - low).max(), strict=True):
        axes.locator_params(axis=axis, nbins=max(1, round(5 * share)))  # short sides overlap
    x, y = corner + size * [0.2 / WIDTH, 0.98]
    figure.text(x, y, patch.name, fontsize=10, fontweight="bold", va="top")
    note = f"{_note(patch)}, curved; lines are normals, pale faces away"
    figure.text(x, y - 0.042 * size[1], note, fontsize=7.5, color=QUIET, va="top")


def _view(patch: Patch) -> Floats:
    """Direction from the skin to the eye: against its mean normal, or across its long side."""
    mean = patch.normals.mean(axis=0)
    length = np.linalg.norm(mean)
    if length > 0.3:
        towards = mean / length
    else:
        towards = np.linalg.svd(patch.positions - patch.positions.mean(axis=0))[2][2]
    up = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 0.8 else np.array([0.3, -1.0, 0.0])
    up -= towards * (up @ towards)
    up /= np.linalg.norm(up)
    towards = 0.8 * towards + 0.5 * up + 0.33 * np.cross(up, towards)  # from above and aside
    return np.asarray(towards / np.linalg.norm(towards))


def _discs(patch: Patch) -> Floats:
    """Rims of the pads, (L, corners, 3) m, each across its normal."""
    helper = np.where(np.abs(patch.normals[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(patch.normals, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(patch.normals, first)
    turn = np.linspace(0.0, 2 * np.pi, CORNERS, endpoint=False)[None, :, None]
    rim = np.cos(turn) * first[:, None] + np.sin(turn) * second[:, None]
    return np.asarray(patch.positions[:, None] + patch.pad_diameter / 2 * rim)
