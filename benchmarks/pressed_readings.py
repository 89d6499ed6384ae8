"""Readings of simulated presses that a benchmark solves, and their models."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.lab.bench.scene import RADIUS, paths
from skinfield.simulate import Bar, Cylinder, Ring, Sphere, press
from skinfield.simulate.pressing.press import readings_anywhere

PATCH, LAYER = sf.layouts.hexagon72(), sf.Layer(2e-3, 100e3, 0.5)
QUANTITIES: dict[str, Any] = {"stress": sf.BaseStress(), "capacitance": sf.Capacitance()}
LOADS = np.geomspace(0.3, 2.0, 7)  # N
SHAPES = {  # that do not move; each reading has noise of its own
    "ball 12 mm, 3 N": Sphere(radius=6e-3, force=3.0),
    "bar 16 x 3 mm, 2 N": Bar(length=16e-3, width=3e-3, force=2.0),
    "ring 10 mm, 2 N": Ring(inner_radius=4e-3, outer_radius=5e-3, force=2.0),
    "flat end 30 mm, 20 N": Cylinder(radius=15e-3, edge_radius=1e-3, force=20.0),
}


def chains(count: int) -> dict[str, np.ndarray]:
    """Readings (count, L) of two wandering balls with noise, by quantity."""
    places, forces = paths(count)
    solved = [
        press(LAYER, [Sphere(radius=RADIUS, force=float(load))], 24e-3, 0.25e-3) for load in LOADS
    ]
    found = {}
    for quantity, kind in QUANTITIES.items():
        tables = [readings_anywhere(each, PATCH.pad_diameter, quantity) for each in solved]
        rows = np.zeros((count, len(PATCH)))
        for row, (places_now, forces_now) in enumerate(zip(places, forces, strict=True)):
            for place, force in zip(places_now, forces_now, strict=True):
                part = np.clip(np.interp(force, LOADS, np.arange(len(LOADS))), 0, len(LOADS) - 1)
                low = min(int(part), len(LOADS) - 2)
                away = PATCH.plane - place
                rows[row] += (low + 1 - part) * tables[low](away)
                rows[row] += (part - low) * tables[low + 1](away)
        noise = np.random.default_rng(0).normal(size=rows.shape) * kind.typical_noise
        found[quantity] = np.array(
            [kind.linearise(each, np.empty_like(each)) for each in rows + noise]
        )
    return found


def staying(body: Any, count: int) -> Iterator[tuple[str, np.ndarray]]:
    """Readings (count, L) of a press that stays, each with noise of its own, by quantity."""
    made = press(LAYER, [body], 50e-3, 0.5e-3)
    for quantity, kind in QUANTITIES.items():
        exact = made.readings(PATCH.plane - [2e-3, 1e-3], PATCH.pad_diameter, quantity)
        noise = np.random.default_rng(1).normal(size=(count, len(PATCH))) * kind.typical_noise
        yield (
            quantity,
            np.array([kind.linearise(each, np.empty_like(each)) for each in exact + noise]),
        )


def model_of(quantity: str, nodes: int) -> ObservationModel:
    """Of readings that are linearised already."""
    kind = QUANTITIES[quantity]
    model = ObservationModel.of(
        PATCH, LAYER, sf.Grid.square(PATCH, nodes), sf.BondedLayer(), kind, kind.typical_noise
    )
    return replace(model, physics=None)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Without the collector of cycles."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
