"""What packets over UDP, TCP and serial have in common: their ports, and waking devices.

A device is told to start when the stream opens, when the connection comes back, and when nothing
came for `SILENCE`: then once a second. Devices that send by themselves need not understand it.
"""

from collections.abc import Sequence

from skinfield.acquisition import Blocks, Count, Port
from skinfield.errors import InputError
from skinfield.protocols.packet import PacketDecoder, PacketDevice, encode_command
from skinfield.protocols.packet.layout import PacketKind
from skinfield.sources.live.link import Link, LinkedStream

SILENCE = 1_000_000_000  # ns
START, STOP = encode_command(PacketKind.START), encode_command(PacketKind.STOP)


def checked_devices(devices: Sequence[PacketDevice] | int) -> tuple[PacketDevice, ...]:
    """Devices as a tuple; a number stands for device 1 with so many channels."""
    if isinstance(devices, int):
        return (PacketDevice(1, devices),)
    return tuple(devices)


def ports_of(devices: Sequence[PacketDevice], names: Sequence[str], unit: str) -> tuple[Port, ...]:
    """A port for each device.

    Raises
    ------
    InputError
        If there are names, but not one for each.
    """
    if not names:
        names = ["skin"] if len(devices) == 1 else [f"device{each.number}" for each in devices]
    if len(names) != len(devices):
        raise InputError(
            f"names are {list(names)}, expected {len(devices)}: one for each device's port"
        )
    return tuple(
        Port(name, device.channels, unit) for name, device in zip(names, devices, strict=True)
    )


class PacketStream(LinkedStream):
    """Packets over one link; see `skinfield.acquisition.Stream`.

    Attributes
    ----------
    decoder : PacketDecoder
        Its `device` tells what is known of each.
    """

    def __init__(
        self,
        devices: Sequence[PacketDevice],
        names: Sequence[str],
        unit: str,
        link: Link,
        command: bool,
    ) -> None:
        super().__init__(ports_of(devices, names, unit), [link])
        self.decoder = PacketDecoder(devices)
        self._command = command
        self._heard_ns = 0
        self._new = True  # connection, over which nothing was told yet

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        before = int(self.counters[Count.RECEIVED])
        self._take_packets(blocks, channel, now_ns)
        packets = int(self.counters[Count.RECEIVED]) - before
        if packets:
            self._heard_ns = now_ns
        if self._command and (self._new or not 0 <= now_ns - self._heard_ns < SILENCE):
            self._new, self._heard_ns = not self._links[0].up, now_ns
            if not self._new:
                self._tell_device(START)
        return packets

    def _take_packets(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        raise NotImplementedError

    def _tell_device(self, packet: bytes) -> None:
        raise NotImplementedError

    def _came_back(self, place: int, now_ns: int) -> None:
        self._new = True

    def _stop(self) -> None:
        if self._command and self._links[0].up:
            self._tell_device(STOP)
