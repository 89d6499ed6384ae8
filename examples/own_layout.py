"""A sensor of one's own: 8 x 8 taxels at 4 mm under 1.5 mm of stiffer rubber; writes a figure."""

import numpy as np

import skinfield as sf
from skinfield.estimate.plot import draw_estimate
from skinfield.plot import save

x, y = np.meshgrid(np.arange(8) * 4e-3, np.arange(8) * 4e-3)
patch = sf.Patch(np.column_stack([x.ravel(), y.ravel()]), pad_diameter=3e-3, name="my array")
layer = sf.Layer(thickness=1.5e-3, young_modulus=300e3, poisson_ratio=0.48)
solver = sf.GaussianField(length_scale=2e-3)  # how fast pressure may change
grid = sf.Grid.square(patch, nodes=29)
reconstruct = sf.Reconstructor(patch, layer, grid, solver=solver, noise_std=0.001)

foot = sf.simulate.Cylinder(radius=4e-3, position=(15e-3, 11e-3), force=3.0)  # m, N
press = sf.simulate.press(layer, [foot], extent=40e-3)
clean = press.capacitance(patch.positions, patch.pad_diameter)
readings = clean + np.random.default_rng(0).normal(scale=0.001, size=len(patch))

estimate = reconstruct(readings)
save(draw_estimate(estimate, readings), "own_layout.png")
print(f"{estimate.contacts[0].normal_force:.2f} N, drawn in own_layout.png")
