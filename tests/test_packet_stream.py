"""Packets out of streams of bytes and over bad networks: against plain Python, and any bytes."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from packet_reference import Reference, counts_packet, raw_packet

from skinfield.acquisition import Blocks, Channels, Count, blocks_of, counters
from skinfield.errors import InputError
from skinfield.protocols.packet import (
    LONGEST,
    PacketDecoder,
    PacketScanner,
    packet_from_bytes,
    packets_of,
)

CHANNELS = 24
BEGINNINGS = [b"S", b"SF", b"SF\x01", b"SF\x01\x02"]
STEP = st.one_of(
    st.tuples(st.just("counts"), st.sampled_from([1, 2, 5]), st.integers(0, 30)),
    st.tuples(st.just("garbage"), st.binary(min_size=1, max_size=40), st.just(0)),
    st.tuples(st.just("magic"), st.sampled_from(BEGINNINGS), st.just(0)),
    st.tuples(st.just("broken"), st.integers(0, 60), st.integers(1, 255)),
    st.tuples(st.just("cut"), st.integers(1, 40), st.just(0)),
    st.tuples(st.just("other"), st.sampled_from([16, 17, 32, 99]), st.integers(0, 9)),
    st.tuples(st.just("stranger"), st.integers(2, 9), st.just(0)),
)  # fmt: skip


def bytes_of(steps: list) -> bytes:
    """A stream as a bad line would deliver it."""
    data = b""
    for number, (what, first, second) in enumerate(steps):
        whole = counts_packet([number % 100] * 4, sequence=number, channel=number % 20)
        if what == "counts":
            data += counts_packet([7] * second, kind=first, sequence=number)
        elif what == "broken":
            at = first % len(whole)
            data += whole[:at] + bytes([whole[at] ^ second]) + whole[at + 1 :]
        elif what == "cut":
            data += whole[:-first] if first < len(whole) else b""
        elif what == "other":
            data += raw_packet(first, sequence=number, payload=bytes(second))
        elif what == "stranger":
            data += counts_packet([1], device=first)
        else:
            data += first
    return data


def in_pieces(data: bytes, cuts: list[int]) -> Iterator[bytes]:
    at = 0
    for size in cuts:
        yield data[at : at + size]
        at += size
    yield data[at:]


@given(st.lists(STEP, max_size=25), st.lists(st.integers(0, 90), max_size=20))
def test_scanner_finds_what_plain_python_finds(steps: list, cuts: list[int]) -> None:
    data = bytes_of(steps)
    reference = Reference(CHANNELS)
    done = reference.stream(data)
    scanner, blocks, seen = PacketScanner(PacketDecoder(CHANNELS)), Blocks(1 << 15), counters()
    state = Channels(CHANNELS)
    for piece in in_pieces(data, cuts):
        scanner.free[: len(piece)] = np.frombuffer(piece, np.uint8)
        blocks.clear()
        scanner.take(len(piece), blocks, 0, seen, 5)
        state.apply(blocks)
    assert scanner.used == len(data) - done
    assert seen[Count.BYTES] == len(data)
    compare(reference, seen, state)


@given(st.lists(STEP, max_size=25))
def test_datagram_gives_what_plain_python_finds(steps: list) -> None:
    data = bytes_of(steps)
    reference = Reference(CHANNELS)
    reference.stream(data, final=True)
    blocks, seen, state = Blocks(1 << 15), counters(), Channels(CHANNELS)
    octets = np.frombuffer(data, np.uint8)
    taken = PacketDecoder(CHANNELS).decode(octets, len(octets), blocks, 0, seen, 5)
    state.apply(blocks)
    assert taken == reference.received + reference.foreign
    compare(reference, seen, state)


def compare(reference: Reference, seen: np.ndarray, state: Channels) -> None:
    assert seen[Count.RECEIVED] == reference.received
    assert seen[Count.FOREIGN] == reference.foreign
    assert seen[Count.MALFORMED] == reference.malformed
    assert seen[Count.READINGS] == reference.readings
    expected = np.full(CHANNELS, np.nan)
    for channel, value in reference.values.items():
        expected[channel] = value
    np.testing.assert_array_equal(state.counts, expected)


@given(st.data())
def test_losses_twins_and_swaps_are_counted_exactly(data: st.DataObject) -> None:
    start = data.draw(st.integers(0, 2**32 - 1))
    count = data.draw(st.integers(1, 60))
    delays = data.draw(
        st.lists(st.sampled_from([0, 0, 0, 0, 1, 2, 5, 30, None]), min_size=count, max_size=count)
    )
    order = sorted((i + d, i) for i, d in enumerate(delays) if d is not None)
    sent = [i for _, i in order]
    twins = data.draw(st.lists(st.booleans(), min_size=len(sent), max_size=len(sent)))
    arrived = [i for i, twice in zip(sent, twins, strict=True) for i in [i] * (1 + twice)]
    decoder, blocks, seen = PacketDecoder(4), Blocks(1 << 15), counters()
    for i in arrived:
        packet = counts_packet([i % 256], kind=1, sequence=(start + i) % 2**32, time=1000 * i)
        octets = np.frombuffer(packet, np.uint8)
        assert decoder.decode(octets, len(octets), blocks, 0, seen, 10**9) == 1
    newest = np.maximum.accumulate([-1, *sent])
    late = [i for i, before in zip(sent, newest, strict=False) if i < before]
    spread = max(sent) - min(sent) + 1 if sent else 0
    assert seen[Count.DUPLICATED] == sum(twins)
    assert seen[Count.SWAPPED] == len(late)
    assert seen[Count.LOST] == spread - len(sent)
    assert seen[Count.READINGS] == len(sent)
    stamps = [b.stamp_ns for b in blocks_of(blocks.data)]
    lateness = [max(0, int(before) - i) for i, before in zip(sent, newest, strict=False)]
    assert stamps == [10**9 - 1_000_000 * many for many in lateness]


def feed(decoder: PacketDecoder, seen: np.ndarray, sequences: object, **fields: int) -> int:
    blocks = Blocks(1 << 12)
    for sequence in sequences:  # type: ignore[attr-defined]
        packet = counts_packet([1], kind=1, sequence=sequence, **fields)
        decoder.decode(np.frombuffer(packet, np.uint8), len(packet), blocks, 0, seen, 5)
        blocks.clear()
    return int(seen[Count.LOST])


def hello(decoder: PacketDecoder, seen: np.ndarray, time: int) -> None:
    packet = raw_packet(16, sequence=0, time=time)
    blocks = Blocks(1 << 12)
    decoder.decode(np.frombuffer(packet, np.uint8), len(packet), blocks, 0, seen, 5)


def test_restart_with_hello_loses_nothing() -> None:
    decoder, seen = PacketDecoder(4), counters()
    hello(decoder, seen, 3)
    feed(decoder, seen, range(1, 40))
    hello(decoder, seen, 3)
    assert seen[Count.DUPLICATED] == 1  # the same time: a copy, not a restart
    hello(decoder, seen, 9)
    assert feed(decoder, seen, range(1, 40)) == 0
    assert decoder.device(0).restarts == 1
    assert seen[Count.DUPLICATED] == 1
    assert feed(decoder, seen, [45]) == 5


def test_restart_without_hello_is_believed_at_the_second_packet() -> None:
    decoder, seen = PacketDecoder(4), counters()
    feed(decoder, seen, range(5000, 7000))
    assert feed(decoder, seen, [3, 4, 5, 8]) == 2
    assert decoder.device(0).restarts == 1
    assert seen[Count.SWAPPED] == 0
    assert seen[Count.READINGS] == 2004


def test_a_very_late_packet_is_no_restart() -> None:
    decoder, seen = PacketDecoder(4), counters()
    feed(decoder, seen, [n for n in range(5000) if n != 2000])
    assert seen[Count.LOST] == 1
    assert feed(decoder, seen, [2000, 5000, 5001]) == 0
    assert (decoder.device(0).restarts, seen[Count.SWAPPED]) == (0, 1)


def test_late_hello_of_the_same_start() -> None:
    decoder, seen = PacketDecoder(4), counters()
    feed(decoder, seen, [1, 2])
    hello(decoder, seen, 0)
    assert feed(decoder, seen, [3, 4]) == 0
    assert (decoder.device(0).restarts, seen[Count.SWAPPED]) == (0, 1)


def test_a_full_stream_goes_on_where_it_stopped() -> None:
    data = b"".join(counts_packet([n] * 8, kind=1, sequence=n) for n in range(100))
    scanner, blocks, seen = PacketScanner(PacketDecoder(8)), Blocks(400), counters()
    scanner.free[: len(data)] = np.frombuffer(data, np.uint8)
    taken, values = scanner.take(len(data), blocks, 0, seen, 5), []
    while taken:
        values += [int(b.payload[0]) for b in blocks_of(blocks.data)]
        blocks.clear()
        taken = scanner.take(0, blocks, 0, seen, 5)
    assert values == list(range(100))
    assert scanner.used == 0
    assert seen[Count.BYTES] == len(data)


def test_a_broken_connection_leaves_no_half_packet() -> None:
    packet = counts_packet([9] * 4, sequence=1)
    scanner, blocks, seen = PacketScanner(PacketDecoder(8)), Blocks(4096), counters()
    for piece in (packet[:20], packet):
        scanner.free[: len(piece)] = np.frombuffer(piece, np.uint8)
        scanner.take(len(piece), blocks, 0, seen, 5)
        scanner.forget()
    assert seen[Count.RECEIVED] == 1
    assert seen[Count.MALFORMED] == 0


def test_longest_packet_fits_the_smallest_scanner() -> None:
    packet = counts_packet([1.5] * 1016, kind=3)
    assert len(packet) == LONGEST
    scanner = PacketScanner(PacketDecoder(1016), 2 * LONGEST)
    blocks, seen = Blocks(1 << 15), counters()
    for byte in packet:
        scanner.free[0] = byte
        scanner.take(1, blocks, 0, seen, 5)
    assert seen[Count.READINGS] == 1
    with pytest.raises(InputError, match="received"):
        scanner.take(2 * LONGEST + 1, blocks, 0, seen, 5)


@given(st.binary(max_size=200), st.integers(0, 250), st.booleans())
def test_any_bytes_are_decoded_or_refused(data: bytes, length: int, framed: bool) -> None:
    if framed and len(data) >= 4:  # let most of them get past the sum
        data = raw_packet(
            data[0], sequence=data[1], channel=data[2], count=data[3], payload=data[4:]
        )
    decoder, blocks, seen = PacketDecoder(30), Blocks(4096), counters()
    blocks.words[:] = 0x55
    octets = np.frombuffer(data, np.uint8)
    taken = decoder.decode(octets, length, blocks, 0, seen, 5)
    assert taken >= 0
    Channels(30).apply(blocks)
    assert (blocks.words[blocks.end[0] :] == 0x55).all()
    decoder.device(0)
    try:
        found = len(list(packets_of(data)))
    except InputError:
        found = -1
    if length >= len(data):
        assert found in (-1, taken)
        try:
            packet_from_bytes(data).values  # noqa: B018
        except InputError:
            assert taken == 0 or data[:2] != b"SF"
