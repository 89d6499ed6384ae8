"""A ring with a skin of two patches whose contacts are known: for tests of ROS 2."""

import time

import numpy as np
from recorder_ring import Engine

from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.slots import CycleHead
from skinfield.signal import Kind
from skinfield.skin import Patch, Skin

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # x to y
MOVE = np.array([0.1, 0.2, 0.3])
TAXELS = (6, 4)


def two_patches() -> Skin:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = TURN, MOVE
    plane = np.array([(i % 3, i // 3) for i in range(6)], float) * 5e-3
    return Skin(
        (
            Patch(plane, name="left palm", link="l_hand", link_from_patch=pose),
            Patch(plane[:4], name="2nd-finger"),
        ),
        name="hand",
    )


def contact(patch: int, track: int, force: float, place, normal=(0.0, 0.0, 1.0)):
    row = np.zeros((), CONTACT)
    row["patch"], row["track"], row["normal_force"] = patch, track, force
    row["position"], row["normal"] = place, normal
    row["force_std"], row["place_std"], row["area"] = 0.1, 2e-4, 3e-5
    row["peak_pressure"], row["age"], row["speed"] = 4e4, 0.5, 1e-3
    row["shape"], row["maybe"], row["radius"] = 2, 2, 4e-3
    return row


class TwoPatches(Engine):
    """Publishes cycles with the contacts that it is told."""

    def __init__(self, name: str = "") -> None:
        super().__init__(two_patches(), name, slots=16, log_bytes=1 << 16)

    def cycle(self, contacts=(), stamps_ns=None, answers=(2, 2), invalid=(), counts=None):
        now = time.time_ns()
        if counts is not None:
            self.blocks.clear()
            self.blocks.put(now, 0, counts, Kind.SHORTS)
            self.ring.log(self.blocks.data)
        slot = self.begin(now)
        slot.head[CycleHead.FRESH] = 2
        slot.patches["answer"] = answers
        slot.patches["fresh"] = TAXELS
        slot.patches["stamp_ns"] = (now, now) if stamps_ns is None else stamps_ns
        slot.values[:] = np.arange(sum(TAXELS))
        slot.valid[list(invalid)] = 0
        slot.patches["invalid"][0] = len(invalid)
        for place in range(2):
            its = [row for row in contacts if row["patch"] == place]
            slot.patches["contacts"][place] = len(its)
            slot.patches["force"][place] = sum(float(row["normal_force"]) for row in its)
            for at, row in enumerate(its):
                slot.contacts[place, at] = row
        self.publish()
