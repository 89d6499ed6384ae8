"""Presses on the paper's patch, solved once each, and what is reconstructed from their readings.

`skinfield.simulate` solves them on cells of 0.4 mm. An indenter that turns about its axis gives
readings that depend on the taxel's distance alone, so each is solved once and then moved.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

import skinfield as sf
from skinfield.elastic import Quantity
from skinfield.errors import Floats
from skinfield.simulate import Cylinder, Sphere, press
from skinfield.skin.geometry import inside_hull

Indenter = Sphere | Cylinder
PATCH = sf.layouts.hexagon72()
LAYER = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
QUANTITIES: dict[str, Quantity] = {"stress": sf.BaseStress(), "capacitance": sf.Capacitance()}
FAR = np.linspace(0.0, 66e-3, 166)  # m; the farthest that a taxel is from a press
BALL = Sphere(radius=6e-3, force=1.0)


@lru_cache(maxsize=64)
def profile(indenter: Indenter, quantity: str, layer: sf.Layer = LAYER) -> Floats:
    """Readings of taxels at the distances FAR from an indenter at the origin."""
    extent = 30e-3 if isinstance(indenter, Cylinder) else 14e-3
    line = np.column_stack([FAR, np.zeros_like(FAR)])
    return press(layer, [indenter], extent, 0.4e-3).readings(line, PATCH.pad_diameter, quantity)


def readings(indenter: Indenter, places: Floats, quantity: str, layer: sf.Layer = LAYER) -> Floats:
    """Readings (P, L) without noise of the patch, pressed at places (P, 2) m."""
    distance = np.linalg.norm(PATCH.plane[None] - places[:, None], axis=2)
    return np.asarray(np.interp(distance, FAR, profile(indenter, quantity, layer)))


def random_places(count: int, seed: int) -> Floats:
    """Points (count, 2) m, evenly spread inside the hull of the taxels."""
    points = np.random.default_rng(seed).uniform(-30e-3, 30e-3, size=(20 * count, 2))
    return points[inside_hull(PATCH.plane, points)][:count]


def inner_places() -> Floats:
    """Sixty points (60, 2) m within 18 mm of the middle, so that no press reaches over the rim."""
    points = random_places(300, seed=3)
    return points[np.linalg.norm(points, axis=1) < 18e-3][:60]


def summed(estimate: sf.Estimate) -> Floats:
    """Normal force of the contacts of each reading, (T,) N."""
    return np.array([sum(c.normal_force for c in found) for found in estimate.contacts])


def misplaced(estimate: sf.Estimate, places: Floats) -> Floats:
    """Distance (T,) m from the strongest contact to the true place; NaN where nothing is found."""
    return np.array(
        [
            np.hypot(*(found[0].position[:2] - place)) if found else np.nan
            for found, place in zip(estimate.contacts, places, strict=True)
        ]
    )


def reconstructor(
    quantity: str,
    solver: Any = None,
    nodes: int = 40,
    layer: sf.Layer = LAYER,
    noise_std: float | None = None,
) -> sf.Reconstructor:
    """Reconstruct, by default by a Gaussian field and with the quantity's typical noise."""
    grid = sf.Grid.square(PATCH, nodes=nodes)
    what = QUANTITIES[quantity]
    by = sf.GaussianField() if solver is None else solver
    return sf.Reconstructor(PATCH, layer, grid, quantity=what, solver=by, noise_std=noise_std)


def stress_per_change() -> float:
    """Calibrate wrongly: Pa per ΔC/C₀ from one press of 0.5 N on a taxel."""
    reference = replace(BALL, force=0.5)
    return float(profile(reference, "stress")[0] / profile(reference, "capacitance")[0])
