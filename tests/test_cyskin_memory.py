"""The shared memory of CySkin's tool."""

import sys
import threading
import uuid
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_devices import SharedMemoryWriter

from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.wire.cyskin import CySkinBoard, CySkinModule, SharedMemoryReader, uids_of
from skinfield.wire.cyskin.shared_memory import Area

MODULES = (CySkinModule(0x5678), CySkinModule(7, 0x7FE), CySkinModule(9))
BOARD = CySkinBoard(300, MODULES)
UIDS, CHANNELS = uids_of([BOARD])
ORDER = np.random.default_rng(1).permutation(len(UIDS))


@pytest.fixture
def keys() -> tuple[int, int]:
    key = uuid.uuid4().int % (2**30) * 2 + 1000
    return key % (2**31 - 2), key % (2**31 - 2) + 1


@pytest.fixture
def writer(keys: tuple[int, int]) -> Iterator[SharedMemoryWriter]:
    try:
        writer = SharedMemoryWriter(UIDS[ORDER], *keys)
    except OSError as error:
        pytest.skip(f"no System V shared memory here: {error}")
    yield writer
    writer.close()


def test_golden_words(writer: SharedMemoryWriter, keys: tuple[int, int]) -> None:
    writer.write(np.arange(34), 1234)
    header, data = Area(keys[0], 10), Area(keys[1], 71)
    assert header.words[:3].tolist() == [34, 0, keys[1]]
    assert data.words.tolist() == [0, 1234, 34, *UIDS[ORDER].tolist(), *range(34)]
    with pytest.raises(ValueError, match="read-only"):
        data.words[0] = 1
    for area in (header, data):
        area.close()


def test_samples_become_blocks(writer: SharedMemoryWriter, keys: tuple[int, int]) -> None:
    reader, blocks, seen, state = SharedMemoryReader([BOARD], keys[0]), Blocks(), counters(), None
    assert not reader.up
    assert reader.read(blocks, 0, seen, 5) == 0
    assert reader.reopen()
    assert reader.read(blocks, 0, seen, 5) == 0  # nothing was written yet
    writer.write(np.zeros(34), 0)
    assert reader.read(Blocks(24), 0, seen, 5) == 0  # no room: it comes later
    assert not seen.any()
    assert reader.read(blocks, 0, seen, 5) == 1
    rng = np.random.default_rng(0)
    for turn in range(4):
        values = rng.integers(0, 65536, len(UIDS))
        writer.write(values, turn)
        blocks.clear()
        assert reader.read(blocks, 10, seen, 77) == 1
        assert reader.read(blocks, 10, seen, 78) == 0
        state = Channels(46)
        state.apply(blocks)
        np.testing.assert_array_equal(state.counts[10 + CHANNELS[ORDER]], values)
        assert {b.stamp_ns for b in blocks_of(blocks.data)} == {77}
    for turn in range(3):
        writer.write(values, turn)
    assert reader.read(blocks, 10, seen, 5) == 1
    assert (seen[Count.RECEIVED], seen[Count.LOST]) == (6, 2)
    writer.write(np.full(34, 70_000), 5)
    assert reader.read(blocks, 10, seen, 5) == 0
    assert seen[Count.MALFORMED] == 1
    reader.close()


def test_a_writer_that_ends_and_begins_again(keys: tuple[int, int]) -> None:
    reader, blocks, seen = SharedMemoryReader([BOARD], keys[0]), Blocks(), counters()
    assert not reader.reopen()
    for turn in range(2):
        with closing(SharedMemoryWriter(UIDS, *keys)) as writer:
            assert reader.reopen()
            writer.write(np.full(34, turn), 0)
            assert reader.read(blocks, 0, seen, 5) == 1
        assert reader.read(blocks, 0, seen, 5) == 0
        assert not reader.up
    assert seen[Count.LOST] == 0


def test_no_torn_sample_is_believed(writer: SharedMemoryWriter, keys: tuple[int, int]) -> None:
    reader, seen = SharedMemoryReader([BOARD], keys[0]), counters()
    reader.reopen()
    stop = threading.Event()

    def write() -> None:
        value = 0
        while not stop.is_set():
            value = (value + 1) % 65536
            writer.write(np.full(34, value), 0)

    thread, before = threading.Thread(target=write), sys.getswitchinterval()
    sys.setswitchinterval(1e-4)  # s: both are interrupted often
    thread.start()
    try:
        state, blocks, found = Channels(36), Blocks(), 0
        for _ in range(200_000):
            blocks.clear()
            if reader.read(blocks, 0, seen, 5):
                state.apply(blocks)
                assert len(np.unique(state.counts[CHANNELS])) == 1
                found += 1
            if found >= 200:
                break
        assert found
    finally:
        stop.set()
        thread.join()
        sys.setswitchinterval(before)
        reader.close()


def test_unknown_uids_are_left_out_and_counted(keys: tuple[int, int]) -> None:
    writer = SharedMemoryWriter([*UIDS.tolist(), 5, int(UIDS[0])], *keys)
    reader, blocks, seen = SharedMemoryReader([BOARD], keys[0]), Blocks(), counters()
    with closing(writer), closing(reader):
        reader.reopen()
        writer.write(np.arange(36), 0)
        assert reader.read(blocks, 0, seen, 5) == 1
        assert seen[Count.FOREIGN] == 1
        assert reader.unknown == 2
        assert [int(b.payload[0]) for b in blocks_of(blocks.data)] == [0, 12, 22]


def test_areas_of_others_are_refused(keys: tuple[int, int]) -> None:
    with pytest.raises(OSError, match="is not there"):
        Area(keys[0], 10)
    with closing(SharedMemoryWriter([], *keys)) as writer:  # areas of 10 and of 12 bytes
        reader = SharedMemoryReader([BOARD], keys[0])
        for sensors, key in ((0, keys[1]), (2**31, keys[1]), (4, keys[1]), (4, keys[1] + 1)):
            writer.header[:3] = (sensors, 0, key)
            assert not reader.reopen()
            assert reader.fault.endswith("no tool runs")
        with pytest.raises(InputError, match="has 10 bytes, expected 44"):
            Area(keys[0], 11)


@given(st.lists(st.integers(0, 2**32 - 1), min_size=1, max_size=60), st.booleans())
def test_any_uids_find_their_channels(uids: list[int], known: bool) -> None:
    if known:
        uids = [int(UIDS[uid % len(UIDS)]) for uid in uids]
    order, blocks, seen = SharedMemoryReader([BOARD]), Blocks(1 << 14), counters()
    order.follow(np.array(uids, np.uint32))
    values = np.arange(len(uids), dtype=np.uint32)
    assert order.put(values, blocks, 0, seen, 5)
    state, expected = Channels(36), np.full(36, np.nan)
    state.apply(blocks)
    places = dict(zip(UIDS.tolist(), CHANNELS.tolist(), strict=True))
    for value, uid in reversed(list(enumerate(uids))):
        if uid in places:
            expected[places[uid]] = value
    np.testing.assert_array_equal(state.counts, expected)
