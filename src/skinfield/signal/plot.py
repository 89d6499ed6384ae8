"""Figures of signals: force over time, gains of taxels, and a log of a new skin."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats, check_finite, check_shape
from skinfield.plot import (
    BLUE,
    INK,
    ORANGE,
    QUIET,
    Place,
    add_colour_bar,
    add_title,
    axes_for,
    new_figure,
    number,
    open_axes,
    style,
)
from skinfield.signal.boards import Bools
from skinfield.signal.calibration import Calibration
from skinfield.skin import Patch
from skinfield.skin.maps import MM, axis_names, draw_pads, extent_of_pads, frame_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_NAMED = 150  # taxels; names of more cannot be read
MOST_TRACES = 6


def plot_calibration(made: Calibration, ax: Place = None, patch: Patch | None = None) -> Any:
    """Draw the gain of each taxel; see `Calibration.plot`."""
    gain = np.where(made.alive, made.gain, np.nan)
    label = f"gain ({made.unit} per ΔC/C₀)"
    note = f"{int(made.alive.sum())} of {len(made)} taxels alive"
    if patch is not None:
        made.check_patch(patch)
    with style():
        if patch is None:
            axes = axes_for(ax, (5.6, 2.6), (0.85, 0.55, 0.2, 0.6))
            axes.plot(np.arange(len(made)), gain, ".", color=ORANGE, ms=4.0)
            axes.axhline(0.0, color=QUIET, lw=0.7)
            axes.set(xlabel="taxel (row of the patch)", ylabel=label)
            open_axes(axes)
            axes.margins(x=0.02)
        else:
            extent = extent_of_pads(patch)
            width, height = np.ptp(extent, axis=0)
            size = (4.4, float(np.clip(4.4 * height / width, 1.0, 5.0)))
            axes = axes_for(ax, size, (0.75, 0.55, 1.15, 0.6))
            pads = draw_pads(axes, patch, gain)
            frame_axes(axes, patch, extent)
            add_colour_bar(axes, pads, label)
        add_title(axes, "", f"Calibration of {made.patch_name}", note)
    return axes


def draw_timeline(
    time_s: ArrayLike,
    force_N: ArrayLike,
    reference: ArrayLike,
    *,
    label: str = "skin",
    reference_label: str = "force/torque sensor",
    title: str = "Normal force",
    unit: str = "N",
) -> "Figure":
    """Figure of the reconstructed normal force over time, with a reference and their difference.

    Parameters
    ----------
    time_s : (T,) array, s
        Of the readings.
    force_N : (T,) array, N
        Reconstructed; a NaN is a gap in the line.
    reference : (T,) array, N
        What another sensor says at these times, NaN where it says nothing.
    label, reference_label, title : str
    unit : str
        Of both, in the words.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    InputError
        If the lengths differ or a time is not finite.
    """
    time, force = as_floats("time_s", time_s), as_floats("force_N", force_N)
    other = as_floats("reference", reference)
    check_shape("time_s", time, (None,), "one time per reading")
    check_finite("time_s", time, "every reading has its time")
    check_shape("force_N", force, time.shape, "one force per time")
    check_shape("reference", other, time.shape, "one force per time")
    with style():
        figure = new_figure(10.0, 5.0)
        forces = figure.add_axes((0.075, 0.41, 0.9, 0.49))
        difference = figure.add_axes((0.075, 0.11, 0.9, 0.24))
        forces.tick_params(labelbottom=False)
        forces.plot(time, other, color=INK, lw=1.0, label=reference_label)
        forces.plot(time, force, color=ORANGE, lw=0.9, label=label)
        forces.set_ylabel("normal force (N)")
        forces.set_title(title, loc="left", fontsize=11, fontweight="bold")
        forces.legend(
            frameon=False, fontsize=8.5, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0),
            borderaxespad=0.2,
        )  # fmt: skip
        difference.plot(time, force - other, color=BLUE, lw=0.9)
        difference.axhline(0.0, color=QUIET, lw=0.7)
        difference.set_ylabel("difference (N)")
        difference.set_xlabel("time (s)")
        known = (force - other)[np.isfinite(force - other)]
        words = "nothing in common with the reference"
        if len(known):
            mean, rms = float(known.mean()), float(np.sqrt((known**2).mean()))
            mean_rms = f"mean {number(mean)} {unit}, root mean square {number(rms)} {unit}"
            words = f"{label} − reference: {mean_rms}"
        difference.set_title(words, loc="left", fontsize=8.5, color=QUIET, pad=4)
        for axes in (forces, difference):
            open_axes(axes)
    return figure


def draw_log(
    patch: Patch,
    names: Sequence[str],
    time_s: Floats,
    readings: Floats,
    rest: Floats,
    noise: Floats,
    usable: Bools,
    presses: Sequence[int],
    *,
    quantity: str = "reading",
    unit: str = "counts",
    loaded: int | None = None,
) -> "Figure":
    """Figure of a log of a skin: its taxels by name, their rest and noise, readings over time.

    Parameters
    ----------
    patch : Patch
    names : sequence of L str
    time_s : (T,) array, s
    readings : (T, L) array
        Conditioned; NaN where invalid.
    rest, noise : (L,) arrays
        In the unit of the log.
    usable : (L,) bool array
        False of taxels that are left out: they are crossed.
    presses : sequence of int
        Readings that are marked over time.
    quantity, unit : str
        What readings are of, and in which unit rest and noise are.
    loaded : int, optional
        Reading that is drawn in place of the rest.
    """
    with style():
        figure = new_figure(11.0, 6.6)
        boxes = [(left, 0.5, 0.24, 0.4) for left in (0.055, 0.355, 0.705)]  # squares
        order, lost = figure.add_axes(boxes[0]), int((~usable).sum())
        title = f"taxels; {lost} left out" if lost else "taxels, in their order"
        _draw_map(figure, order, patch, np.arange(float(len(patch))), usable, title, "")
        if len(patch) <= MOST_NAMED:
            for (x, y), name in zip(patch.plane * MM, names, strict=True):
                order.text(x, y, name[-5:], fontsize=5.5, ha="center", va="center", color=INK)
        first = rest, f"rest ({unit})"
        if loaded is not None:
            first = readings[loaded], f"{quantity} at {time_s[loaded]:.2f} s"
        for box, (values, words) in zip(
            boxes[1:], (first, (noise, f"noise ({unit})")), strict=True
        ):
            _draw_map(figure, figure.add_axes(box), patch, values, usable, words, words)
        axes = figure.add_axes((0.075, 0.08, 0.905, 0.28))
        _draw_readings(axes, names, time_s, readings, presses, quantity)
    return figure


def _draw_map(
    figure: "Figure",
    axes: "Axes",
    patch: Patch,
    values: Floats,
    usable: Bools,
    title: str,
    label: str,
) -> None:
    """Taxels at their places, coloured by a value; those that are left out are crossed."""
    x, y = patch.plane.T * MM
    look: dict[str, Any] = {} if label else {"alpha": 0.45}
    low, high = extent_of_pads(patch) * MM
    middle, half = (low + high) / 2, float((high - low).max()) / 2
    axes.set(xlim=middle[0] + [-half, half], ylim=middle[1] + [-half, half])
    size = float(np.clip(9000.0 / len(patch), 12.0, 160.0))
    dots = axes.scatter(x, y, c=values, s=size, cmap="viridis", clip_on=False, zorder=2, **look)
    axes.scatter(x[~usable], y[~usable], s=size, marker="x", color=ORANGE, lw=1.6, clip_on=False)
    first, second = axis_names(patch)
    axes.set(xlabel=f"{first} (mm)", ylabel=f"{second} (mm)")
    axes.set_title(title, loc="left", fontsize=10, fontweight="bold")
    if label:
        box = axes.get_position()
        bar = figure.add_axes((box.x1 + 0.004, box.y0, 0.008, box.height))
        figure.colorbar(dots, cax=bar).ax.tick_params(labelsize=6.5)
        bar.ticklabel_format(useOffset=False, axis="y")
    open_axes(axes)


def _draw_readings(
    axes: "Axes",
    names: Sequence[str],
    time_s: Floats,
    readings: Floats,
    presses: Sequence[int],
    quantity: str,
) -> None:
    """Readings over time of the taxels that are pressed most."""
    known = np.nan_to_num(readings)
    peak = known.max(axis=0)
    chosen = [int(known[at].argmax()) for at in presses] or [int(peak.argmax())]
    chosen = list(dict.fromkeys(chosen))[:MOST_TRACES]
    for taxel in chosen:
        axes.plot(time_s, readings[:, taxel], lw=0.9, label=names[taxel])
    for at in presses:
        axes.axvline(time_s[at], color=QUIET, lw=0.6, ls=":")
    axes.set(xlabel="time (s)", ylabel=quantity, xlim=(time_s[0], time_s[-1]))
    axes.set_title("the taxels that are pressed most", loc="left", fontsize=10, fontweight="bold")
    axes.legend(frameon=False, fontsize=8, ncols=MOST_TRACES, loc="lower right",
                bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)  # fmt: skip
    open_axes(axes)
