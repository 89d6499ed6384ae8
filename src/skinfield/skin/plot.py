"""Figures of a skin: pads, modules and normals of each patch; readings of channels over time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, check_count
from skinfield.plot import (
    EDGES,
    FAINT,
    INK,
    QUIET,
    TITLE,
    Place,
    add_title,
    axes_for,
    new_figure,
    number,
    open_axes,
    plural,
    style,
)
from skinfield.skin import Patch, Skin
from skinfield.skin.geometry import facing_from_positions
from skinfield.skin.maps import MM, draw_circles, draw_modules, extent_of_pads, frame_axes
from skinfield.skin.reading import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours, lightened: told apart by every kind of colour vision.
HUES = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"]
WIDTH, LEFT, RIGHT, ABOVE, BELOW, HEAD = 6.4, 0.75, 0.25, 0.6, 0.55, 0.35  # of a panel, inches
MOST_NUMBERED = 40  # modules; more of them cannot be read
MOST_NAMED = 150  # taxels; numbers of more cannot be read


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


def plot_patch(patch: Patch, ax: Place = None) -> Any:
    """Draw the pads of a patch; see `Patch.plot`."""
    flat = facing_from_positions(patch.positions).is_flat
    with style():
        if flat:
            width = WIDTH - LEFT - RIGHT
            axes = axes_for(ax, (width, _height(patch) - ABOVE - BELOW), EDGES)
        else:
            axes = axes_for(ax, (4.6, 4.2), (0.3, 0.3, 0.5, 0.6), projection="3d")
        if hasattr(axes, "get_zlim"):
            _draw_in_space(axes, patch)
            axes.set_title(f"{patch.name}\n{_note(patch)}", loc="left", fontsize=9)
        else:
            _draw_flat(axes, patch, "flat, seen from outside" if flat else "flattened")
    return axes


SPACE = 2.0  # pad diameters between patches that are drawn side by side


def plot_skin(skin: Skin, ax: Place = None) -> Any:
    """Draw all patches of a skin, to one scale; see `Skin.plot`."""
    if len(skin) == 1:
        return plot_patch(skin[0], ax)
    boxes = [extent_of_pads(patch) for patch in skin]
    sizes = np.array([np.ptp(box, axis=0) for box in boxes]) * MM
    gap = SPACE * max(patch.pad_diameter for patch in skin) * MM
    corners, (wide, high) = _shelved(sizes + np.array([gap, 2.0 * gap]))
    with style():
        inner = (5.4, float(np.clip(5.4 * high / wide, 1.0, 6.0)))
        axes = axes_for(ax, inner)
        for patch, box, size, corner in zip(skin, boxes, sizes, corners, strict=True):
            low = corner - box[0] * MM
            look: dict[str, Any] = {"facecolors": _fill(patch), "edgecolors": QUIET}
            pads = draw_circles(axes, patch, linewidths=0.2, **look)
            pads.set_offsets(patch.plane * MM + low)
            if len(skin) <= MOST_NUMBERED:
                x, y = corner[0], corner[1] + size[1] + 0.1 * gap
                axes.text(x, y, patch.name, fontsize=7, color=INK, va="bottom", clip_on=True)
        axes.set(xlim=(-gap, wide), ylim=(-gap, high), xlabel="x (mm)", ylabel="y (mm)")
        axes.set_aspect("equal", adjustable="box", anchor="NW")
        taxels = plural(sum(len(patch) for patch in skin), "taxel")
        note = "each patch in its own plane, side by side, to one scale"
        add_title(axes, "", f"{skin.name}: {len(skin)} patches, {taxels}", note)
    return axes


def _shelved(sizes: Floats) -> tuple[Floats, tuple[float, float]]:
    """Lower left corners (P, 2) of boxes (P, 2) in rows of about one width, and size of all."""
    across = max(float(sizes[:, 0].max()), float(np.sqrt(1.4 * sizes.prod(axis=1).sum())))
    corners, x, y, row = np.zeros_like(sizes), 0.0, 0.0, 0.0
    for place, (width, height) in enumerate(sizes):
        if x > 0.0 and x + width > across:
            x, y, row = 0.0, y + row, 0.0
        corners[place] = x, y
        x, row = x + width, max(row, float(height))
    wide, high = float((corners[:, 0] + sizes[:, 0]).max()), y + row
    corners[:, 1] = high - corners[:, 1] - sizes[:, 1]  # the first on top
    return corners, (wide, high)


LIVELIEST = 6
COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito
QUANTITIES = {"count": "counts", "dC/C0": "ΔC/C₀", "Pa": "stress at the base (Pa)"}
QUANTITIES |= {"1": "indentation over thickness"}
MOST_DRAWN = 4000  # readings of a line; of more, the lowest and highest of each run


def plot_recording(
    recording: Recording, ax: Place = None, channels: Sequence[int] | None = None
) -> Any:
    """Draw readings over time; see `Recording.plot`."""
    width = recording.counts.shape[1]
    if channels is None:
        reach = _reach(recording.counts)
        chosen = np.argsort(-reach, kind="stable")[:LIVELIEST].tolist()
    else:
        chosen = [int(channel) for channel in channels]
        for channel in chosen:
            check_count("channels", channel, 0, width - 1, f"one of the {width} recorded")
    with style():
        axes = axes_for(ax, (6.2, 2.6), (0.8, 0.55, 0.2, 0.65))
        draw_channels(axes, recording, chosen, "channel")
        axes.set_xlabel("time (s)")
        open_axes(axes)
        if chosen:
            axes.legend(
                frameon=False, fontsize=7.5, ncols=len(chosen), loc="lower right",
                bbox_to_anchor=(1.0, 0.985), handlelength=1.2, columnspacing=1.0, borderaxespad=0.1,
            )  # fmt: skip
        which = "the liveliest" if channels is None else "chosen"
        shown = plural(width, "channel")
        add_title(axes, "", shown if width <= len(chosen) else f"{which} of {shown}")
    return axes


def draw_channels(axes: "Axes", recording: Recording, columns: Sequence[int], word: str) -> None:
    """Draw columns of a recording over time, the first on top, named by `word` and number."""
    colours = [COLOURS[place % len(COLOURS)] for place in range(len(columns))]
    for column, colour in zip(columns[::-1], colours[::-1], strict=True):
        time, values = _thinned(recording.time, recording.counts[:, column])
        look: dict[str, Any] = {"where": "post", "lw": 0.7, "label": f"{word} {column}"}
        axes.step(time, values, color=colour, **look)
    axes.set_ylabel(QUANTITIES.get(recording.unit, f"readings ({recording.unit})"))


def _reach(counts: Floats) -> Floats:
    """How far each column (C,) moves, 0 where it says nothing."""
    low = np.fmin.reduce(counts, axis=0, initial=np.inf)
    high = np.fmax.reduce(counts, axis=0, initial=-np.inf)
    return np.where(high >= low, high - low, 0.0)


def _thinned(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Points that draw the same line: of many the lowest and the highest of each run."""
    if len(time) <= MOST_DRAWN:
        return time, values
    run = -(-len(time) // (MOST_DRAWN // 2))
    whole = len(time) // run * run
    blocks = values[:whole].reshape(-1, run)
    pairs = np.column_stack([np.fmin.reduce(blocks, axis=1), np.fmax.reduce(blocks, axis=1)])
    starts = time[:whole].reshape(-1, run)[:, [0, run // 2]]
    rest = slice(whole, None)
    return np.r_[starts.ravel(), time[rest]], np.r_[pairs.ravel(), values[rest]]


def _draw_flat(axes: "Axes", patch: Patch, words: str = "flat, seen from outside") -> None:
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
    if len(modules) == 1 < len(patch) <= MOST_NAMED:
        for taxel, (x, y) in enumerate(plane):
            axes.text(x, y, str(taxel), color=INK, fontsize=5.5, ha="center", va="center")
    frame_axes(axes, patch, extent_of_pads(patch))
    add_title(axes, "", patch.name, f"{_note(patch)}, {words}")


def _draw_curved(figure: "Figure", corner: Floats, size: Floats, patch: Patch) -> None:
    box = (*corner, size[0], size[1] * 0.93)
    axes: Any = figure.add_axes(box, projection="3d")
    _draw_in_space(axes, patch)
    x, y = corner + size * [0.2 / WIDTH, 0.98]
    figure.text(x, y, patch.name, fontsize=10, fontweight="bold", va="top")
    note = f"{_note(patch)}, curved; lines are normals"
    figure.text(x, y - 0.042 * size[1], note, fontsize=7.5, color=QUIET, va="top")


def _draw_in_space(axes: Any, patch: Patch) -> None:
    """Pads and normals of a patch in its own frame."""
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
