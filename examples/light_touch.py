"""A touch of 0.1 N that no single reading shows is found in live readings, with its place."""

import numpy as np

import skinfield as sf

RATE = 50.0  # readings per second
NOISE = 3.8e3  # Pa of one reading; 0.1 N over a taxel raises it by 5.8e3

patch = sf.layouts.hexagon72()
layer = sf.Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)
detector = sf.Detector(patch, layer, quantity=sf.BaseStress(), noise_std=NOISE)
stream = detector.stream(window=0.3, rate=RATE)

x, y = patch.plane[30]
ball = sf.simulate.Sphere(radius=6e-3, position=(x, y), force=0.1)  # m, N
touch = sf.simulate.press(layer, [ball]).base_stress(patch.positions, patch.pad_diameter)

rng = np.random.default_rng(2)
seen = []
for index in range(65):  # the touch begins with the 50th
    reading = rng.normal(scale=NOISE, size=len(patch)) + (touch if index >= 50 else 0.0)
    found = stream.update(reading, stamp_ns=round(index / RATE * 1e9))
    if found.detected:
        seen.append((index - 49) / RATE)

off = np.linalg.norm(found.position[:2] - [x, y])
print(f"first seen {seen[0]:.2f} s after touch; at 0.30 s probability {found.probability:.2f},")
print(f"place ± {found.position_std * 1e3:.1f} mm, {off * 1e3:.1f} mm off")
