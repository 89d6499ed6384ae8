"""
Broken taxels found in a recording
==================================

A dead taxel, one that sticks and one that is noisy are found in a recording of ordinary touches,
with the evidence in words. Readings of the others go on being used.
"""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.signal import Verdict
from skinfield.simulate.pressing.press import readings_anywhere
from skinfield.skin.maps import draw_circles, draw_modules, extent_of_pads, frame_axes
from skinfield.skin.reading import Recording

# %%
# A finger strokes over the skin in all directions; it is one press, read by taxels that move.

RATE, NOISE, GAIN, REST = 50, 0.002, 2000.0, 1000.0  # Hz; ΔC/C₀; counts per ΔC/C₀; counts
patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa
ball = sf.simulate.Sphere(radius=8e-3, force=1.5)
press = sf.simulate.press(layer, [ball], extent=16e-3)
rng = np.random.default_rng(0)
corners = rng.uniform(-20e-3, 20e-3, (14, 2))
way = np.concatenate([np.linspace(a, b, 60) for a, b in pairwise(corners)])
points = (patch.plane[None] - way[:, None]).reshape(-1, 2)
felt = readings_anywhere(press, patch.pad_diameter, "capacitance")(points)
change = np.concatenate([np.zeros((100, len(patch))), felt.reshape(len(way), -1)])
counts = np.rint(REST + GAIN * (change + rng.normal(scale=NOISE, size=change.shape)))

# %%
# Break some, and look.

DEAD, STUCK, NOISY = 21, 40, 55
counts[:, DEAD] = REST
counts[400:, STUCK] = counts[400, STUCK]
counts[:, NOISY] += np.rint(rng.normal(scale=25.0, size=len(counts)))

faults = sf.find_faults(counts, patch)
for sentence in faults.sentences:
    print(sentence)

# %%

stamps = np.arange(len(counts), dtype=np.int64) * (10**9 // RATE)
figure, (left, right) = plt.subplots(
    1, 2, figsize=(11.0, 4.4), width_ratios=(3, 2), layout="constrained"
)
Recording(stamps, counts).plot(left, channels=[NOISY, DEAD, STUCK, 30])
frame_axes(right, patch, extent_of_pads(patch))
draw_modules(right, patch)
draw_circles(right, patch, faults.usable, facecolors="white", edgecolors="#6b6b75", lw=0.5)
draw_circles(right, patch, ~faults.usable, facecolors="#e24d34", edgecolors="#6b6b75", lw=0.5)
for taxel in np.flatnonzero(~faults.usable):
    name = Verdict(faults.verdict[taxel]).name.lower()
    right.annotate(name, patch.plane[taxel] * 1e3, (7, 5), textcoords="offset points", fontsize=8)
right.set_title("What is wrong, and where")
plt.show()

assert set(np.flatnonzero(~faults.usable)) == {DEAD, STUCK, NOISY}
