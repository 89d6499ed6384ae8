"""
Errors that hold
================

Each contact comes with the standard deviation of its force and place. Forty presses anywhere on
the skin show whether these can be believed: two thirds of the answers should lie within one.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE, COUNT = 0.002, 40  # ΔC/C₀ of one reading

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa
reconstruct = sf.Reconstructor(patch, layer, noise_std=NOISE)

# %%
# The layer has no border, so a press anywhere is read as by taxels that move the other way: four
# presses are solved, and each is set down at ten places under the taxels.

rng = np.random.default_rng(5)
forces = np.repeat([0.7, 1.2, 1.8, 2.5], COUNT // 4)  # N
presses = {
    force: sf.simulate.press(layer, [sf.simulate.Sphere(radius=8e-3, force=force)], extent=16e-3)
    for force in np.unique(forces)
}
places = patch.plane[rng.integers(len(patch), size=COUNT)] * 0.8  # m
contacts = []
for force, place in zip(forces, places):
    clean = presses[force].capacitance(patch.plane - place, patch.pad_diameter)
    reconstruct.reset()  # one press has nothing to do with the one before
    contacts.append(reconstruct(clean + rng.normal(scale=NOISE, size=len(patch))).contacts[0])

# %%
# Left, forces found with their standard deviations beside the truth; right, how far places are
# off, and two of the stated deviations.

force = np.array([contact.normal_force for contact in contacts])
force_std = np.array([contact.force_std for contact in contacts])
away = np.array([c.position[:2] - place for c, place in zip(contacts, places)]) * 1e3
place_std = np.array([np.sqrt(np.diag(c.covariance)[:2]) for c in contacts]) * 1e3

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained")
spread = forces + rng.uniform(-0.12, 0.12, COUNT)
left.errorbar(spread, force, force_std, fmt="o", color="#0072b2", ms=3.5, lw=1)
left.plot([0.5, 2.8], [0.5, 2.8], color="#6b6b75", lw=1, zorder=0)
left.set(xlabel="true force (N), spread out", ylabel="force found (N)", aspect="equal")
right.errorbar(*away.T, xerr=place_std.T[0], yerr=place_std.T[1], fmt="o", color="#0072b2",
               ms=3.5, lw=0.6, elinewidth=0.6)  # fmt: skip
right.plot(0, 0, "+", color="#d55e00", ms=14, mew=2)
right.set(xlabel="x off by (mm)", ylabel="y off by (mm)", aspect="equal")
for axes in (left, right):
    axes.spines[["top", "right"]].set_visible(False)
plt.show()

off = np.abs(force - forces) / force_std
print(f"{np.mean(off < 1):.0%} within one deviation, {np.mean(off < 1.96):.0%} within 1.96")
assert 0.85 <= np.mean(off < 1.96) <= 1.0  # 0.95, of 40
