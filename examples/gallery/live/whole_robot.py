"""
A whole robot's skin
====================

Twenty patches, one budget of time for all: an engine looks at every patch first, and spends what is
left on those that are touched.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE = 0.002  # ΔC/C₀ of one reading

hexagon = sf.layouts.hexagon72()
skin = sf.Skin(tuple(replace(hexagon, name=f"arm {i}") for i in range(20)), name="arm")
engine = sf.Engine(skin, budget=2e-3, noise_std=NOISE)  # s, for all patches

# %%
# Two patches are touched.

touched = {"arm 7": (1.5, (12e-3, -10e-3)), "arm 16": (2.5, (-8e-3, 6e-3))}  # N, m
clean = {}
for name, (force, place) in touched.items():
    ball = sf.simulate.Sphere(radius=6e-3, position=place, force=force)
    press = sf.simulate.press(sf.Layer(), [ball])
    clean[name] = press.capacitance(hexagon.positions, hexagon.pad_diameter)

# %%
# A robot's loop: readings in, estimates out. Estimates of a patch are by its name.

rng = np.random.default_rng(0)
for _ in range(20):
    readings = {p.name: rng.normal(scale=NOISE, size=len(p)) + clean.get(p.name, 0) for p in skin}
    estimates = engine(readings)
print(f"{len(estimates.report.idle)} of {len(skin)} patches idle")

estimates = engine(readings, budget=0.2)  # the last readings again, without hurry

# %%

figure, axes = plt.subplots(figsize=(9.0, 6.0), layout="constrained")
skin.plot(axes)
plt.show()

# %%

# sphinx_gallery_thumbnail_number = 2
figure, pair = plt.subplots(1, 2, figsize=(10.6, 4.6), layout="constrained")
for axes, (name, (force, place)) in zip(pair, touched.items()):
    estimates[name].plot(axes, truth=[(place, force, 0.0)])
    print(f"{name}: {estimates[name].normal_force:.2f} N found, {force} N pressed")
plt.show()

assert len(estimates.report.idle) == 18
assert abs(estimates["arm 16"].normal_force - 2.5) < 0.3  # N
