"""
The paper's method, and today's
===============================

The inverse of the paper (half-space, stress at the taxels' centres, 20 x 20 nodes) beside the
default solver, on one reading that suits both. It finds less than the 2 N that press, as it
interpolates between the taxels; contacts that are fitted do not.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE, PLACE, FORCE = 400.0, (12e-3, -10e-3), 2.0  # Pa of one reading; m; N

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
ball = sf.simulate.Sphere(radius=15e-3, position=PLACE, force=FORCE)
press = sf.simulate.press(layer, [ball], mechanics=sf.HalfSpace(point_forces=False))
stress = press.base_stress(patch.positions, pad_diameter=0.0)  # Pa, at the centres of the taxels
stress += np.random.default_rng(0).normal(scale=NOISE, size=len(patch))

# %%
# Both are told the same: layer, mechanics, quantity and noise.

told: dict[str, Any] = {
    "mechanics": sf.HalfSpace(),
    "quantity": sf.BaseStress(pad_averaged=False),
    "noise_std": NOISE,
}
grid = sf.Grid.square(patch, nodes=20)
paper = sf.Reconstructor(patch, layer, grid, solver=sf.Inverse(), **told)(stress)
today = sf.Reconstructor(patch, layer, **told)(stress)

# %%

figure, (left, right) = plt.subplots(1, 2, figsize=(10.6, 4.6), layout="constrained")
truth = [(PLACE, FORCE, 0.0)]
paper.plot(left, truth=truth)
today.plot(right, truth=truth)
left.set_title(f"Inverse: {paper.normal_force:.2f} N in all", loc="left", pad=32)
right.set_title(f"Auto: {today.normal_force:.2f} N in all", loc="left", pad=32)
plt.show()

print(f"{paper.normal_force:.2f} N and {today.normal_force:.2f} N, {FORCE} N pressed")
assert 1.6 < paper.normal_force < 1.95  # N
assert abs(today.normal_force - FORCE) < 0.15  # N
