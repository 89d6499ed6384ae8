"""
How true is the ground truth?
=============================

Every simulated press is solved on a grid that knows no formula. For a ball there is one, an
integral equation of its own: contact radius and depth agree to parts in a thousand.
"""

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.elastic import axisymmetric

RADIUS = 6e-3  # m
layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
forces = np.array([0.1, 0.3, 0.6, 1.0, 1.5])  # N

# %%
# Three answers: the solver's on a grid; the integral equation's; and Hertz's, who has no layer.

found = sf.simulate.press_ladder(layer, sf.simulate.Sphere(radius=RADIUS), forces, extent=16e-3)
body = axisymmetric.Ball(radius=RADIUS)
exact = [axisymmetric.indent_by_force(layer, body, force) for force in forces]
modulus = layer.young_modulus / (1 - layer.poisson_ratio**2)
hertz = (9 * forces**2 / (16 * modulus**2 * RADIUS)) ** (1 / 3)  # m

depth = np.array([press.approach[0] for press in found])
exact_depth = np.array([each.depth for each in exact])

# %%
# Right, the pressure of the highest force along a line through the middle, and the pressed area.

figure, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.2), layout="constrained")
left.plot(exact_depth * 1e3, forces, color="#6b6b75", lw=3, alpha=0.5, label="integral equation")
left.plot(depth * 1e3, forces, "o", color="#0072b2", label="simulated on a grid")
left.plot(hertz * 1e3, forces, color="#d55e00", ls="--", label="Hertz, without a layer")
left.set(xlabel="depth (mm)", ylabel="force (N)", ylim=(0, None))
left.legend(frameon=False)
press = found[-1]
rows, columns = press.grid.shape
line = press.pressure.reshape(rows, columns)[rows // 2] / 1e3
right.step(press.grid.plane[:columns, 0] * 1e3, line, where="mid", color="#0072b2")
for side in (-1, 1):
    right.axvline(side * exact[-1].contact_radius * 1e3, color="#6b6b75", ls="--", lw=1)
right.set(xlabel="x (mm)", ylabel="pressure (kPa)", ylim=(0, None))
right.set_title(f"{forces[-1]} N; dashed: exact rim", fontsize=10)
for axes in (left, right):
    axes.spines[["top", "right"]].set_visible(False)
plt.show()

off = np.abs(depth / exact_depth - 1).max()
print(f"depth of 1 N: {depth[3] * 1e3:.4f} mm, exact {exact_depth[3] * 1e3:.4f} mm; "
      f"Hertz {hertz[3] * 1e3:.3f} mm")  # fmt: skip
assert 0.5195e-3 < depth[3] < 0.5205e-3  # m; the integral equation has 0.5200
assert off < 2e-3
