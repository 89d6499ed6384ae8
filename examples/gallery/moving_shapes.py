"""
Shapes that sharpen as they move
================================

One reading knows little between taxels. A stamp that moves over the skin is seen by other taxels in
each reading, and its image sharpens: with its poses known to the robot, or found along with it.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.simulate.pressing.press import readings_anywhere

NOISE, FORCE, PIXEL = 0.002, 5.0, 0.2e-3  # ΔC/C₀ of one reading; N; m

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa

# %%
# A stamp of the letter L, 12 mm by 16 mm, with strokes of 4 mm. It is pressed once, and read
# wherever the taxels are as seen from it.

axis = np.arange(-10e-3, 10e-3, PIXEL) + PIXEL / 2
x, y = np.meshgrid(axis * 1e3, axis * 1e3)
letter = (np.abs(x + 4) < 2) & (np.abs(y) < 8) | (np.abs(x) < 6) & (np.abs(y + 6) < 2)
heights = np.where(letter, 0.0, np.nan)
stamp = sf.simulate.HeightMap(heights=heights, pixel=PIXEL, force=FORCE)
press = sf.simulate.press(layer, [stamp], extent=24e-3, cell=0.25e-3)
clean = readings_anywhere(press, patch.pad_diameter, "capacitance", spacing=0.5e-3)

# %%
# It goes a round way, a pitch wide, and turns by some degrees to and fro.

turn = np.linspace(0.0, 2 * np.pi, 30)
poses = np.column_stack([2.7e-3 * np.cos(turn), 2.7e-3 * np.sin(turn), 0.4 + 0.2 * np.sin(turn)])
rng = np.random.default_rng(0)
readings = []
for place_x, place_y, angle in poses:  # m, m, rad
    cos, sin = np.cos(angle), np.sin(angle)
    seen = (patch.plane - (place_x, place_y)) @ np.array([[cos, -sin], [sin, cos]])
    readings.append(clean(seen) + rng.normal(scale=NOISE, size=len(patch)))

# %%
# Images after 1, 10 and 30 readings; above the poses are given, below they are found.

reconstruct = sf.Reconstructor(patch, layer, noise_std=NOISE)
figure, table = plt.subplots(2, 3, figsize=(12.6, 8.4))
figure.subplots_adjust(0.06, 0.08, 0.94, 0.92, wspace=0.5, hspace=0.45)
last = {}
for known, row in zip((True, False), table):
    images = sf.ContactImages(reconstruct)
    for count, (reading, pose) in enumerate(zip(readings, poses), start=1):
        images.update(reading, poses=pose if known else None)
        if count in (1, 10, 30):
            image = last[known] = images.images[0]
            axes = image.plot(row[(1, 10, 30).index(count)])
            if known:
                for line in press.outline:
                    axes.plot(*line.T * 1e3, color="#0072b2", lw=1.2, ls="--")
    row[0].set_ylabel(f"poses {'given' if known else 'found'}; y of the body (mm)")
plt.show()

image = last[True]
print(f"{image.area * 1e6:.0f} mm² of {press.contact_area * 1e6:.0f}; {image.force:.2f} N")
assert abs(image.area / press.contact_area - 1) < 0.15
assert abs(image.force / FORCE - 1) < 0.1
