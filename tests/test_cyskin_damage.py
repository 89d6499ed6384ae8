"""CySkin's messages lost, doubled, swapped and damaged: against plain Python, and any bytes."""

import numpy as np
from bus_peers import rows_of
from cyskin_reference import Reference, crc8
from hypothesis import given
from hypothesis import strategies as st

from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.cyskin import CySkinBoard, CySkinDecoder, CySkinEncoder, CySkinModule

BOARDS = (
    CySkinBoard(1, tuple(CySkinModule(i) for i in range(5))),
    CySkinBoard(7, tuple(CySkinModule(10 + i) for i in range(3))),
)
CHANNELS = 12 * 8
Rows = list[tuple[int, bytes]]


def sent_rows(readings: int, per_packet: int, seed: int) -> Rows:
    encoder, messages = CySkinEncoder(BOARDS, per_packet=per_packet), CanMessages(4000)
    rng, count = np.random.default_rng(seed), 0
    for _ in range(readings):
        encoder.counts[:] = rng.integers(0, 65536, CHANNELS)
        count = encoder.encode(messages, count, 0)
    return rows_of(messages, count)


def messages_of(rows: Rows) -> CanMessages:
    messages = CanMessages(max(len(rows), 1))
    for row, (identifier, data) in enumerate(rows):
        messages.put(row, identifier, data)
    return messages


def damaged(rows: Rows, faults: list[tuple[str, int, int]]) -> Rows:
    rows = list(rows)
    for what, where, how in faults:
        if not rows:
            break
        at = where % len(rows)
        identifier, data = rows[at]
        if what == "lose":
            del rows[at]
        elif what == "double":
            rows.insert(at, rows[at])
        elif what == "swap":
            rows[at], rows[at - 1] = rows[at - 1], rows[at]
        elif what == "bit" and data:
            place = how % len(data)
            data = data[:place] + bytes([data[place] ^ 1 << how % 8]) + data[place + 1 :]
            rows[at] = identifier, data
        elif what == "identifier":
            rows[at] = identifier ^ 1 << how % 11, data
        elif what == "shorten":
            rows[at] = identifier, data[: how % 8]
        elif what == "reboot":
            del rows[at : at + how % 9]
        elif what == "own":
            body = bytes([0x43, 2 + 2 * (how % 3), how % 7, how % 13]) + bytes(2 * (how % 3))
            rows.insert(at, (0x501, (body + bytes([crc8(body)]))[:8]))
    return rows


FAULT = st.tuples(
    st.sampled_from(["lose", "double", "swap", "bit", "identifier", "shorten", "reboot", "own"]),
    st.integers(0, 10_000),
    st.integers(0, 200),
)


@given(
    st.integers(1, 3),
    st.sampled_from([1, 3, 12, 40, 126]),
    st.integers(0, 9),
    st.lists(FAULT, max_size=12),
    st.integers(1, 40),
)
def test_damage_is_seen_as_plain_python_sees_it(
    readings: int, per_packet: int, seed: int, faults: list, batch: int
) -> None:
    rows = damaged(sent_rows(readings, per_packet, seed), faults)
    reference = Reference({1: 5, 7: 3}, {1: 0, 7: 60})
    for identifier, data in rows:
        reference.take(identifier, data)
    decoder, seen, state = CySkinDecoder(BOARDS), counters(), Channels(CHANNELS)
    readings_of_blocks = 0
    for first in range(0, len(rows), batch):
        part, blocks = rows[first : first + batch], Blocks(1 << 16)
        assert decoder.decode(messages_of(part), len(part), blocks, 0, seen) == len(part)
        readings_of_blocks += len(list(blocks_of(blocks.data)))
        state.apply(blocks)
    expected = np.full(CHANNELS, np.nan)
    expected[list(reference.values)] = list(reference.values.values())
    np.testing.assert_array_equal(state.counts, expected)
    for name in ("RECEIVED", "FOREIGN", "MALFORMED", "LOST", "DUPLICATED", "READINGS"):
        assert seen[Count[name]] == reference.counts[name], name
    assert seen[Count.READINGS] == readings_of_blocks


@given(
    st.sets(st.integers(0, 10_000), max_size=3), st.sampled_from([4, 20, 126]), st.integers(0, 9)
)
def test_ends_of_packets_that_come_twice_spoil_nothing(
    which: set, per_packet: int, seed: int
) -> None:
    rows = sent_rows(1, per_packet, seed)
    ends = [at for at, (identifier, _) in enumerate(rows) if identifier >> 8 in (1, 4)]
    twice = {ends[at % len(ends)] for at in which}
    rows = [row for at, row in enumerate(rows) for row in [row] * (1 + (at in twice))]
    messages, blocks = messages_of(rows), Blocks(1 << 16)
    decoder, seen, state = CySkinDecoder(BOARDS), counters(), Channels(CHANNELS)
    decoder.decode(messages, len(rows), blocks, 0, seen)
    state.apply(blocks)
    assert np.isfinite(state.counts).all()
    assert seen[Count.DUPLICATED] == len(twice)
    assert seen[Count.RECEIVED] == len(rows)
    assert not seen[[Count.LOST, Count.MALFORMED]].any()
