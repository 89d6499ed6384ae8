"""Packets of skinfield's own: layout of the bytes, reading and writing one.

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
23     1     `skinfield.signal.Status` bits, of all these channels
24     ...   payload
24 + n 2     CRC-16/CCITT-FALSE of all bytes before it
====== ===== =========================================================================

The same packet goes by UDP (one or several in a datagram), TCP and serial, where it is found by
magic, length and CRC. A packet has at most 4090 bytes, up to where that CRC finds every error of
three bits (`X^16 + X^12 + X^5 + 1` has Hamming distance 4 below 32,752 bits).
"""

from binascii import crc_hqx
from dataclasses import dataclass, replace
from enum import IntEnum, IntFlag
from struct import Struct, error, pack
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import InputError, check_count
from skinfield.settings import Range, Section
from skinfield.signal import Status
from skinfield.skin.reading import UNITS

MAGIC = b"SF"
VERSION = 1
HEADER = Struct("<2sBBHHIIHHHBB")
HEADER_BYTES = 24
CRC_BYTES, CRC_BEGIN = 2, 0xFFFF
LONGEST_PAYLOAD = 4064  # bytes; with header and CRC 4090
LONGEST = HEADER_BYTES + LONGEST_PAYLOAD + CRC_BYTES
EVERY_DEVICE = 0xFFFF  # in commands: whoever hears it
HELLO = Struct("<HBBI8sB")
ANSWER = Struct("<BBHI")
LONGEST_NAME = 64  # bytes of UTF-8
UNIT_CODES = tuple(UNITS)  # "count", "dC/C0", "Pa", "1": the unit's code is its place
NO_HASH = bytes(8)


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


DTYPES: dict[int, np.dtype[Any]] = {
    PacketKind.BYTES: np.dtype("<u1"),
    PacketKind.SHORTS: np.dtype("<u2"),
    PacketKind.FLOATS: np.dtype("<f4"),
    PacketKind.SIGNED: np.dtype("<i2"),
}
COMMANDS = frozenset(kind for kind in PacketKind if kind >= PacketKind.START)


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
        if self.kind not in DTYPES:
            return ()
        return tuple(np.frombuffer(self.payload, DTYPES[self.kind]).tolist())


def payload_bytes(kind: int, count: int) -> int:
    """Bytes that the payload of `count` channels must have; -1 where the kind leaves it open."""
    if kind in DTYPES:
        return DTYPES[kind].itemsize * count
    return -(-count // 8) if kind == PacketKind.STATUS else -1


def packet_from_bytes(data: bytes | memoryview, start: int = 0) -> Packet:
    """Read the packet that begins at `start`.

    Raises
    ------
    InputError
        If there is none, or it is not whole, or its CRC is wrong.
    """
    room = len(data) - start
    if room < HEADER_BYTES:
        raise InputError(
            f"packet at byte {start} has {room} bytes, expected a header of {HEADER_BYTES}: the "
            "data was cut"
        )
    magic, version, kind, device, length, *fields = HEADER.unpack_from(data, start)
    sequence, time, channel, count, reading, flags, status = fields
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
    size = HEADER_BYTES + length
    if size + CRC_BYTES > room:
        raise InputError(
            f"packet at byte {start} has {room} bytes, expected {size + CRC_BYTES}: the data was "
            "cut"
        )
    body = bytes(data[start : start + size])
    stated = int.from_bytes(data[start + size : start + size + CRC_BYTES], "little")
    if stated != crc_hqx(body, CRC_BEGIN):
        raise InputError(
            f"packet at byte {start} has CRC {stated:#06x}, expected "
            f"{crc_hqx(body, CRC_BEGIN):#06x}: damaged"
        )
    return Packet(
        kind=kind, device=device, sequence=sequence, time_us=time, channel=channel, count=count,
        reading=reading, flags=flags, status=status, payload=body[HEADER_BYTES:],
    )  # fmt: skip


def encode_packet(packet: Packet) -> bytes:
    """Bytes of a packet.

    Raises
    ------
    InputError
        If a field is out of its range, or the payload does not fit kind and count.
    """
    length = len(packet.payload)
    check_count("bytes of payload", length, 0, LONGEST_PAYLOAD, "split the reading")
    if payload_bytes(packet.kind, packet.count) not in (-1, length):
        raise InputError(
            f"payload has {length} bytes, expected {payload_bytes(packet.kind, packet.count)}: "
            f"{packet.count} channels of kind {packet.kind}"
        )
    try:
        head = HEADER.pack(
            MAGIC, VERSION, packet.kind, packet.device, length, packet.sequence & 0xFFFFFFFF,
            packet.time_us & 0xFFFFFFFF, packet.channel, packet.count, packet.reading & 0xFFFF,
            packet.flags, packet.status,
        )  # fmt: skip
    except error as wrong:
        raise InputError(f"{packet!r:.200} does not fit its fields: {wrong}") from wrong
    body = head + packet.payload
    return body + crc_hqx(body, CRC_BEGIN).to_bytes(CRC_BYTES, "little")


def encode_counts(values: ArrayLike, packet: Packet) -> bytes:
    """Bytes of a packet of counts.

    Parameters
    ----------
    values : (n,) array
        Cast to the type of the packet's kind.
    packet : Packet
        The other fields; its `count` and `payload` are not looked at.

    Raises
    ------
    InputError
        If the kind is none of counts, or there are too many values.
    """
    if packet.kind not in DTYPES:
        kinds = ", ".join(str(int(each)) for each in DTYPES)
        raise InputError(f"kind is {packet.kind}, expected one of {kinds}: the kinds of counts")
    array = np.asarray(values).astype(DTYPES[packet.kind])
    return encode_packet(replace(packet, count=len(array), payload=array.tobytes()))


@dataclass(frozen=True, kw_only=True)
class Hello(Section):
    """What a device says of itself, at its start and when asked.

    In the payload: channels uint16, kind uint8, unit uint8 (0 count, 1 dC/C0, 2 Pa, 3 the
    indentation over the thickness), period uint32 in µs, 8 bytes of layout, length of the name
    uint8, name in UTF-8.

    Parameters
    ----------
    channels : int
    kind : PacketKind
        Of its counts.
    unit : str
        One of `skinfield.skin.reading.UNITS`.
    period_us : int, µs
        From reading to reading; 0 if unknown.
    layout : (8,) bytes
        Any fingerprint of its layout, such as the first bytes of its file's SHA-256; zeros if
        unknown.
    name : str
        At most 64 bytes of UTF-8.
    """

    channels: Annotated[int, Range(1, 65535, "of one device")]
    kind: int = PacketKind.SHORTS
    unit: str = "count"
    period_us: Annotated[int, Range(0, 2**32 - 1, "µs, or 0 for unknown")] = 0
    layout: bytes = NO_HASH
    name: str = ""

    def check(self) -> None:
        """See `Section`."""
        if self.kind not in DTYPES:
            raise InputError(f"kind is {self.kind}, expected one of counts, such as SHORTS")
        if self.unit not in UNIT_CODES:
            raise InputError(f"unit is {self.unit!r}, expected one of {', '.join(UNIT_CODES)}")
        if len(self.layout) != 8 or len(self.name.encode()) > LONGEST_NAME:
            raise InputError(
                f"layout has {len(self.layout)} bytes and name {len(self.name.encode())}, "
                f"expected 8 and at most {LONGEST_NAME}"
            )

    @property
    def payload(self) -> bytes:
        """Bytes of the packet's payload."""
        name = self.name.encode()
        unit = UNIT_CODES.index(self.unit)
        return (
            HELLO.pack(self.channels, self.kind, unit, self.period_us, self.layout, len(name))
            + name
        )


@dataclass(frozen=True)
class CommandReply:
    """What a device answers to a command: payload uint8 command, uint8 result, uint16 0, uint32.

    Parameters
    ----------
    command : int
        One of `PacketKind`.
    result : int
        0 done, 1 unknown to this device, 2 refused.
    sequence : int
        Of the command.
    """

    command: int
    result: int
    sequence: int

    @property
    def payload(self) -> bytes:
        """Bytes of the packet's payload."""
        return ANSWER.pack(self.command, self.result, 0, self.sequence)


def encode_command(
    kind: PacketKind, *, device: int = EVERY_DEVICE, sequence: int = 0, period_us: int | None = None
) -> bytes:
    """Bytes of a command from the host.

    Parameters
    ----------
    kind : PacketKind
        START, STOP, PERIOD, TARE or ASK.
    device : int
        `EVERY_DEVICE` for whoever hears it.
    sequence : int
        The host's own number of this command; devices answer with it.
    period_us : int, µs
        For PERIOD only.

    Raises
    ------
    InputError
        If it is no command, or `period_us` is missing or idle.
    """
    if kind < PacketKind.START:
        raise InputError(f"kind is {kind!r}, expected START, STOP, PERIOD, TARE or ASK")
    if (kind == PacketKind.PERIOD) != (period_us is not None):
        raise InputError(f"period_us is {period_us} for {kind!r}, expected it for PERIOD alone")
    payload = b""
    if period_us is not None:
        check_count("period_us", period_us, 1, 2**32 - 1, "µs from reading to reading")
        payload = pack("<I", period_us)
    return encode_packet(Packet(kind=kind, device=device, sequence=sequence, payload=payload))
