"""Skinfield's own packets, version 1: what a microcontroller sends, byte by byte.

One packet holds counts of a run of channels of one device. Everything is little-endian:

====== ===== =========================================================================
offset bytes what
====== ===== =========================================================================
0      2     magic, the letters S F
2      1     version, 1
3      1     `PacketKind`
4      2     device
6      2     payload, bytes (0 to 4064)
8      4     sequence number: 0 after the start, one more with every packet
12     4     time of the device, µs; wraps around after 71.6 minutes
16     2     first channel
18     2     channels
20     2     number of the reading; the same in all packets of one reading
22     1     `PacketFlag` bits
23     1     `skinfield.acquisition.Status` bits, of all these channels
24     ...   payload
24 + n 2     CRC-16/CCITT-FALSE of all bytes before it
====== ===== =========================================================================

The same packet goes by UDP (one or several in a datagram), TCP and serial, where it is found by
magic, length and CRC. A packet has at most 4090 bytes, up to where that CRC finds every error of
three bits (`X^16 + X^12 + X^5 + 1` has Hamming distance 4 below 32,752 bits).
"""

from binascii import crc_hqx
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from struct import Struct, error

from skinfield.acquisition import Status
from skinfield.errors import InputError

MAGIC = b"SF"
VERSION = 1
HEADER = Struct("<2sBBHHIIHHHBB")
HEADER_BYTES = 24
CRC_BYTES = 2
LONGEST_PAYLOAD = 4064  # bytes; with header and CRC 4090
LONGEST = HEADER_BYTES + LONGEST_PAYLOAD + CRC_BYTES
EVERY_DEVICE = 0xFFFF  # in commands: whoever hears it


class PacketKind(IntEnum):
    """What a packet's payload is."""

    BYTES = 1  # counts, uint8 each
    SHORTS = 2  # counts, uint16 each
    FLOATS = 3  # numbers, float32 each; NaN where a taxel did not answer
    STATUS = 4  # no counts: the status byte, and one bit per channel: out of range
    SIGNED = 5  # counts, int16 each
    HELLO = 16  # what the device is, see `Hello`
    ANSWER = 17  # to a command, see `Answer`
    START = 32  # host to device, from here on: send readings
    STOP = 33
    PERIOD = 34  # payload uint32: µs from reading to reading
    TARE = 35  # take the baseline anew
    ASK = 36  # send a HELLO


COMMANDS = frozenset(kind for kind in PacketKind if kind >= PacketKind.START)
WIDTH = {PacketKind.BYTES: 1, PacketKind.SHORTS: 2, PacketKind.FLOATS: 4, PacketKind.SIGNED: 2}
CODE = {PacketKind.BYTES: "B", PacketKind.SHORTS: "H", PacketKind.FLOATS: "f"}
CODE[PacketKind.SIGNED] = "h"


class PacketFlag(IntFlag):
    """What a packet says of itself."""

    NONE = 0
    LAST = 1  # the reading is complete with this packet


@dataclass(frozen=True, kw_only=True)
class Packet:
    """One packet, as its fields.

    Parameters
    ----------
    kind : int
        One of `PacketKind`; of a newer device also another.
    device : int
    sequence : int
    time_us : int, µs
        Of the device's clock.
    channel, count : int
        First channel and how many.
    reading : int
    flags : PacketFlag
    status : Status
    payload : bytes
    """

    kind: int
    device: int = 1
    sequence: int = 0
    time_us: int = 0
    channel: int = 0
    count: int = 0
    reading: int = 0
    flags: int = PacketFlag.LAST
    status: int = Status.OK
    payload: bytes = b""

    @property
    def values(self) -> tuple[float, ...]:
        """Numbers (count,) of a packet of counts; empty for other kinds."""
        if self.kind not in CODE:
            return ()
        return Struct(f"<{self.count}{CODE[PacketKind(self.kind)]}").unpack(self.payload)


def payload_bytes(kind: int, count: int) -> int:
    """Bytes that the payload of `count` channels must have; -1 where the kind leaves it open."""
    if kind in WIDTH:
        return WIDTH[PacketKind(kind)] * count
    return -(-count // 8) if kind == PacketKind.STATUS else -1


def packet_from_bytes(data: bytes | memoryview, start: int = 0) -> Packet:
    """Read the packet that begins at `start`.

    Raises
    ------
    InputError
        If there is none, or it is not whole, or its CRC is wrong.
    """
    packet, length = _header(data, start)
    end = start + HEADER_BYTES + length
    if end + CRC_BYTES > len(data):
        raise InputError(
            f"packet at byte {start} has {len(data) - start} bytes, expected "
            f"{HEADER_BYTES + length + CRC_BYTES}: the data was cut"
        )
    stated = int.from_bytes(data[end : end + CRC_BYTES], "little")
    found = crc_of(data[start:end])
    if stated != found:
        raise InputError(
            f"packet at byte {start} has CRC {stated:#06x}, expected {found:#06x}: damaged"
        )
    return packet


def packets_of(data: bytes | memoryview) -> Iterator[Packet]:
    """Read packets that lie one after the other; for tools and for devices, not for the loop.

    Raises
    ------
    InputError
        At the first that cannot be read; what was yielded before is good.
    """
    at = 0
    while at < len(data):
        packet = packet_from_bytes(data, at)
        yield packet
        at += HEADER_BYTES + len(packet.payload) + CRC_BYTES


def _header(data: bytes | memoryview, start: int) -> tuple[Packet, int]:
    try:
        fields = HEADER.unpack_from(data, start)
    except error as short:
        raise InputError(
            f"packet at byte {start} has {len(data) - start} bytes, expected a header of "
            f"{HEADER_BYTES}: the data was cut"
        ) from short
    magic, version, kind, device, length, sequence, time, channel, count, reading = fields[:10]
    if magic != MAGIC or version != VERSION:
        raise InputError(
            f"byte {start} begins with {magic!r} and version {version}, expected {MAGIC!r} and "
            f"{VERSION}: no packet, or of a newer device"
        )
    if length > LONGEST_PAYLOAD or payload_bytes(kind, count) not in (-1, length):
        raise InputError(
            f"packet at byte {start} has {length} bytes of payload, expected those of {count} "
            f"channels of kind {kind}, at most {LONGEST_PAYLOAD}: damaged"
        )
    payload = bytes(data[start + HEADER_BYTES : start + HEADER_BYTES + length])
    packet = Packet(
        kind=kind, device=device, sequence=sequence, time_us=time, channel=channel, count=count,
        reading=reading, flags=fields[10], status=fields[11], payload=payload,
    )  # fmt: skip
    return packet, length


def crc_of(data: bytes | memoryview) -> int:
    """CRC-16/CCITT-FALSE of some bytes."""
    return crc_hqx(data, 0xFFFF)
