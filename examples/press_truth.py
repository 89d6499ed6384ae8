"""Ground truth: two presses on the same skin, and closed forms beside what the solver finds.

The contact solver knows no formula for a ball; the integral equation knows no grid; Hertz's formula
knows no layer.
"""

from dataclasses import replace

import numpy as np

import skinfield as sf
from skinfield.elastic import axisymmetric

layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
ball = sf.simulate.Sphere(radius=6e-3, force=1.0)  # m, N
found = sf.simulate.press(layer, [ball], extent=16e-3)
exact = axisymmetric.indent_by_force(layer, axisymmetric.Ball(radius=6e-3), 1.0)
modulus = layer.young_modulus / (1 - layer.poisson_ratio**2)
hertz = (9 * 1.0**2 / (16 * modulus**2 * 6e-3)) ** (1 / 3)  # m

radius = np.sqrt(found.contact_area / np.pi)
print(f"contact radius: {radius * 1e3:.3f} mm, exact {exact.contact_radius * 1e3:.3f} mm")
print(f"Hertz, who has no layer: {hertz * 1e3:.3f} mm deep")
print(f"exact: {exact.depth * 1e3:.4f} mm deep; found: {found.approach[0] * 1e3:.4f} mm deep")

# What has no formula: a leaning cylinder beside the ball; the ball pushed sideways until it slips.
stamp = sf.simulate.Cylinder(
    radius=4e-3, edge_radius=1e-3, position=(9e-3, 0.0), tilt=(0.0, np.radians(2.0)), force=2.0
)
both = sf.simulate.press(layer, [ball, stamp], extent=30e-3)
print(f"with a leaning cylinder: {both.force:.3f} N on {both.contact_area * 1e6:.0f} mm²")
dragged = replace(ball, shear=(0.5, 0.0))
slid = sf.simulate.press(layer, [dragged], extent=16e-3, friction=0.8)
print(f"under 0.5 N of shear {slid.slipping_share:.0%} of the contact slips")
