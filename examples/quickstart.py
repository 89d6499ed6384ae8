"""From raw readings to contacts in newtons and metres: a ball pressed on the paper's patch."""

import numpy as np

import skinfield as sf

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
grid = sf.Grid.square(patch, nodes=40)
reconstruct = sf.Reconstructor(patch, layer, grid, quantity=sf.Capacitance(), noise_std=0.002)

ball = sf.simulate.Sphere(radius=15e-3, position=(12e-3, -10e-3), force=2.0)  # m, N
press = sf.simulate.press(layer, [ball])
clean = press.capacitance(patch.positions, patch.pad_diameter)
readings = clean + np.random.default_rng(0).normal(scale=0.002, size=len(patch))

estimate = reconstruct(readings)
for contact in estimate.contacts:
    x, y, _ = contact.position * 1e3
    print(f"{contact.normal_force:.2f} N at x = {x:.1f} mm, y = {y:.1f} mm")
