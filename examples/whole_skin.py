"""A robot's skin within half a millisecond: one budget for all patches."""

from dataclasses import replace

import numpy as np

import skinfield as sf

hexagon = sf.layouts.hexagon72()
skin = sf.Skin(tuple(replace(hexagon, name=f"arm {i}") for i in range(20)))
engine = sf.Engine(skin, budget=500e-6, noise_std=0.002)  # s, for all patches

ball = sf.simulate.Sphere(radius=6e-3, position=(12e-3, -10e-3), force=1.5)  # m, N
clean = sf.simulate.press(sf.Layer(), [ball]).capacitance(hexagon.positions, hexagon.pad_diameter)
rng = np.random.default_rng(0)

for _ in range(50):  # a robot's loop
    readings = {patch.name: rng.normal(scale=0.002, size=len(patch)) for patch in skin}
    readings["arm 7"] += clean
    report = engine(readings).report
print(f"{report.spent * 1e6:.0f} µs spent, {len(report.idle)} patches idle")

estimates = engine(readings, budget=50e-3)  # the last readings again, without hurry
report = estimates.report
for name in (each.name for each in report if each.answer != "idle"):
    print(
        f"{name}: {report[name].answer} on {report[name].rung} nodes a side {report[name].skipped}"
    )
    for contact in estimates[name].contacts:
        x, y, _ = contact.position * 1e3
        print(f"{contact.normal_force:.2f} N at x = {x:.1f} mm, y = {y:.1f} mm")
