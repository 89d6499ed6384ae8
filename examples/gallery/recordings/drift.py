"""
Drift of rest is followed
=========================

Warmth and creep move what taxels read at rest, by far more than a light touch does. A run that is
answered in order follows the rest and keeps the touch; a baseline of the first second does not.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

RATE, SECONDS, NOISE, FORCE = 10, 60, 0.002, 1.0  # Hz, s, ΔC/C₀ of one reading, N

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa

# %%
# In a minute the taxels drift by up to 2.3 %, each by its own amount. From second 35 to 45 a ball
# presses.

time = np.arange(SECONDS * RATE) / RATE
rng = np.random.default_rng(0)
drift = np.outer(1 - np.exp(-time / 40), rng.uniform(0.0, 0.03, len(patch)))  # ΔC/C₀
held = (time >= 35) & (time < 45)
ball = sf.simulate.Sphere(radius=8e-3, position=(6e-3, 4e-3), force=FORCE)
touch = sf.simulate.press(layer, [ball]).capacitance(patch.positions, patch.pad_diameter)
readings = drift + held[:, None] * touch + rng.normal(scale=NOISE, size=drift.shape)

# %%
# With stamps, the reconstructor knows how long each reading is after the one before. Reset before
# each reading, it knows nothing but the rest that was taken once.

reconstruct = sf.Reconstructor(patch, layer, noise_std=NOISE)
stamps = np.round(time * 1e9).astype(np.int64)
followed = reconstruct(readings, stamp_ns=stamps).contacts.normal_force
once = np.full(len(time), np.nan)
for row in range(0, len(time), 10):
    reconstruct.reset()
    once[row] = reconstruct(readings[row]).contacts.normal_force

# %%

figure, (above, below) = plt.subplots(2, 1, figsize=(9.6, 5.4), sharex=True, layout="constrained")
liveliest = np.argsort(-touch)[:3]
above.plot(time, readings[:, liveliest] * 100, lw=0.8)
above.set(ylabel="ΔC/C₀ (%)", title="Three taxels that are touched, and drift")
below.plot(time, once, "o", color="#d55e00", ms=3, label="rest taken once")
below.plot(time, followed, color="#0072b2", label="rest followed")
below.plot(time, held * FORCE, color="#6b6b75", ls="--", lw=1, label="truth")
below.set(xlabel="time (s)", ylabel="force (N)", xlim=(0, SECONDS))
below.legend(frameon=False)
for axes in (above, below):
    axes.spines[["top", "right"]].set_visible(False)
plt.show()

print(f"held: {np.median(followed[held]):.2f} N; {FORCE} N is true")
print(f"at the end, untouched: {np.median(followed[-50:]):.2f} N; {np.nanmedian(once[-50:]):.2f} N "
      "with the first rest")  # fmt: skip
assert abs(np.median(followed[held]) - FORCE) < 0.15  # N
assert np.median(followed[~held]) == 0.0
