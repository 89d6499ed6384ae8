"""Blocks of a recording that is replayed: any words are refused, or copied as whole blocks."""

import numpy as np

from skinfield.errors import InputError
from skinfield.files.recordings.replay import BlockReplayStream
from skinfield.signal import Blocks, Kind, blocks_of

INTERPRETED = True
NOW = 1_700_000_000_000_000_000


def good() -> bytes:
    """A recording with blocks of all kinds of counts."""
    blocks = Blocks(4096)
    for step in range(3):
        blocks.put(NOW + step, 0, [1, 2, 3], Kind.BYTES)
        blocks.put(NOW + step, 3, [400, 500], Kind.SHORTS)
        blocks.put(NOW + step, 5, [0.5], Kind.FLOATS)
        blocks.put_number(NOW + step, 0, Kind.LOST, 5)
    return blocks.data.tobytes()


SEEDS = [good()]


def one_input(data: bytes) -> None:
    """Play it at three speeds, through a small buffer."""
    words = np.frombuffer(data[: len(data) // 8 * 8], np.int64)
    for speed in (0.01, 1.0, float("inf")):
        try:
            stream = BlockReplayStream((), words, speed, False, "tape")
        except InputError:
            return
        blocks = Blocks(256)
        for step in range(4):
            blocks.clear()
            stream.poll(blocks, 7, NOW + step * 10**15)
            for block in blocks_of(blocks.data):
                assert block.kind not in (Kind.BYTES, Kind.SHORTS, Kind.FLOATS) or (
                    block.channel >= 7
                    and block.channel + block.count <= 7 + stream.ports[0].channels
                )
