"""Packets from their fields: for devices in software, tests and commands."""

from dataclasses import dataclass, replace
from struct import Struct, error, pack
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import InputError, check_count
from skinfield.protocols.packet.layout import (
    CRC_BYTES,
    EVERY_DEVICE,
    HEADER,
    LONGEST_PAYLOAD,
    MAGIC,
    VERSION,
    WIDTH,
    Packet,
    PacketKind,
    crc_of,
    payload_bytes,
)
from skinfield.reading import UNITS

HELLO = Struct("<HBBI8sB")
ANSWER = Struct("<BBHI")
LONGEST_NAME = 64  # bytes of UTF-8
UNIT_CODES = tuple(UNITS)  # "count", "dC/C0", "Pa", "1": the unit's code is its place
DTYPES = {PacketKind.BYTES: "<u1", PacketKind.SHORTS: "<u2", PacketKind.FLOATS: "<f4"}
DTYPES[PacketKind.SIGNED] = "<i2"
NO_HASH = bytes(8)


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
    return body + crc_of(body).to_bytes(CRC_BYTES, "little")


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
    if packet.kind not in WIDTH:
        raise InputError(
            f"kind is {packet.kind}, expected one of {', '.join(str(int(k)) for k in WIDTH)}: "
            "the kinds of counts"
        )
    array = np.asarray(values).astype(DTYPES[PacketKind(packet.kind)])
    return encode_packet(replace(packet, count=len(array), payload=array.tobytes()))


@dataclass(frozen=True, kw_only=True)
class Hello:
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
        One of `skinfield.reading.UNITS`.
    period_us : int, µs
        From reading to reading; 0 if unknown.
    layout : (8,) bytes
        Any fingerprint of its layout, such as the first bytes of its file's SHA-256; zeros if
        unknown.
    name : str
        At most 64 bytes of UTF-8.
    """

    channels: int
    kind: int = PacketKind.SHORTS
    unit: str = "count"
    period_us: int = 0
    layout: bytes = NO_HASH
    name: str = ""

    def __post_init__(self) -> None:
        check_count("channels", self.channels, 1, 65535, "of one device")
        check_count("period_us", self.period_us, 0, 2**32 - 1, "µs, or 0 for unknown")
        if self.kind not in WIDTH:
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

    @classmethod
    def from_payload(cls, payload: bytes) -> "Hello":
        """Read it back.

        Raises
        ------
        InputError
            If it is none.
        """
        channels, kind, unit, period, layout, length = _unpack(HELLO, payload, "hello")
        name = payload[HELLO.size : HELLO.size + length]
        if len(name) != length or unit >= len(UNIT_CODES):
            raise InputError(
                f"hello has unit {unit} and {len(name)} bytes of name, expected at most "
                f"{len(UNIT_CODES) - 1} and {length}"
            )
        return cls(
            channels=channels, kind=kind, unit=UNIT_CODES[unit], period_us=period, layout=layout,
            name=name.decode("utf-8", "replace"),
        )  # fmt: skip


@dataclass(frozen=True)
class Answer:
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

    @classmethod
    def from_payload(cls, payload: bytes) -> "Answer":
        """Read it back.

        Raises
        ------
        InputError
            If it is none.
        """
        command, result, _, sequence = _unpack(ANSWER, payload, "answer")
        return cls(command, result, sequence)


def _unpack(fields: Struct, payload: bytes, what: str) -> tuple[Any, ...]:
    if len(payload) < fields.size:
        raise InputError(f"{what} has {len(payload)} bytes, expected {fields.size} or more")
    return fields.unpack_from(payload)


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
