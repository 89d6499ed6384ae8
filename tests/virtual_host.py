"""A host for virtual skins in tests: plain Python, that shares no decoder with the package."""

import numpy as np
from bus_peers import rows_of, wait_for

from skinfield.emulator import VirtualSettings, VirtualSkin, Wires
from skinfield.wire.can import BusSettings, open_bus
from skinfield.wire.can.messages import CanMessages

SECOND = 1_000_000_000
QUIET = {"noise_scale": 0.0, "scene": "idle", "bus": "udp"}
START = ["4D 02 01 F0", "50 00 0F 02 01 00 22", "07 00"]
PUNCTUAL = Wires(jitter_us=0.0)  # else what is due now may be due a moment after
STEPPED = {"control": "", "rate": 100.0, "lead_in": 0.0, "wires": PUNCTUAL}
LONG = 180.0  # s: far more than anything here takes


class Host:
    """Sends a host's messages to boards on a bus over UDP and takes in what they send."""

    def __init__(self, address):
        self.bus = open_bus(BusSettings("udp", port=0, peer=address))
        self.into = CanMessages(1 << 16)

    def tell(self, *messages, board=1):
        for message in messages:
            assert self.bus.send(0x200 | board, bytes.fromhex(message))

    def messages(self):
        """All that has arrived, as (identifier, data)."""
        found = []
        while count := self.bus.receive(self.into):
            found += rows_of(self.into, count)
        return found

    def wait_for(self, count):
        """At least so many messages."""
        found = []
        wait_for(lambda: (found.extend(self.messages()), len(found) >= count)[1])
        return found

    def close(self):
        self.bus.close()


class Stepped:
    """A virtual skin in this process, whose time the test makes: nothing depends on the clock."""

    def __init__(self, **settings):
        given = {**QUIET, **STEPPED, **settings}
        self.now_ns = 10**9 * SECOND + SECOND // 2000  # on no multiple of a period
        self.skin = VirtualSkin(VirtualSettings(**given), lambda: self.now_ns)
        self.host = Host(self.skin.hardware.addresses[0])
        self.received = 0
        self.meet(0)

    def meet(self, bus):
        """Wait until a bus knows its host, which said so with an empty datagram."""
        wire = self.skin.hardware.wires[bus]
        wait_for(lambda: (self.skin.hardware.listen(self.now_ns, 0.0), wire.bus._peer)[1])

    def hear(self):
        """Let the boards take in what the host has sent."""
        hardware, before = self.skin.hardware, self.skin.hardware.commands
        wait_for(lambda: (hardware.listen(self.now_ns, 0.0), hardware.commands > before)[1])

    def tell(self, *messages, board=1):
        for message in messages:
            self.host.tell(message, board=board)
            self.hear()

    def step(self, seconds=0.01):
        """Let time go on; what was sent meanwhile."""
        self.now_ns += round(seconds * SECOND)
        self.skin.step(self.now_ns)
        due = self.skin.hardware.wires[0].counts["messages"] - self.received
        self.received += due
        return self.host.wait_for(due)

    def close(self):
        self.skin.close()
        self.host.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def bytes_by_channel(messages, board=1):
    """Newest byte of each channel of a board, by the format's own words."""
    found = np.full(192, -1)
    for identifier, data in messages:
        if identifier >> 8 != 4 or identifier >> 4 & 15 != board:
            continue
        first = 12 * (identifier & 15)
        if data[0] == 0x40:
            found[first : first + 7] = list(data[1:8])
        elif data[0] == 0xC0:
            found[first + 7 : first + 12] = list(data[1:6])
    return found


def byte_of(difference, no_load=240, shift=2):
    """A board's byte from converter counts above its base, in words of the firmware."""
    if difference <= -((255 - no_load) << shift):
        return 255
    if difference >= no_load << shift:
        return 0
    return no_load - (difference >> shift)
