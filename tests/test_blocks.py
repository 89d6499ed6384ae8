"""Blocks: written by compiled code and by NumPy, read back by plain Python."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Kind, Status, blocks_of
from skinfield.signal.blocks_kernel import begin_block

BLOCK = st.tuples(
    st.one_of(st.integers(0, 2**62), st.integers(0, 3 * 10**9)),
    st.integers(0, 40),
    st.lists(st.integers(0, 255), max_size=20),
    st.sampled_from([Kind.BYTES, Kind.SHORTS, Kind.FLOATS]),
    st.sampled_from([Status.OK, Status.NO_ACK, Status.INVALID | Status.NOT_CONNECTED]),
)


def put(blocks: Blocks, data: bytes) -> None:
    """Whole blocks as they were recorded."""
    blocks.octets[: len(data)] = np.frombuffer(data, np.uint8)
    blocks.end[0] = len(data) // 8


def test_bytes_of_a_block_are_those_of_the_table() -> None:
    blocks = Blocks(1024)
    blocks.put(0x1122334455667788, 7, [1, 2, 300], Kind.SHORTS, Status.NO_ACK)
    expected = struct.pack("<qIHBB3H2x", 0x1122334455667788, 7, 3, 2, 1, 1, 2, 300)
    assert blocks.data.tobytes() == expected


@given(st.lists(BLOCK, max_size=12))
def test_what_is_written_is_read_back(drawn: list) -> None:
    blocks = Blocks(1 << 14)
    for stamp, channel, values, kind, status in drawn:
        blocks.put(stamp, channel, values, kind, status)
    for (stamp, channel, values, kind, status), block in zip(
        drawn, blocks_of(blocks.data), strict=True
    ):
        assert (stamp, channel, len(values), kind, status) == (
            block.stamp_ns,
            block.channel,
            block.count,
            block.kind,
            block.status,
        )
        assert block.payload.tolist() == values


@given(st.lists(BLOCK, max_size=12))
def test_channels_hold_what_the_last_block_brought(drawn: list) -> None:
    blocks, channels = Blocks(1 << 14), Channels(60)
    counts, stamps, states = np.full(60, np.nan), np.zeros(60, np.int64), np.zeros(60, np.uint8)
    for stamp, channel, values, kind, status in drawn:
        blocks.put(stamp, channel, values, kind, status)
        there = np.arange(channel, channel + len(values))
        late = (stamps[there] > stamp) & (stamps[there] < stamp + 10**9)
        there, kept = there[~late], np.array(values)[~late]
        counts[there], stamps[there] = kept, stamp
        if status:
            states[there] = status
    assert channels.apply(blocks) == len(drawn)
    np.testing.assert_array_equal(channels.counts, counts)
    np.testing.assert_array_equal(channels.stamp_ns, stamps)
    np.testing.assert_array_equal(channels.status, states)


def test_status_reaches_its_channels_and_no_others() -> None:
    blocks, channels = Blocks(1024), Channels(24)
    at = begin_block(blocks.words, blocks.end, 5, 12, 12, int(Kind.STATUS), 1)
    blocks.octets[at : at + 2] = 0b0000_0010, 0b1000
    channels.apply(blocks)
    assert channels.status[:12].tolist() == [0] * 12
    assert channels.status[12:].tolist() == [1, 5, 1, 1, 1, 1, 1, 1, 1, 1, 1, 5]


def test_a_block_that_does_not_fit_changes_nothing() -> None:
    blocks = Blocks(48)
    blocks.put(1, 0, [1, 2], Kind.BYTES)
    before = blocks.data.tobytes()
    with pytest.raises(InputError, match="does not fit"):
        blocks.put(1, 0, np.zeros(20), Kind.SHORTS)
    assert blocks.data.tobytes() == before


@given(st.binary(max_size=256))
def test_any_bytes_are_applied_or_refused(data: bytes) -> None:
    blocks, channels = Blocks(512), Channels(8)
    put(blocks, data[: len(data) // 8 * 8])
    try:
        read = list(blocks_of(blocks.data))
        beyond = any(b.kind <= Kind.STATUS and b.channel + b.count > 8 for b in read)
    except InputError:
        beyond = True
    if beyond:
        with pytest.raises(InputError, match="begins no block"):
            channels.apply(blocks)
    else:
        assert channels.apply(blocks) == len(read)


def test_settings_of_older_recordings_are_passed_over() -> None:
    blocks, channels = Blocks(1024), Channels(8)
    counts = struct.pack("<qIHBB3B5x", 5, 2, 3, 1, 0, 7, 8, 9)
    old = [struct.pack("<qIHBB", 5, 0, 3, kind, 0) for kind in (7, 8, 9, 10)]
    sizes = (144, 24, 48, 8)
    data = b"".join(head + bytes(size) for head, size in zip(old, sizes, strict=True))
    put(blocks, counts + data + counts)
    assert [block.payload.tolist() for block in blocks_of(blocks.data)] == [[7, 8, 9]] * 2
    assert channels.apply(blocks) == 2
    assert channels.counts[2:5].tolist() == [7, 8, 9]
