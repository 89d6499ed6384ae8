"""A finger slides over the skin: one contact with one number, its speed, and when it moved."""

import numpy as np

import skinfield as sf
from skinfield.simulate import Sphere, press

PERIOD, NOISE = 0.02, 0.002  # s; ΔC/C₀
patch, layer = sf.layouts.hexagon72(), sf.Layer(young_modulus=100e3)
finger = press(layer, [Sphere(radius=6e-3, force=1.5)], extent=12e-3, cell=0.4e-3)

x = np.concatenate([np.full(10, -6e-3), np.linspace(-6e-3, 6e-3, 16), np.full(10, 6e-3)])
rng = np.random.default_rng(0)
reconstruct = sf.Reconstructor(patch, layer, solver=sf.ContactFit(), noise_std=NOISE)
tracker = sf.Tracker(period=PERIOD)

# the layer has no border: a press that is moved is read as by taxels moved the other way
readings = {
    place: finger.readings(patch.plane - (place, 5e-3), patch.pad_diameter, "capacitance")
    for place in set(x)
}
fastest = 0.0
for place in x:
    contacts = tracker(reconstruct(readings[place] + rng.normal(scale=NOISE, size=len(patch))))
    for event in tracker.events:
        print(f"{event.time:.2f} s: {event.kind} {event.ids}")
    fastest = max([fastest, *(contact.speed for contact in contacts)])

(contact,) = contacts
print(f"number {contact.track_id}: {contact.normal_force:.2f} ± {contact.force_std:.2f} N")
print(f"at rest for {contact.since_slip:.2f} s, touching for {contact.duration:.2f} s")
print(f"at {contact.position[0] * 1e3:.1f} mm, fastest {fastest * 1e3:.0f} mm/s")
