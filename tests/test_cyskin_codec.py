"""CySkin's packets: bytes written out by hand, checksums, readings, boards."""

import numpy as np
import pytest
from cyskin_reference import crc8
from hypothesis import given
from hypothesis import strategies as st

import skinfield as sf
from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.skin.generators import hexagon72
from skinfield.wire.can.messages import EXTENDED, CanMessages
from skinfield.wire.cyskin import (
    Command,
    Crc,
    CySkinBoard,
    CySkinBoardState,
    CySkinDecoder,
    CySkinEncoder,
    CySkinModule,
    CySkinWire,
    Sum,
    Unchecked,
    boards_from_uids,
    matching_checksums,
    on_boards,
    port_of,
    skin_on_boards,
    start_messages,
    stop_messages,
    uids_of,
)
from skinfield.wire.cyskin.wire import octets_behind

MODULES = (CySkinModule(100), CySkinModule(101, 0b0111_1111_1110), CySkinModule(102))
BOARDS = (CySkinBoard(5, MODULES[:2]), CySkinBoard(9, MODULES[2:], bus=1))


def test_sensor_data_in_three_messages() -> None:
    # 43 SENSOR_DATA, 14 octets, module 0, sensor 10, six responses: 2 of module 0, 4 of module 1,
    # whose sensor 0 is cut; CRC-8 with 0x07 at the end.
    body = "43 0e 00 0a 0001 0002 0102 ffff 0003 0004"
    rest = crc8(bytes.fromhex(body)).to_bytes().hex()
    rows = [(0x105, "43 0e 00 0a 00 01 00 02"), (0x205, "01 02 ff ff 00 03 00 04"), (0x405, rest)]
    messages = CanMessages(3)
    for row, (identifier, text) in enumerate(rows):
        messages.put(row, identifier, bytes.fromhex(text))
        messages.stamp_ns[row] = 1000 + row
    decoder, blocks, seen = CySkinDecoder(BOARDS), Blocks(1024), counters()
    assert decoder.decode(messages, 3, blocks, 100, seen) == 3
    assert [(b.stamp_ns, b.channel, b.payload.tolist()) for b in blocks_of(blocks.data)] == [
        (1002, 110, [1, 2]),
        (1002, 113, [258, 65535, 3, 4]),
    ]
    assert seen[Count.RECEIVED] == 3
    assert seen[Count.READINGS] == 2
    assert seen[Count.BYTES] == 17
    assert not seen[[Count.LOST, Count.MALFORMED, Count.FOREIGN]].any()
    assert decoder.channels == 36


@pytest.mark.parametrize(
    ("wire", "identifier", "packet"),
    [
        (CySkinWire(), 0x505, "3b 00 6e"),
        (CySkinWire(checksum=Sum()), 0x505, "3b 00 c5"),
        (CySkinWire(checksum=Unchecked(0)), 0x505, "3b 00"),
        (CySkinWire(extended=True), 0x94000005, "3b 00 6e"),
    ],
)
def test_golden_sync(wire: CySkinWire, identifier: int, packet: str) -> None:
    found = list(wire.messages(5, wire.packet(Command.SYNC)))
    assert found == [(identifier, bytes.fromhex(packet))]


def test_golden_start_and_stop() -> None:
    texts = map(bytes.fromhex, ["36 02 ff 00", "38 02 00 32", "37 01 01"])
    expected = [(0x505, data + bytes([crc8(data)])) for data in texts]
    assert start_messages(BOARDS[:1]) == expected
    little = CySkinWire(big_endian=False, extended=True)
    assert start_messages(BOARDS[:1], little, period_ms=300)[1][1][:4].hex() == "38022c01"
    assert [d[:3].hex() for _, d in stop_messages(BOARDS)] == ["370100"] * 2


def test_identifiers_of_parts() -> None:
    packet = bytes(range(20))
    standard = list(CySkinWire().messages(0xFF, packet))
    assert [(i, len(d)) for i, d in standard] == [(0x1FF, 8), (0x2FF, 8), (0x4FF, 4)]
    extended = list(CySkinWire(extended=True).messages(0x3FFFFFF, packet))
    assert [i ^ EXTENDED for i, _ in extended] == [0x07FFFFFF, 0x0BFFFFFF, 0x13FFFFFF]
    with pytest.raises(InputError, match="number of a board"):
        list(CySkinWire().messages(256, packet))


@pytest.mark.parametrize(
    ("checksum", "expected"),
    [  # the check values of the catalogues of CRCs, of 123456789
        (Crc(), "f4"),
        (Crc(polynomial=0x31, reflected=True), "a1"),  # MAXIM-DOW
        (Crc(polynomial=0x1D, begin=0xFF, final=0xFF), "4b"),  # SAE-J1850
        (Crc(polynomial=0x9B, begin=0xFF), "da"),  # CDMA2000
        (Crc(octets=2, polynomial=0x1021, begin=0xFFFF), "b129"),  # IBM-3740
        (Crc(octets=2, polynomial=0x1021, begin=0xFFFF, high_first=True), "29b1"),
        (Crc(octets=2, polynomial=0x1021, begin=0xFFFF, final=0xFFFF, reflected=True), "6e90"),
        (Crc(octets=2, polynomial=0x8005, begin=0xFFFF, reflected=True), "374b"),  # MODBUS
        (Sum(), "23"),
        (Sum(negated=False), "dd"),
        (Unchecked(2), "0000"),
        (Unchecked(0), ""),
    ],
)
def test_check_values(checksum: Crc, expected: str) -> None:
    assert octets_behind(b"123456789", checksum).hex() == expected


WIRES = st.builds(
    CySkinWire,
    extended=st.booleans(),
    big_endian=st.booleans(),
    checksum=st.one_of(
        st.builds(
            Crc, octets=st.just(1), polynomial=st.sampled_from([7, 0x31]),
            begin=st.sampled_from([0, 255]), reflected=st.booleans(),
        ),
        st.builds(
            Crc, octets=st.just(2), polynomial=st.sampled_from([0x1021, 0x8005]),
            final=st.sampled_from([0, 0xFFFF]), reflected=st.booleans(), high_first=st.booleans(),
        ),
        st.builds(Sum, st.booleans()),
        st.builds(Unchecked, st.integers(0, 2)),
    ),
)  # fmt: skip


@given(
    WIRES, st.lists(st.integers(1, 0xFFF), min_size=2, max_size=40), st.integers(1, 126), st.data()
)
def test_readings_come_back(
    wire: CySkinWire, masks: list[int], per_packet: int, data: st.DataObject
) -> None:
    modules = tuple(CySkinModule(7 * i, mask) for i, mask in enumerate(masks))
    cut = data.draw(st.integers(1, len(modules) - 1))
    boards = (CySkinBoard(3, modules[:cut]), CySkinBoard(200, modules[cut:]))
    encoder = CySkinEncoder(boards, wire=wire, per_packet=per_packet)
    decoder, seen = CySkinDecoder(boards, wire=wire), counters()
    rng = np.random.default_rng(len(masks))
    messages, state = CanMessages(2000), Channels(decoder.channels)
    for _ in range(3):
        encoder.counts[:] = rng.integers(0, 65536, len(encoder.counts))
        count = encoder.encode(messages, 5, 77)
        assert count - 5 == encoder.messages_per_reading
        blocks = Blocks(1 << 16)
        assert decoder.decode(messages, count, blocks, 0, seen, 5) == count
        state.apply(blocks)
    there = uids_of(boards)[1]
    np.testing.assert_array_equal(state.counts[there], encoder.counts[there])
    assert np.isfinite(state.counts).sum() == len(there)
    assert not seen[[Count.LOST, Count.MALFORMED, Count.FOREIGN]].any()


def test_boards_of_two_buses_share_the_channels() -> None:
    encoder, messages = CySkinEncoder(BOARDS, bus=1), CanMessages(40)
    encoder.counts[:] = np.arange(36) * 10
    count = encoder.encode(messages, 0, 5)
    for bus, expected in ((0, []), (1, list(range(240, 360, 10)))):
        blocks, seen = Blocks(1024), counters()
        CySkinDecoder(BOARDS, bus).decode(messages, count, blocks, 0, seen)
        assert [v for b in blocks_of(blocks.data) for v in b.payload.tolist()] == expected
        assert seen[Count.FOREIGN] == (count if bus == 0 else 0)


def test_the_checksum_of_a_board_is_found() -> None:
    truth = Crc(polynomial=0x31, begin=0xFF)
    wire = CySkinWire(checksum=truth)
    packets = [wire.packet(Command.SENSOR_DATA, bytes([0, n, n * 7 % 256, n])) for n in range(12)]
    assert matching_checksums(packets) == (truth,)
    assert Crc() in matching_checksums([CySkinWire().packet(0x3B)])
    assert matching_checksums([b"\x43\x01\x00\x11\x22\x33"]) == ()
    with pytest.raises(InputError, match="expected ten or more"):
        matching_checksums([])
    with pytest.raises(InputError, match="has 2 octets"):
        matching_checksums([b"12"])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: CySkinModule(1, 0), "at least one"),
        (lambda: CySkinModule(2**32), "number of a module"),
        (lambda: CySkinBoard(1, ()), "of one board"),
        (lambda: CySkinDecoder([]), "each .bus, number. once"),
        (lambda: CySkinDecoder([BOARDS[0], CySkinBoard(6, MODULES[:1])]), r"\[100\] stand there"),
        (lambda: CySkinEncoder(BOARDS, per_packet=127), "responses in a packet"),
        (lambda: CySkinEncoder(BOARDS).encode(CanMessages(2), 0, 0), "2 rows, expected 7"),
        (lambda: CySkinWire().packet(5), "below are numbers"),
        (lambda: CySkinWire().packet(0x3B, bytes(256)), "split"),
        (lambda: start_messages(BOARDS, period_ms=0), "between two readings"),
    ],
)
def test_mistakes_are_named(make: object, says: str) -> None:
    with pytest.raises(InputError, match=says):
        make()  # type: ignore[operator]


def test_uids_channels_and_skins() -> None:
    uids, channels = uids_of(BOARDS)
    assert uids[:2].tolist() == [1600, 1601]
    assert channels.tolist() == [*range(12), *range(13, 23), *range(24, 36)]
    positions = np.array([[0.01 * i, 0.0] for i in range(4)] + [[0.0, 0.01]])
    patch = sf.Patch(positions, uid=[1619, 1601, 1632, 1611, 1643], name="p")
    skin = skin_on_boards(sf.Skin((patch,), "arm"), BOARDS)
    assert skin[0].channel.tolist() == [15, 1, 24, 11, 35]
    assert (skin[0].n_channels, skin.name, port_of(BOARDS).channels) == (36, "arm", 36)
    with pytest.raises(InputError, match=r"\[1616\].*1 have no sensor"):
        skin_on_boards(sf.Skin(sf.Patch(positions[:3], uid=[1616, 1601, 1602])), BOARDS)


def test_boards_of_a_layout() -> None:
    boards = boards_from_uids([0x101, 0x10B, 0x203, 0x305], numbers=(4, 8))
    assert [board.number for board in boards] == [4, 8]
    assert [m.sui for board in boards for m in board.modules] == [0x10, 0x20, 0x30]
    assert boards[0].modules[0].sensors == (0, 1, 11)
    assert boards_from_uids([0x101], temperature=False)[0].modules[0].sensors == (1,)
    with pytest.raises(InputError, match="no more"):
        boards_from_uids([0x10C])
    with pytest.raises(InputError, match="1 modules for 2 boards"):
        boards_from_uids([0x101], numbers=(1, 2))


def test_any_skin_gets_boards() -> None:
    skin, boards = on_boards(sf.Skin(hexagon72()))
    sensors = sum(len(m.sensors) for board in boards for m in board.modules)
    assert sensors == sum(map(len, skin)) == 72
    assert sorted(skin[0].channel.tolist()) == list(range(72))
    again, same = on_boards(skin)
    assert same == boards
    np.testing.assert_array_equal(again[0].channel, skin[0].channel)


def test_a_board_in_software_obeys() -> None:
    wire = CySkinWire()
    state = CySkinBoardState(wire)
    for _, packet in start_messages(BOARDS[:1], wire, period_ms=20):
        whole = wire.unpacked(packet)
        assert whole is not None
        state = state.after(*whole)
    assert (state.sending, state.period_ms, state.syncs) == (True, 20, 0)
    assert state.after(0x32, b"") == state.after(Command.SET_AUTO_SYNC_PERIOD, b"\0\0") == state
    state = state.after(Command.SYNC, b"").after(Command.SET_AUTO_SYNC, b"\0")
    assert (state.sending, state.syncs) == (False, 1)


@pytest.mark.parametrize("packet", ["", "3b", "3b 00", "3b 01 00", "3b 00 00", "3b 00 6e 00"])
def test_damaged_packets_are_none(packet: str) -> None:
    assert CySkinWire().unpacked(bytes.fromhex(packet)) is None
