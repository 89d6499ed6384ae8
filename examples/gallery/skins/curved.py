"""
A curved skin
=============

Taxels on a forearm: positions in space make a patch, and normals and the way round follow. Contacts
are found on the curved surface, with the direction in which they press.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE, PLACE, FORCE = 0.002, (11e-3, -8e-3), 3.0  # ΔC/C₀ of one reading; m along the skin; N

# %%
# Half a cylinder of 40 mm radius, by its points alone: (L, 3) in m. A layout file or a generator
# such as `skinfield.layouts.cylinder` would do as well.

angle, along = np.meshgrid(np.linspace(-0.9, 0.9, 16), np.linspace(-30e-3, 30e-3, 13))
points = np.stack([40e-3 * np.sin(angle), along, 40e-3 * np.cos(angle)], axis=-1)
patch = sf.Patch(points.reshape(-1, 3), pad_diameter=4e-3, name="forearm")
patch.plot()
plt.show()

# %%
# Where the radius is large beside the layer's thickness, a press is as on a flat skin, unrolled:
# `patch.plane` are the taxels there.

layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa
ball = sf.simulate.Sphere(radius=15e-3, position=PLACE, force=FORCE)
readings = sf.simulate.press(layer, [ball]).capacitance(patch.plane, patch.pad_diameter)
readings += np.random.default_rng(0).normal(scale=NOISE, size=len(patch))

estimate = sf.Reconstructor(patch, layer, noise_std=NOISE)(readings)
estimate.plot(truth=[(PLACE, FORCE, 0.0)])
plt.show()

# %%
# Place and force are in the patch's frame, in space.

(contact,) = estimate.contacts
print(f"{contact.normal_force:.2f} N at {np.round(contact.position * 1e3, 1)} mm, "
      f"force {np.round(contact.force, 2)} N")  # fmt: skip
assert abs(contact.normal_force - FORCE) < 0.3  # N
assert abs(np.hypot(*contact.position[[0, 2]]) - 40e-3) < 0.2e-3  # m: on the cylinder
