"""Skinfield's own packets: any bytes are decoded or counted, as stream and as datagram."""

from binascii import crc_hqx

import numpy as np

from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.wire.packet import (
    CommandReply,
    Hello,
    Packet,
    PacketDecoder,
    PacketDevice,
    PacketScanner,
    encode_packet,
    packet_from_bytes,
)

DEVICES = [PacketDevice(1, 40), PacketDevice(2, 7)]
INTERPRETED = True
FENCE = 0x0123456789ABCDEF
HEAD = 20  # bytes of a packet behind magic, version and kind


def good(kind: int, count: int, payload: bytes, sequence: int = 0) -> bytes:
    """A packet that is in order."""
    return encode_packet(Packet(kind=kind, count=count, payload=payload, sequence=sequence))


SEEDS = [
    good(2, 3, b"123456") + good(1, 40, bytes(40), 1),
    good(5, 2, b"abcd") + b"noise" + good(4, 9, b"\x01\x01", 5) + good(3, 1, bytes(4), 2),
    good(16, 0, Hello(channels=40, name="palm").payload)
    + good(17, 0, CommandReply(34, 0, 9).payload),
    good(34, 0, b"\x01\0\0\0") + b"SF\x01",
]


def one_input(data: bytes) -> None:
    """Read the bytes as they are, and as packets whose sums are right."""
    read(data)
    read(mended(data))


def mended(data: bytes) -> bytes:
    """Each piece of the input as the rest of a packet, with the length and sum that it needs."""
    made = b""
    for piece in data.split(b"\n"):
        if len(piece) > HEAD:
            kind, rest, payload = piece[:1], piece[1:HEAD], piece[HEAD:4084]
            body = b"SF\x01" + kind + rest[:2] + len(payload).to_bytes(2, "little")
            body += rest[2:4] + b"\0\0" + rest[4:8] + bytes([rest[8] % 50, 0])
            width = {1: 1, 2: 2, 3: 4, 5: 2}.get(kind[0])
            count = len(payload) // width if width else rest[9]
            body += count.to_bytes(2, "little") + rest[10:14]
            body += payload
            made += body + crc_hqx(body, 0xFFFF).to_bytes(2, "little")
    return made


def read(data: bytes) -> None:
    """A datagram, then a stream in pieces: the same packets."""
    octets = np.frombuffer(data, np.uint8)
    blocks, whole = fenced(3 * len(data) + 64)
    seen, decoder = counters(), PacketDecoder(DEVICES)
    stamps, lengths = np.array([10**9]), np.array([len(octets)])
    assert decoder.decode_many(octets[np.newaxis], lengths, stamps, 0, 1, blocks, 5, seen) == 1
    look(blocks, whole, decoder)
    plain_packets(data)
    scanner, again = PacketScanner(PacketDecoder(DEVICES)), counters()
    for at in range(0, len(data), 37):
        piece = octets[at : at + 37]
        scanner.free[: len(piece)] = piece
        blocks, whole = fenced(3 * (len(piece) + scanner.used) + 64)
        scanner.take(len(piece), blocks, 5, again, 10**9)
        look(blocks, whole, scanner.decoder)
    for count in (Count.RECEIVED, Count.FOREIGN, Count.READINGS, Count.LOST, Count.DUPLICATED):
        assert again[count] <= seen[count] or scanner.used


def fenced(size: int) -> tuple[Blocks, np.ndarray]:
    """Blocks behind whose end something stands that must stay."""
    blocks = Blocks(size + 16)
    whole, blocks.words = blocks.words, blocks.words[:-2]
    whole[-2:] = FENCE
    return blocks, whole


def look(blocks: Blocks, whole: np.ndarray, decoder: PacketDecoder) -> None:
    """What became of it is whole, and within the channels."""
    assert (whole[-2:] == FENCE).all()
    channels = Channels(5 + decoder.channels)
    assert channels.apply(blocks) == len(list(blocks_of(blocks.data)))
    assert np.isnan(channels.counts[:5]).all()


def plain_packets(data: bytes) -> None:
    """What plain Python reads, it also writes."""
    at = 0
    try:
        while at < len(data):
            packet = packet_from_bytes(data, at)
            assert len(packet.values) in (0, packet.count)
            encode_packet(packet)
            at += 26 + len(packet.payload)
    except InputError:
        pass
