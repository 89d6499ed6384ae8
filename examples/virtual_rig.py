"""A rig in software: presses in raw counts of a board, reconstructed, and judged by the truth."""

import numpy as np

import skinfield as sf
from skinfield.files import readings_for
from skinfield.simulate import rig

scenario = rig.Scenario(
    seed=4,
    layer=sf.Layer(thickness=2e-3, young_modulus=90e3, poisson_ratio=0.3),  # a foam
    tools=(rig.Tool(name="ball", indenter=sf.simulate.Sphere(radius=8e-3)),),
    places=(rig.OverTaxels(), rig.Random(count=2)),
    loads=rig.Loads(forces=(1.0,)),
    profile=rig.LoadProfile(rest=1.0, hold=1.0, pause=0.5),
    solving=rig.ContactAccuracy(extent=16e-3, rungs=4),
)
run = rig.run_rig(scenario)  # run.recording is an ordinary recording, run.load_cell a force's

patch, change = scenario.patch, run.skin.calibration.relative_capacitance_from_counts
recording = readings_for(run.recording, scenario.patch)
grid = sf.Grid.square(patch, nodes=20)
noise = run.skin.calibration.quantity_std()
reconstruct = sf.Reconstructor(patch, scenario.layer, grid, noise_std=noise)

truth = run.truth
for press, end in enumerate(truth.press_release_s):
    held = (recording.time > end - 0.5) & (recording.time < end)
    reading = np.nanmean(change(recording.counts[held]), axis=0)  # half a second, held
    contacts = reconstruct(reading).contacts
    place = np.array([truth.press_x_m[press], truth.press_y_m[press]])
    true = f"true {truth.press_force_N[press]:.2f} N"
    if not contacts:
        print(f"{true}: missed")
        continue
    off = np.hypot(*(contacts[0].position[:2] - place)) * 1e3
    print(f"{true}: {off:.1f} mm off, found {contacts[0].normal_force:.2f} N")
