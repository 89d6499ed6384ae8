"""
An array from numbers
=====================

Eight by eight taxels at 4 mm under 1.5 mm of stiffer rubber: a patch takes positions in metres and
the diameter of a pad. A flat punch presses; a field shows its rim, where the pressure is highest.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE, PLACE, FORCE = 0.001, (15e-3, 11e-3), 3.0  # ΔC/C₀ of one reading; m; N

x, y = np.meshgrid(np.arange(8) * 4e-3, np.arange(8) * 4e-3)  # m
patch = sf.Patch(np.column_stack([x.ravel(), y.ravel()]), pad_diameter=3e-3, name="my array")
layer = sf.Layer(thickness=1.5e-3, young_modulus=300e3, poisson_ratio=0.48)  # m, Pa

# %%
# What the layer and the array look like; `skinfield.save_layout(patch, "my_array.toml")` keeps it.

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained")
patch.plot(left)
layer.plot(right, pad_diameter=patch.pad_diameter)
plt.show()

# %%

# sphinx_gallery_thumbnail_number = 2
punch = sf.simulate.Cylinder(radius=4e-3, position=PLACE, force=FORCE)
press = sf.simulate.press(layer, [punch], extent=40e-3)
readings = press.capacitance(patch.positions, patch.pad_diameter)
readings += np.random.default_rng(0).normal(scale=NOISE, size=len(patch))

estimate = sf.Reconstructor(patch, layer, noise_std=NOISE)(readings)
estimate.plot(truth=[(PLACE, FORCE, 4e-3)])
plt.show()

(contact,) = estimate.contacts
print(f"{contact.shape}, {contact.normal_force:.2f} ± {contact.force_std:.2f} N")
assert abs(contact.normal_force - FORCE) < 0.4  # N
