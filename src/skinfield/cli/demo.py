"""`skinfield demo`: the main job with nothing at hand."""

import time
from collections.abc import Callable
from typing import Any

import click
import numpy as np

from skinfield.cli.inputs import skin_from_text
from skinfield.cli.options import (
    QUANTITIES,
    layer_from_options,
    model_options,
    patch_of,
    reconstructor_from_options,
)
from skinfield.cli.report import console, table_of_contacts
from skinfield.errors import Floats, InputError, as_floats, check_positive
from skinfield.fields import Estimate
from skinfield.pipeline import Reconstructor
from skinfield.simulate import Sphere

DEFAULT_PRESSES = ("-16,8,1.5,6", "13,-12,1,6")  # mm, mm, N, mm


@click.command(
    short_help="Simulate a press on a patch, reconstruct it, draw it.",
    help="""Simulate rigid balls that press on a patch, reconstruct force, deformation and contacts
from the noisy readings, and compare with what is known.

The truth comes from a contact solver on a finer grid of its own and, for capacitance, from the
nonlinear electrostatics of the pads; the reconstruction sees readings only.

\b
  skinfield demo
  skinfield demo --press 0,6,2,6 --solver contact
  skinfield demo --press 0,6,2,6 --solver tikhonov --grid 20 -o demo.pdf
  skinfield demo --quantity stress --mechanics half-space --solver inverse
""",
)
@click.option("--layout", default="hexagon72", show_default=True, help="Layout file or generator.")
@click.option(
    "--press",
    "presses",
    multiple=True,
    metavar="X,Y,F,R",
    help="A ball: place mm, force N, radius mm; may be given several times.",
)
@click.option("--noise", type=float, help="Of a reading, in the quantity's unit.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the noise."
)
@click.option("-o", "--output", default="demo.png", show_default=True, help="Figure to write.")
@model_options(grid=40)
def demo(
    layout: str,
    presses: tuple[str, ...],
    noise: float | None,
    seed: int,
    output: str,
    **options: Any,
) -> None:
    """Simulate, reconstruct, compare."""
    from skinfield.figures import check_name, draw_estimate, save
    from skinfield.simulate import press

    check_name(output)
    patch = patch_of(skin_from_text(layout), None)
    layer = layer_from_options(options["thickness_mm"], options["modulus_kpa"], options["poisson"])
    name = "capacitance" if options["quantity"] == "auto" else options["quantity"]
    quantity = QUANTITIES[name]()
    spread = quantity.typical_noise if noise is None else noise
    check_positive("--noise", spread, "no reading is exact")
    balls = [_ball_of(text) for text in presses or DEFAULT_PRESSES]
    extent = 2 * float(np.abs(patch.plane).max()) + 12e-3
    true = press(layer, balls, extent=extent, cell=min(0.4e-3, extent / 40))
    clean = true.readings(patch.plane, patch.pad_diameter, name)
    readings = clean + np.random.default_rng(seed).normal(scale=spread, size=len(patch))
    start = time.perf_counter()
    reconstructor = reconstructor_from_options(patch, layer, quantity, spread, options)
    prepared = time.perf_counter() - start
    estimate = reconstructor(readings)
    figure = draw_estimate(
        estimate,
        readings,
        truth=[(ball.position, ball.force, ball.radius / 2) for ball in balls],
        quantity_name=quantity.symbol,
        quantity_unit={"1": "%", "Pa": "kPa"}[quantity.unit],
    )
    save(figure, output)
    _report(reconstructor, estimate, balls, readings, prepared)
    console().print(f"wrote {output}", highlight=False, soft_wrap=True)


def _ball_of(text: str) -> Sphere:
    parts = text.split(",")
    if len(parts) != 4:
        raise InputError(f"--press is {text!r}, expected x,y,force,radius in mm, mm, N, mm")
    x, y, force, radius = as_floats("--press", parts).tolist()
    return Sphere(position=(x * 1e-3, y * 1e-3), force=force, radius=radius * 1e-3)


def _report(
    reconstructor: Reconstructor,
    estimate: Estimate,
    balls: list[Sphere],
    readings: Floats,
    prepared: float,
) -> None:
    from rich.table import Table

    out = console()
    out.print(table_of_contacts(estimate.contacts, "Contacts reconstructed"))
    table = Table(title="Against the known truth", title_justify="left")
    for column in ("press", "true N", "found N", "force error", "place error mm"):
        table.add_column(column, justify="right")
    for index, ball in enumerate(balls, start=1):
        places = [np.hypot(*(c.position[:2] - ball.position)) for c in estimate.contacts]
        nearest = int(np.argmin(places)) if places else -1
        if nearest < 0 or places[nearest] > 8e-3:
            table.add_row(str(index), f"{ball.force:.2f}", "missed", "", "")
            continue
        found = estimate.contacts[nearest].normal_force
        table.add_row(
            str(index),
            f"{ball.force:.2f}",
            f"{found:.2f}",
            f"{(found / ball.force - 1) * 100:+.0f} %",
            f"{places[nearest] * 1e3:.2f}",
        )
    out.print(table)
    latency = _latency(reconstructor, estimate, readings)
    out.print(
        f"latency: {latency}; prepared once in {prepared:.1f} s",
        highlight=False,
        soft_wrap=True,
    )


def _latency(reconstructor: Reconstructor, estimate: Estimate, readings: Floats) -> str:
    nodes = f"{estimate.grid.shape[0]} x {estimate.grid.shape[1]} nodes"
    whole = f"{estimate.latency * 1e3:.1f} ms"
    try:
        plan = reconstructor.plan
    except InputError:  # not linear: nothing comes before the contacts
        again = _median_time(lambda: reconstructor(readings), 20)
        return f"{whole} for contacts and fields at {nodes}, {again * 1e3:.1f} ms the next time"
    buffer = np.empty(len(plan.operator))
    alone = _median_time(lambda: reconstructor.apply(readings, buffer), 200)
    return f"{alone * 1e6:.0f} µs for pressure and displacement at {nodes}, {whole} with contacts"


def _median_time(call: Callable[[], object], laps: int) -> float:
    """In seconds."""
    times = np.empty(laps)
    for index in range(laps):
        start = time.perf_counter()
        call()
        times[index] = time.perf_counter() - start
    return float(np.median(times))
