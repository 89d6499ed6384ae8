"""
Calibrate by a load cell
========================

The modulus of the rubber is seldom known, and every force goes with it. A load cell below the skin
and ten seconds of presses give the factor, and how well it holds.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.signal import fit_scale

GUESS = 100e3  # Pa: assumed of the modulus; it truly is 150e3

# %%
# A recording that skinfield simulates by itself. What a load cell below would read is the sum of
# the forces, at times of its own, with noise.

pressed = sf.datasets.load("two_presses")
recording = pressed.recording
cell_ns = recording.stamp_ns[0] + np.arange(1200, dtype=np.int64) * 5_000_000  # 200 Hz
cell = np.interp(cell_ns, recording.stamp_ns, pressed.force.sum(axis=1))  # N
cell += np.random.default_rng(0).normal(scale=0.02, size=len(cell))

# %%
# Reconstruct with the guess, and fit the one factor that is missing.

layer = sf.Layer(thickness=2e-3, young_modulus=GUESS)
reconstruct = sf.Reconstructor(pressed.patch, layer, calibration=pressed.calibration)
every = slice(0, None, 4)
stamps = recording.stamp_ns[every]
guessed = reconstruct(recording.counts[every], stamp_ns=stamps).normal_force
fit = fit_scale(stamps, guessed, cell_ns, cell)
modulus = fit.factor * GUESS
print(f"modulus: {modulus / 1e3:.0f} ± {fit.factor_std * GUESS / 1e3:.0f} kPa")
print(f"off by {fit.rms:.2f} N rms, {fit.held_out_rms:.2f} N where it was not fitted")

# %%

figure, axes = plt.subplots(figsize=(8.6, 3.8), layout="constrained")
axes.plot((cell_ns - stamps[0]) / 1e9, cell, color="#c9c9d1", lw=3, label="load cell")
time = (stamps - stamps[0]) / 1e9
axes.plot(time, guessed, color="#d55e00", ls="--", label=f"skin, {GUESS / 1e3:.0f} kPa guessed")
axes.plot(
    time, guessed * fit.factor, color="#0072b2", label=f"skin, {modulus / 1e3:.0f} kPa fitted"
)
axes.set(xlabel="time (s)", ylabel="force (N)", ylim=(-0.2, None))
axes.spines[["top", "right"]].set_visible(False)
axes.legend(frameon=False)
plt.show()

assert 140e3 < modulus < 160e3  # Pa
