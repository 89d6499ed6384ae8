"""A small recording, made without an engine."""

from pathlib import Path

import numpy as np

from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.schema import (
    CYCLES,
    FIELDS,
    Cycle,
    CycleFlag,
    CycleLayout,
    Enclosed,
    FieldRecord,
)

CONTACT = np.dtype([("track", "<i8"), ("force", "<f8", (3,))])
PATCH = np.dtype([("answer", "<i4"), ("rung", "<i4"), ("force", "<f8")])
ROWS = CycleLayout(CONTACT, PATCH)
START = 1_700_000_000_000_000_000


def cycle_of(number: int) -> Cycle:
    contacts = np.zeros(number % 3, CONTACT)
    contacts["track"] = number
    patches = np.zeros(2, PATCH)
    patches["force"] = number
    flags = CycleFlag.LATE if number % 4 == 0 else CycleFlag(0)
    at = 1000 * number
    return Cycle(number, flags, at, at + 1, at + 2, at + 3, START + at, 48 * (number + 1),
                 contacts, patches)  # fmt: skip


def field_of(number: int) -> FieldRecord:
    """Of two patches with 4 and 9 nodes of 16, and three taxels."""
    pressure = np.zeros((2, 16), np.float32)
    pressure[0, number % 4], pressure[1, :9] = number, 1.0
    taxels = np.full(3, np.nan, np.float32), np.arange(3, dtype=np.float32), np.ones(3, np.uint8)
    return FieldRecord.of(number, START + 1000 * number, np.array([2, 3]), pressure, taxels)


def blocks_at(number: int) -> bytes:
    return bytes(range(number % 200, number % 200 + 48))


def write(
    path: Path, cycles: int = 12, flush_every: int = 3, close: bool = True
) -> RecordingWriter:
    """A cycle and 48 bytes of the log each; a chunk every `flush_every` cycles."""
    enclosed = Enclosed("configuration.json", "application/json", b'{"a": 1}')
    writer = RecordingWriter(path, [enclosed], layout=ROWS)
    for number in range(cycles):
        cycle = cycle_of(number)
        writer.write_blocks(cycle.wall_ns, 48 * number, blocks_at(number))
        writer.write(CYCLES, cycle.wall_ns, ROWS.encode(cycle))
        if number % flush_every == 0:
            writer.write(FIELDS, cycle.wall_ns, field_of(number).encode())
        if number % flush_every == flush_every - 1:
            writer.flush()
    writer.timing(START + 10**6, {"cycles": cycles, "wake_us": {"p50": 1.5, "max": float("nan")}})
    writer.event(START + 10**6, "source_down", "the arm is gone", source=0)
    if close:
        writer.close()
    else:
        writer.flush()
    return writer
