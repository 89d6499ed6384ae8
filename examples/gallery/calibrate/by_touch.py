"""
Calibrate by touching
=====================

Forty touches of anything round, anywhere, and nothing known of them: they tell the thickness of
the layer and the gain of each taxel, as every touch is read by several.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

NOISE, COUNT = 0.001, 40  # ΔC/C₀ of one reading; presses
rng = np.random.default_rng(0)

patch = sf.layouts.rectangular(rows=5, columns=5, pitch=5e-3, pad_diameter=4e-3)
truly = sf.Layer(thickness=2.3e-3, young_modulus=150e3, poisson_ratio=0.48)  # m, Pa
true_gain = np.exp(rng.normal(scale=0.1, size=len(patch)))

# %%
# Five kinds of press, each set down at eight places; each taxel reads with a gain of its own.

kinds = zip((4e-3, 6e-3, 6e-3, 9e-3, 9e-3), (0.6, 0.8, 1.5, 1.5, 2.5))  # m, N
presses = [
    sf.simulate.press(truly, [sf.simulate.Sphere(radius=radius, force=force)], extent=16e-3)
    for radius, force in kinds
]
places = rng.uniform(-11e-3, 11e-3, (COUNT, 2))
readings = np.array(
    [
        presses[number % 5].capacitance(patch.plane - place, patch.pad_diameter)
        for number, place in enumerate(places)
    ]
)
readings = true_gain * readings + rng.normal(scale=NOISE, size=readings.shape)

# %%
# Said is a layer of 2 mm; the touches know better.

found = sf.calibrate.touch(patch, readings, noise_std=NOISE)
print(found.verdict)

# %%

figure, (left, right) = plt.subplots(
    1, 2, figsize=(7.4, 4.4), width_ratios=(4, 1), layout="constrained"
)
gain = true_gain / np.exp(np.log(true_gain).mean())  # their common factor goes with the force
left.errorbar(gain, found.gain, found.gain_std, fmt="o", color="#0072b2", ms=4, lw=1)
left.axline((1, 1), slope=1, color="#6b6b75", lw=1, zorder=0)
left.set(xlabel="true gain of a taxel", ylabel="gain found", aspect="equal")
right.errorbar([0], [found.thickness * 1e3], [found.thickness_std * 1e3], fmt="o", color="#0072b2")
right.axhline(truly.thickness * 1e3, color="#6b6b75", lw=1)
right.axhline(2.0, color="#d55e00", lw=1, ls="--")
right.annotate("true", (-0.55, truly.thickness * 1e3), (0, 3), textcoords="offset points")
right.annotate("stated", (-0.55, 2.0), (0, 3), textcoords="offset points", color="#d55e00")
right.set(ylabel="thickness (mm)", xticks=[], xlim=(-0.6, 0.6), ylim=(1.9, 2.5))
for axes in (left, right):
    axes.spines[["top", "right"]].set_visible(False)
plt.show()

left_over = np.std(np.log(found.gain / gain))
print(f"gains differ by {np.std(np.log(gain)):.1%}; after the calibration by {left_over:.1%}")
assert left_over < 0.07
assert abs(found.thickness - truly.thickness) < 3 * found.thickness_std
