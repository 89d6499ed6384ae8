"""
A filter for what lasts
=======================

A press of 0.2 N comes and goes in the noise of single readings. An exponential filter of a tenth of
a second holds it, and says what it costs: how late it is, and how much noise is left.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.signal import Exponential, filtered

RATE, NOISE, FORCE = 50.0, 0.002, 0.2  # readings per second; ΔC/C₀ of one reading; N

patch = sf.layouts.hexagon72()
ball = sf.simulate.Sphere(radius=15e-3, position=(12e-3, -10e-3), force=FORCE)
touch = sf.simulate.press(sf.Layer(), [ball]).capacitance(patch.positions, patch.pad_diameter)
time = np.arange(-25, 150) / RATE  # the filter has run in at 0
pressed = time >= 1.0
raw = np.random.default_rng(0).normal(scale=NOISE, size=(len(time), len(patch)))
raw += pressed[:, None] * touch

# %%
# The filter knows what noise it leaves; the reconstructor is told.

exponential = Exponential(time_constant=0.1)
smooth = filtered(exponential, raw, RATE)
factor, delay = exponential.noise_factor(RATE), exponential.delay(RATE)
print(f"{delay * 1e3:.0f} ms late, {factor:.0%} of the noise left")

# %%
# Each reading by itself, without memory of the one before.

force = {}
for name, readings, noise in (("raw", raw, NOISE), ("filtered", smooth, NOISE * factor)):
    reconstruct = sf.Reconstructor(patch, noise_std=noise)
    force[name] = np.zeros(len(time))
    for row, reading in enumerate(readings):
        reconstruct.reset()
        force[name][row] = reconstruct(reading).contacts.normal_force

figure, axes = plt.subplots(figsize=(8.6, 4.0), layout="constrained")
axes.plot(time, force["raw"], ".", color="#c9c9d1", label="single readings")
axes.plot(time, force["filtered"], color="#0072b2", label="filtered")
axes.plot(time, pressed * FORCE, color="#6b6b75", ls="--", lw=1, label="truth")
axes.set(xlabel="time (s)", ylabel="force (N)", xlim=(0, time[-1]), ylim=(-0.02, 0.6))
axes.spines[["top", "right"]].set_visible(False)
axes.legend(frameon=False, loc="upper left")
plt.show()

settled = time > 1.5
for name, found in force.items():
    print(f"{name}: {found[settled].mean():.2f} ± {found[settled].std():.2f} N")
assert (force["filtered"][settled] > 0).all()
assert abs(force["filtered"][settled].mean() - FORCE) < 0.05  # N
