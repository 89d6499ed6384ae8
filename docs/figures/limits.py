"""Make the pictures of README and docs, and print the numbers that they quote.

  python docs/figures/limits.py                                   all that need no outside data
  python docs/figures/limits.py --foot REC --force FT --foot-layout FILE    the real foot as well

The presses are those of `presses.py` beside this file.
"""

import csv
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from presses import (
    BALL,
    FAR,
    LAYER,
    PATCH,
    QUANTITIES,
    Indenter,
    inner_places,
    misplaced,
    profile,
    random_places,
    readings,
    reconstructor,
    stress_per_change,
    summed,
)

import skinfield as sf
from skinfield.cli import main as skinfield
from skinfield.errors import Floats
from skinfield.files import open_recording
from skinfield.plot import (
    BLUE,
    FAINT,
    INK,
    ORANGE,
    QUIET,
    TITLE,
    add_colour_bar,
    add_title,
    new_figure,
    save,
    style,
)
from skinfield.signal.plot import draw_timeline
from skinfield.simulate import Cylinder, Sphere
from skinfield.skin.geometry import inside_hull
from skinfield.skin.maps import draw_cells, extent_of, frame_axes, outline_pads

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IMAGES = Path(__file__).parents[1] / "images"
SHOWN = {"stress": (1e-3, "kPa"), "capacitance": (100.0, "%")}  # factor and unit of a figure
SIGMAS = 5.0  # noise that a reading must exceed to count as seen
STANDING = 6.8  # s; then the robot tips over backwards


def holes() -> None:
    """Where a point is farthest from every taxel."""
    from scipy.spatial import Voronoi

    corners = Voronoi(PATCH.plane).vertices
    corners = corners[inside_hull(PATCH.plane, corners)]
    radius = np.linalg.norm(corners[:, None] - PATCH.plane, axis=2).min(axis=1)
    found: dict[tuple[float, ...], float] = {}
    for corner, size in sorted(zip(corners.tolist(), radius, strict=True), key=lambda c: -c[1]):
        if all(np.hypot(x - corner[0], y - corner[1]) > 3e-3 for x, y in found):
            found[tuple(corner)] = float(size)
    click.echo("\nholes: place (mm), distance to the nearest taxel's centre (mm)")
    for (x, y), size in list(found.items())[:8]:
        click.echo(f"  {x * 1e3:6.1f} {y * 1e3:6.1f}   {size * 1e3:.2f}")


def blindness(quantity: str) -> None:
    """Print the reading of the best taxel for a ball with 1 N at each place; draw capacitance's."""
    grid = sf.Grid.window(PATCH, [-30e-3, -30e-3], [30e-3, 30e-3], 0.4e-3)
    factor, unit = SHOWN[quantity]
    best = readings(BALL, grid.plane, quantity).max(axis=1) * factor
    floor = SIGMAS * QUANTITIES[quantity].typical_noise * factor
    if quantity == "capacitance":
        label = f"best taxel's reading of 1 N ({unit})"
        save(draw_blindness(grid, best, floor, label), IMAGES / "blind-capacitance.png")
    inside = inside_hull(PATCH.plane, grid.plane)
    centre = float(best[np.linalg.norm(grid.plane, axis=1).argmin()])
    low, median, high = np.quantile(best[inside], [0.05, 0.5, 1.0])
    click.echo(
        f"{quantity}: best {high:.2f}, median {median:.2f}, worst twentieth below {low:.3f}, "
        f"centre {centre:.3f} {unit}; {np.mean(best[inside] < floor):.0%} of the patch below "
        f"{floor:g} {unit}, {np.mean(0.2 * best[inside] < floor):.0%} at 0.2 N"
    )


def draw_blindness(grid: sf.Grid, best: Floats, floor: float, label: str) -> "Figure":
    """Draw a map of the best reading, and its profile along the middle of the patch."""
    along = np.linspace(29e-3, -29e-3, 601)
    profile = best.reshape(grid.shape)[
        :, np.abs(grid.plane[: grid.shape[1], 0]).argmin()
    ]  # of x = 0
    profile = np.interp(along, grid.plane[:: grid.shape[1], 1], profile)
    over = np.hypot(PATCH.plane[:, 0], PATCH.plane[:, 1] - along[:, None]).min(axis=1)
    with style():
        figure = new_figure(10.0, 4.6)
        title = "A ball of 12 mm with 1 N, read as capacitance"
        figure.text(0.02, 0.95, title, va="center", **TITLE)
        axes = figure.add_axes((0.065, 0.12, 0.37, 0.66))
        add_colour_bar(axes, draw_cells(axes, grid, best), label)
        frame_axes(axes, grid.patch, extent_of(grid))
        outline_pads(axes, PATCH)
        axes.plot([0, 0], along[[0, -1]] * 1e3, color=BLUE, lw=1.3, ls=(0, (4, 2)))
        add_title(axes, "a", "Over the patch", "circles: pads; white: blind; dashed: line of b")
        beside = figure.add_axes((0.59, 0.135, 0.385, 0.645))
        x, top = (along[0] - along) * 1e3, 1.12 * profile.max()
        pads = (over <= PATCH.pad_diameter / 2).tolist()
        beside.fill_between(x, 0, top, where=pads, color=FAINT, alpha=0.5, lw=0)
        beside.plot(x, profile, color=BLUE)
        beside.axhline(floor, color=ORANGE, lw=1.1, label=f"{SIGMAS:g} times the noise: {floor:g}")
        beside.legend(frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1, 1))
        beside.set(xlim=(0, x[-1]), ylim=(min(0.0, float(profile.min())), top))
        beside.set(xlabel="distance along the line (mm)", ylabel=label)
        beside.spines[["top", "right"]].set_visible(False)
        add_title(beside, "b", "Along the line", "grey: the line is over a pad")
    return figure


def ring() -> None:
    """Draw what a taxel reads at a distance from a press."""
    kinds: dict[str, tuple[Indenter, str]] = {
        "ball of 12 mm": (BALL, INK),
        "ball of 6 mm": (replace(BALL, radius=3e-3), ORANGE),
        "flat end of 12 mm": (Cylinder(radius=6e-3, force=1.0), BLUE),
    }
    near = FAR <= 14e-3
    panels = [
        ("stress", "Stress", "kPa, mean below the pad", None),
        ("capacitance", "Capacitance", "%, of the same three presses", None),
        ("capacitance", "Capacitance, enlarged", "grey: one σ of noise, 0.2 %", (-1.3, 1.3)),
    ]
    with style():
        figure = new_figure(10.0, 3.5)
        for index, (quantity, title, note, limits) in enumerate(panels):
            axes = figure.add_axes((0.06 + index * 0.325, 0.15, 0.26, 0.62))
            factor = SHOWN[quantity][0]
            for label, (indenter, colour) in kinds.items():
                curve = profile(indenter, quantity)[near] * factor
                axes.plot(FAR[near] * 1e3, curve, color=colour, label=label)
            axes.axhline(0.0, color=QUIET, lw=0.7)
            axes.set(xlabel="distance from the press (mm)", xlim=(0, 14), ylim=limits)
            axes.spines[["top", "right"]].set_visible(False)
            add_title(axes, "abc"[index], title, note)
            if limits:
                axes.axhspan(-0.2, 0.2, color=FAINT, alpha=0.5, lw=0)
            if index == 0:
                axes.legend(frameon=False, fontsize=8)
        save(figure, IMAGES / "ring.png")
    click.echo("\n1 N at a distance: stress and ΔC/C₀ over the press, least ΔC/C₀ and where")
    for label, (indenter, _) in kinds.items():
        stress, change = profile(indenter, "stress"), profile(indenter, "capacitance")
        click.echo(
            f"  {label}: {stress[0] / 1e3:.1f} kPa, {change[0]:.2%}; {change.min():.2%} at "
            f"{FAR[change.argmin()] * 1e3:.1f} mm"
        )


def random_presses() -> None:
    """Print median errors over 60 presses: four indenters, four forces, random places."""
    shapes: tuple[Any, ...] = (
        Sphere(radius=3e-3),
        BALL,
        Sphere(radius=15e-3),
        Cylinder(radius=6e-3),
    )
    indenters = [replace(s, force=f) for s, f in product(shapes, (0.5, 1.0, 2.0, 3.0))]
    places = random_places(60, seed=1)
    pressed = [indenters[index % 16] for index in range(60)]
    force = np.array([indenter.force for indenter in pressed])
    click.echo("\n60 presses, typical noise: missed | contacts' force | field's force | place")
    solvers: Sequence[tuple[Any, int]] = (
        (sf.ContactFit(), 40), (sf.GaussianField(), 40), (sf.Tikhonov(), 40),
        (sf.Tikhonov(), 20), (sf.Inverse(), 20),
    )  # fmt: skip
    for name, taken in (*zip(QUANTITIES, QUANTITIES, strict=True), ("capacitance", "stress")):
        clean = np.vstack(
            [readings(i, p[None], name) for i, p in zip(pressed, places, strict=True)]
        )
        noise = np.random.default_rng(2).normal(size=clean.shape)
        noisy = clean + QUANTITIES[name].typical_noise * noise
        gain = 1.0 if taken == name else stress_per_change()
        for solver, nodes in solvers:
            spread = gain * QUANTITIES[name].typical_noise
            estimate = reconstructor(taken, solver, nodes, noise_std=spread)(gain * noisy)
            place = misplaced(estimate, places)
            contacts, field = (
                np.quantile(np.abs(found / force - 1), [0.5, 0.9])
                for found in (summed(estimate), np.asarray(estimate.normal_force))
            )
            near, far = np.nanquantile(place, [0.5, 0.9]) * 1e3
            click.echo(
                f"  {name} as {taken}, {type(solver).__name__} {nodes}: "
                f"{np.isnan(place).mean():.0%} | "
                f"{contacts[0]:.0%} [{contacts[1]:.0%}] | {field[0]:.0%} [{field[1]:.0%}] | "
                f"{near:.1f} [{far:.1f}] mm"
            )


def wrong_quantity() -> None:
    """Draw the force found where readings of capacitance are taken as stress."""
    kinds: dict[str, Indenter] = {
        "ball 6 mm, 1 N": replace(BALL, radius=3e-3),
        "ball 12 mm, 0.2 N": replace(BALL, force=0.2),
        "ball 12 mm, 1 N": BALL,
        "ball 12 mm, 3 N": replace(BALL, force=3.0),
        "ball 30 mm, 1 N": replace(BALL, radius=15e-3),
        "flat 6 mm, 1 N": Cylinder(radius=3e-3, force=1.0),
        "flat 12 mm, 1 N": Cylinder(radius=6e-3, force=1.0),
        "flat 24 mm, 5 N": Cylinder(radius=12e-3, force=5.0),
    }
    constant = stress_per_change()
    places = inner_places()
    ways = {
        "stress skin, read as stress": ("stress", "stress", 1.0),
        "capacitive skin, read as capacitance": ("capacitance", "capacitance", 1.0),
        "capacitive skin, read as stress": ("capacitance", "stress", constant),
    }
    colours, heights = (INK, BLUE, ORANGE), np.arange(len(kinds))[::-1]
    click.echo(f"\nas stress: {constant / 1e3:.0f} kPa per unit; found/true: median [10 %, 90 %]")
    with style():
        figure = new_figure(10.0, 4.4)
        axes = figure.add_axes((0.15, 0.12, 0.82, 0.69))
        for row, (label, (true, taken, gain)) in enumerate(ways.items()):
            rec = reconstructor(taken, noise_std=gain * QUANTITIES[true].typical_noise)
            quantiles = []
            for indenter in kinds.values():
                estimate = rec(gain * readings(indenter, places, true))
                quantiles.append(np.quantile(summed(estimate) / indenter.force, [0.1, 0.5, 0.9]))
            low, middle, high = np.array(quantiles).T
            at = heights + 0.22 * (1 - row)
            axes.hlines(at, np.maximum(low, 0), high, color=colours[row], lw=2.2, alpha=0.45)
            axes.plot(middle, at, "o", color=colours[row], ms=5, label=label)
            for kind, (a, b, c) in zip(kinds, quantiles, strict=True):
                click.echo(f"  {label}; {kind}: {b:.2f} [{a:.2f}, {c:.2f}]")
        axes.axvline(1.0, color=QUIET, lw=0.8)
        axes.set(xlabel="force found / true", yticks=heights, yticklabels=list(kinds))
        axes.set_xlim(0, None)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8, loc="lower right")
        note = "contacts summed, no noise; dot: median of 60 places, bar: four fifths of them"
        add_title(axes, "", "What the wrong quantity costs", note)
        save(figure, IMAGES / "wrong-quantity.png")
    click.echo("  ΔC/C₀ per MPa over the press:")
    for kind, indenter in kinds.items():
        ratio = profile(indenter, "capacitance")[0] / profile(indenter, "stress")[0] * 1e6
        click.echo(f"    {kind}: {ratio:.2f}")


def compressible() -> None:
    """Print how the force comes out by Poisson's ratio, for capacitance."""
    indenters: list[Indenter] = [BALL, Cylinder(radius=6e-3), Cylinder(radius=12e-3, force=5.0)]
    places = inner_places()
    click.echo("\nν: contacts' force, field's force (found/true, medians of 60 places)")
    for ratio in (0.5, 0.49, 0.45, 0.3):
        layer = replace(LAYER, poisson_ratio=ratio)
        rec = reconstructor("capacitance", layer=layer)
        for indenter in indenters:
            estimate = rec(readings(indenter, places, "capacitance", layer))
            contacts = np.median(summed(estimate)) / indenter.force
            field = np.median(np.asarray(estimate.normal_force)) / indenter.force
            click.echo(f"  {ratio:g} {type(indenter).__name__}, {indenter.force:g} N: "
                       f"{contacts:.2f} {field:.2f}")  # fmt: skip


def real_foot(recording: str, force: str, layout: str) -> None:
    """Draw a robot's foot, and its force beside that of the sensor above it.

    One number, the modulus, is fitted while the robot stands.
    """
    common = ["--skin", layout, "--poisson", "0.3"]
    table, result = IMAGES / "foot.csv", IMAGES / "foot.json"
    run("calibrate scale", recording, force, *common)
    run("calibrate scale", recording, force, *common, "--seconds", f"0,{STANDING:g}",
        "-o", str(result), "--force")  # fmt: skip
    modulus = json.loads(result.read_text())["modulus_kpa"]
    run("reconstruct", recording, *common, "--modulus-kpa", f"{modulus:.0f}", "-o", str(table))
    with table.open() as lines:
        rows = list(csv.DictReader(lines))
    load: dict[int, float] = {}
    for row in rows:
        stamp = int(row["stamp_ns"])
        load[stamp] = load.get(stamp, 0.0) + float(row["force_N"] or 0.0)
    table.unlink()
    result.unlink()
    stamps, skin = np.array(list(load)), np.array(list(load.values()))
    sensor = open_recording(force)
    time = (stamps - stamps[0]) * 1e-9
    truth = np.interp(time, (sensor.stamp_ns - stamps[0]) * 1e-9, -sensor.counts[:, 2])
    figure = draw_timeline(
        time, skin, truth, label=f"skin, E = {modulus:.0f} kPa",
        title=f"Foot of an iCub; modulus fitted while it stands, 0 to {STANDING:g} s",
    )  # fmt: skip
    save(figure, IMAGES / "foot-force.png")
    click.echo("\nfoot: seconds, skin N, sensor N, rms N")
    for start, end in ((0.0, STANDING), (STANDING, 7.4), (7.8, time[-1] + 1)):
        part = (time >= start) & (time < end)
        error = np.sqrt(np.mean((skin - truth)[part] ** 2))
        click.echo(
            f"  {start:g} to {end:.1f}: {skin[part].mean():.1f} {truth[part].mean():.1f} "
            f"{error:.1f}"
        )
    highest = skin.argmax()
    click.echo(f"  highest at {time[highest]:.2f}: {skin[highest]:.0f}, {truth[highest]:.0f}")


def run(command: str, *arguments: str) -> None:
    """Run a command of skinfield."""
    with suppress(SystemExit):
        skinfield([*command.split(), *arguments])


@click.command()
@click.option("--foot", help="Recording of an iCub's foot.")
@click.option("--force", help="Recording of the force/torque sensor beside it.")
@click.option("--foot-layout", help="Its layout.")
def main(foot: str | None, force: str | None, foot_layout: str | None) -> None:
    """Make all pictures."""
    IMAGES.mkdir(exist_ok=True)
    holes()
    for quantity in QUANTITIES:
        blindness(quantity)
    ring()
    random_presses()
    wrong_quantity()
    compressible()
    if foot and force and foot_layout:
        real_foot(foot, force, foot_layout)


if __name__ == "__main__":
    main()
