"""How late loops wake: the share of wakes that were later than a time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.figures.bench import COLOURS
from skinfield.figures.style import FAINT, QUIET, add_title, new_figure, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 9.6, 4.0  # inches
PANELS = ((0.075, 0.17, 0.4, 0.66), (0.57, 0.17, 0.4, 0.66))
SHARES = {1.0: "all", 0.1: "10 %", 0.01: "1 %", 1e-3: "0.1 %", 1e-4: "0.01 %"}
TIMES = {1e-5: "10 µs", 1e-4: "100 µs", 1e-3: "1 ms", 1e-2: "10 ms", 1e-1: "100 ms"}
LOOK = {"solid": "-", "dashed": (0, (4, 2))}


@dataclass(frozen=True, eq=False)
class Late:
    """One loop.

    Attributes
    ----------
    name : str
    time, share : (B,) arrays
        Time in s, and the share of wakes that were later.
    colour : int
        Of `COLOURS`.
    kind : str
        "solid" or "dashed".
    """

    name: str
    time: Floats
    share: Floats
    colour: int
    kind: str = "solid"


def draw_lateness(
    left: tuple[str, str, Sequence[Late]], right: tuple[str, str, Sequence[Late]], foot: str = ""
) -> "Figure":
    """Two panels of title, note and loops, on logarithmic axes.

    Raises
    ------
    InputError
        If a panel has no loop, or a loop no wakes.
    """
    if not (left[2] and right[2]):
        raise InputError("a panel has no loops, expected one or more: there is nothing to draw")
    for each in (*left[2], *right[2]):
        if not len(each.time):
            raise InputError(f"{each.name} has no wakes, expected some: was it measured?")
    latest = max(float(each.time[-1]) for _, _, loops in (left, right) for each in loops)
    with style():
        figure = new_figure(WIDTH, HEIGHT)
        for (title, note, loops), box, letter in zip((left, right), PANELS, "ab", strict=True):
            axes = figure.add_axes(box)
            axes.set_xscale("log")
            axes.set_yscale("log")
            for each in loops:
                seen = each.share > 0
                axes.plot(
                    np.append(each.time[seen], each.time[-1]),
                    np.append(each.share[seen], each.share[seen][-1:]),
                    color=COLOURS[each.colour],
                    ls=LOOK[each.kind],
                    lw=1.6,
                    label=each.name,
                )
            axes.grid(color=FAINT, lw=0.5, alpha=0.7)
            axes.spines[["top", "right"]].set_visible(False)
            axes.set_xlim(5e-6, 1.3 * latest)
            axes.set_ylim(1e-5, 1.3)
            axes.set_yticks(list(SHARES), list(SHARES.values()))
            shown = [time for time in TIMES if time <= latest]
            axes.set_xticks(shown, [TIMES[time] for time in shown])
            axes.minorticks_off()
            axes.set(xlabel="time after it was due", ylabel="wakes that are later")
            axes.legend(frameon=False, fontsize=8, loc="lower left")
            add_title(axes, letter, title, note)
        figure.text(0.985, 0.012, foot, ha="right", va="bottom", fontsize=6.5, color=QUIET)
    return figure
