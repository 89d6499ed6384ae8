"""`skinfield demo`: the main job with nothing at hand."""

import time
from collections.abc import Callable
from typing import Annotated

import numpy as np

from skinfield.cli.options import (
    OUTPUT,
    Force,
    layer_of,
    part,
    patch_of,
    profile_in_use,
    quantity_of,
    reconstructor_of,
    skin_from_text,
)
from skinfield.cli.report import check_new, console, free_name, table_of_contacts
from skinfield.errors import Floats, InputError, as_floats, check_count, check_positive
from skinfield.estimate import Estimate
from skinfield.reconstruct import Reconstructor
from skinfield.settings import Elastomer, ModelSettings
from skinfield.simulate import Sphere

DEFAULT_PRESSES = ("-16,8,1.5,6", "13,-12,1,6")  # mm, mm, N, mm
PICTURE = "demo.png"


def demo(
    *,
    layout: str = "hexagon72",
    press: tuple[str, ...] = (),
    noise: float | None = None,
    seed: int = 0,
    output: Annotated[str | None, OUTPUT] = None,
    force: Force = False,
    elastomer: Annotated[Elastomer, part("Elastomer")] = Elastomer(),
    model: Annotated[ModelSettings, part("Model")] = ModelSettings(),
) -> None:
    """Simulate rigid balls that press on a patch, reconstruct what they do, and compare.

    The truth comes from a contact solver on a finer grid of its own and, for capacitance, from the
    nonlinear electrostatics of the pads; the reconstruction sees noisy readings only.

      skinfield demo
      skinfield demo --press 0,6,2,6 --solver contact
      skinfield demo --press 0,6,2,6 --solver tikhonov --grid 20 -o demo.pdf
      skinfield demo --quantity stress --mechanics half-space --solver inverse

    Parameters
    ----------
    layout : str
        Layout file, or a generator by name.
    press : tuple of str
        A ball, X,Y,F,R: place mm, force N, radius mm; again for more.
    noise : float, optional
        Of a reading, in the quantity's unit.
    seed : int
        Of the noise.
    output : str, optional
        Figure to write: .png, .pdf or .svg. Default demo.png, or a name that is free.
    """
    from skinfield.plot import check_name, draw_estimate, save
    from skinfield.simulate import press as pressed

    picture = free_name(PICTURE) if output is None else output
    check_name(picture)
    check_new("--output", picture, force)
    patch = patch_of(skin_from_text(layout), None)
    profile = profile_in_use(elastomer, layout=layout)
    layer = layer_of(elastomer, profile)
    name = model.quantity or "capacitance"
    quantity = quantity_of(name)
    spread = quantity.typical_noise if noise is None else noise
    check_positive("--noise", spread, "no reading is exact")
    check_count("--seed", seed, 0, 1 << 63, "of the noise")
    balls = [_ball_of(text) for text in press or DEFAULT_PRESSES]
    extent = 2 * float(np.abs(patch.plane).max()) + 12e-3
    true = pressed(layer, balls, extent=extent, cell=min(0.4e-3, extent / 40))
    clean = true.readings(patch.plane, patch.pad_diameter, name)
    readings = clean + np.random.default_rng(seed).normal(scale=spread, size=len(patch))
    start = time.perf_counter()
    reconstructor = reconstructor_of(patch, layer, quantity, spread, model, profile)
    prepared = time.perf_counter() - start
    estimate = reconstructor(readings)
    figure = draw_estimate(
        estimate,
        readings,
        truth=[(ball.position, ball.force, ball.radius / 2) for ball in balls],
        quantity_name=quantity.symbol,
        quantity_unit={"1": "%", "Pa": "kPa"}[quantity.unit],
    )
    save(figure, picture)
    _report(reconstructor, estimate, balls, readings, prepared)
    console().print(f"wrote {picture}", highlight=False, soft_wrap=True)


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
