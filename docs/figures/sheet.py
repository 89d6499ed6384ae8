"""Make the picture of the page on sheets of many taxels, and print how far off the forces are.

  python docs/figures/sheet.py

Ten thousand taxels are pressed in several places; each press is simulated on cells of 0.5 mm, far
enough from the others that their readings add up.
"""

from pathlib import Path
from typing import Any

import click
import numpy as np

import skinfield as sf
from skinfield.errors import Floats
from skinfield.plot import (
    INK,
    QUIET,
    add_colour_bar,
    add_title,
    new_figure,
    save,
    signed_colours,
    style,
)
from skinfield.simulate import Bar, Cylinder, Ring, Sphere, press

IMAGES = Path(__file__).parents[1] / "images"
LAYER = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
SIDE = 100  # taxels
DISTANCE = 5.8e-3
NOISE = 200.0  # Pa
BODIES: dict[str, Any] = {
    "ball": Sphere(radius=9e-3, force=2.0),
    "flat end": Cylinder(radius=10e-3, force=8.0),
    "bar": Bar(length=40e-3, width=8e-3, force=12.0),
    "ring": Ring(inner_radius=14e-3, outer_radius=18e-3, force=12.0),
}
TOUCHES = 6  # along each side of the sheet
NEAR = 30e-3  # m from a touch's middle: where its force is summed
HALF = 34e-3  # m: half the side of the part that is shown


def places() -> Floats:
    """Taxels about a square lattice, moved at random by up to 30 % of their distance."""
    rng = np.random.default_rng(0)
    index = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), -1).reshape(-1, 2)
    return np.asarray((index + rng.uniform(-0.3, 0.3, index.shape)) * DISTANCE)


def touches() -> list[tuple[str, Floats, float]]:
    """What touches, where (2,) m, and turned by how much: 72 mm apart or more."""
    rng, step = np.random.default_rng(2), SIDE * DISTANCE / TOUCHES
    found = []
    for index in range(TOUCHES**2):
        middle = (np.array(divmod(index, TOUCHES)) + 0.5) * step + rng.uniform(-10e-3, 10e-3, 2)
        name = list(BODIES)[int(rng.integers(len(BODIES)))]
        found.append((name, middle, float(rng.uniform(0, np.pi))))
    return found


def readings(taxels: Floats) -> Floats:
    """Stress under all touches, with noise, (L,) Pa."""
    total = np.random.default_rng(1).normal(size=len(taxels)) * NOISE
    solved = {
        name: press(LAYER, [body], extent=60e-3, cell=0.5e-3) for name, body in BODIES.items()
    }
    for name, middle, turn in touches():
        cosine, sine = np.cos(turn), np.sin(turn)
        local = (taxels - middle) @ np.array([[cosine, -sine], [sine, cosine]])
        near = np.abs(local).max(axis=1) < 40e-3
        total[near] += solved[name].readings(local[near], 4e-3, "stress")
    return total


def report(sheet: sf.Sheet, estimate: sf.Estimate) -> None:
    """Print the force about the touches, over the true one."""
    share: dict[str, list[float]] = {name: [] for name in BODIES}
    pressure = estimate.pressure.reshape(sheet.shape)
    x, y = (
        low + np.arange(count) * sheet.pitch
        for low, count in zip(sheet.origin, sheet.shape[::-1], strict=True)
    )
    for name, middle, _ in touches():
        near = np.hypot(y[:, None] - middle[1], x - middle[0]) < NEAR
        force = pressure[near].sum() * sheet.pitch**2
        share[name].append(force / BODIES[name].force)
    click.echo(f"{sheet.shape} cells, {estimate.iterations} steps")
    for name, parts in share.items():
        low, middle, high = np.quantile(parts, [0.0, 0.5, 1.0])
        click.echo(f"  {len(parts)} x {name:9s} {middle:.2f} [{low:.2f}, {high:.2f}]")


def draw(axes: Any, sheet: sf.Sheet, values: Floats, label: str, part: Any) -> None:
    """One field in millimetres of the sheet, its colours for some part of it."""
    half = sheet.pitch / 2
    low = (sheet.origin - half) * 1e3
    high = low + np.array(sheet.shape[::-1]) * sheet.pitch * 1e3
    colours, scale = signed_colours(values[part])
    extent = (low[0], high[0], low[1], high[1])
    image = axes.imshow(values, origin="lower", extent=extent, cmap=colours, norm=scale)
    add_colour_bar(axes, image, label)
    axes.set(xlabel="x (mm)", ylabel="y (mm)")


def picture(sheet: sf.Sheet, taxels: Floats, estimate: sf.Estimate) -> None:
    """Pressure and deformation of the sheet, and of a part of it."""
    pressure = estimate.pressure.reshape(sheet.shape) * 1e-3
    inwards = estimate.indentation.reshape(sheet.shape) * 1e6
    middle = next(place for name, place, _ in touches() if name == "ring")
    column, row = np.floor((middle - HALF - sheet.origin) / sheet.pitch).astype(int)
    count = int(2 * HALF / sheet.pitch) + 1
    part = np.s_[row : row + count, column : column + count]
    with style():
        figure = new_figure(9.6, 8.6)
        boxes = [(0.07 + 0.5 * (k % 2), 0.55 - 0.49 * (k // 2), 0.345, 0.385) for k in range(4)]
        panels = [figure.add_axes(box) for box in boxes]
        for axes, shown in zip(panels[::2], (np.s_[:], part), strict=True):
            draw(axes, sheet, pressure, "pressure (kPa)", shown)
        for axes, shown in zip(panels[1::2], (np.s_[:], part), strict=True):
            draw(axes, sheet, inwards, "indentation (µm)", shown)
        add_title(panels[0], "a", "Pressure", f"{len(sheet):,} taxels, {pressure.size:,} cells")
        add_title(panels[1], "b", "Deformation", "inwards; below zero the surface bulges out")
        add_title(panels[2], "c", "A ring: pressure", "dots are taxels; dashed, the ring's edges")
        add_title(panels[3], "d", "A ring: deformation", "arrows: along the surface, times 20")
        for axes in panels[2:]:
            low, high = (middle - HALF) * 1e3, (middle + HALF) * 1e3
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
            edges(axes, middle)
        near = np.abs(taxels - middle).max(axis=1) < HALF
        panels[2].plot(*taxels[near].T * 1e3, ".", color=QUIET, markersize=3, alpha=0.7)
        arrows(panels[3], sheet, estimate, part)
        save(figure, IMAGES / "sheet.png", dpi=110.0)


def edges(axes: Any, middle: Floats) -> None:
    """Both edges of the ring that presses."""
    angle = np.linspace(0, 2 * np.pi, 100)
    for radius in (BODIES["ring"].inner_radius, BODIES["ring"].outer_radius):
        x, y = (middle + radius * np.column_stack([np.cos(angle), np.sin(angle)])).T * 1e3
        axes.plot(x, y, "--", color=QUIET, linewidth=0.8)


def arrows(axes: Any, sheet: sf.Sheet, estimate: sf.Estimate, part: Any) -> None:
    """Displacement along the surface about the part that is shown."""
    row, column = (np.arange(along.start, along.stop, 2) for along in part)
    moved = estimate.displacement.reshape(*sheet.shape, 3)[np.ix_(row, column)] * 1e3
    large = np.hypot(moved[..., 0], moved[..., 1]) > 5e-3
    axes.quiver(
        ((sheet.origin[0] + column * sheet.pitch) * 1e3 + 0 * row[:, None])[large],
        ((sheet.origin[1] + row * sheet.pitch)[:, None] * 1e3 + 0 * column)[large],
        *moved[large][:, :2].T,
        color=INK,
        angles="xy",
        scale_units="xy",
        scale=1 / 20,
        width=0.004,
    )


def main() -> None:
    """Solve and draw."""
    taxels = places()
    sheet = sf.Sheet(taxels, LAYER, noise_std=NOISE)
    estimate = sheet(readings(taxels))
    report(sheet, estimate)
    picture(sheet, taxels, estimate)


if __name__ == "__main__":
    main()
