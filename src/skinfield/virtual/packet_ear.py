"""Commands that a host sends in packets, out of any bytes."""

from collections.abc import Iterator

from skinfield.errors import InputError
from skinfield.protocols.packet import COMMANDS, Packet, packet_from_bytes
from skinfield.protocols.packet.layout import CRC_BYTES, HEADER_BYTES, LONGEST, MAGIC

MOST = 64  # commands of one call, so that a flood of them delays no reading for long


class Ear:
    """Finds whole commands in a stream; what is none is passed over."""

    def __init__(self) -> None:
        self._bytes = b""

    def packets(self, more: bytes) -> Iterator[Packet]:
        """Commands that are whole with these bytes."""
        self._bytes = (self._bytes + more)[-4 * LONGEST :]
        for _ in range(MOST):
            at = self._bytes.find(MAGIC)
            if at < 0:
                self._bytes = self._bytes[-1:]  # the letter that may begin the next
                return
            self._bytes = self._bytes[at:]
            if len(self._bytes) < HEADER_BYTES + CRC_BYTES:
                return
            try:
                packet = packet_from_bytes(self._bytes)
            except InputError:
                if self._is_cut():
                    return
                self._bytes = self._bytes[1:]
                continue
            self._bytes = self._bytes[HEADER_BYTES + len(packet.payload) + CRC_BYTES :]
            if packet.kind in COMMANDS:
                yield packet

    def _is_cut(self) -> bool:
        """Whether the packet at the beginning may be whole with more bytes."""
        length = int.from_bytes(self._bytes[6:8], "little")
        whole = HEADER_BYTES + length + CRC_BYTES
        return len(self._bytes) < whole <= LONGEST
