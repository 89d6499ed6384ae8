"""A press of 0.2 N comes and goes in the noise of single readings; a filter holds it."""

import numpy as np

import skinfield as sf
from skinfield.signal import Exponential, NoFilter, filtered

RATE = 50.0  # readings per second
NOISE = 0.002  # ΔC/C₀ of one reading

patch = sf.layouts.hexagon72()
ball = sf.simulate.Sphere(radius=15e-3, position=(12e-3, -10e-3), force=0.2)  # m, N
press = sf.simulate.press(sf.Layer(), [ball])
clean = press.capacitance(patch.positions, patch.pad_diameter)
raw = clean + np.random.default_rng(0).normal(scale=NOISE, size=(100, len(patch)))

grid = sf.Grid.square(patch, nodes=20)
for choice in (NoFilter(), Exponential(time_constant=0.1)):
    reconstruct = sf.Reconstructor(patch, grid=grid, noise_std=NOISE * choice.noise_factor(RATE))
    estimate = reconstruct(filtered(choice, raw, RATE)[50:])
    force = [sum(contact.normal_force for contact in found) for found in estimate.contacts]
    print(
        f"{type(choice).__name__}: seen in {np.mean(np.array(force) > 0):.0%} of the readings, "
        f"{np.mean(force):.2f} ± {np.std(force):.2f} N, {choice.delay(RATE) * 1e3:.0f} ms late"
    )
