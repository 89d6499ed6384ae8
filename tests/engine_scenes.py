"""Skins of a few patches, touched ones among them, for tests of engines."""

from dataclasses import replace
from typing import Any

import numpy as np

import skinfield as sf
from skinfield.errors import Floats
from skinfield.reconstruct.engine import Engine
from skinfield.skin import generators

NOISE = 0.002
ENOUGH = 10.0  # s
LAYER = sf.Layer()
HEXAGON, TRIANGLE = generators.hexagon72(), generators.icub_triangle()
MOVED = replace(TRIANGLE, positions=np.add(TRIANGLE.positions, [0.1, -0.2, 0.0]), name="moved")
SKIN = sf.Skin((TRIANGLE, HEXAGON, MOVED, replace(HEXAGON, name="other")))
BALL = sf.simulate.press(LAYER, [sf.simulate.Sphere(radius=6e-3, force=2.0)], cell=0.6e-3)
CUT = 3e-3  # what a stamped product may leave out of a linear answer
RUNGS = (8, 16, 32)


def touched(patch: sf.Patch, seed: int, taxel: int | None = None) -> Floats:
    """Readings of a ball on a taxel, solved on a grid of its own, with noise."""
    rng = np.random.default_rng(seed)
    taxel = int(rng.integers(len(patch))) if taxel is None else taxel
    at = patch.plane - patch.plane[taxel]
    clean = BALL.readings(at, patch.pad_diameter, "capacitance")
    return np.asarray(clean + rng.normal(0.0, NOISE, len(patch)))


def readings_of(skin: sf.Skin, hot: tuple[str, ...], seed: int = 0) -> dict[str, Floats]:
    rng = np.random.default_rng(seed + 1000)
    return {
        patch.name: touched(patch, seed + i)
        if patch.name in hot
        else rng.normal(0.0, NOISE, len(patch))
        for i, patch in enumerate(skin)
    }


def engine_of(solver: Any, skin: sf.Skin | sf.Patch = SKIN, **options: Any) -> Engine:
    given = {"budget": ENOUGH, "rungs": RUNGS, "noise_std": NOISE, **options}
    return Engine(skin, LAYER, solver=solver, **given)


def apart(a: Floats, b: Floats) -> float:
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))
