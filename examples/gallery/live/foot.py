"""
A foot steps
============

A step on a sole of 112 taxels: heel first, then the ball. The contacts of each reading give the
load and the centre of pressure, the point that balances a walking robot.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.skin.maps import draw_circles, extent_of_pads, frame_axes

step = sf.datasets.load("foot_step")
print(step.about)

# %%
# Every third reading, by itself. Readings without load have no centre.

reconstruct = sf.Reconstructor(step.patch, step.layer, calibration=step.calibration)
chosen = slice(0, None, 3)
time = step.recording.time[chosen]
force = np.zeros(len(time))
centre = np.full((len(time), 2), np.nan)
for row, counts in enumerate(step.recording.counts[chosen]):
    reconstruct.reset()
    contacts = reconstruct(counts).contacts
    force[row] = contacts.normal_force
    if force[row] > 2.0:  # N
        load = np.array([c.normal_force for c in contacts])
        centre[row] = load @ np.array([c.position[:2] for c in contacts]) / load.sum()

# %%
# The truth is dashed.

true_force = step.force[chosen].sum(axis=1)
with np.errstate(invalid="ignore"):
    weighted = np.einsum("tp,tpc->tc", step.force[chosen], step.place[chosen])
    true_centre = weighted / true_force[:, None]
figure, (left, right) = plt.subplots(
    1, 2, figsize=(9.6, 5.2), width_ratios=(1, 2), layout="constrained"
)
frame_axes(left, step.patch, extent_of_pads(step.patch))
draw_circles(left, step.patch, facecolors="#f5f5f8", edgecolors="#c9c9d1", lw=0.5)
left.plot(*true_centre.T * 1e3, "k--", lw=0.8)
dots = left.scatter(*centre.T * 1e3, c=time, s=14, cmap="viridis", zorder=3)
figure.colorbar(dots, ax=left, label="time (s)", location="left", shrink=0.6)
left.set_title("Centre of pressure")
right.plot(time, force, color="#0072b2", label="found")
right.plot(time, true_force, "k--", lw=0.8, label="truth")
right.set(xlabel="time (s)", ylabel="load (N)", xlim=(0, time[-1]), ylim=(-2, None))
right.spines[["top", "right"]].set_visible(False)
right.legend(frameon=False)
plt.show()

loaded = true_force > 10.0
off = np.nanmedian(np.hypot(*(centre - true_centre)[loaded].T)) * 1e3
highest, truly = force.max(), true_force.max()
print(f"centre off by {off:.1f} mm (median), at most {highest:.0f} N; {truly:.0f} N true")
assert off < 3.0  # mm
