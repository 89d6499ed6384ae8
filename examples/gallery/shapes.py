"""
Shapes: contacts or a field
===========================

A ball, a rod and a tube press with 6 N each. Contacts are exact where what presses has a simple
shape; a field of pressure supposes none, and shows a ring as a ring.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.plot import signed_colours
from skinfield.skin.maps import draw_cells, extent_of_pads, frame_axes, outline_pads

NOISE, FORCE = 0.001, 6.0  # ΔC/C₀ of one reading; N
PLACE = (1e-3, 1.5e-3)  # m

patch = sf.layouts.rectangular(rows=10, columns=10, pitch=4e-3)
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa
pressed: dict[str, Any] = {"position": PLACE, "force": FORCE}
bodies = {
    "Ball": sf.simulate.Sphere(radius=10e-3, **pressed),
    "Rod": sf.simulate.Rod(radius=4e-3, length=24e-3, edge_radius=4e-3, rotation=0.6, **pressed),
    "Tube": sf.simulate.Ring(inner_radius=9e-3, outer_radius=12e-3, edge_radius=1.5e-3, **pressed),
}

# %%
# Contacts that are fitted, and a field that is never negative, of the same 100 readings.

rng = np.random.default_rng(0)
solvers: dict[str, Any] = {"Contacts": sf.ContactFit(), "Field": sf.NonNegative()}
methods = {
    name: sf.Reconstructor(patch, layer, solver=solver, noise_std=NOISE)
    for name, solver in solvers.items()
}
figure, table = plt.subplots(3, 3, figsize=(9.6, 10.6), layout="constrained")
found = {}
for (body_name, body), column in zip(bodies.items(), table.T):
    press = sf.simulate.press(layer, [body])
    readings = press.capacitance(patch.positions, patch.pad_diameter)
    readings += rng.normal(scale=NOISE, size=len(patch))
    colours, scale = signed_colours(press.pressure / 1e3)
    maps = {f"{body_name}: {FORCE} N": (press.grid, press.pressure)}
    for name, reconstruct in methods.items():
        estimate = found[body_name, name] = reconstruct(readings)
        maps[f"{name}: {estimate.normal_force:.2f} N"] = reconstruct.grid, estimate.pressure
    for axes, (title, (grid, pressure)) in zip(column, maps.items()):
        cells = draw_cells(axes, grid, pressure / 1e3, cmap=colours, norm=scale)
        frame_axes(axes, patch, extent_of_pads(patch))
        outline_pads(axes, patch)
        axes.set_title(title)
    figure.colorbar(cells, ax=column, location="bottom", shrink=0.9, label="pressure (kPa)")
plt.show()

(rod,) = found["Rod", "Contacts"].contacts
print(f"the rod is a {rod.shape} of {rod.normal_force:.2f} ± {rod.force_std:.2f} N")
assert rod.shape == "line"
assert abs(rod.normal_force - FORCE) < 0.6  # N
