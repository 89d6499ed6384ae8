"""Reads a recording of a live skin without skinfield: forces of each cycle, and every reading.

python examples/read_recording.py touch.mcap

The bytes are described in docs/reference/recording-file.md.
"""

import json
import math
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from numpy.typing import NDArray

COUNTS = {1: "u1", 2: "<u2", 3: "<f4"}  # by the kind of a block
BYTES = {1: 1, 2: 2, 3: 4, 4: 0.125, 7: 48, 8: 8, 9: 16, 10: 1}  # of a channel; else 8 in all


def forces(path: str) -> Iterator[float]:
    """Sum of the contacts' normal forces of each cycle, N."""
    with Path(path).open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(["/skin/cycles"]):
            head = struct.unpack_from("<HHI7q6IQ", message.data)
            start = head[1] + 8 * head[10] * head[11]  # behind the head, and what version 0.1 adds
            fields = [tuple(field) for field in json.loads(channel.metadata["contact"])]
            contacts = np.frombuffer(message.data, np.dtype(fields), head[12], start)
            yield float(contacts["normal_force"].sum())


def readings(path: str) -> Iterator[tuple[int, int, NDArray[Any]]]:
    """Stamp in ns since the epoch, first channel, and counts of each block."""
    with Path(path).open("rb") as file:
        for _, _, message in make_reader(file).iter_messages(["/skin/blocks"]):
            at = 8  # behind the position
            while at < len(message.data):
                stamp, first, count, kind, _ = struct.unpack_from("<qIHBB", message.data, at)
                if kind in COUNTS:
                    yield stamp, first, np.frombuffer(message.data, COUNTS[kind], count, at + 16)
                size = math.ceil(BYTES[kind] * count) if kind in BYTES else 8
                at += 16 + -(-size // 8) * 8


if __name__ == "__main__":
    print(f"at most {max(forces(sys.argv[1]), default=0.0):.2f} N")
    print(f"{sum(1 for _ in readings(sys.argv[1]))} blocks of counts")
