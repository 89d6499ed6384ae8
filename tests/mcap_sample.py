"""A small recording, made without an engine."""

from pathlib import Path

import numpy as np

from skinfield.acquisition.recorded import Cycle, CycleFlag, CycleLayout, Enclosed
from skinfield.sinks.mcap import RecordingSettings, RecordingWriter, Zstd

CONTACT = np.dtype([("track", "<i8"), ("force", "<f8", (3,))])
PATCH = np.dtype([("answer", "<i4"), ("rung", "<i4"), ("force", "<f8")])
ROWS = CycleLayout(CONTACT, PATCH)
START = 1_700_000_000_000_000_000


def cycle_of(number: int) -> Cycle:
    contacts = np.zeros(number % 3, CONTACT)
    contacts["track"] = number
    patches = np.zeros(2, PATCH)
    patches["force"] = number
    script = np.arange(4, dtype=np.int64).reshape(2, 2) + number
    key = CycleFlag.KEY if number % 4 == 0 else CycleFlag(0)
    at = 1000 * number
    return Cycle(number, key, at, at + 1, at + 2, at + 3, START + at, 48 * (number + 1),
                 script, contacts, patches)  # fmt: skip


def blocks_at(number: int) -> bytes:
    return bytes(range(number % 200, number % 200 + 48))


def write(
    path: Path, cycles: int = 12, compression=None, flush_every: int = 3, close: bool = True
) -> RecordingWriter:
    """A cycle and 48 bytes of the log each; a chunk every `flush_every` cycles."""
    writer = RecordingWriter(
        path,
        [Enclosed("configuration.json", "application/json", b'{"a": 1}')],
        layout=ROWS,
        settings=RecordingSettings(compression or Zstd()),
    )
    for number in range(cycles):
        cycle = cycle_of(number)
        writer.write_blocks(cycle.wall_ns, 48 * number, blocks_at(number))
        writer.write_cycle(cycle.wall_ns, ROWS.encode(cycle))
        if number % flush_every == flush_every - 1:
            writer.flush()
    writer.timing(START + 10**6, {"cycles": cycles, "wake_us": {"p50": 1.5, "max": float("nan")}})
    writer.event(START + 10**6, "source_down", "the arm is gone", source=0)
    if close:
        writer.close()
    else:
        writer.flush()
    return writer
