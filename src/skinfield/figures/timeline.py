"""Force over time against a reference."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats, check_finite, check_shape
from skinfield.figures.style import BLUE, FAINT, INK, ORANGE, QUIET, new_figure, number, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_timeline(
    time_s: ArrayLike,
    force_N: ArrayLike,
    reference: ArrayLike | None = None,
    *,
    reference_time_s: ArrayLike | None = None,
    std: ArrayLike | None = None,
    label: str = "skin",
    reference_label: str = "force/torque sensor",
    title: str = "Normal force",
) -> "Figure":
    """Figure of the reconstructed normal force over time, with a reference and their difference.

    Parameters
    ----------
    time_s : (T,) array, s
        Of the readings.
    force_N : (T,) array, N
        Reconstructed; a NaN is a gap in the line.
    reference : (R,) array, N, optional
        What another sensor says, at `time_s` or at `reference_time_s`.
    reference_time_s : (R,) array, s, optional
        Increasing; the reference is interpolated to `time_s` within its own time.
    std : (T,) array or float, N, optional
        One standard deviation of `force_N`: a band of two of them is drawn.
    label, reference_label, title : str

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    InputError
        If the lengths differ or a time is not finite.
    """
    time, force = as_floats("time_s", time_s), as_floats("force_N", force_N)
    check_shape("time_s", time, (None,), "one time per reading")
    check_finite("time_s", time, "every reading has its time")
    check_shape("force_N", force, time.shape, "one force per time")
    band = np.broadcast_to(as_floats("std", 0.0 if std is None else std), force.shape)
    with style():
        figure = new_figure(10.0, 5.0 if reference is not None else 3.4)
        if reference is None:
            panels = [figure.add_axes((0.075, 0.16, 0.9, 0.68))]
        else:
            panels = [
                figure.add_axes((0.075, 0.41, 0.9, 0.49)),
                figure.add_axes((0.075, 0.11, 0.9, 0.24)),
            ]
            panels[0].tick_params(labelbottom=False)
            other, residual = _compare(time, force, reference, reference_time_s)
            panels[0].plot(*other, color=INK, lw=1.0, label=reference_label, zorder=2)
            _draw_residual(panels[1], time, residual, band, f"{label} − reference")
        _draw_force(panels[0], time, force, band, label)
        panels[0].set_title(title, loc="left", fontsize=11, fontweight="bold")
        panels[-1].set_xlabel("time (s)")
    return figure


def _compare(
    time: Floats, force: Floats, reference: ArrayLike, reference_time_s: ArrayLike | None
) -> tuple[tuple[Floats, Floats], Floats]:
    """Time and force of the reference, and force minus reference at `time` (NaN outside of it)."""
    there = time if reference_time_s is None else as_floats("reference_time_s", reference_time_s)
    other = as_floats("reference", reference)
    check_shape("reference_time_s", there, (None,), "one time per reference")
    check_finite("reference_time_s", there, "every reference has its time")
    check_shape("reference", other, there.shape, "one force per time of the reference")
    if not len(there):
        return (there, other), np.full_like(force, np.nan)
    return (there, other), force - np.interp(time, there, other, left=np.nan, right=np.nan)


def _draw_force(axes: "Axes", time: Floats, force: Floats, band: Floats, label: str) -> None:
    axes.plot(time, force, color=ORANGE, lw=0.9, label=label, zorder=3)
    if band.any():
        axes.fill_between(
            time,
            force - 2 * band,
            force + 2 * band,
            color=ORANGE,
            alpha=0.22,
            lw=0,
            label="± 2 σ",
            zorder=1,
        )
    axes.set_ylabel("normal force (N)")
    _dress(axes)
    axes.legend(
        frameon=False,
        fontsize=8.5,
        ncols=3,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        borderaxespad=0.2,
    )


def _draw_residual(axes: "Axes", time: Floats, residual: Floats, band: Floats, label: str) -> None:
    axes.plot(time, residual, color=BLUE, lw=0.9)
    if band.any():
        axes.fill_between(time, -2 * band, 2 * band, color=ORANGE, alpha=0.22, lw=0)
    axes.axhline(0.0, color=QUIET, lw=0.7)
    axes.set_ylabel("difference (N)")
    known = residual[np.isfinite(residual)]
    words = "nothing in common with the reference"
    if len(known):
        words = (
            f"{label}: mean {number(float(known.mean()))} N, "
            f"root mean square {number(float(np.sqrt((known**2).mean())))} N"
        )
    axes.set_title(words, loc="left", fontsize=8.5, color=QUIET, pad=4)
    _dress(axes)


def _dress(axes: "Axes") -> None:
    axes.grid(color=FAINT, lw=0.5, alpha=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.0)
