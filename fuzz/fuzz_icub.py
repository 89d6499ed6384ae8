"""iCub's messages and commands: any bytes are decoded, or counted as malformed."""

import numpy as np

from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.icub import (
    BoardState,
    Firmware,
    ICubDecoder,
    ICubEncoder,
    command_from,
)

INTERPRETED = True
SEEDS = [
    bytes.fromhex("d0040000080140f0f0f08cf0f0f0 d00400000801c0f0f0f0f0f00011") * 2,
    bytes.fromhex("4d0032f000000000 50000f0201002200 0700000000000000 4c01010300200035"),
]
ROOM, FENCE = 40, 0x0123456789ABCDEF
MESSAGES = CanMessages(ROOM)
BLOCKS, CHANNELS, COUNTERS = Blocks(2048), Channels(3 * 192), counters()
DECODERS = [ICubDecoder([(0, 13), (1, 3), (0, 2)], bus, period=0.01) for bus in (0, 1)]
ENCODERS = [ICubEncoder([(1, t) for t in range(16)]), ICubEncoder([(1, 0)])]


def one_input(data: bytes) -> None:
    """Read the same bytes as messages, and as a host's commands."""
    as_messages(data)
    as_commands(data)


def as_messages(data: bytes) -> None:
    """14 bytes for each message: identifier, length, time since the one before, data."""
    count = min(len(data) // 14, ROOM)
    stamp = 0
    for row in range(count):
        item = data[14 * row : 14 * row + 14]
        MESSAGES.ids[row] = int.from_bytes(item[:4], "little") & (0xE0000FFF, 0x4FF)[row & 1]
        MESSAGES.lengths[row] = item[4] if item[4] > 200 else item[4] % 9
        stamp += item[5] * 100_000
        MESSAGES.stamp_ns[row] = stamp
        MESSAGES.data[row] = list(item[6:])
    whole, BLOCKS.words = BLOCKS.words, BLOCKS.words[:-2]
    whole[-2:] = FENCE
    try:
        for decoder in DECODERS:
            COUNTERS[:] = 0
            at = 0
            while at < count:
                BLOCKS.clear()
                then = decoder.decode(MESSAGES, count, BLOCKS, 0, COUNTERS, at)
                assert at < then <= count
                assert CHANNELS.apply(BLOCKS) == len(list(blocks_of(BLOCKS.data)))
                at = then
            kinds = (Count.RECEIVED, Count.MALFORMED, Count.FOREIGN)
            assert sum(int(COUNTERS[each]) for each in kinds) == count
            assert int(COUNTERS[Count.READINGS]) <= count
        assert (whole[-2:] == FENCE).all()
    finally:
        BLOCKS.words = whole


def as_commands(data: bytes) -> None:
    """Up to 8 bytes for each command; the board that obeys is encoded after each."""
    for firmware, encoder in zip(Firmware, reversed(ENCODERS), strict=True):
        state = BoardState(firmware=firmware)
        for at in range(0, min(len(data), 80), 8):
            command, state = command_from(data[at : at + 8]), state.after(data[at : at + 8])
            assert command is None or command_from(command.data) == command
        encoder.follow(1, state)
        encoder.raw[0] = np.frombuffer(data[:24].ljust(24, b"\0"), np.uint16)
        assert encoder.encode(MESSAGES, 0, 0) == 2 * int(encoder.sends.sum())
