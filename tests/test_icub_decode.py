"""iCub's messages to blocks: what was encoded, what was lost on the way, and any bytes at all."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from icub_streams import BOARDS, MS, decoded, filled, head, regular

from skinfield.acquisition import Blocks, CanMessages, Channels, Count, Kind, blocks_of, counters
from skinfield.acquisition.can import ERROR, EXTENDED, REMOTE
from skinfield.errors import InputError
from skinfield.protocols.icub import ICubDecoder, ICubEncoder, MessageClass, port_of


def test_a_triangle_becomes_counts_and_status():
    rows = [
        (0x4D5, bytes.fromhex("40 f0f0f08cf0f1f2"), 1.0),
        (0x4D5, bytes.fromhex("c0 f3f400f5f6 fff2"), 1.1),
    ]
    (first, second, status), counts = decoded(rows, channel=1000)
    assert (first.channel, first.count, first.kind, first.stamp_ns) == (1060, 7, Kind.BYTES, MS)
    assert first.payload.tolist() == [0xF0, 0xF0, 0xF0, 0x8C, 0xF0, 0xF1, 0xF2]
    assert (second.channel, second.count, second.stamp_ns) == (1067, 5, 1_100_000)
    assert second.payload.tolist() == [0xF3, 0xF4, 0x00, 0xF5, 0xF6]
    assert (status.channel, status.count, status.kind) == (1060, 12, Kind.STATUS)
    assert status.status == 2
    assert status.payload.tolist() == [0xFF, 0x0F]
    assert counts == Counter(RECEIVED=2, READINGS=2, BYTES=16)


def test_channels_are_those_of_the_board_s_place():
    rows = [(*head(1, 2, 15), 0.0), (*head(1, 3, 1), 0.1)]
    blocks, counts = decoded(rows)
    assert [block.channel for block in blocks] == [2 * 192 + 15 * 12]
    assert counts["FOREIGN"] == 1  # board 3 hangs on the other bus
    blocks, counts = decoded(rows, bus=1)
    assert [block.channel for block in blocks] == [192 + 12]
    assert port_of("arm", BOARDS).channels == 576 == ICubDecoder(BOARDS).channels


def test_encoded_triangles_come_back():
    encoder = ICubEncoder([(13, t) for t in range(16)] + [(2, t) for t in range(16)])
    rng = np.random.default_rng(0)
    encoder.raw[:] = rng.integers(0x7F00, 0x8200, encoder.raw.shape)
    encoder.raw[3] = 0xFFFF
    messages = CanMessages(64)
    count = encoder.encode(messages, 0, 5 * MS)
    blocks, channels = Blocks(1 << 14), Channels(600)
    ICubDecoder(BOARDS).decode(messages, count, blocks, 24, counters())
    channels.apply(blocks)
    places = 24 + 12 * np.concatenate([np.arange(16), 32 + np.arange(16)])
    data = messages.data.reshape(-1, 2, 8)
    for row, first in enumerate(places):
        expected = [*data[row, 0, 1:], *data[row, 1, 1:6]]
        assert channels.counts[first : first + 12].tolist() == expected
        assert (channels.stamp_ns[first : first + 12] == 5 * MS).all()
    assert (channels.status[places[3] : places[3] + 12] & 2 == 2).all()
    assert not (channels.status[places[4] : places[4] + 12] & 2).any()
    assert np.isnan(channels.counts[24 + 192 : 24 + 384]).all()  # the board of the other bus


@pytest.mark.parametrize(
    ("identifier", "data", "name"),
    [
        (0x4D0, "40 01020304050607", "RECEIVED"),
        (0x3D0, "40 01020304050607", "RECEIVED"),
        (0x4D0, "c0 0102030405", "RECEIVED"),  # without diagnostics
        (0x4D0, "c0 0102030405 00", "RECEIVED"),
        (0x4D0, "40 010203040506", "MALFORMED"),
        (0x4D0, "c0 01020304", "MALFORMED"),
        (0x4D0, "00 01020304050607", "MALFORMED"),
        (0x4D0, "", "MALFORMED"),
        (0x4D0 | REMOTE, "40 01020304050607", "MALFORMED"),
        (0x4D0 | ERROR, "40 01020304050607", "MALFORMED"),
        (0x1000, "40 01020304050607", "MALFORMED"),
        (0x4D0 | EXTENDED, "40 01020304050607", "FOREIGN"),
        (0x4C0, "40 01020304050607", "FOREIGN"),
        (0x4C0, "40", "FOREIGN"),
        (0x5D0, "40 01020304050607", "FOREIGN"),
        (0x20D, "07 00", "FOREIGN"),
        (0x100, "0102030405060708", "FOREIGN"),
    ],
)
def test_each_message_counts_once(identifier, data, name):
    blocks, counts = decoded([(identifier, bytes.fromhex(data), 0.0)])
    assert counts[name] == 1
    assert sum(counts[each] for each in ("RECEIVED", "MALFORMED", "FOREIGN")) == 1
    assert counts["BYTES"] == len(bytes.fromhex(data))
    assert bool(blocks) == (name == "RECEIVED")
    kinds = [block.kind for block in blocks]
    assert (Kind.STATUS in kinds) == (len(bytes.fromhex(data)) == 8 and data.startswith("c0"))


def test_classes_are_those_asked_for():
    rows = [(0x3D0, bytes([0x40] * 8), 0.0), (0x4D0, bytes([0x40] * 8), 9.0)]
    assert decoded(rows, classes=[MessageClass.SKIN])[1]["FOREIGN"] == 1
    assert decoded(rows)[1]["FOREIGN"] == 0


def test_what_does_not_fit_stays_for_the_next_call():
    rows = regular(40, 4)
    messages, count = filled(rows)
    whole, small = Blocks(1 << 16), Blocks(56)
    ICubDecoder(BOARDS).decode(messages, count, whole, 0, counters())
    decoder, counts = ICubDecoder(BOARDS), counters()
    parts, at, calls = b"", 0, 0
    while at < count:
        small.clear()
        then = decoder.decode(messages, count, small, 0, counts, at)
        assert at < then <= count
        parts += small.data.tobytes()
        at, calls = then, calls + 1
    assert parts == whole.data.tobytes()
    assert calls > 100
    assert counts[Count.RECEIVED] == count
    tiny = Blocks(40)
    assert decoder.decode(messages, count, tiny, 0, counts) == 0
    assert not len(tiny.data)


def test_a_reset_forgets_the_order():
    decoder, blocks, counts = ICubDecoder(BOARDS), Blocks(1 << 12), counters()
    messages, count = filled([(*head(1), 0.0)])
    for _ in range(3):
        decoder.decode(messages, count, blocks, 0, counts)
        decoder.reset()
    assert counts[Count.READINGS] == 3
    assert counts[Count.LOST] == counts[Count.DUPLICATED] == 0


def test_what_cannot_be_a_decoder_is_said():
    with pytest.raises(InputError, match="each \\(bus, address\\) once"):
        ICubDecoder([(0, 1), (0, 1)])
    with pytest.raises(InputError, match="boards are \\[\\]"):
        ICubDecoder([])
    with pytest.raises(InputError, match="address is 16"):
        ICubDecoder([(0, 16)])
    with pytest.raises(InputError, match="period is 0"):
        ICubDecoder([(0, 1)], period=0.0)
    decoder = ICubDecoder([(0, 1)])
    for first, count in ((0, 5), (3, 2), (-1, 0)):
        with pytest.raises(InputError, match="expected rows of the messages"):
            decoder.decode(CanMessages(4), count, Blocks(64), 0, counters(), first)


ANY_MESSAGE = st.tuples(
    st.one_of(
        st.integers(0, 0xFFFFFFFF),
        st.builds(lambda c, b: c << 8 | b, st.integers(3, 4), st.integers(0, 255)),
    ),
    st.one_of(
        st.binary(max_size=8),
        st.builds(
            lambda k, d: bytes([k]) + d, st.sampled_from([0x40, 0xC0]), st.binary(max_size=7)
        ),
    ),
    st.integers(-(1 << 62) // MS, (1 << 62) // MS),
)


@given(st.lists(ANY_MESSAGE, max_size=40), st.integers(0, 3), st.integers(1, 60))
def test_any_messages_at_all(rows, bus, room):
    """Against a reader in plain Python; and nothing is written behind the end of the blocks."""
    messages, count = filled(rows)
    messages.lengths[::3] += np.uint8(247) * (messages.lengths[::3] == 8)  # no such length
    blocks, counts = Blocks(8 * room + 16), counters()
    blocks.words[-2:] = 0x0123456789ABCDEF
    blocks.words = blocks.words[:-2]
    decoder = ICubDecoder(BOARDS, bus=bus)
    done = decoder.decode(messages, count, blocks, 0, counts)
    assert (blocks.words.base[-2:] == 0x0123456789ABCDEF).all()
    assert counts[Count.RECEIVED] + counts[Count.MALFORMED] + counts[Count.FOREIGN] == done
    places = {b: place for place, (its, b) in enumerate(BOARDS) if its == bus}
    expected = []
    for row in range(done):
        identifier, length = int(messages.ids[row]), int(messages.lengths[row])
        data = messages.data[row].tobytes()
        place = places.get(identifier >> 4 & 15)
        if identifier > 0x7FF or identifier >> 8 not in (3, 4) or place is None or length > 8:
            continue
        first = 192 * place + 12 * (identifier & 15)
        if data[0] == 0x40 and length == 8:
            expected.append((first, data[1:8]))
        if data[0] == 0xC0 and length >= 6:
            expected.append((first + 7, data[1:6]))
    found = [
        (block.channel, block.payload.tobytes())
        for block in blocks_of(blocks.data)
        if block.kind == Kind.BYTES
    ]
    if not counts[Count.DUPLICATED]:
        assert found == expected
    assert len(found) == counts[Count.READINGS] == len(expected) - counts[Count.DUPLICATED]
