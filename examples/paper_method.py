"""The method of the paper: half-space, stress at the taxels' centres, plain inverse on 20 x 20.

It finds less than the 2 N that press, although the truth is a half-space too: what lies between
the taxels is interpolated, and no solver can get it back.
"""

import numpy as np

import skinfield as sf

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
reconstruct = sf.Reconstructor(
    patch,
    layer,
    sf.Grid.square(patch, nodes=20),
    mechanics=sf.HalfSpace(),
    quantity=sf.BaseStress(pad_averaged=False),
    solver=sf.Inverse(),
    noise_std=400.0,  # Pa
)

ball = sf.simulate.Sphere(radius=15e-3, position=(12e-3, -10e-3), force=2.0)  # m, N
press = sf.simulate.press(layer, [ball], mechanics=sf.HalfSpace(point_forces=False))
stress = press.base_stress(patch.positions, pad_diameter=0.0)
noise = np.random.default_rng(0).normal(scale=400.0, size=len(patch))

estimate = reconstruct(stress + noise)
print(f"{estimate.normal_force:.2f} N in all, {len(estimate.contacts)} contact")
