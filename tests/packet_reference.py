"""Packets found and counted by plain Python, to compare the compiled decoder with."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import InputError
from skinfield.signal import Blocks, Count
from skinfield.wire.packet import (
    Packet,
    PacketDecoder,
    PacketKind,
    encode_counts,
    encode_packet,
    packet_from_bytes,
)

COUNTED = ("RECEIVED", "FOREIGN", "MALFORMED", "READINGS")


def decode(
    decoder: PacketDecoder,
    data: bytes | np.ndarray,
    blocks: Blocks,
    seen: np.ndarray,
    now_ns: int = 5,
    channel: int = 0,
) -> int | None:
    """Take one datagram; its packets, or None where the blocks might not hold them."""
    octets = np.frombuffer(bytearray(data), np.uint8)[np.newaxis]
    before = int(seen[Count.RECEIVED] + seen[Count.FOREIGN])
    lengths = np.array([len(data)])
    taken = decoder.decode_many(octets, lengths, np.array([now_ns]), 0, 1, blocks, channel, seen)
    return int(seen[Count.RECEIVED] + seen[Count.FOREIGN]) - before if taken else None


def packets_of(data: bytes) -> Iterator[Packet]:
    """Packets that lie one after the other."""
    at = 0
    while at < len(data):
        packet = packet_from_bytes(data, at)
        yield packet
        at += 26 + len(packet.payload)


def raw_packet(kind: int, **fields: object) -> bytes:
    return encode_packet(Packet(kind=kind, **fields))  # type: ignore[arg-type]


def counts_packet(values: list, kind: int = 2, **fields: int) -> bytes:
    return encode_counts(values, Packet(kind=kind, **fields))  # type: ignore[arg-type]


def packet_at(data: bytes, at: int) -> Packet | bool | None:
    """The packet at `at`; None if it may become one; False if it is none."""
    rest = data[at:]
    if not b"SF\x01".startswith(rest[:3]):
        return False
    try:
        return packet_from_bytes(rest)
    except InputError as error:
        return None if "was cut" in str(error) else False


@dataclass
class Reference:
    """What a decoder must make of bytes: channel values, and counts of what happened."""

    channels: int
    device: int = 1
    values: dict = field(default_factory=dict)
    counts: dict = field(default_factory=lambda: dict.fromkeys(COUNTED, 0))

    def stream(self, data: bytes, final: bool = False) -> int:
        """Octets that are done with."""
        at, torn = 0, False
        while at < len(data):
            packet = packet_at(data, at)
            if packet:
                self.take(packet)
                at, torn = at + 26 + len(packet.payload), False
            elif packet is None and not final:
                break
            else:
                self.counts["MALFORMED"] += not torn
                torn = True
                at += 1
                while at < len(data) and data[at] != 0x53:
                    at += 1
        return at

    def take(self, packet: Packet) -> None:
        channel, count = packet.channel, packet.count
        beyond = packet.kind <= PacketKind.SIGNED and channel + count > self.channels
        if packet.device != self.device or packet.kind >= PacketKind.START or beyond:
            self.counts["FOREIGN"] += 1
            return
        self.counts["RECEIVED"] += 1
        if packet.kind <= PacketKind.SIGNED and packet.kind != PacketKind.STATUS:
            self.counts["READINGS"] += 1
            self.values.update(zip(range(channel, channel + count), packet.values, strict=True))
