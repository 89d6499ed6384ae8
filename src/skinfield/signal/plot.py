"""Figures of signals: force over time against a reference; gains of taxels."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import as_floats, check_finite, check_shape
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
from skinfield.signal.calibration import Calibration
from skinfield.skin import Patch
from skinfield.skin.maps import draw_pads, extent_of_pads, frame_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
