"""Error of readings on a sphere and a cylinder, their curvature ignored, corrected and exact.

Run: python benchmarks/curved_layer.py

A load of one force, 3 mm wide, stands above the middle of the pads of a layer of 2 mm. Ignored is
`BondedLayer()`; corrected is the flat layer by which contacts are fitted, thinner and of another
modulus (`Physics.flat`); exact is `CurvedLayer()`. Errors are those of all pads together (root of
squares), against the closed series of Legendre and Fourier, the larger of ν = 0.3 and 0.5.
"""

import sys
from pathlib import Path

import numpy as np

import skinfield as sf
from skinfield.elastic.curved_series import cylinder_responses, legendre_series
from skinfield.elastic.hankel import jinc

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
import curved_closed_forms as closed

H, PAD, WIDTH = 2e-3, 4e-3, 3e-3
QUANTITIES = {"stress": sf.BaseStress(), "indentation": sf.Gap()}


def sphere(radius: float, nu: float):
    """Patch, pressure at places, and true readings by the name of a response."""
    pitch = min(5e-3, 0.6 * radius)
    patch = sf.layouts.sphere_cap(radius=radius, cap_angle=min(1.6, 20e-3 / radius), pitch=pitch)

    def away(at):
        return np.arccos(np.clip(at[:, 2] / np.linalg.norm(at, axis=1), -1.0, 1.0))

    edge = WIDTH / (radius + H)

    def dome(angle):
        return np.sqrt(np.maximum(1.0 - (angle / edge) ** 2, 0.0))

    series = legendre_series(radius / H, nu)
    pads = PAD / 2 / radius, away(patch.positions), edge, dome

    def true(name):
        return closed.of_cap(getattr(series, name), radius, *pads)

    return patch, lambda at: dome(away(at)), true


def cylinder(radius: float, nu: float):
    """See `sphere`."""
    outer, width = radius / H + 1.0, WIDTH / H / 2
    arc = min(2.5, 40e-3 / radius)
    patch = sf.layouts.cylinder(radius=radius, length=40e-3, arc_angle=arc, pitch=5e-3)

    def places(at):
        return (np.arctan2(at[:, 0], at[:, 2]), at[:, 1] / H)

    def bump(at):
        angle, along = places(at)
        return np.exp(-((angle * outer) ** 2 + along**2) / (2 * width**2))

    m, k = np.arange(int(8 * outer)), np.linspace(0.0, 8.0, 81)
    waves = [each.ravel() for each in np.meshgrid(m, k, indexing="ij")]
    series = cylinder_responses(waves[0], waves[1], radius / H, nu)
    mean = jinc(np.hypot(waves[0] * H / radius, waves[1]), PAD / 2 / H)

    def true(name):
        response = (getattr(series, name) * mean).reshape(len(m), len(k))
        return closed.of_bump(response, outer, m / outer, k, places(patch.positions), width)

    return patch, bump, true


def errors(body, radius: float, nu: float) -> list:
    """Of stress, ignored and exact; of the gap, ignored, corrected and exact."""
    patch, pressure, true = body(radius, nu)
    layer, found = sf.Layer(thickness=H, poisson_ratio=nu), []
    grid = sf.Grid.square(patch, nodes=120)
    for name, quantity in QUANTITIES.items():
        exact = sf.ObservationModel.of(patch, layer, grid, sf.CurvedLayer(), quantity)
        load = pressure(exact.grid.positions)
        laid = exact.physics.flat
        truth = true(name) * (1.0 if name == "stress" else 2 * (1 + nu) / layer.young_modulus)
        readings = [exact.matrix @ load]
        for flat in (laid.layer, layer)[name == "stress" :]:
            model = sf.ObservationModel.of(patch, flat, grid, laid.mechanics, quantity)
            readings.insert(0, model.matrix @ load * exact.grid.spread)
        found += [np.linalg.norm(each - truth) / np.linalg.norm(truth) for each in readings]
    return found


print("| R/h | body | base stress: ignored | exact | gap: ignored | corrected | exact |")
print("| ---: | --- | ---: | ---: | ---: | ---: | ---: |")
for ratio in (2.5, 5.0, 7.5, 15.0, 30.0):
    for body in (sphere, cylinder):
        worst = np.max([errors(body, ratio * H, nu) for nu in (0.3, 0.5)], axis=0)
        cells = " | ".join(f"{100 * each:.1f} %" for each in worst)
        print(f"| {ratio:g} | {body.__name__} | {cells} |", flush=True)
