"""Backends that are at hand, and readings for them."""

from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.pipeline.array_backend import ArrayBackend

PATCH = sf.layouts.hexagon72()
LAYER = sf.Layer(2e-3, 100e3, 0.4)
GRID = sf.Grid.square(PATCH, nodes=18)


def torch(device: str) -> ArrayBackend:
    pytest.importorskip("array_api_compat", reason="array-api-compat: the extra gpu has it")
    library = pytest.importorskip("torch", reason="PyTorch is not installed: the extra gpu has it")
    if device == "cuda" and not library.cuda.is_available():
        pytest.skip("PyTorch finds no GPU")
    return ArrayBackend.torch(device)


def cupy() -> ArrayBackend:
    pytest.importorskip("array_api_compat", reason="array-api-compat: the extra gpu has it")
    library = pytest.importorskip("cupy", reason="CuPy is not installed")
    if not library.cuda.is_available():
        pytest.skip("CuPy finds no GPU")
    return ArrayBackend.cupy()


def strict() -> ArrayBackend:
    """The standard and nothing beyond, so that no library's habits are relied on."""
    return ArrayBackend(pytest.importorskip("array_api_strict", reason="of the extra test"))


BACKENDS = {
    "numpy": ArrayBackend.numpy,
    "strict": strict,
    "torch-cpu": lambda: torch("cpu"),
    "torch-cuda": lambda: torch("cuda"),
    "cupy": cupy,
}


def faded_in() -> np.ndarray:
    """Of two bodies, fading in, with noise; linearised."""
    bodies = [
        sf.simulate.Sphere(radius=6e-3, position=(-9e-3, 6e-3), force=1.0),
        sf.simulate.Cylinder(radius=3e-3, position=(12e-3, -8e-3), force=1.5),
    ]
    press = sf.simulate.press(LAYER, bodies, extent=70e-3, cell=1e-3)
    change = press.capacitance(PATCH.positions, PATCH.pad_diameter)
    noise = np.random.default_rng(3).normal(scale=2e-3, size=(23, 72))
    table = np.linspace(0.0, 1.0, 23)[:, None] * change + noise
    return sf.Capacitance().linearise(table, np.empty_like(table))


def operator_of(solver: sf.NonNegative) -> Any:
    rec = sf.Reconstructor(PATCH, LAYER, GRID, solver=solver, noise_std=2e-3)
    return solver.prepare(rec.model)
