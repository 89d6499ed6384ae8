"""Recordings as MCAP files: any bytes are read, or refused, and what is recovered is whole."""

import contextlib
import os
import struct
import tempfile
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Schema

from skinfield.errors import FileError, InputError
from skinfield.files.mcap.container import Container
from skinfield.files.mcap.live import LiveRecording, NewestField
from skinfield.files.mcap.reader import live_stream
from skinfield.files.mcap.records import MAGIC
from skinfield.files.mcap.schema import (
    CYCLE_HEAD,
    FIELD_HEAD,
    CycleLayout,
    FieldRecord,
)
from skinfield.files.mcap.summary import summary_of
from skinfield.files.recordings.open import collected
from skinfield.record.recover import recover

ROWS = CycleLayout(np.dtype([("track", "<i8")]), np.dtype([("force", "<f8")]))
FIELD_RECORD = FIELD_HEAD.pack(1, FIELD_HEAD.size, 2, 5, 0, 3, 9, 2, 0)
FIELD_RECORD += struct.pack("<6I2f", 3, 2, 1, 1, 8, 3, 1.0, 2.0) + bytes(9 * 3)
PORTS = b'{"ports": [["a", 9, "count"]]}'
FOLDER = Path(tempfile.gettempdir()) / "skinfield-fuzz-mcap"
FOLDER.mkdir(exist_ok=True)
os.fdatasync = lambda _: None  # nothing here needs to outlast the machine


class Kept:
    """An output in memory."""

    def __init__(self) -> None:
        self.data = bytearray()

    @property
    def end(self) -> int:
        """Bytes so far."""
        return len(self.data)

    def append(self, piece: bytes) -> None:
        """Add a piece."""
        self.data += piece

    def sync(self) -> None:
        """Nothing to do."""

    def close(self) -> None:
        """Nothing to do."""


def sample(finish: bool) -> bytes:
    """A recording of two cycles with the shortest schemas, without its first 8 bytes."""
    kept = Kept()
    container = Container(kept, "skinfield", "x")
    rows = {"cycles": ROWS.metadata()}
    for number, name in enumerate(("blocks", "cycles", "events", "fields"), 1):
        container.put(Schema(number, b"", "", name))
        container.put(Channel(number, f"/skin/{name}", "x", rows.get(name, {}), number))
    container.put(Attachment(1, 1, "configuration.json", "application/json", PORTS))
    for number in range(2):
        block = struct.pack("<qIHBB8s", 10, 0, 8, 1, 0, bytes(range(8)))
        container.add_message(1, number, 5, struct.pack("<q", 24 * number) + block)
        head = (1, CYCLE_HEAD.size, 1, number, 1, 2, 3, 4, 5, 24 * number + 24, 1, 2, 1, 8, 1, 8, 0)
        container.add_message(2, number, 5, CYCLE_HEAD.pack(*head) + bytes(32))
        container.add_message(3, number, 5, b'{"kind": "dropped", "bytes": 3}')
        container.add_message(4, number, 5, FIELD_RECORD)
        container.flush()
    if finish:
        container.finish()
    return bytes(kept.data[len(MAGIC) :])


SEEDS = [sample(finish=True), sample(finish=False)]
SEEDS += [FIELD_RECORD]

BEGINNING = MAGIC + sample(finish=False)


def one_input(data: bytes) -> None:
    """Take the bytes for records of a file, then for a chunk of messages, then for a message."""
    check(MAGIC + data)
    check(BEGINNING + chunk_of(data))
    with contextlib.suppress(InputError):
        field = FieldRecord.decode(data)
        if len(field.sides) * field.grid < 1 << 20:
            field.pressure_into(np.zeros((len(field.sides), field.grid), np.float32))
        assert FieldRecord.decode(field.encode()).encode() == field.encode()


def chunk_of(data: bytes) -> bytes:
    """A chunk whose lengths are right; each piece of the input becomes a record in it."""
    inner = b""
    for piece in data.split(b"\n"):
        if len(piece) > 1:
            channel = struct.pack("<HIQQ", piece[1] % 5, 0, 1, 1) if piece[0] % 2 else b""
            opcode = 5 if channel else piece[0] % 16
            body = channel + piece[2:]
            inner += struct.pack("<BQ", opcode, len(body)) + body
    body = struct.pack("<QQQII", 1, 1, len(inner), 0, 0) + struct.pack("<Q", len(inner)) + inner
    return struct.pack("<BQ", 6, len(body)) + body


def check(data: bytes) -> None:
    """Read it by all ways; recover it, and have mcap read what came of it."""
    bad, good = (FOLDER / f"{os.getpid()}-{name}.mcap" for name in ("bad", "good"))
    bad.write_bytes(data)
    with contextlib.suppress(InputError):
        read(bad)
    try:
        report = recover(bad, good, overwrite=True)
    except FileError:
        return
    with good.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert len(list(reader.iter_messages())) == sum(report.messages.values())
        assert reader.get_summary() is not None
    assert recover(good, bad, overwrite=True).was_whole


def read(path: Path) -> None:
    """Everything that a recording offers."""
    found = LiveRecording.open(path)
    for _ in (*found.blocks(), *found.cycles(), *found.events(), *found.timing()):
        pass
    index = found.index
    assert all(begin <= end for begin, end in index.gaps)
    for number, _ in enumerate(found.outline.records):
        assert 0 <= index.record_before(number) < len(found.outline.records)
    known, newest = [each.number for each in found.fields()], NewestField(found)
    for place in index.fields:
        record = newest.before(place.time_ns)
        assert record is None or record.number in known
    summary_of(found)
    collected(live_stream(found))
