"""Readings of a table or a recording come when their time has come, and as they were."""

import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_devices import HEXAGON

from skinfield.errors import FileError, InputError
from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.schema import CycleLayout
from skinfield.files.recordings.replay import BlockReplayStream, ReplaySource, tape_of
from skinfield.signal import Block, Blocks, Channels, Count, Kind, Port, Status, blocks_of
from skinfield.skin import Patch

START = 1_700_000_000_000_000_000
MS = 1_000_000


def polled(stream: object, now_ns: int, size: int = 1 << 16) -> list[Block]:
    blocks = Blocks(size)
    stream.poll(blocks, 10, now_ns)
    return list(blocks_of(blocks.data.tobytes()))


def table(speed: float = 1.0, loop: bool = False) -> BlockReplayStream:
    counts = np.arange(12.0).reshape(4, 3) * 100
    after = np.array([0, 10, 10, 30]) * MS
    ports = (Port("a", 2), Port("b", 1))
    return BlockReplayStream(ports, tape_of(counts, after), speed, loop, pause_ns=10 * MS)


def test_readings_come_at_their_time_with_their_stamps() -> None:
    stream = table()
    (first,) = polled(stream, START)
    assert (first.stamp_ns, first.channel, first.kind) == (START, 10, Kind.FLOATS)
    assert first.payload.tolist() == [0, 100, 200]
    assert polled(stream, START + 9 * MS) == []
    late = polled(stream, START + 25 * MS)
    assert [block.stamp_ns for block in late] == [START + 10 * MS] * 2
    assert [block.payload.tolist() for block in late] == [[300, 400, 500], [600, 700, 800]]
    assert stream.up
    last, down = polled(stream, START + 30 * MS)
    assert last.payload.tolist() == [900, 1000, 1100]
    assert (down.kind, down.payload[0]) == (Kind.SOURCE, 0)
    assert stream.ended
    assert not stream.up
    assert stream.fault == "the recording is over"
    assert polled(stream, START + 99 * MS) == []


def test_at_double_speed_and_once_more() -> None:
    stream = table(speed=2.0, loop=True)
    stamps = []
    for step in range(60):
        stamps += [each.stamp_ns - START for each in polled(stream, START + step * MS)]
    assert np.allclose(np.array(stamps) / MS, [0, 5, 5, 15, 20, 25, 25, 35, 40, 45, 45, 55])


def test_rounds_that_nobody_polled_are_not_made_up_for() -> None:
    stream = table(loop=True)
    polled(stream, START)
    assert len(polled(stream, START + 10_000 * MS)) <= 2 * 4


def test_a_reading_per_poll(tmp_path: Path) -> None:
    path = csv(tmp_path, "time_s,taxel_0", ["0,0", "0.02,300", "0.02,600", "0.04,900"])
    stream = ReplaySource(path, speed=float("inf")).open()
    for step in range(4):
        block = polled(stream, START + step)[0]
        assert block.stamp_ns == START + step
        assert block.payload[0] == 300 * step
    assert not stream.up


@given(st.lists(st.floats(width=32), min_size=1, max_size=20))
def test_numbers_keep_their_values(values: list[float]) -> None:
    counts = np.array([values], np.float64)
    stream = BlockReplayStream((), tape_of(counts, np.zeros(1, np.int64)))
    (block, *_) = polled(stream, START)
    np.testing.assert_array_equal(block.payload.astype(float), counts[0])


def csv(folder: Path, names: str, rows: list[str]) -> Path:
    path = folder / "recording.csv"
    path.write_text("\n".join([names, *rows]) + "\n")
    return path


def test_a_recording_by_channel(tmp_path: Path) -> None:
    path = csv(tmp_path, "time_s,taxel_0,taxel_1", ["0,1,2", "0.02,3,4", "0.04,5,6"])
    stream = ReplaySource(path).open()
    assert stream.ports == (Port("skin", 2),)
    blocks = polled(stream, START) + polled(stream, START + 40 * MS)
    assert [block.payload.tolist() for block in blocks[:3]] == [[1, 2], [3, 4], [5, 6]]
    assert [block.stamp_ns - START for block in blocks[:3]] == [0, 20 * MS, 40 * MS]


def test_a_recording_by_uid_goes_to_the_skins_channels(tmp_path: Path) -> None:
    patch = Patch(
        np.zeros((3, 2)) + np.arange(3)[:, None] * 4e-3,
        pad_diameter=3e-3,
        uid=np.array([1007, 1008, 1009]),
        channel=np.array([4, 0, 2]),
        n_channels=6,
        name="arm",
    )
    path = csv(tmp_path, "time_s,uid_1009,uid_1007,uid_1008", ["0,90,70,80", "1,91,71,81"])
    stream = ReplaySource(path, skin=patch).open()
    assert stream.ports == (Port("arm", 6),)
    (block,) = polled(stream, START)
    np.testing.assert_array_equal(block.payload, [80, np.nan, 90, np.nan, 70, np.nan])
    with pytest.raises(InputError, match="expected common ones"):
        ReplaySource(path, skin=HEXAGON).open()


def test_recordings_that_cannot_be_played(tmp_path: Path) -> None:
    with pytest.raises(FileError):
        ReplaySource(tmp_path / "nonesuch.csv").open()
    (tmp_path / "bad").write_bytes(b"\x89MCAP0\r\nrubbish")
    with pytest.raises(FileError):
        ReplaySource(tmp_path / "bad").open()
    forces = csv(tmp_path, "time_s,fx,fy,fz", ["0,1,2,3", "1,1,2,3"])
    with pytest.raises(InputError, match="force log"):
        ReplaySource(forces).open()
    with pytest.raises(InputError, match="speed"):
        ReplaySource(forces, speed=0.0)


def live_blocks() -> Blocks:
    """As three sources leave them in a live skin's log."""
    blocks = Blocks(1 << 16)
    for step in range(5):
        stamp = START + step * 20 * MS
        blocks.put(stamp, 0, [step] * 7, Kind.BYTES)
        blocks.put(stamp + 1, 7, [step + 300] * 5, Kind.SHORTS, Status.NO_ACK)
        blocks.put(stamp + 2, 12, [step + 0.5], Kind.FLOATS)
        blocks.put_number(stamp + 3, 0, Kind.LOST, 5)
        blocks.put_number(stamp + 3, 1, Kind.SOURCE, 1)
    return blocks


def live_recording(folder: Path) -> Path:
    path, data = folder / "live.mcap", live_blocks().data.tobytes()
    rows = CycleLayout(np.dtype([("a", "<i4")]), np.dtype([("b", "<i4")]))
    writer, cut = RecordingWriter(path, layout=rows), 104
    writer.write_blocks(START, 0, data[:cut])
    writer.write_blocks(START, cut, data[cut:])
    writer.close()
    return path


def test_a_live_recording_comes_as_it_was(tmp_path: Path) -> None:
    path, now = live_recording(tmp_path), time.time_ns()
    stream = ReplaySource(path, speed=2.0).open()
    assert stream.ports == (Port("skin", 13),)
    found = polled(stream, now)
    while not stream.ended:
        now += MS
        found += polled(stream, now)
    assert found.pop().kind == Kind.SOURCE  # it is over
    recorded = [each for each in blocks_of(live_blocks().data) if each.kind <= Kind.STATUS]
    assert len(found) == len(recorded) == stream.counters[Count.RECEIVED]
    for played, original in zip(found, recorded, strict=True):
        assert played.channel == original.channel + 10
        assert (played.kind, played.status) == (original.kind, original.status)
        assert played.payload.tolist() == original.payload.tolist()
        assert 2 * (played.stamp_ns - found[0].stamp_ns) in range(
            original.stamp_ns - START - 2, original.stamp_ns - START + 1
        )
    assert not stream.up


def test_a_live_recording_step_by_step_and_through_a_small_buffer(tmp_path: Path) -> None:
    path = live_recording(tmp_path)
    stream = ReplaySource(path, speed=float("inf"), loop=True).open()
    for step in range(7):
        expected = [step % 5, step % 5 + 300, step % 5 + 0.5]
        assert [b.payload.tolist()[0] for b in polled(stream, START + step)] == expected
    stream, channels, blocks = ReplaySource(path).open(), Channels(13), Blocks(40)
    for step in range(20):
        blocks.clear()
        stream.poll(blocks, 0, START + step * 10**9)
        channels.apply(blocks)
    assert channels.counts.tolist() == [4.0] * 7 + [304.0] * 5 + [4.5]
    assert stream.ended


def test_ports_of_a_live_recording() -> None:
    tape = np.frombuffer(live_blocks().data.tobytes(), np.int64)
    ports = (Port("hand", 12), Port("arm", 4))
    assert BlockReplayStream(ports, tape).ports == ports
    with pytest.raises(FileError, match="channel 12, expected channels below 12"):
        BlockReplayStream((Port("hand", 12),), tape)
