"""Make the picture of docs/explanation/electronics.md: a press, step by step from force to bytes.

python docs/figures/electronics.py
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import skinfield as sf
from skinfield.elastic import StandardLinearSolid
from skinfield.errors import Floats
from skinfield.plot import (
    BLUE,
    FAINT,
    INK,
    ORANGE,
    QUIET,
    TITLE,
    add_title,
    new_figure,
    save,
    style,
)
from skinfield.simulate.electronics import (
    Electronics,
    Noise,
    Sampling,
    TaxelArray,
    ThermalDrift,
    icub_electronics,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

IMAGE = Path(__file__).parents[1] / "images" / "electronics.png"
PATCH = sf.layouts.icub_hexagon()
UNDER, BESIDE = 3, 4  # taxels: under the ball, and the one that a ball's edge pulls up
ON, OFF, END = 3.0, 9.0, 15.0  # s: pressed, released, end
FORCE = 1.0  # N
SOLID = StandardLinearSolid(relaxed_fraction=0.75, time_constant=1.0)
WARMING = 2.0  # K/s, far more than any room does: so that the drift can be seen in 15 s
ZOOM = (ON + 0.02, ON + 1.3)  # of the bytes: it creeps


def effective_force(instants: Floats) -> Floats:
    """Elastic load (N) at any instants (s) of the step press."""
    time = np.array([0.0, ON, ON, OFF, OFF])
    force = np.array([0.0, 0.0, FORCE, FORCE, 0.0])
    fine = np.unique(np.concatenate([time, np.linspace(0, END, 3001)]))
    fine = np.sort(np.concatenate([fine, [ON, OFF]]))  # both ends of each step
    steps = np.interp(fine, time, force)
    steps[np.searchsorted(fine, [ON, OFF])] = [0.0, FORCE]
    steps[np.searchsorted(fine, [ON, OFF], side="right") - 1] = [FORCE, 0.0]
    return np.interp(instants, fine, SOLID.effective_force(fine, steps))


def changes(sampling: Sampling) -> Floats:
    """ΔC/C₀ (T, L) of a ball over taxel `UNDER`, from elastic presses at a ladder of loads."""
    ladder = FORCE * np.array([0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0])
    place = PATCH.plane[UNDER]
    ball = sf.simulate.Sphere(radius=6e-3)
    presses = sf.simulate.press_ladder(sf.Layer(), ball, ladder.tolist(), extent=16e-3, cell=0.4e-3)
    read = [press.capacitance(PATCH.plane - place, PATCH.pad_diameter) for press in presses]
    table = np.vstack([np.zeros(len(PATCH)), *read])
    load = effective_force(sampling.instants)
    loads = np.concatenate([[0.0], ladder])
    return np.column_stack([np.interp(load[:, k], loads, table[:, k]) for k in range(len(PATCH))])


def made_with(settings: Electronics) -> TaxelArray:
    """Taxels of the same draw, whatever is switched off in `settings`."""
    return settings.manufacture(PATCH, np.random.default_rng(4))


def main() -> None:
    """Draw it."""
    full = replace(
        icub_electronics(),
        drift=ThermalDrift(per_kelvin=0.3, taxel_spread=0.1, time_constant=5.0),
        noise=Noise(white=1.5),
    )
    array = made_with(full)
    sampling = array.sample_times(END, np.random.default_rng(5))
    change = changes(sampling)
    temperature = full.drift.reference + WARMING * sampling.time

    def counts(settings: Electronics, warm: bool = True) -> Floats:
        skin = made_with(settings)
        return skin.counts(change, temperature if warm else None, np.random.default_rng(6))

    level = replace(full, quantised=False)
    silent = replace(level, noise=Noise())
    stages = {
        "change alone": counts(silent, warm=False),
        "with drift": counts(silent),
        "with noise": counts(level),
        "sent": counts(full),
    }
    with style():
        figure = new_figure(9.6, 7.4)
        figure.text(0.065, 0.965, "One press, from force to bytes", **TITLE)
        boxes = [(0.065, 0.547), (0.565, 0.547), (0.065, 0.075), (0.565, 0.075)]
        panels = [figure.add_axes((left, low, 0.41, 0.33)) for left, low in boxes]
        draw_force(panels[0])
        draw_change(panels[1], sampling, change)
        draw_stages(panels[2], sampling, stages)
        draw_bytes(panels[3], sampling, stages)
        for axes in panels:
            axes.spines[["top", "right"]].set_visible(False)
            axes.grid(color=FAINT, lw=0.5, alpha=0.6)
            axes.set_xlabel("time (s)")
        save(figure, IMAGE)


def draw_force(axes: "Axes") -> None:
    """Force, and the load of the elastic solution."""
    time = np.linspace(0, END, 2000)
    axes.plot([0, ON, ON, OFF, OFF, END], [0, 0, FORCE, FORCE, 0, 0], color=INK, label="force")
    axes.plot(time, effective_force(time), color=ORANGE, label="effective force")
    axes.set_ylabel("force (N)")
    axes.set_ylim(-0.05, 1.3)
    axes.legend(frameon=False, ncols=2, loc="upper left")
    add_title(axes, "A", "Creep", "elastic load with the same deformation: 75 % at once, τ = 1 s")


def draw_change(axes: "Axes", sampling: Sampling, change: Floats) -> None:
    """What two taxels feel."""
    for taxel, colour, label in ((UNDER, ORANGE, "taxel below"), (BESIDE, BLUE, "its neighbour")):
        time = sampling.instants[:, taxel]
        axes.plot(time, 100 * change[:, taxel], color=colour, label=label)
    axes.set_ylabel("ΔC/C₀ (%)")
    axes.set_ylim(-2, 20)
    axes.legend(frameon=False, ncols=2, loc="upper left")
    add_title(axes, "B", "Change of capacitance", "ball of 6 mm radius on 2 mm of silicone")


def draw_stages(axes: "Axes", sampling: Sampling, stages: dict[str, Floats]) -> None:
    """The level of the taxel, one effect after the other."""
    looks = {"change alone": (QUIET, 1.6), "with drift": (BLUE, 1.4), "with noise": (ORANGE, 0.7)}
    time = sampling.instants[:, UNDER]
    for (name, (colour, width)), order in zip(looks.items(), (3, 4, 2), strict=True):
        axes.plot(time, stages[name][:, UNDER], color=colour, lw=width, label=name, zorder=order)
    axes.set_ylabel("level of the taxel below (counts)")
    axes.legend(frameon=False, ncols=3, loc="lower right", columnspacing=1.2)
    axes.margins(y=0.2)
    add_title(
        axes, "C", "Drift and noise", "warming by 2 K/s with a lag of 5 s; noise of 1.5 counts"
    )


def draw_bytes(axes: "Axes", sampling: Sampling, stages: dict[str, Floats]) -> None:
    """Bytes as they are sent, while the skin creeps under the ball."""
    time = sampling.instants[:, UNDER]
    shown = (time > ZOOM[0]) & (time < ZOOM[1])
    sent, level = stages["sent"][shown, UNDER], stages["with noise"][shown, UNDER]
    axes.plot(time[shown], stages["with drift"][shown, UNDER], color=BLUE, label="without noise")
    axes.plot(time[shown], level, "-o", color=ORANGE, lw=0.7, ms=2.5, label="level, converted")
    stamps = sampling.stamp_ns[shown] * 1e-9
    axes.step(stamps, sent, where="post", color=FAINT, lw=0.9, zorder=1)
    axes.plot(stamps, sent, "o", ms=3.5, color=INK, label="byte, arriving")
    for moment, byte, own in zip(stamps, sent, level, strict=True):
        axes.annotate(
            f"{byte:.0f}", (moment, byte), (0, 6 if byte > own else -6), ha="center", va="center",
            textcoords="offset points", fontsize=6, color=QUIET,
        )  # fmt: skip
    axes.set_ylabel("level and byte (counts)")
    axes.margins(y=0.22)
    axes.legend(frameon=False, ncols=3, loc="upper right", columnspacing=1.0, fontsize=7.5)
    add_title(
        axes, "D", "Byte by byte", "from 3 s on; a reading arrives 10 ms after its cycle begins"
    )


if __name__ == "__main__":
    main()
