"""
A control loop with a deadline
==============================

A finger is to press with 1 N, by what the skin says. Each cycle has 5 ms: `Reconstructor.into`
answers within its deadline, with the best so far, and allocates nothing.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.simulate import press_ladder

PERIOD, NOISE, GOAL = 0.02, 0.002, 1.0  # s; ΔC/C₀ of one reading; N

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3)  # m, Pa

# %%
# What the finger does: readings of eight forces are solved, those between are interpolated.

forces = np.geomspace(0.02, 2.0, 8)  # N
ball = sf.simulate.Sphere(radius=8e-3, position=(5e-3, 3e-3))
ladder = press_ladder(layer, ball, forces)
known = np.array([p.capacitance(patch.positions, patch.pad_diameter) for p in ladder])


def read(force: float) -> np.ndarray:
    """What the taxels read under a force, N."""
    felt = [np.interp(force, np.r_[0.0, forces], np.r_[0.0, taxel]) for taxel in known.T]
    return np.array(felt) + rng.normal(scale=NOISE, size=len(patch))


# %%
# The loop: an integrator, and a push from outside after two seconds.

rng = np.random.default_rng(0)
reconstruct = sf.Reconstructor(patch, layer, noise_std=NOISE)
contacts = reconstruct.rows()
true, seen, command = np.zeros(200), np.zeros(200), 0.0
for cycle in range(200):
    push = 0.6 if cycle >= 100 else 0.0
    true[cycle] = np.clip(command + push, 0.0, 2.0)
    stamp_ns = round(cycle * PERIOD * 1e9)
    count = reconstruct.into(read(true[cycle]), contacts, stamp_ns=stamp_ns, deadline=5e-3)
    seen[cycle] = contacts["normal_force"][:count].sum()
    command += 0.1 * (GOAL - seen[cycle])

# %%

time = np.arange(200) * PERIOD
figure, axes = plt.subplots(figsize=(8.6, 4.0), layout="constrained")
axes.plot(time, seen, color="#0072b2", lw=0.9, label="seen by the skin")
axes.plot(time, true, color="#1b1b1f", label="true")
axes.axhline(GOAL, color="#6b6b75", ls="--", lw=1, label="goal")
axes.axvline(2.0, color="#d55e00", lw=1)
axes.annotate("pushed with 0.6 N", (2.0, 0.1), (4, 0), textcoords="offset points", color="#d55e00")
axes.set(xlabel="time (s)", ylabel="force (N)", xlim=(0, 4), ylim=(0, None))
axes.spines[["top", "right"]].set_visible(False)
axes.legend(frameon=False, ncols=3, loc="upper left")
plt.show()

print(f"{np.median(true[-50:]):.2f} N in the last second, {GOAL} N asked for")
assert abs(np.median(true[-50:]) - GOAL) < 0.1  # N
