"""CySkin's CAN messages and shared memory: any bytes are decoded, or counted."""

from contextlib import suppress

import numpy as np

from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.cyskin import (
    Crc,
    CySkinBoard,
    CySkinBoardState,
    CySkinDecoder,
    CySkinModule,
    CySkinWire,
    Sum,
    Unchecked,
    matching_checksums,
)
from skinfield.wire.cyskin.shared_memory import SharedMemoryReader

INTERPRETED = True
FENCE = 0x0123456789ABCDEF
BOARDS = (
    CySkinBoard(1, (CySkinModule(1), CySkinModule(2, 0x7FE), CySkinModule(3, 0x555))),
    CySkinBoard(2, (CySkinModule(4),)),
)
WIRES = [
    CySkinWire(checksum=Unchecked(1)),
    CySkinWire(checksum=Unchecked(0), extended=True, big_endian=False),
    CySkinWire(checksum=Sum()),
    CySkinWire(checksum=Crc(octets=2, polynomial=0x1021, reflected=True)),
]
ROOM = 120  # messages


def rows(wire: CySkinWire, board: int, packet: bytes) -> bytes:
    """Messages of a packet as an input holds them."""
    made = b""
    for identifier, data in wire.messages(board, packet):
        part = identifier >> 26 & 7 if wire.extended else identifier >> 8
        made += bytes([board | part << 4, len(data)]) + data.ljust(8, b"\0")
    return made


SEEDS = [
    bytes([n]) + rows(wire, 1, wire.packet(0x43, bytes([0, 10]) + bytes(range(20))))
    + rows(wire, 2, wire.packet(0x3D, b"\xff"))
    for n, wire in enumerate(WIRES)
] + [b"\0" + bytes([0, 2, 0, 12, 0, 11, 1, 2, 0, 3, 255, 255])]  # fmt: skip


def one_input(data: bytes) -> None:
    """The first byte chooses the wire; then 10 bytes for each message."""
    wire = WIRES[data[0] % len(WIRES)] if data else WIRES[0]
    as_messages(wire, data[1:])
    as_host(wire, data[1:])
    as_memory(data[1:])
    as_checksums(data[1:])


def as_messages(wire: CySkinWire, data: bytes) -> None:
    """Decode them in one go, and in small steps with little room: the same blocks."""
    messages, count = CanMessages(ROOM), min(len(data) // 10, ROOM)
    for row in range(count):
        head, length, *octets = data[10 * row : 10 * row + 10]
        shift = 26 if wire.extended else 8
        messages.ids[row] = (head >> 4) << shift | (head & 15) | wire.extended << 31
        messages.lengths[row] = length if length > 200 else length % 9
        messages.data[row] = octets
        messages.stamp_ns[row] = row
    whole, seen = Blocks(1 << 16), counters()
    assert CySkinDecoder(BOARDS, wire=wire).decode(messages, count, whole, 5, seen) == count
    channels = Channels(5 + 48)
    channels.apply(whole)
    assert np.isnan(channels.counts[:5]).all()
    assert sum(b.count > 0 for b in blocks_of(whole.data)) <= seen[Count.READINGS]
    assert (seen >= 0).all()
    small, decoder, again, found, at = (
        fenced(6600),
        CySkinDecoder(BOARDS, wire=wire),
        counters(),
        b"",
        0,
    )
    while at < count:
        small.clear()
        then = decoder.decode(messages, count, small, 5, again, at)
        assert then > at
        at, found = then, found + small.data.tobytes()
    assert found == whole.data.tobytes()
    assert (again == seen).all()


def fenced(size: int) -> Blocks:
    """Blocks of so many bytes in a larger memory."""
    blocks = Blocks(size + 16)
    blocks.words = blocks.words[:-2]
    return blocks


def as_host(wire: CySkinWire, data: bytes) -> None:
    """A board in software takes them as packets of its host."""
    state = CySkinBoardState(wire)
    for at in range(0, min(len(data), 10 * ROOM), 10):
        packet = wire.unpacked(data[at + 2 : at + 10])
        if packet is not None:
            state = state.after(*packet)
    assert 0 < state.period_ms <= 0xFFFF


def as_memory(data: bytes) -> None:
    """Words of the shared memory."""
    uids, responses = np.frombuffer(data[: len(data) // 8 * 8], np.uint32).reshape(2, -1)
    reader, blocks = SharedMemoryReader(BOARDS), Blocks(1 << 16)
    reader.follow(uids)
    assert reader.put(responses, blocks, 0, counters(), 5)
    Channels(48).apply(blocks)


def as_checksums(data: bytes) -> None:
    """A packet whose checksum is looked for."""
    if len(data) > 200:
        return  # many sums of many octets are slow
    with suppress(InputError):
        matching_checksums([data])
