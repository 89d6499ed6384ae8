"""
Light touch
===========

A touch of 0.15 N is lost in the noise of a single reading. :class:`~skinfield.Detector` finds it,
at a stated rate of false alarms, from several readings and all that the layer says about touches.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf

RATE, NOISE = 50.0, 3.8e3  # readings per second; Pa of one reading

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)  # m, Pa
detector = sf.Detector(
    patch, layer, quantity=sf.BaseStress(), noise_std=NOISE, false_alarm_rate=1e-3
)

# %%
# A small ball over taxel 30, from the second second on.

TAXEL, BEGINS, COUNT = 30, 50, 100
ball = sf.simulate.Sphere(radius=6e-3, position=tuple(patch.plane[TAXEL]), force=0.15)  # m, N
touch = sf.simulate.press(layer, [ball]).base_stress(patch.positions, patch.pad_diameter)
readings = np.random.default_rng(2).normal(scale=NOISE, size=(COUNT, len(patch)))
readings[BEGINS:] += touch

# %%
# The stream looks back over 0.3 s with each new reading.

stream = detector.stream(window=0.3, rate=RATE)
time = np.arange(COUNT) / RATE
found = [stream.update(reading, stamp_ns=round(t * 1e9)) for reading, t in zip(readings, time)]
detected = np.array([each.detected for each in found])
delay = time[detected][0] - time[BEGINS]
print(f"seen after {delay:.2f} s; before the touch {detected[:BEGINS].sum()} false alarms")

# %%
# Above, the taxel that is touched: nothing that an eye would trust. Below, what the detector makes
# of all taxels: the probability that something touches.

figure, (above, below) = plt.subplots(2, 1, figsize=(9.6, 5.0), sharex=True, layout="constrained")
above.plot(time, readings[:, TAXEL] / 1e3, color="#6b6b75")
above.set_ylabel(f"Taxel {TAXEL} (kPa)")
below.plot(time, [each.probability for each in found], color="#0072b2")
below.fill_between(time, 0, 1, where=detected, color="#0072b2", alpha=0.15, lw=0)
below.set(xlabel="Time (s)", ylabel="Probability of touch", ylim=(0, 1.03), xlim=(0, time[-1]))
for axes in (above, below):
    axes.axvline(time[BEGINS], color="#d55e00", ls="--", lw=1)
    axes.spines[["top", "right"]].set_visible(False)
above.annotate("0.15 N from here", (time[BEGINS], above.get_ylim()[1]), (4, -8),
               textcoords="offset points", color="#d55e00")  # fmt: skip
plt.show()

assert not detected[:BEGINS].any()
assert delay < 0.3  # s
