"""
First press
===========

A ball presses on a patch of 72 taxels. From the noisy readings :class:`~skinfield.Auto`, the
default solver, finds how hard and where, and says how sure it is.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.skin.maps import draw_pads, extent_of_pads, frame_axes

NOISE = 0.002  # ΔC/C₀ of one reading

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)  # m, Pa

# %%
# What the taxels read
# --------------------
#
# A real skin gives readings; here they are simulated, so that the truth is known: a ball of 10 mm
# radius, pressed with 3 N. The press is solved on a finer grid than any solver uses.

ball = sf.simulate.Sphere(radius=10e-3, position=(8e-3, -6e-3), force=3.0)  # m, N
press = sf.simulate.press(layer, [ball])
readings = press.capacitance(patch.positions, patch.pad_diameter)
readings += np.random.default_rng(0).normal(scale=NOISE, size=len(patch))

# %%
# What touches
# ------------

reconstruct = sf.Reconstructor(patch, layer, quantity=sf.Capacitance(), noise_std=NOISE)
estimate = reconstruct(readings)
(contact,) = estimate.contacts
x, y, _ = contact.position * 1e3
print(f"{contact.normal_force:.2f} ± {contact.force_std:.2f} N at ({x:.1f}, {y:.1f}) mm")

# %%
# Readings on the left; on the right the pressure that explains them, and the true place.

figure, (left, right) = plt.subplots(1, 2, figsize=(10.6, 4.6), layout="constrained")
frame_axes(left, patch, extent_of_pads(patch))
pads = draw_pads(left, patch, readings)
figure.colorbar(pads, ax=left, shrink=0.8, label="ΔC/C₀ of the taxels")
estimate.plot(right, truth=[(ball.position, ball.force, 0.0)])
plt.show()

assert abs(contact.normal_force - 3.0) < 0.2  # N
