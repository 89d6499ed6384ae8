"""
From a file to a table
======================

Any recording becomes an object with a picture, its answer a data frame. Here one that skinfield
makes by itself is written to a file, read back, and answered.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import skinfield as sf
from skinfield.files import save_recording

# %%
# Five small data sets come with their truth; all are made on the spot.

print(*sf.datasets.names(), sep="\n")
stroke = sf.datasets.load("stroke")
print(stroke.about)

# %%
# `skinfield.read` takes any recording, layout, calibration or result: what is in it says which.

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "stroke.csv"
    save_recording(stroke.recording, path)
    recording = sf.read(path)
recording.plot()
plt.show()

# %%
# Each third reading is answered; the contacts become a table with units in its head.

reconstruct = sf.Reconstructor(stroke.patch, stroke.layer, calibration=stroke.calibration)
chosen = slice(0, None, 3)
estimate = reconstruct(recording.counts[chosen], stamp_ns=recording.stamp_ns[chosen])
table = estimate.contacts.to_pandas()
table[["time_s", "force_N", "force_std_N", "x_m", "y_m", "shape"]].round(4).head()

# %%
# And a table becomes whatever pandas can do.

held = table[table.force_N > 1.0]
look = {"colormap": "magma_r", "figsize": (7.0, 4.0), "xlabel": "x (m)", "ylabel": "y (m)"}
axes = held.plot.scatter("x_m", "y_m", c="force_N", s=60, **look)
axes.set_aspect("equal")
plt.show()

print(f"{held.force_N.median():.2f} N in the middle of {len(held)} readings; 1.5 N is true")
assert 1.4 < held.force_N.median() < 1.6  # N
