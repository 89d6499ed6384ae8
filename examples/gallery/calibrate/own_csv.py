"""
Your own array, from two CSV files
==================================

Where the taxels are, and what the board logged: that is all it takes to get newtons. The command
`skinfield new` asks for the same; here it is in Python, with two files that stand for yours.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.signal import Calibration, estimate_baseline
from skinfield.skin.reading import Recording

# %%
# `taxels.csv` has a row for each taxel, in mm; `log.csv` the time in seconds and a column of counts
# for each taxel.

folder = tempfile.TemporaryDirectory()
positions_csv, log_csv = Path(folder.name) / "taxels.csv", Path(folder.name) / "log.csv"


def write_files() -> None:
    """Write what a user has: 6 x 6 taxels, 8 s at 50 Hz, a press of 3 N from second 4 to 6."""
    x, y = (5.0 * axis.ravel() for axis in np.meshgrid(np.arange(6), np.arange(6)))
    np.savetxt(positions_csv, np.column_stack([x, y]), "%.2f", ",", header="x_mm,y_mm", comments="")
    time, rng = np.arange(0, 8, 0.02), np.random.default_rng(0)
    ball = sf.simulate.Sphere(radius=8e-3, position=(1e-3, -2e-3), force=3.0)
    places = np.column_stack([x, y]) * 1e-3 - 12.5e-3
    change = sf.simulate.press(sf.Layer(1.5e-3, 300e3), [ball]).capacitance(places, 4e-3)
    share = np.interp(time, [4, 4.3, 5.7, 6], [0, 1, 1, 0])
    counts = 8000 + 20_000 * share[:, None] * change + rng.normal(scale=30.0, size=(400, 36))
    names = ",".join(["t", *(f"ch{k}" for k in range(36))])
    table = np.column_stack([time, counts.round()])
    np.savetxt(log_csv, table, "%.2f", ",", header=names, comments="")


write_files()

# %%
# Read them; and say what covers the taxels: thickness, modulus and Poisson's ratio of the rubber.

positions = np.loadtxt(positions_csv, delimiter=",", skiprows=1) * 1e-3  # m
patch = sf.Patch(positions, pad_diameter=4e-3, name="my array")
layer = sf.Layer(thickness=1.5e-3, young_modulus=300e3, poisson_ratio=0.5)  # m, Pa
log = np.loadtxt(log_csv, delimiter=",", skiprows=1)
recording = Recording(np.round(log[:, 0] * 1e9).astype(np.int64), log[:, 1:], source="log.csv")

# %%
# Rest and noise are found in the first three seconds of the log. The gain is the board's, from its
# data sheet; without one, forces hold up to a factor, which
# :ref:`a load cell <sphx_glr_gallery_calibrate_scale.py>` finds.

rest = estimate_baseline(recording.counts, recording.rate, quiet=slice(0, 150))
calibration = Calibration.from_baseline(patch, rest, gain=20_000.0)

reconstruct = sf.Reconstructor(patch, layer, calibration=calibration)
every = slice(0, None, 10)
estimate = reconstruct(recording.counts[every], stamp_ns=recording.stamp_ns[every])

# %%

figure, (left, right) = plt.subplots(
    1, 2, figsize=(11.0, 4.2), width_ratios=(5, 4), layout="constrained"
)
recording.plot(left)
estimate[25].plot(right)
plt.show()

force = estimate.normal_force[23:28].mean()
print(f"{force:.2f} N while 3 N pressed, {estimate.normal_force[:15].max():.2f} N before")
assert abs(force - 3.0) < 0.3  # N
folder.cleanup()
