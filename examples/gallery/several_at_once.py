"""
Several touches at once
=======================

Three fingertips press close to each other, and none is told how many there are. The default solver
finds the fewest contacts that explain the reading, each with a force, a place and their errors.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE = 0.002  # ΔC/C₀ of one reading

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa

# %%
# Three balls of different size: radius in m, place in m, force in N.

presses = [
    (8e-3, (-12e-3, 5e-3), 2.0),
    (6e-3, (9e-3, 8e-3), 1.0),
    (7e-3, (3e-3, -11e-3), 1.5),
]
balls = [sf.simulate.Sphere(radius=r, position=place, force=f) for r, place, f in presses]
press = sf.simulate.press(layer, balls)
readings = press.capacitance(patch.positions, patch.pad_diameter)
readings += np.random.default_rng(1).normal(scale=NOISE, size=len(patch))

# %%
# One reading is enough. Crosses are the truth.

reconstruct = sf.Reconstructor(patch, layer, noise_std=NOISE)
estimate = reconstruct(readings)
for contact in estimate.contacts:
    x, y, _ = contact.position * 1e3
    print(f"{contact.normal_force:.2f} ± {contact.force_std:.2f} N at ({x:.1f}, {y:.1f}) mm")
estimate.plot(truth=[(place, force, 0.0) for _, place, force in presses])
plt.show()

assert len(estimate.contacts) == 3
assert np.allclose([c.normal_force for c in estimate.contacts], [2.0, 1.5, 1.0], atol=0.3)  # N
