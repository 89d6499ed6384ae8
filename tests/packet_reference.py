"""Packets read and counted by plain Python, to compare the compiled decoder with."""

import struct
from binascii import crc_hqx
from dataclasses import dataclass, field

import numpy as np

from skinfield.signal import Blocks, Count
from skinfield.wire.packet import PacketDecoder


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


WIDTHS = {1: 1, 2: 2, 3: 4, 5: 2}
FORMATS = {1: "B", 2: "H", 3: "f", 5: "h"}
COUNTED = ("RECEIVED", "FOREIGN", "MALFORMED", "READINGS")


def raw_packet(
    kind: int,
    *,
    device: int = 1,
    sequence: int = 0,
    time: int = 0,
    channel: int = 0,
    count: int = 0,
    reading: int = 0,
    flags: int = 1,
    status: int = 0,
    payload: bytes = b"",
) -> bytes:
    head = b"SF\x01" + bytes([kind])
    head += struct.pack(
        "<HHIIHHHBB", device, len(payload), sequence, time, channel, count, reading, flags, status
    )
    body = head + payload
    return body + struct.pack("<H", crc_hqx(body, 0xFFFF))


def counts_packet(values: list, kind: int = 2, **fields: int) -> bytes:
    payload = struct.pack(f"<{len(values)}{FORMATS[kind]}", *values)
    return raw_packet(kind, count=len(values), payload=payload, **fields)


def packet_at(data: bytes, at: int) -> int:
    """Octets of the packet at `at`; 0 if it may become one; -1 if it is none."""
    rest = data[at:]
    if not b"SF\x01".startswith(rest[:3]):
        return -1
    if len(rest) < 24:
        return 0
    kind, length, count = rest[3], u16(rest, 6), u16(rest, 18)
    wanted = WIDTHS[kind] * count if kind in WIDTHS else (count + 7) // 8 if kind == 4 else length
    if length > 4064 or wanted != length:
        return -1
    if len(rest) < 26 + length:
        return 0
    good = crc_hqx(rest[: 24 + length], 0xFFFF) == u16(rest, 24 + length)
    return 26 + length if good else -1


def u16(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 2], "little")


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
            size = packet_at(data, at)
            if size > 0:
                self.take(data[at : at + size])
                at, torn = at + size, False
            elif size == 0 and not final:
                break
            else:
                self.counts["MALFORMED"] += not torn
                torn = True
                at += 1
                while at < len(data) and data[at] != 0x53:
                    at += 1
        return at

    def take(self, packet: bytes) -> None:
        kind = packet[3]
        device, channel, count = u16(packet, 4), u16(packet, 16), u16(packet, 18)
        beyond = (kind in WIDTHS or kind == 4) and channel + count > self.channels
        if device != self.device or kind >= 32 or beyond:
            self.counts["FOREIGN"] += 1
            return
        self.counts["RECEIVED"] += 1
        if kind in WIDTHS:
            self.counts["READINGS"] += 1
            numbers = struct.unpack(f"<{count}{FORMATS[kind]}", packet[24:-2])
            self.values.update(zip(range(channel, channel + count), numbers, strict=True))
