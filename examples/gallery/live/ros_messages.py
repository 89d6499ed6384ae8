"""
Messages of ROS 2, without ROS
==============================

Contacts become the messages that `skinfield run --ros2` publishes, byte for byte; no ROS is
installed for that. Read back, they say the same to seven digits.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.files.ros import RosbagKinds
from skinfield.files.ros.messages import SkinMessages

NOISE = 0.002  # ΔC/C₀ of one reading

patch = sf.layouts.hexagon72()
presses = [((8e-3, -6e-3), 2.0), ((-10e-3, 7e-3), 1.2)]  # m, N
balls = [sf.simulate.Sphere(radius=8e-3, position=place, force=f) for place, f in presses]
readings = sf.simulate.press(sf.Layer(), balls).capacitance(patch.positions, patch.pad_diameter)
readings += np.random.default_rng(0).normal(scale=NOISE, size=len(patch))

# %%
# Contacts as rows of an array, as loops have them, and their messages: all contacts, the wrench on
# the patch, a frame for each contact.

reconstruct = sf.Reconstructor(patch, noise_std=NOISE)
rows = reconstruct.rows()
count = reconstruct.into(readings, rows, stamp_ns=1_000_000_000)
kinds = RosbagKinds()
messages = SkinMessages(sf.Skin((patch,)), kinds)
sent = {
    message.topic: (message.kind, kinds.bytes_of(message.kind, message.message))
    for message in messages.of_contacts([1_000_000_000], rows[:count], [True])
}
for topic, (kind, data) in sent.items():
    print(f"{topic}: {kind}, {len(data)} bytes")

# %%
# Any reader of ROS 2 takes these bytes; here rosbags.

kind, data = sent["/skin/contacts"]
received: Any = kinds.store.deserialize_cdr(data, kind)
for contact in received.contacts:
    x, y = contact.position.x * 1e3, contact.position.y * 1e3
    force, std = contact.normal_force, contact.force_std
    print(f"{force:.3f} ± {std:.3f} N, {contact.shape} at ({x:.1f}, {y:.1f}) mm")

# %%
# What was received, beside the field that the same reading gives.

axes = reconstruct(readings).plot()
for contact in received.contacts:
    x, y = contact.position.x * 1e3, contact.position.y * 1e3
    words = f"{contact.contact_frame}\nforce.z = {contact.wrench.force.z:.2f} N"
    axes.annotate(words, (x, y), (14, -30), textcoords="offset points", color="#d55e00", fontsize=8)
plt.show()

kind, data = sent[f"/skin/{patch.name}/wrench"]
stamped: Any = kinds.store.deserialize_cdr(data, kind)
assert np.isclose(-stamped.wrench.force.z, rows["normal_force"][:count].sum())  # N
