"""Packets of microcontrollers: golden bytes, encoders, streams of bytes, bad networks."""

from binascii import crc_hqx
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from packet_reference import Reference, counts_packet, decode, packets_of, raw_packet

from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count, Kind, Status, blocks_of, counters
from skinfield.wire.packet import (
    EVERY_DEVICE,
    LONGEST,
    CommandReply,
    Hello,
    Packet,
    PacketDecoder,
    PacketDevice,
    PacketEncoder,
    PacketFlag,
    PacketKind,
    PacketScanner,
    encode_command,
    encode_counts,
    encode_packet,
    packet_from_bytes,
)
from skinfield.wire.packet.kernel import RESTARTS, crc_ccitt

SHORTS = "5346 01 02 0100 0600 07000000 40420f00 0300 0300 0200 01 00 0100 0200 2c01 073b"
BYTES = "5346 01 01 0200 0300 00000000 00000000 0000 0300 0000 00 02 0a 14 ff c15c"
FLOATS = "5346 01 03 0100 0800 01000000 00000000 0000 0200 0000 01 00 0000803f 0000c07f 52e2"
SIGNED = "5346 01 05 0100 0400 01000000 00000000 0000 0200 0000 01 00 ffff 0080 ceae"
STATUS = "5346 01 04 0100 0200 09000000 00000000 0400 0a00 0000 01 01 0102 0606"
HELLO = (
    "5346 01 10 0100 1500 00000000 00000000 0000 0000 0000 01 00"
    "4800 02 00 10270000 0011223344556677 04 70616c6d 3f7e"
)
ANSWER = "5346 01 11 0100 0800 02000000 00000000 0000 0000 0000 01 00 22 02 0000 05000000 844f"
PERIOD = "5346 01 22 ffff 0400 05000000 00000000 0000 0000 0000 01 00 e8030000 95cc"
GOLDEN = {
    SHORTS: Packet(
        kind=2, device=1, sequence=7, time_us=1_000_000, channel=3, count=3, reading=2,
        payload=bytes.fromhex("0100 0200 2c01"),
    ),
    BYTES: Packet(
        kind=1, device=2, count=3, flags=PacketFlag.NONE, status=Status.NOT_CONNECTED,
        payload=bytes([10, 20, 255]),
    ),
    FLOATS: Packet(kind=3, sequence=1, count=2, payload=bytes.fromhex("0000803f 0000c07f")),
    SIGNED: Packet(kind=5, sequence=1, count=2, payload=bytes.fromhex("ffff 0080")),
    STATUS: Packet(
        kind=4, sequence=9, channel=4, count=10, status=Status.NO_ACK, payload=b"\x01\x02"
    ),
    HELLO: Packet(kind=16, payload=Hello(
        channels=72, period_us=10_000, layout=bytes.fromhex("0011223344556677"), name="palm"
    ).payload),
    ANSWER: Packet(kind=17, sequence=2, payload=CommandReply(PacketKind.PERIOD, 2, 5).payload),
    PERIOD: Packet(kind=34, device=0xFFFF, sequence=5, payload=bytes.fromhex("e8030000")),
}  # fmt: skip


@pytest.mark.parametrize("text", GOLDEN)
def test_golden_bytes(text: str) -> None:
    data = bytes.fromhex(text)
    assert encode_packet(GOLDEN[text]) == data
    assert packet_from_bytes(data) == GOLDEN[text]
    assert crc_hqx(data[:-2], 0xFFFF) == int.from_bytes(data[-2:], "little")


@given(st.binary(max_size=300), st.integers(0, 20))
def test_sum_is_that_of_the_standard_library(data: bytes, start: int) -> None:
    octets = np.frombuffer(b"\0" * 20 + data, np.uint8)
    assert crc_ccitt(octets, start, len(octets)) == crc_hqx(octets[start:].tobytes(), 0xFFFF)


def test_values_and_commands() -> None:
    assert packet_from_bytes(bytes.fromhex(SIGNED)).values == (-1, -32768)
    assert packet_from_bytes(bytes.fromhex(STATUS)).values == ()
    assert encode_counts([1, 2, 300], GOLDEN[SHORTS]) == bytes.fromhex(SHORTS)
    assert encode_command(PacketKind.PERIOD, sequence=5, period_us=1000) == bytes.fromhex(PERIOD)
    start = packet_from_bytes(encode_command(PacketKind.START))
    assert (start.kind, start.device, start.payload) == (32, EVERY_DEVICE, b"")


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: encode_packet(Packet(kind=2, count=2, payload=b"123")), "expected 4"),
        (lambda: encode_packet(Packet(kind=16, payload=bytes(4065))), "split"),
        (lambda: encode_packet(Packet(kind=16, device=65536)), "does not fit"),
        (lambda: encode_counts([1], Packet(kind=16)), "kinds of counts"),
        (lambda: encode_command(PacketKind.SHORTS), "expected START"),
        (lambda: encode_command(PacketKind.PERIOD), "period_us is None"),
        (lambda: Hello(channels=3, unit="N"), "unit is 'N'"),
        (lambda: Hello(channels=3, name="x" * 65), "at most 64"),
        (lambda: packet_from_bytes(b"SF"), "header of 24"),
        (lambda: packet_from_bytes(b"XX" + bytes(30)), "no packet"),
        (lambda: packet_from_bytes(bytes.fromhex(SHORTS)[:-1]), "cut"),
        (lambda: packet_from_bytes(bytes.fromhex(SHORTS)[:-1] + b"\0"), "damaged"),
        (lambda: PacketDecoder([]), "each once"),
        (lambda: PacketDecoder([PacketDevice(1, 2), PacketDevice(1, 2)]), "each once"),
        (lambda: PacketEncoder(72, PacketKind.HELLO), "expected BYTES"),
    ],
)
def test_mistakes_are_named(make: object, says: str) -> None:
    with pytest.raises(InputError, match=says):
        make()  # type: ignore[operator]


@pytest.mark.parametrize("kind", [1, 2, 3, 5])
@pytest.mark.parametrize("channels", [1, 12, 701, 4000])
def test_a_reading_comes_back_whole(kind: int, channels: int) -> None:
    rng = np.random.default_rng(channels)
    low, high = {1: (0, 256), 2: (0, 65536), 3: (-9, 9), 5: (-32768, 32768)}[kind]
    values = rng.integers(low, high, channels).astype(float)
    encoder, decoder = PacketEncoder(channels, PacketKind(kind)), PacketDecoder(channels)
    blocks, seen, state = Blocks(1 << 16), counters(), Channels(channels)
    for turn in range(2):
        packets = encoder.encode(values + (turn == 1) * (kind == 3), 1000 * turn)
        assert len(packets) == -(-channels // (1446 // {1: 1, 2: 2, 3: 4, 5: 2}[kind]))
        for packet in packets:
            assert len(packet) <= 1472
            assert packet_from_bytes(packet).flags == (packet is packets[-1])
            assert decode(decoder, packet, blocks, seen) == 1
    state.apply(blocks)
    np.testing.assert_array_equal(state.counts, values + (kind == 3))
    assert seen[Count.READINGS] == seen[Count.RECEIVED] == 2 * len(packets)
    assert seen[Count.LOST] == seen[Count.MALFORMED] == seen[Count.FOREIGN] == 0


def test_a_reading_is_numbered_across_its_packets() -> None:
    encoder, values = PacketEncoder(1500, PacketKind.SIGNED, device=9), range(-700, 800)
    encoder.sequence, encoder.reading = 0xFFFFFFFE, 65535
    packets = encoder.encode(values, 2**32 + 77, Status.INVALID)
    found = list(packets_of(b"".join(packets)))
    assert [p.values for p in found] == [tuple(values[at : at + 723]) for at in (0, 723, 1446)]
    assert [p.sequence for p in found] == [0xFFFFFFFE, 0xFFFFFFFF, 0]
    assert [p.channel for p in found] == [0, 723, 1446]
    assert [p.flags for p in found] == [0, 0, 1]
    assert {(p.device, p.time_us, p.reading, p.status) for p in found} == {(9, 77, 65535, 8)}
    assert (encoder.sequence, encoder.reading) == (1, 0)


def test_several_devices_lie_one_after_the_other() -> None:
    decoder = PacketDecoder([PacketDevice(7, 3), PacketDevice(2, 4)])
    blocks, seen = Blocks(1024), counters()
    data = counts_packet([5], device=2, channel=3) + counts_packet([6, 7], device=7, channel=1)
    data += counts_packet([1], device=3) + counts_packet([1, 2], device=7, channel=2, sequence=1)
    data += raw_packet(32, device=7)
    assert decode(decoder, data, blocks, seen, channel=10) == 5
    assert [(b.channel, b.payload.tolist()) for b in blocks_of(blocks.data)] == [
        (16, [5]),
        (11, [6, 7]),
    ]
    assert (seen[Count.RECEIVED], seen[Count.FOREIGN], seen[Count.BYTES]) == (2, 3, len(data))


def test_status_is_set_and_taken_back() -> None:
    decoder, blocks, seen, state = PacketDecoder(10), Blocks(1024), counters(), Channels(10)

    def take(packet: bytes) -> list[int]:
        blocks.clear()
        assert decode(decoder, packet, blocks, seen) == 1
        state.apply(blocks)
        return state.status.tolist()

    assert take(counts_packet([1] * 10)) == [0] * 10
    assert (
        take(counts_packet([1] * 4, channel=2, sequence=1, status=0xF2))
        == [0, 0] + [2] * 4 + [0] * 4
    )
    assert take(counts_packet([1] * 2, channel=4, sequence=2)) == [0, 0, 2, 2] + [0] * 6
    assert take(raw_packet(4, sequence=3, count=10, status=1, payload=b"\x01\x02")) == [
        5, 1, 1, 1, 1, 1, 1, 1, 1, 5,
    ]  # fmt: skip
    # What a packet of status said stays, as the next of them takes it back.
    assert take(counts_packet([1] * 10, sequence=4))[0] == 5
    assert take(raw_packet(4, sequence=5, count=10, payload=b"\0\0")) == [0] * 10


def test_without_room_nothing_is_taken() -> None:
    decoder, blocks, seen = PacketDecoder(400), Blocks(1200), counters()
    data = counts_packet([3] * 200) + counts_packet([4] * 200, channel=200, sequence=1)
    assert decode(decoder, data, blocks, seen) is None
    assert not seen.any()
    assert len(blocks.data) == 0
    blocks = Blocks(1 << 14)
    assert decode(decoder, data, blocks, seen) == 2
    assert [b.kind for b in blocks_of(blocks.data)] == [Kind.SHORTS] * 2


def test_many_datagrams_at_once() -> None:
    decoder, blocks, seen = PacketDecoder(8), Blocks(512), counters()
    packets = [counts_packet([i] * 8, kind=1, sequence=i) for i in range(20)]
    rows, lengths = np.zeros((20, 64), np.uint8), np.array([len(each) for each in packets])
    for row, data in zip(rows, packets, strict=True):
        row[: len(data)] = np.frombuffer(data, np.uint8)
    at, found = 0, []
    while at < 20:
        before = at
        at = decoder.decode_many(rows, lengths, np.arange(20), at, 20, blocks, 0, seen)
        assert at > before
        found += [(b.stamp_ns, b.payload[0]) for b in blocks_of(blocks.data)]
        blocks.clear()
    assert found == [(i, i) for i in range(20)]
    assert seen[Count.RECEIVED] == 20


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


def scan(scanner: PacketScanner, piece: bytes, blocks: Blocks, seen: np.ndarray) -> int:
    scanner.free[: len(piece)] = np.frombuffer(piece, np.uint8)
    return scanner.take(len(piece), blocks, 0, seen, 5)


@given(st.lists(STEP, max_size=25), st.none() | st.lists(st.integers(0, 90), max_size=20))
def test_what_plain_python_finds_is_found(steps: list, cuts: list[int] | None) -> None:
    """In a stream that is cut, or in one datagram."""
    data, reference = bytes_of(steps), Reference(CHANNELS)
    done = reference.stream(data, final=cuts is None)
    decoder, blocks, seen = PacketDecoder(CHANNELS), Blocks(1 << 15), counters()
    state = Channels(CHANNELS)
    if cuts is None:
        taken = decode(decoder, data, blocks, seen)
        assert taken == reference.counts["RECEIVED"] + reference.counts["FOREIGN"]
        state.apply(blocks)
    else:
        scanner = PacketScanner(decoder)
        for piece in in_pieces(data, cuts):
            blocks.clear()
            scan(scanner, piece, blocks, seen)
            state.apply(blocks)
        assert scanner.used == len(data) - done
    assert seen[Count.BYTES] == len(data)
    for name, count in reference.counts.items():
        assert seen[Count[name]] == count, name
    expected = np.full(CHANNELS, np.nan)
    expected[list(reference.values)] = list(reference.values.values())
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
        packet = counts_packet([i % 256], kind=1, sequence=(start + i) % 2**32, time_us=1000 * i)
        assert decode(decoder, packet, blocks, seen, 10**9) == 1
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


ALL_BUT_2000 = [n for n in range(5000) if n != 2000]


@pytest.mark.parametrize(
    ("steps", "restarts", "counts"),
    [  # numbers of packets, or the time of a HELLO; a copy of it has the same time
        ([3, range(1, 40), 3, 9, range(1, 40)], 1, {"DUPLICATED": 1}),
        ([3, range(1, 40), 9, range(1, 40), [45]], 1, {"LOST": 5}),
        # without a HELLO it is believed at the second packet
        ([range(5000, 7000), [3, 4, 5, 8]], 1, {"LOST": 2, "READINGS": 2004}),
        ([ALL_BUT_2000], 0, {"LOST": 1}),
        ([ALL_BUT_2000, [2000, 5000, 5001]], 0, {"SWAPPED": 1}),  # very late, but no restart
        ([[1, 2], 0, [3, 4]], 0, {"SWAPPED": 1}),  # a late HELLO of the same start
    ],
)
def test_restarts_are_told_from_late_packets(steps: list, restarts: int, counts: dict) -> None:
    decoder, seen = PacketDecoder(4), counters()
    for step in steps:
        packets = [raw_packet(16, time_us=step)] if isinstance(step, int) else (
            counts_packet([1], kind=1, sequence=sequence) for sequence in step
        )  # fmt: skip
        for packet in packets:
            decode(decoder, packet, Blocks(512), seen)
    assert decoder.state[0, RESTARTS] == restarts
    for name in ("LOST", "DUPLICATED", "SWAPPED", *counts):
        assert seen[Count[name]] == counts.get(name, 0), name


def test_a_full_stream_goes_on_where_it_stopped() -> None:
    data = b"".join(counts_packet([n] * 8, kind=1, sequence=n) for n in range(100))
    scanner, blocks, seen = PacketScanner(PacketDecoder(8)), Blocks(400), counters()
    taken, values = scan(scanner, data, blocks, seen), []
    while taken:
        values += [int(b.payload[0]) for b in blocks_of(blocks.data)]
        blocks.clear()
        taken = scanner.take(0, blocks, 0, seen, 5)
    assert values == list(range(100))
    assert scanner.used == 0
    assert seen[Count.BYTES] == len(data)


def test_the_longest_packet_byte_by_byte() -> None:
    packet = counts_packet([1.5] * 1016, kind=3)
    assert len(packet) == LONGEST
    scanner = PacketScanner(PacketDecoder(1016))
    blocks, seen = Blocks(1 << 15), counters()
    for at in range(len(packet)):
        scan(scanner, packet[at : at + 1], blocks, seen)
    assert seen[Count.READINGS] == 1
    with pytest.raises(InputError, match="received"):
        scanner.take(len(scanner.free) + 1, blocks, 0, seen, 5)
