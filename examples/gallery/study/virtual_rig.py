"""
A test rig in software
======================

A rig presses a foam at four places and logs counts, as a lab would; what the readings give is
judged by what truly happened. So a method can be tried before the rig is built.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.simulate import rig
from skinfield.skin.maps import extent_of_pads, frame_axes, outline_pads

scenario = rig.Scenario(
    seed=4,
    layer=sf.Layer(thickness=2e-3, young_modulus=90e3, poisson_ratio=0.3),  # a foam
    tools=(rig.Tool(name="ball", indenter=sf.simulate.Sphere(radius=8e-3)),),
    places=(rig.Random(count=4),),
    loads=rig.Loads(forces=(1.0,)),
    profile=rig.LoadProfile(rest=1.0, hold=1.0, pause=0.5),
    solving=rig.ContactAccuracy(extent=16e-3, rungs=4),
)
run = rig.run_rig(scenario)
patch, truth = scenario.patch, run.truth

# %%
# Half a second of each press, held, is one reading.

reconstruct = sf.Reconstructor(patch, scenario.layer, calibration=run.skin.calibration)
time, counts = run.recording.time, run.recording.counts
true_place = np.column_stack([truth.press_x_m, truth.press_y_m])
place, force = np.full((len(true_place), 2), np.nan), np.zeros(len(true_place))
for press, end in enumerate(truth.press_release_s):
    reading = np.nanmean(counts[(time > end - 0.5) & (time < end)], axis=0)
    reconstruct.reset()
    for contact in reconstruct(reading).contacts[:1]:  # none where it was missed
        place[press], force[press] = contact.position[:2], contact.normal_force

# %%
# Left, circles are the truth and crosses what was found; right, the load cell of the rig.

figure, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.4), layout="constrained")
frame_axes(left, patch, extent_of_pads(patch))
outline_pads(left, patch)
left.plot(*true_place.T * 1e3, "o", mfc="none", mec="#0072b2", ms=14, mew=1.5)
left.plot(*place.T * 1e3, "x", color="#d55e00", ms=7, mew=1.5)
cell = run.load_cell
right.plot(
    (cell.stamp_ns - run.recording.stamp_ns[0]) / 1e9,
    cell.force,
    color="#6b6b75",
    lw=1,
    label="load cell",
)
right.plot(truth.press_release_s - 0.25, force, "x", color="#d55e00", ms=8, mew=1.5, label="skin")
right.set(xlabel="time (s)", ylabel="force (N)", ylim=(-0.05, 1.3))
right.spines[["top", "right"]].set_visible(False)
right.legend(frameon=False, loc="upper left", ncols=2)
plt.show()

off = np.hypot(*(place - true_place).T) * 1e3
newtons = np.abs(force - truth.press_force_N)
print(f"off by {np.nanmedian(off):.2f} mm and {np.median(newtons):.2f} N (medians)")
assert np.nanmedian(off) < 0.5  # mm
