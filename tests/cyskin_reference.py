"""CySkin's CAN messages put together and read by plain Python: shares no code with the decoder."""

import struct
from collections import Counter
from dataclasses import dataclass, field


def crc8(data: bytes) -> int:
    """Polynomial 0x07, begins with 0."""
    crc = 0
    for octet in data:
        crc ^= octet
        for _ in range(8):
            crc = (crc << 1 ^ 0x07) & 0xFF if crc & 0x80 else crc << 1
    return crc


@dataclass
class Reference:
    """What a decoder must make of messages of boards with whole modules of 12 sensors.

    Standard identifiers, CRC-8 with 0x07, big-endian.
    """

    modules: dict[int, int]  # of each board
    first_channel: dict[int, int]
    parts: dict = field(default_factory=dict)
    values: dict = field(default_factory=dict)
    counts: Counter = field(default_factory=Counter)
    before: dict = field(default_factory=dict)  # whole packet and its last message

    def take(self, identifier: int, data: bytes) -> None:
        board, part = identifier & 0xFF, identifier >> 8
        if board not in self.modules or identifier > 0x7FF:
            self.counts["FOREIGN"] += 1
            return
        if part not in (1, 2, 4, 5):
            self.counts["MALFORMED"] += 1
            return
        self.counts["RECEIVED"] += 1
        open_packet = self.parts.get(board)
        if (part == 1 and open_packet == data) or (
            part == 4 and open_packet is None and self.before.get(board) == data != b""
        ):
            self.counts["DUPLICATED"] += 1
            return
        skipped = not isinstance(open_packet, bytes) and part in (2, 4)
        if not skipped:
            self.before[board] = None
        if part in (1, 5):
            if isinstance(open_packet, bytes):
                left = open_packet[1] + 3 - len(open_packet) if len(open_packet) >= 2 else 1
                self.counts["LOST"] += max(1, -(-left // 8))
            self.parts[board] = data
        elif isinstance(open_packet, bytes):
            if len(open_packet) + len(data) > 280:
                self.counts["MALFORMED"] += 1
                self.parts[board] = None if part == 4 else "skip"
                return
            self.parts[board] = open_packet + data
        else:
            self.counts["LOST"] += open_packet != "skip"
            self.parts[board] = None if part == 4 else "skip"
            return
        if part in (4, 5):
            if outcome := self.packet(board, self.parts[board]):
                self.counts[outcome] += 1
            whole = len(self.parts[board])
            if whole > 8 and len(data) == (whole - 1) % 8 + 1:
                self.before[board] = data
            self.parts[board] = None

    def packet(self, board: int, packet: bytes) -> str:
        """What is counted of a whole packet, if anything."""
        if packet and packet[0] < 0x10:
            return "FOREIGN"
        if len(packet) < 3:
            return "MALFORMED"
        size = packet[1]
        if len(packet) < 3 + size:
            self.counts["LOST"] += -(-(3 + size - len(packet)) // 8)
            return ""
        if len(packet) > 3 + size or packet[-1] != crc8(packet[:-1]):
            return "MALFORMED"
        if packet[0] != 0x43:
            return ""
        if size < 2 or size % 2:
            return "MALFORMED"
        module, sensor, count = packet[2], packet[3], (size - 2) // 2
        last = 12 * module + sensor + count
        if module >= self.modules[board] or sensor >= 12 or last > 12 * self.modules[board]:
            return "FOREIGN"
        start = self.first_channel[board] + 12 * module + sensor
        numbers = struct.unpack(f">{count}H", packet[4:-1])
        self.values.update(zip(range(start, start + count), numbers, strict=True))
        return "READINGS" if count else ""
