"""Make the picture of the page on the engine, and print the numbers that it quotes.

  OMP_NUM_THREADS=1 python docs/engine_figures.py        docs/images/engine-budget.png

A skin of 60 hexagons of 72 taxels, six of them pressed by balls that wander; the presses are solved
on cells of 0.5 mm. Of some hundred cycles for each budget, the one is drawn that took longer than a
tenth of them: what a cycle takes when little else runs on the machine.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

import skinfield as sf
from skinfield.errors import Floats
from skinfield.plot import ABOVE, BELOW, FAINT, INK, QUIET, add_title, new_figure, save, style
from skinfield.reconstruct.engine import CycleReport
from skinfield.reconstruct.engine.state import Step

IMAGES = Path(__file__).parent / "images"
PATCH = sf.layouts.hexagon72()
PATCHES, TOUCHED, CYCLES = 60, 6, 150
PLACES, STAY = 20, 4  # where the balls go, and for how many cycles they stay there
BUDGETS = (150e-6, 300e-6, 600e-6, 1200e-6)
NOISE = 0.002
WORDS = {
    "around": ("intake, turns, report", FAINT),
    "test": ("idle test of all patches", BELOW[4]),
    "start": ("coarse linear answers", BELOW[7]),
    "search": ("searches", ABOVE[5]),
}


def skin() -> sf.Skin:
    """As many hexagons as a robot of the iCub's size has taxels for."""
    return sf.Skin(tuple(replace(PATCH, name=f"patch {i}") for i in range(PATCHES)))


def recorded() -> list[list[Floats]]:
    """Readings of all patches, cycle after cycle; each ball stays where it is for some of them."""
    ball = sf.simulate.Sphere(radius=5e-3, force=1.0)
    pressed, rng = sf.simulate.press(sf.Layer(), [ball]), np.random.default_rng(0)
    touches = []
    for angle in np.linspace(0, 2 * np.pi, PLACES, endpoint=False):
        away = PATCH.plane - PATCH.plane[30] - 5e-3 * np.array([np.cos(angle), np.sin(angle)])
        touches.append(pressed.readings(away, PATCH.pad_diameter, "capacitance"))
    cycles = []
    for cycle in range(CYCLES):
        readings = [rng.normal(0.0, NOISE, len(PATCH)) for _ in range(PATCHES)]
        for place in range(0, PATCHES, PATCHES // TOUCHED):
            readings[place] += touches[(cycle // STAY + place) % PLACES]
        cycles.append(readings)
    return cycles


def run(engine: sf.Engine, cycles: list[list[Floats]], budget: float) -> list[CycleReport]:
    """Reports of all cycles, after some that are not counted."""
    for readings in cycles[: CYCLES // 3]:
        engine(readings, budget=budget)
    return [engine(readings, budget=budget).report for readings in cycles]


def typical(reports: list[CycleReport]) -> CycleReport:
    """The cycle that took longer than a tenth of them."""
    return sorted(reports, key=lambda report: report.spent)[len(reports) // 10]


def kind_of(step: Any) -> Any:
    """Which of `WORDS` a step is."""
    return {Step.TEST: "test", Step.SEARCH: "search"}.get(step.kind, "start")


def draw_cycle(axes: Any, row: int, report: CycleReport) -> None:
    """Steps of one cycle as a bar of time."""
    axes.barh(row, report.spent * 1e6, height=0.62, color=WORDS["around"][1], zorder=1)
    for step in report.steps:
        began, took = (step.start - report.started) * 1e-3, (step.end - step.start) * 1e-3
        colour = WORDS[kind_of(step)][1]
        axes.barh(row, took, left=began, height=0.62, color=colour, ec="white", lw=0.4, zorder=2)
    budget = report.budget * 1e6
    axes.plot([budget, budget], [row - 0.37, row + 0.37], color=INK, lw=2.0, zorder=3)


def summary(report: CycleReport) -> str:
    """What a cycle came to, in words."""
    found = Counter(f"{each.answer} on {each.rung}" for each in report if each.answer != "idle")
    tested = {each.rung for each in report if each.answer == "idle"}
    words = [f"{count} {what}" for what, count in sorted(found.items())]
    return ", ".join([*words, f"others idle, tested on {max(tested)}"])


def draw_cycles(axes: Any, chosen: list[CycleReport]) -> None:
    """One bar for each budget."""
    for row, report in enumerate(chosen):
        draw_cycle(axes, row, report)
        axes.text(3, row + 0.37, summary(report), fontsize=7.5, color=QUIET, va="top")
    axes.set_yticks(range(len(chosen)), [f"{r.budget * 1e6:.0f} µs" for r in chosen])
    axes.set_ylim(len(chosen) - 0.25, -0.6)
    axes.set_xlim(0, 1.04 * max(report.budget for report in chosen) * 1e6)
    axes.set_xlabel("time since the cycle began, µs")
    axes.set_ylabel("budget of the cycle")
    handles = [axes.barh(0, 0, color=colour, label=word) for word, colour in WORDS.values()]
    handles.append(axes.plot([], [], color=INK, lw=2.0, label="budget")[0])
    axes.legend(handles=handles, fontsize=7.5, frameon=False, loc="upper right")


def main() -> None:
    """Run the cycles, print what they came to, and draw them."""
    engine, cycles = sf.Engine(skin(), solver=sf.NonNegative(), noise_std=NOISE), recorded()
    reports = {budget: run(engine, cycles, budget) for budget in BUDGETS}
    chosen = [typical(each) for each in reports.values()]
    with style():
        figure = new_figure(7.2, 4.6)
        axes = figure.add_axes((0.11, 0.12, 0.86, 0.72))
        draw_cycles(axes, chosen)
        add_title(axes, "", "Where the time of a cycle goes", "60 patches, 6 of them touched")
        save(figure, IMAGES / "engine-budget.png")
    for budget, each in reports.items():
        spent = np.array([report.spent for report in each]) * 1e6
        late = np.mean([report.overrun for report in each])
        click.echo(f"{budget * 1e6:6.0f} µs: p10 {np.percentile(spent, 10):.0f}, ", nl=False)
        click.echo(
            f"p50 {np.median(spent):.0f} µs, late {100 * late:.1f} %; {summary(typical(each))}"
        )


if __name__ == "__main__":
    main()
