"""
A live loop with tracks
=======================

What `skinfield run` does in a process of its own, in a loop of yours: an engine answers each
reading within its budget, and contacts keep their number while they move.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.skin.maps import extent_of_pads, frame_axes, outline_pads

# %%
# A finger strokes over the skin; the recording takes the place of the board.

stroke = sf.datasets.load("stroke")
engine = sf.Engine(stroke.patch, stroke.layer, calibration=stroke.calibration, budget=20e-3)
tracker = sf.Tracker(period=1 / stroke.recording.rate)

# %%
# The loop. Beside a running engine, `with sf.connect() as live: for estimate in live: ...` gives
# the same contacts from its shared memory.

rows, spent = [], []
for stamp_ns, counts in zip(stroke.recording.stamp_ns, stroke.recording.counts):
    estimates = engine([counts], stamp_ns=stamp_ns)
    spent.append(estimates.report.spent * 1e3)  # ms
    for contact in tracker(estimates[stroke.patch.name]):
        rows.append((stamp_ns, contact.track_id, *contact.position[:2], contact.normal_force))

# %%
# Where it went, on the skin; and how hard it pressed.

stamps, numbers, x, y, force = np.array(rows).T
time = (stamps - stroke.recording.stamp_ns[0]) / 1e9
figure, (left, right) = plt.subplots(1, 2, figsize=(10.6, 4.4), layout="constrained")
frame_axes(left, stroke.patch, extent_of_pads(stroke.patch))
outline_pads(left, stroke.patch)
dots = left.scatter(x * 1e3, y * 1e3, c=time, s=22, cmap="viridis", zorder=5)
figure.colorbar(dots, ax=left, label="time (s)", shrink=0.8)
right.plot(time, force, ".", color="#0072b2", label="found")
right.plot(stroke.recording.time, stroke.force[:, 0], color="#6b6b75", lw=1, label="truth")
right.set(xlabel="time (s)", ylabel="force (N)", ylim=(0, 2))
right.spines[["top", "right"]].set_visible(False)
right.legend(frameon=False)
plt.show()

print(f"{len(spent)} readings, {np.median(spent):.1f} ms each (median)")
held = (time > 2) & (time < 4)
print(f"{np.median(force[held]):.2f} N, contact {np.unique(numbers[held]).astype(int)}")
assert abs(np.median(force[held]) - 1.5) < 0.1  # N
