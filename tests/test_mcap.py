"""MCAP files of live recordings: written, read, cut, damaged, recovered."""

import errno
import struct
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from mcap_sample import ROWS, START, blocks_at, cycle_of, field_of, write

from skinfield.errors import FileError, InputError
from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.container import FileOutput
from skinfield.files.mcap.live import LiveRecording, NewestField
from skinfield.files.mcap.schema import (
    CYCLES,
    CycleLayout,
)
from skinfield.record.recover import recover

RECORDS = [ROWS.encode(cycle_of(number)) for number in range(12)]


def records_of(found: LiveRecording) -> list[bytes]:
    return [ROWS.encode(cycle) for cycle in found.cycles()]


@pytest.fixture
def path(tmp_path):
    """A whole recording of twelve cycles."""
    write(tmp_path / "a.mcap")
    return tmp_path / "a.mcap"


def test_round_trip(path):
    found = LiveRecording.open(path)
    assert found.finished
    assert found.cycle_layout == ROWS
    assert records_of(found) == RECORDS
    assert [each.data for each in found.blocks()] == [blocks_at(n) for n in range(12)]
    assert [each.position for each in found.blocks()] == [48 * n for n in range(12)]
    assert found.configuration == {"a": 1}
    (timing,) = found.timing()
    assert timing["wake_us"] == {"p50": 1.5, "max": None}
    (event,) = found.events()
    assert event == {
        "wall_ns": START + 10**6, "kind": "source_down", "text": "the arm is gone", "source": 0
    }  # fmt: skip
    assert found.damage == []
    assert [each.encode() for each in found.fields()] == [
        field_of(n).encode() for n in range(0, 12, 3)
    ]


def test_the_newest_field_up_to_any_time_is_found(path):
    found = LiveRecording.open(path)
    assert (found.index.cycles, found.index.gaps) == (12, [])
    assert (found.index.first_ns, found.index.last_ns) == (START, START + 11_000)
    newest = NewestField(found)
    for number in (11, 0, 5, 4, 9, 3):
        assert newest.before(START + 1000 * number).number == number // 3 * 3
    assert newest.before(START - 1) is None
    pressure = np.ones((2, 16), np.float32)
    newest.before(START + 5000).pressure_into(pressure)
    assert pressure[0].tolist() == [0.0] * 3 + [3.0] + [0.0] * 12
    assert pressure[1].sum() == 9


def mcaps_own(path: Path) -> tuple[Any, list[tuple[str, Any]]]:
    """Summary of a file, and its messages with their topics, as mcap itself reads them."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        return reader.get_summary(), [(c.topic, m) for _, c, m in reader.iter_messages()]


def test_mcap_itself_reads_it_in_both_ways(path):
    summary, messages = mcaps_own(path)
    assert summary.statistics.message_count == 30
    assert summary.statistics.channel_message_counts == {1: 12, 2: 12, 3: 4, 4: 1, 5: 1}
    assert len(summary.chunk_indexes) == 5
    cycles = [message for topic, message in messages if topic == CYCLES]
    assert [message.data for message in cycles] == RECORDS
    assert [message.sequence for message in cycles] == list(range(12))
    with path.open("rb") as file:
        reader = make_reader(file)
        assert len(list(reader.iter_messages(topics=[CYCLES]))) == 12
        assert [each.name for each in reader.iter_attachments()] == ["configuration.json"]
    with path.open("rb") as file:  # record by record, all checksums
        kinds = [type(each).__name__ for each in StreamReader(file, validate_crcs=True).records]
    assert kinds.count("Message") == 30
    assert kinds[-1] == "Footer"


def test_a_file_is_not_replaced_unless_asked(path):
    before = path.read_bytes()
    with pytest.raises(InputError, match="is there already"):
        write(path)
    assert path.read_bytes() == before
    RecordingWriter(path, layout=ROWS, overwrite=True).close()
    assert list(LiveRecording.open(path).cycles()) == []


@pytest.mark.parametrize("compression", CompressionType)
def test_files_of_mcaps_own_writer_are_read(tmp_path, compression):
    """With its channels in the first chunk, as other programs write."""
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=200, compression=compression)
        writer.start()
        schema = writer.register_schema("x", "", b"")
        channel = writer.register_channel("/skin/blocks", "", schema)
        cycles = writer.register_channel("/skin/cycles", "", schema, ROWS.metadata())
        for n in range(9):
            data = struct.pack("<q", 48 * n) + blocks_at(n)
            writer.add_message(channel, START, data, START)
            writer.add_message(cycles, START, RECORDS[n], START)
        writer.finish()
    found = LiveRecording.open(path)
    assert records_of(found) == RECORDS[:9]
    assert [each.data for each in found.blocks()] == [blocks_at(n) for n in range(9)]
    report = recover(path, tmp_path / "b.mcap")
    assert report.was_whole
    assert sum(report.messages.values()) == 18


def test_cut_anywhere(tmp_path, monkeypatch):
    """All that is up to the last whole chunk before the cut is there, and no more.

    At every byte around the ends of chunks, at every so many-th elsewhere.
    """
    path, bad, good = (tmp_path / name for name in ("a.mcap", "bad.mcap", "good.mcap"))
    write(path, cycles=6)
    monkeypatch.setattr("os.fdatasync", lambda _: None)
    data = path.read_bytes()
    chunks = mcaps_own(path)[0].chunk_indexes
    ends = sorted(each.chunk_start_offset + each.chunk_length for each in chunks)
    counts = [0, 7, 14, 16]
    sizes = {*range(8, len(data), 29), *(end + i for end in ends for i in range(-30, 30))}
    for size in sorted(sizes):
        bad.write_bytes(data[:size])
        report = recover(bad, good, overwrite=True)
        expected = counts[sum(end <= size for end in ends)]
        assert sum(report.messages.values()) == expected, size
        assert not report.was_whole
        assert report.dropped_bytes <= size - 8
        if size % 3 == 0:  # mcap's reader takes its time
            assert len(mcaps_own(good)[1]) == expected


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_flipped_bytes(data):
    """Whatever is flipped: what comes out is whole, and each message in it is one of those."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path, bad, good = (folder / each for each in ("a.mcap", "bad.mcap", "good.mcap"))
        write(path)
        octets = bytearray(path.read_bytes())
        known = {message.data for _, message in mcaps_own(path)[1]}
        places = st.tuples(st.integers(8, len(octets) - 1), st.integers(1, 255))
        for at, what in data.draw(st.lists(places, min_size=1, max_size=4)):
            octets[at] ^= what
        bad.write_bytes(octets)
        try:
            report = recover(bad, good)
        except FileError:
            return
        found = [message.data for _, message in mcaps_own(good)[1]]
        assert len(found) == sum(report.messages.values())
        assert set(found) <= known
        read_all(good)
        read_all(bad)


def read_all(path: Path) -> None:
    try:
        found = LiveRecording.open(path)
        for _ in (*found.cycles(), *found.events(), *found.timing(), *found.blocks()):
            pass
        newest = NewestField(found)
        for time_ns in (found.index.first_ns, found.index.last_ns, 1 << 62):
            newest.before(time_ns)
        assert len(list(found.fields())) <= len(found.index.fields)
    except FileError:
        return


def test_scripts_of_older_files_are_passed_over():
    """They stood between the head of a cycle and its rows."""
    data, script = RECORDS[5], bytes(range(80))
    old = data[:64] + struct.pack("<II", 2, 5) + data[72:96] + script + data[96:]
    assert ROWS.encode(ROWS.decode(old)) == RECORDS[5]
    with pytest.raises(InputError, match="expected"):
        ROWS.decode(old[:-8])


class FullDisk(FileOutput):
    """An output on which there is room for so many bytes."""

    room, refused = 1 << 20, 0

    def append(self, piece) -> None:
        if self.end + len(piece) > self.room:
            self.refused += 1
            raise OSError(errno.ENOSPC, "No space left on device")
        super().append(piece)


def test_nothing_is_lost_while_a_disk_is_full(tmp_path):
    path = tmp_path / "a.mcap"
    disk = FullDisk(path)
    writer = RecordingWriter(path, layout=ROWS, output=disk)
    disk.room = disk.end + 10
    writer.write(CYCLES, START, RECORDS[0])
    for _ in range(3):
        with pytest.raises(FileError, match="No space left"):
            writer.flush()
    writer.write(CYCLES, START, RECORDS[1])
    disk.room = 1 << 20
    writer.flush()
    writer.write(CYCLES, START, RECORDS[2])
    writer.close()
    assert records_of(LiveRecording.open(path)) == RECORDS[:3]
    assert disk.refused == 3


def test_what_cannot_be_written(path, tmp_path):
    with pytest.raises(FileError, match="cannot be made"):
        RecordingWriter("/nonesuch/a.mcap", layout=ROWS)
    writer = write(tmp_path / "b.mcap")
    with pytest.raises(InputError, match="is closed"):
        writer.event(START, "x", "y")
    writer.close()
    with pytest.raises(InputError, match="damaged file itself"):
        recover(path, path, overwrite=True)
    other = tmp_path / "b.txt"
    other.write_text("hello")
    with pytest.raises(FileError, match="no MCAP file"):
        recover(other, tmp_path / "c.mcap")
    assert not (tmp_path / "c.mcap").exists()


def test_layouts_that_cannot_be_are_refused() -> None:
    for wrong in (np.dtype("<f8"), np.dtype([("a", "O")])):
        with pytest.raises(InputError, match="plain numbers"):
            CycleLayout(wrong, ROWS.patch)
    for metadata in ({}, {"patch": "[["}, ROWS.metadata() | {"contact": '[["a", "O"]]'}):
        with pytest.raises(InputError, match="expected the fields of contact, patch"):
            CycleLayout.from_metadata(metadata)
    contacts = np.zeros(3, [("x", "<f8")])
    with pytest.raises(InputError, match="those that the recording began with"):
        ROWS.encode(replace(cycle_of(0), contacts=contacts))


@given(st.dictionaries(st.sampled_from(["contact", "patch", "x"]), st.text(max_size=60)))
def test_any_metadata(metadata: dict[str, str]) -> None:
    with pytest.raises(InputError):
        CycleLayout.from_metadata(metadata)
