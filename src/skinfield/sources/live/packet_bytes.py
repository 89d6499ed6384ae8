"""Packets out of a stream of bytes, of TCP or a serial line."""

from collections.abc import Sequence
from typing import Protocol

from skinfield.acquisition import Blocks
from skinfield.acquisition.block import Octets
from skinfield.protocols.packet import PacketDevice, PacketScanner
from skinfield.sources.live.link import Link
from skinfield.sources.live.packet_stream import PacketStream

ROUNDS = 8  # of a poll
BUFFER = 1 << 18  # bytes


class ByteLink(Link, Protocol):
    """A connection that brings bytes."""

    def receive(self, into: Octets) -> int:
        """Write what has arrived, as far as there is room; how many bytes. Never waits."""
        ...

    def send(self, data: bytes) -> None:
        """Send a few bytes, as far as they go without waiting."""
        ...


class ByteStream(PacketStream):
    """See `PacketStream`."""

    def __init__(
        self,
        devices: Sequence[PacketDevice],
        names: Sequence[str],
        unit: str,
        link: ByteLink,
        command: bool,
    ) -> None:
        super().__init__(devices, names, unit, link, command)
        self._link = link
        self._scanner = PacketScanner(self.decoder, BUFFER)
        self._scanner.take(0, Blocks(1024), 0, self.counters, 0)  # compiles

    def _take_packets(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        scanner = self._scanner
        for _ in range(ROUNDS):
            free = scanner.free
            received = self._link.receive(free) if len(free) else 0
            if not received and not scanner.used:
                break
            before = scanner.used + received
            scanner.take(received, blocks, channel, self.counters, now_ns)
            if received < len(free) or scanner.used == before:
                break  # nothing more waits, or the blocks are full

    def _tell_device(self, packet: bytes) -> None:
        self._link.send(packet)

    def _came_back(self, place: int, now_ns: int) -> None:
        super()._came_back(place, now_ns)
        self._scanner.forget()  # half a packet of the old connection; whole ones are taken by now
