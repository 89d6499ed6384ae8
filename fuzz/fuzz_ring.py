"""Files of rings: any bytes are refused as damaged, or read without a fault."""

import os
import tempfile
from pathlib import Path

import numpy as np

from skinfield.errors import InputError
from skinfield.ring import Field, Ring, RingReader

PLACE, NAME = Path(tempfile.gettempdir()), f"fuzz-{os.getpid()}"
FIELDS = [Field("number", "<i8"), Field("words", "<u4", (3, 2)), Field("valid", "?", (70,))]
CUT = 0xFFFF  # where, in place of a change: the file ends there


def sample() -> bytes:
    """A ring of which everything is in use, as small as can be."""
    with Ring.create(NAME, FIELDS, FIELDS[:2], {"a": 1}, 2, 4096, folder=PLACE) as ring:
        for _ in range(3):
            ring.begin()["words"][:] = 7
            ring.log(np.arange(1500, dtype=np.uint64).view(np.uint8), 3000)
            ring.publish()
        data = ring.path.read_bytes()
        ring.unlink()
    return data


GOOD = sample()
ENDS = np.frombuffer(GOOD[24:120], "<u8").astype(int)  # offsets and sizes, as `header` says


SEEDS = [GOOD[:640], b"", (128).to_bytes(2, "little") + bytes([6]) + b"\x08" * 8]


def one_input(data: bytes) -> None:
    """Read the bytes as a file, as the beginning of a good one, and as changes of that."""
    read(data)
    read(data + GOOD[len(data) :])
    read(changed(data))


def changed(data: bytes) -> bytes:
    """Each 11 bytes: place (2), part of the file (1) and the 8 bytes that come there."""
    made = bytearray(GOOD)
    starts = (0, ENDS[0], ENDS[3], ENDS[5], ENDS[7], ENDS[10], 128, 512)
    for at in range(0, len(data) - 10, 11):
        place = int.from_bytes(data[at : at + 2], "little")
        if place == CUT:
            del made[int.from_bytes(data[at + 3 : at + 7], "little") % len(GOOD) :]
            continue
        start = min(int(starts[data[at + 2] % 8]) + place % 1024, len(made))
        made[start : start + 8] = data[at + 3 : at + 11]
    return bytes(made)


def read(data: bytes) -> None:
    """Everything that a reader offers, on a file of these bytes."""
    path = PLACE / f"skinfield.{NAME}"
    path.write_bytes(data)
    try:
        with RingReader(NAME, folder=PLACE) as reader:
            look(reader)
    except InputError:
        pass
    finally:
        path.unlink()


def look(reader: RingReader) -> None:
    """Read what there is; damage that shows only here is refused too."""
    slot, copies = reader.slot(), reader.status
    assert {*slot} == {field.name for field in reader.slot_fields}
    assert {*copies} == {field.name for field in reader.status_fields}
    assert sum(array.nbytes for array in slot.arrays.values()) >= 0
    assert min(reader.pid, reader.heartbeat_ns, reader.generation, reader.log_end) >= 0
    for number in (0, 1, reader.number, reader.number - 1, 1 << 63):
        found = reader.get(number, slot)
        assert found is None or found.number == number
    reader.wait(0, 0)
    assert not reader.alive
    for position in (0, reader.log_end):
        log = reader.log_reader(position)
        for most in (None, 100, 1):
            before = log.position
            taken, lost = log.read(most)
            assert lost >= 0
            assert log.position == before + lost + len(taken)
            assert len(taken) <= reader.log_bytes
    assert reader.latest(slot) is None or slot.number == reader.number
    assert reader.state >= 0
