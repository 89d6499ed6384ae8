"""Make the picture of the page on the contact fit, and print the numbers that it quotes.

  python docs/figures/contact_fit.py             docs/images/contact-fit.png
  python docs/figures/contact_fit.py --table     errors and names of shapes, by what presses
  python docs/figures/contact_fit.py --pairs     how often two balls are found as two
  python docs/figures/contact_fit.py --time      how long a reading takes, by processor time

Presses are solved on cells of 0.25 mm and carried to places that no setting was chosen by.
"""

import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import click
import numpy as np
from looks import draw_field

import skinfield as sf
from skinfield.errors import Floats
from skinfield.plot import add_colour_bar, add_title, new_figure, save, signed_colours, style
from skinfield.simulate.pressing.press import readings_anywhere

IMAGES = Path(__file__).parents[1] / "images"
PATCH, LAYER = sf.layouts.hexagon72(), sf.Layer()
QUANTITIES: dict[str, Any] = {"stress": sf.BaseStress(), "capacitance": sf.Capacitance()}
SOLVERS: dict[str, Any] = {"GaussianField": sf.GaussianField(), "ContactFit": sf.ContactFit()}
NOISE = 0.002  # of the picture
LEVELS = {"stress": (0.0, 40.0, 380.0, 1000.0), "capacitance": (0.0, 5e-4, 0.002, 0.005)}
TOLD = {"stress": 40.0, "capacitance": 5e-4}  # noise that is stated where there is none
DRAWS = 60
BODIES: dict[str, tuple[Any, ...]] = {
    "ball": tuple(
        sf.simulate.Sphere(radius=radius * 1e-3, force=force)
        for radius, force in (
            (3, 0.3),
            (4, 1.0),
            (6, 0.5),
            (6, 1.0),
            (6, 3.0),
            (10, 1.0),
            (12, 2.0),
        )
    ),
    "flat end": tuple(
        sf.simulate.Cylinder(radius=radius * 1e-3, force=force)
        for radius, force in ((2, 0.5), (3, 1.0), (4, 2.0))
    ),
    "bar": (sf.simulate.Bar(length=16e-3, width=3e-3, force=2.0),),
    "ring": (sf.simulate.Ring(inner_radius=4e-3, outer_radius=5e-3, force=2.0),),
}
SHAPE = {"ball": "sphere", "flat end": "flat", "bar": "line", "ring": "other"}
Pose = tuple[float, float, float]  # m, m, rad
BALL = sf.simulate.Sphere(radius=6e-3, force=1.0)
SHOWN: dict[str, list[tuple[Any, Pose]]] = {
    "ball between taxels": [(BALL, (-3.8e-3, 6.1e-3, 0.0))],
    "two balls": [(BALL, (-9e-3, 3e-3, 0.0)), (BALL, (4e-3, 9e-3, 0.0))],
    "bar": [(BODIES["bar"][0], (-4e-3, 5e-3, 0.5))],
    "ring": [(BODIES["ring"][0], (6e-3, -6e-3, 0.0))],
}


@lru_cache(maxsize=64)
def solved(body: Any, quantity: str) -> tuple[sf.simulate.Press, Callable[[Floats], Floats]]:
    """A press at the origin, and what taxels anywhere read of it."""
    press = sf.simulate.press(LAYER, [body], extent=36e-3, cell=0.25e-3)
    return press, readings_anywhere(press, PATCH.pad_diameter, quantity, 0.75e-3)


def readings(body: Any, pose: Pose, quantity: str) -> Floats:
    """Of all taxels, (72,), without noise."""
    x, y, turn = pose
    cos, sin = np.cos(turn), np.sin(turn)
    away = (PATCH.plane - (x, y)) @ np.array([[cos, -sin], [sin, cos]])
    return solved(body, quantity)[1](away)


def drawn_pose(rng: np.random.Generator) -> Pose:
    """Anywhere on the inner patch."""
    x, y = rng.uniform(-0.3, 0.3, 2) * np.ptp(PATCH.plane, axis=0)
    return float(x), float(y), float(rng.uniform(0, 2 * np.pi))


def reconstructor(name: str, quantity: str, noise: float, nodes: int = 40) -> sf.Reconstructor:
    """For the patch, of one of the two solvers."""
    return sf.Reconstructor(
        PATCH,
        LAYER,
        sf.Grid.square(PATCH, nodes=nodes),
        quantity=QUANTITIES[quantity],
        noise_std=noise,
        solver=SOLVERS[name],
    )


# ---- numbers


def table() -> None:
    """Print medians and 90th percentiles of errors, and how often the shape is named."""
    for quantity, levels in LEVELS.items():
        for noise in levels:
            recs = {n: reconstructor(n, quantity, noise or TOLD[quantity], 20) for n in SOLVERS}
            for kind, bodies in BODIES.items():
                for name, rec in recs.items():
                    click.echo(f"{quantity:11s} {noise:7g} {kind:8s} {name:13s} "
                               f"{line_of(rec, quantity, noise, kind, bodies)}")  # fmt: skip


def line_of(
    rec: sf.Reconstructor, quantity: str, noise: float, kind: str, bodies: tuple[Any, ...]
) -> str:
    """Errors of the nearest contact of each of some presses."""
    rng = np.random.default_rng(7)
    found, named, false = [], 0, 0
    for index in range(DRAWS):
        body, pose = bodies[index % len(bodies)], drawn_pose(rng)
        rec.reset()
        contacts = rec(readings(body, pose, quantity) + noise * rng.normal(size=72)).contacts
        apart = [float(np.hypot(*(c.position[:2] - pose[:2]))) for c in contacts]
        if not apart or min(apart) > 8e-3:
            continue
        nearest = contacts[int(np.argmin(apart))]
        found.append((abs(nearest.normal_force / body.force - 1), min(apart) * 1e3))
        named += nearest.shape == SHAPE[kind]
        false += len(contacts) - 1
    if not found:
        return "none found"
    force, place = np.quantile(found, [0.5, 0.9], axis=0).T
    return (
        f"found {len(found):2d}/{DRAWS} force {force[0]:.3f} [{force[1]:.3f}] "
        f"place {place[0]:.3f} [{place[1]:.2f}] mm named {named / len(found):.2f} "
        f"more {false / DRAWS:.2f}"
    )


def pairs() -> None:
    """Print how often two balls of 1 N at a distance are found, each within a third of it."""
    for quantity, noise in (("stress", 380.0), ("capacitance", 0.002)):
        rec = reconstructor("ContactFit", quantity, noise, 20)
        for apart in (8e-3, 10e-3, 12e-3, 15e-3, 20e-3):
            rng, two, one_line = np.random.default_rng(3), 0, 0
            for _ in range(DRAWS):
                x, y, turn = drawn_pose(rng)
                off = 0.5 * apart * np.array([np.cos(turn), np.sin(turn)])
                places = np.array([x, y]) + np.array([off, -off])
                clean = sum(readings(BALL, (*place, 0.0), quantity) for place in places.tolist())
                rec.reset()
                contacts = rec(clean + noise * rng.normal(size=72)).contacts
                spots = np.array([c.position[:2] for c in contacts]).reshape(-1, 2)
                near = np.hypot(*(spots[:, None] - places).transpose(2, 0, 1)) < apart / 3
                two += len(contacts) == 2 and bool(near.any(axis=0).all())
                one_line += [c.shape for c in contacts] == ["line"]
            click.echo(f"{quantity} {noise:g} {apart * 1e3:.0f} mm: two {two}, a line {one_line}")


def times() -> None:
    """Print processor time per reading: cold, and warm with noise alone anew."""
    for quantity, noise in (("stress", 380.0), ("capacitance", 0.002)):
        rec, rng = reconstructor("ContactFit", quantity, noise, 20), np.random.default_rng(1)
        clean = {
            "one ball": readings(BALL, (-9e-3, 3e-3, 0.0), quantity),
            "two balls": readings(BALL, (-9e-3, 3e-3, 0.0), quantity)
            + readings(BALL, (8e-3, -5e-3, 0.0), quantity),
            "idle": np.zeros(72),
        }
        for name, values in clean.items():
            laps: dict[str, list[float]] = {"cold": [], "warm": []}
            for _ in range(100):
                rec.reset()
                for lap in laps.values():
                    noisy = values + noise * rng.normal(size=72)
                    start = time.process_time()
                    rec(noisy)
                    lap.append((time.process_time() - start) * 1e3)
            shown = ", ".join(
                f"{key} {np.median(lap):.2f} [{np.quantile(lap, 0.9):.2f}] ms"
                for key, lap in laps.items()
            )
            click.echo(f"{quantity} {name}: {shown}")


# ---- picture


def on_cells(parts: list[tuple[Any, Pose]], grid: sf.Grid) -> Floats:
    """Mean of the true pressure over each cell of a grid, (K,) Pa."""
    from scipy.interpolate import RegularGridInterpolator

    share = grid.pitch * ((np.arange(5) + 0.5) / 5 - 0.5)
    within = np.stack(np.meshgrid(share, share), axis=-1).reshape(-1, 2)
    points = grid.plane[:, None] + within
    total = np.zeros(points.shape[:2])
    for body, (x, y, turn) in parts:
        press = solved(body, "capacitance")[0]
        axis = np.unique(np.round(press.grid.plane[:, 0], 9))
        pressure = press.pressure.reshape(len(axis), len(axis))
        at = RegularGridInterpolator((axis, axis), pressure, bounds_error=False, fill_value=0.0)
        cos, sin = np.cos(turn), np.sin(turn)
        there = (points - (x, y)) @ np.array([[cos, -sin], [sin, cos]])
        total += at(there[..., ::-1])
    return np.asarray(total.mean(axis=1))


def mark(axes: Any, contact: sf.estimate.Contact) -> None:
    """Draw a contact's outline, place, and the ellipse that holds the place with 90 %."""
    from matplotlib.patches import Ellipse

    axes.plot(*contact.outline[:, :2].T * 1e3, color="0.25", linewidth=1.0)
    variance, direction = np.linalg.eigh(contact.covariance[:2, :2])
    wide = 2e3 * np.sqrt(4.605 * variance)
    angle = np.degrees(np.arctan2(direction[1, 1], direction[0, 1]))
    x, y = contact.position[:2] * 1e3
    axes.add_patch(Ellipse((x, y), wide[1], wide[0], angle=angle, fill=False, edgecolor="#d62728",
                           linewidth=1.2))  # fmt: skip
    axes.plot(x, y, "+", color="#d62728", markersize=5)


def note_of(estimate: sf.Estimate) -> str:
    """Forces of the contacts, and shapes where they are told."""
    parts = [
        f"{c.normal_force:.2f} ± {c.force_std:.2f} N"
        + (f", {c.shape}" if c.shape != "other" else "")
        for c in estimate.contacts[:2]
    ]
    return "; ".join(parts) or "no contact"


def picture() -> None:
    """Truth, the default field and the contact fit, of capacitance with typical noise."""
    grid = sf.Grid.square(PATCH, nodes=60)
    recs = {name: reconstructor(name, "capacitance", NOISE, 60) for name in SOLVERS}
    with style():
        figure = new_figure(9.6, 12.2)
        for row, (what, parts) in enumerate(SHOWN.items()):
            clean = sum(readings(body, pose, "capacitance") for body, pose in parts)
            noisy = clean + np.random.default_rng(1).normal(scale=NOISE, size=72)
            found = {name: rec(noisy) for name, rec in recs.items()}
            fields = {"Truth": on_cells(parts, grid) * 1e-3}
            fields |= {name: each.pressure * 1e-3 for name, each in found.items()}
            colours, scale = signed_colours(np.stack(list(fields.values())))
            middle = np.mean([pose[:2] for _, pose in parts], axis=0) * 1e3
            for column, (name, pressure) in enumerate(fields.items()):
                axes = figure.add_axes((0.07 + column * 0.29, 0.79 - row * 0.248, 0.27, 0.178))
                image = draw_field(axes, PATCH, grid, pressure, cmap=colours, norm=scale)
                axes.set(
                    xlim=(middle[0] - 14, middle[0] + 14), ylim=(middle[1] - 11, middle[1] + 11)
                )
                axes.set_xlabel("x (mm)")
                if column:
                    axes.set_yticklabels([])
                    for contact in found[name].contacts:
                        mark(axes, contact)
                else:
                    axes.set_ylabel("y (mm)")
                true = "; ".join(f"{body.force:.2f} N" for body, _ in parts)
                add_title(axes, "abcdefghijkl"[3 * row + column], f"{name}, {what}" if not column
                          else name, note_of(found[name]) if column else true)  # fmt: skip
                if column == 2:
                    add_colour_bar(axes, image, "pressure (kPa)")
        save(figure, IMAGES / "contact-fit.png", dpi=110)


@click.command()
@click.option("--table", "numbers", is_flag=True, help="Print errors by what presses.")
@click.option("--pairs", "two", is_flag=True, help="Print how often two balls are two.")
@click.option("--time", "laps", is_flag=True, help="Print processor time per reading.")
def main(numbers: bool, two: bool, laps: bool) -> None:
    """Make the picture, or print numbers."""
    chosen = [each for each, wanted in ((table, numbers), (pairs, two), (times, laps)) if wanted]
    for each in chosen or [picture]:
        each()


if __name__ == "__main__":
    main()
