"""
Tracks
======

Two fingers slide over the skin and pass each other. :class:`~skinfield.Tracker` follows them from
reading to reading: each keeps its number, with a filtered place, force and speed.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.simulate.pressing.press import readings_anywhere
from skinfield.skin.maps import draw_modules, extent_of_pads, frame_axes, outline_pads

PERIOD, NOISE = 0.02, 0.002  # s; ΔC/C₀ of one reading

patch, layer = sf.layouts.hexagon72(), sf.Layer(thickness=2e-3, young_modulus=100e3)  # m, Pa

# %%
# Each press is solved once: the layer has no border, so a press that moves is read as by taxels
# that move the other way. 1.5 N slides to the right above, 1 N to the left below.

firm, light = (
    readings_anywhere(
        sf.simulate.press(layer, [sf.simulate.Sphere(radius=6e-3, force=force)], extent=12e-3),
        patch.pad_diameter,
        "capacitance",
    )
    for force in (1.5, 1.0)  # N
)
x = np.linspace(-18e-3, 18e-3, 40)
paths = np.stack([np.column_stack([x, 12e-3 - 0 * x]), np.column_stack([-x, -12e-3 - 0 * x])])
clean = [firm(patch.plane - one) + light(patch.plane - other) for one, other in zip(*paths)]

# %%
# Reconstruct each reading, and hand what touches to the tracker.

rng = np.random.default_rng(0)
reconstruct = sf.Reconstructor(patch, layer, solver=sf.ContactFit(), noise_std=NOISE)
tracker = sf.Tracker(period=PERIOD)
tracks: dict[int, list[tuple[float, ...]]] = {}
for step in range(len(x)):
    noise = rng.normal(scale=NOISE, size=len(patch))
    for contact in tracker(reconstruct(clean[step] + noise)):
        row = (*contact.position[:2], contact.normal_force)
        tracks.setdefault(contact.track_id, []).append(row)
tracks = {number: rows for number, rows in tracks.items() if len(rows) > 10}  # false ones are brief

# %%
# Where they went and how hard they pressed; dashed is the truth.

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.4), layout="constrained")
frame_axes(left, patch, extent_of_pads(patch))
draw_modules(left, patch)
outline_pads(left, patch)
for colour, (number, rows) in zip(("#0072b2", "#d55e00"), tracks.items()):
    east, north, force = np.array(rows).T
    left.plot(east * 1e3, north * 1e3, color=colour, lw=2)
    right.plot(np.arange(len(force)) * PERIOD, force, color=colour, label=f"Number {number}")
for path, force in zip(paths, (1.5, 1.0)):
    left.plot(*path.T * 1e3, "k--", lw=0.8)
    right.axhline(force, color="k", ls="--", lw=0.8)
right.set(xlabel="Time (s)", ylabel="Normal force (N)", ylim=(0, 2.5))
right.spines[["top", "right"]].set_visible(False)
right.legend(frameon=False)
plt.show()

forces = [np.array(rows)[:, 2].mean() for rows in tracks.values()]
print("mean force:", ", ".join(f"{force:.2f} N" for force in forces))
assert np.allclose(forces, (1.5, 1.0), atol=0.15)  # N
