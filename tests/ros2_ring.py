"""A ring with a skin of two patches whose contacts are known: for tests of ROS 2."""

import time

import numpy as np
from recorder_ring import NoSource

from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.model_config import Configuration, ModelConfig, write_configuration
from skinfield.loop.ring_fields import description_of, status_fields
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import PATCH, Head, Sizes, Slot
from skinfield.ring import Ring, State
from skinfield.signal import Blocks, Kind, Port
from skinfield.skin import Patch, Skin

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # x to y
MOVE = np.array([0.1, 0.2, 0.3])
TAXELS = (6, 4)
ROOM = (16, 1 << 16)  # slots, bytes of the log


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
    return row


class TwoPatches:
    """Publishes cycles with the contacts that it is told."""

    def __init__(self, name: str) -> None:
        self.skin = two_patches()
        settings = LiveSettings(skin=self.skin, sources=(NoSource(),), name=name, rungs=(4,))
        ports = tuple(Port(p.name, n) for p, n in zip(self.skin, TAXELS, strict=True))
        model_config = ModelConfig.of(settings, ports)
        sizes = Sizes(2, sum(TAXELS), 16, 8)
        self.fields = sizes.fields(), status_fields(2, sum(TAXELS))
        self.ring = Ring.create(name, *self.fields, description_of(settings, model_config), *ROOM)
        self.blocks = Blocks(1 << 12)
        status = self.ring.status
        status["noise_std"][:], status["tares"][0] = 0.01, 1
        known = Configuration(1, settings.solver, Tuning())
        write_configuration(status["configuration"], known)
        self.ring.set_state(State.RUNNING)

    def cycle(self, contacts=(), stamps_ns=None, answers=(2, 2), invalid=(), counts=None):
        now = time.time_ns()
        if counts is not None:
            self.blocks.clear()
            self.blocks.put(now, 0, counts, Kind.SHORTS)
            self.ring.log(self.blocks.data)
        slot = Slot.of(self.ring.begin())
        slot.head[:] = 0
        slot.head[Head.WALL_NS], slot.head[Head.FRESH] = now, 2
        slot.head[Head.LOG_POSITION] = self.ring.log_end
        slot.patches[:] = np.zeros((), PATCH)
        slot.patches["answer"] = answers
        slot.patches["fresh"] = TAXELS
        slot.patches["stamp_ns"] = (now, now) if stamps_ns is None else stamps_ns
        slot.values[:] = np.arange(sum(TAXELS))
        slot.valid[:] = 1
        slot.valid[list(invalid)] = 0
        slot.patches["invalid"][0] = len(invalid)
        for place in range(2):
            its = [row for row in contacts if row["patch"] == place]
            slot.patches["contacts"][place] = len(its)
            slot.patches["force"][place] = sum(float(row["normal_force"]) for row in its)
            for at, row in enumerate(its):
                slot.contacts[place, at] = row
        self.ring.heartbeat(time.monotonic_ns())
        self.ring.status["totals"][0] += 1
        self.ring.publish()

    def reopen(self):
        """As a new process after a crash."""
        name = self.ring.name
        self.ring.close()
        self.ring = Ring.reopen(name, *self.fields, *ROOM)
        self.ring.set_state(State.RUNNING)

    def close(self):
        self.ring.unlink()
        self.ring.close()
