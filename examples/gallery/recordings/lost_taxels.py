"""
Lost taxels are repaired
========================

Taxels that do not answer are NaN and left out of the answer, never taken for zero. What they would
have read comes back with the estimate, by the contacts and the neighbours, with its error.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import Normalize

import skinfield as sf
from skinfield.skin.maps import draw_pads, extent_of_pads, frame_axes

NOISE, PLACE, FORCE = 0.002, (3e-3, -2e-3), 6.0  # ΔC/C₀ of one reading; m; N

patch = sf.layouts.rectangular(rows=10, columns=10, pitch=4e-3)
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa
ball = sf.simulate.Sphere(radius=20e-3, position=PLACE, force=FORCE)
truth = sf.simulate.press(layer, [ball]).capacitance(patch.positions, patch.pad_diameter)

# %%
# Two of the five taxels nearest to the press are gone, and eight others.

rng = np.random.default_rng(3)
near = np.argsort(np.hypot(*(patch.plane - PLACE).T))
lost = np.concatenate([near[[1, 3]], rng.choice(near[5:], size=8, replace=False)])
readings = truth + rng.normal(scale=NOISE, size=len(patch))
readings[lost] = np.nan
estimate = sf.Reconstructor(patch, layer, noise_std=NOISE)(readings)

# %%
# As measured, and repaired. Both have one scale of colours.

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.4), layout="constrained")
for axes, values, title in (
    (left, readings, f"As measured, {len(lost)} taxels lost"),
    (right, estimate.readings, "Repaired"),
):
    frame_axes(axes, patch, extent_of_pads(patch))
    pads = draw_pads(axes, patch, values)
    pads.set(norm=Normalize(truth.min(), truth.max()), cmap="magma_r")
    axes.set_title(title)
figure.colorbar(pads, ax=(left, right), label="ΔC/C₀", shrink=0.8)
plt.show()

# %%

off = np.abs(estimate.readings - truth)[lost]
for taxel in near[[1, 3]]:
    print(f"taxel {taxel}: {estimate.readings[taxel]:.3f} ± {estimate.readings_std[taxel]:.3f}, "
          f"truly {truth[taxel]:.3f}")  # fmt: skip
(contact,) = estimate.contacts
print(f"{contact.normal_force:.2f} ± {contact.force_std:.2f} N, {FORCE} N pressed")
assert np.all(off < 4 * estimate.readings_std[lost])
assert abs(contact.normal_force - FORCE) < 0.6  # N
