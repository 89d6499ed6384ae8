"""Messages of CAN as msgpack maps: against msgpack and python-can themselves."""

import struct

import can
import msgpack
import numpy as np
import pytest
from bus_peers import drawn_messages
from can.interfaces.udp_multicast.utils import pack_message
from hypothesis import example, given, settings
from hypothesis import strategies as st

from skinfield.acquisition import CanMessages
from skinfield.acquisition.can import ERROR, EXTENDED, REMOTE
from skinfield.sources.buses.can_map_kernel import NAMES, unpack_message, unpack_messages
from skinfield.sources.buses.can_pack_kernel import ENCODED, pack_messages
from skinfield.sources.buses.msgpack_kernel import BAD, behind, item_at

GUARD = 64  # octets behind a datagram that must not matter
USUAL = {
    "timestamp": 0.0,
    "arbitration_id": 0x4D5,
    "is_extended_id": False,
    "is_remote_frame": False,
    "is_error_frame": False,
    "channel": None,
    "dlc": 3,
    "data": b"abc",
    "is_fd": False,
    "bitrate_switch": False,
    "error_state_indicator": False,
}


def unpacked(datagram: bytes, guard: int = 0xA5) -> tuple[int, bytes] | None:
    """Identifier and data that the compiled reader finds; None of what it refuses."""
    octets = np.full(len(datagram) + GUARD, guard, np.uint8)
    octets[: len(datagram)] = np.frombuffer(datagram, np.uint8)
    data = np.zeros(8, np.uint8)
    good, identifier, length = unpack_message(octets, 0, len(datagram), data)
    if not good:
        return None
    return int(identifier), bytes(length) if identifier & REMOTE else data[:length].tobytes()


def encoded(messages: CanMessages) -> list[bytes]:
    count = len(messages)
    octets = np.full(count * ENCODED, 0xEE, np.uint8)
    lengths, seconds = np.zeros(count, np.int64), np.zeros(1)
    pack_messages(
        messages.ids, messages.lengths, messages.data, messages.stamp_ns, 0, count, octets,
        ENCODED, lengths, seconds, seconds.view(np.int64),
    )  # fmt: skip
    rows = octets.reshape(count, ENCODED)
    return [row[:length].tobytes() for row, length in zip(rows, lengths, strict=True)]


def python_cans(messages: CanMessages, row: int) -> can.Message:
    identifier, length = int(messages.ids[row]), int(messages.lengths[row])
    remote = bool(identifier & REMOTE)
    return can.Message(
        timestamp=messages.stamp_ns[row] * 1e-9,
        arbitration_id=identifier & 0x1FFFFFFF,
        is_extended_id=bool(identifier & EXTENDED),
        is_remote_frame=remote,
        dlc=length,
        data=None if remote else messages.data[row, :length].tobytes(),
        check=True,
    )


def test_what_is_sent_is_what_python_can_packs() -> None:
    messages = drawn_messages(np.random.default_rng(1), 300)
    edges = [0, 0x7F, 0x80, 0xFF, 0x100, 0x7FF, 0xFFFF | EXTENDED, 0x10000 | EXTENDED]
    messages.ids[: len(edges)] = edges
    for row, datagram in enumerate(encoded(messages)):
        assert datagram == pack_message(python_cans(messages, row)), hex(messages.ids[row])


def test_what_python_can_packs_is_understood() -> None:
    messages = drawn_messages(np.random.default_rng(2), 300)
    for row in range(len(messages)):
        identifier, length = int(messages.ids[row]), int(messages.lengths[row])
        expected = bytes(length) if identifier & REMOTE else messages.data[row, :length].tobytes()
        assert unpacked(pack_message(python_cans(messages, row))) == (identifier, expected)


@pytest.mark.parametrize(
    "change",
    [
        {"arbitration_id": 0x800},  # of 11 bits
        {"arbitration_id": -1},
        {"arbitration_id": 0x2000_0000, "is_extended_id": True},
        {"arbitration_id": 2**64 - 1, "is_extended_id": True},
        {"arbitration_id": 5.0},
        {"arbitration_id": None},
        {"dlc": 4},
        {"data": bytes(9), "dlc": 9},
        {"data": bytes(12), "dlc": 12, "is_fd": True},
        {"data": "abc", "is_remote_frame": True},
        {"data": [1, 256], "dlc": 2},
        {"data": 7},
        {"is_extended_id": "yes"},
    ],
)
def test_what_is_no_message_of_classic_can_is_refused(change: dict) -> None:
    assert unpacked(msgpack.packb(USUAL | change)) is None


@pytest.mark.parametrize(
    "change",
    [
        {"is_extended_id": 0, "is_remote_frame": 0.0, "is_fd": None},
        {"more": {"of": [1, {"everything": [None, b"x" * 40]}]}, "and": -(2**62)},
        {"dlc": None},
        {"data": [97, 98, 99]},
        {"data": "abc"},
        {"timestamp": 2**63, "channel": "can0"},
        {"channel": msgpack.ExtType(4, b"1234"), "timestamp": msgpack.Timestamp(5, 6)},
    ],
)
def test_other_ways_to_say_the_same_are_understood(change: dict) -> None:
    assert unpacked(msgpack.packb(USUAL | change)) == (0x4D5, b"abc")


def test_keys_in_any_order_and_of_other_kinds() -> None:
    backwards = dict(reversed(USUAL.items()))
    assert unpacked(msgpack.packb(backwards)) == (0x4D5, b"abc")
    assert unpacked(msgpack.packb({7: 8, (1, 2): 3, None: [4], b"dlc": 9} | USUAL)) is not None
    assert unpacked(msgpack.packb({"arbitration_id": 1, "is_extended_id": True})) == (
        1 | EXTENDED,
        b"",
    )


@pytest.mark.parametrize("head", [b"\x8b", b"\xde\x00\x0b", b"\xdf\x00\x00\x00\x0b"])
def test_any_width_of_every_number(head: bytes) -> None:
    body = msgpack.packb(USUAL)[1:]
    wide = struct.pack(">Q", 0x4D5)
    body = body.replace(b"\xcd\x04\xd5", b"\xcf" + wide).replace(
        b"\xa3dlc\x03", b"\xd9\x03dlc\xd1\x00\x03"
    )
    body = body.replace(b"\xc4\x03abc", b"\xc6\x00\x00\x00\x03abc").replace(
        b"\xa4data", b"\xda\x00\x04data"
    )
    assert unpacked(head + body) == (0x4D5, b"abc")


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_cut_datagrams_are_refused_whatever_lies_behind(drawn: st.DataObject) -> None:
    datagram = msgpack.packb(USUAL)
    cut = drawn.draw(st.integers(0, len(datagram) - 1))
    for guard in (0x00, 0xC0, 0xA5, 0xFF):
        assert unpacked(datagram[:cut], guard) is None
    assert unpacked(datagram + b"\xc0") is None  # nor with anything behind


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text(max_size=5)
    | st.binary(max_size=10),
    lambda inner: st.lists(inner, max_size=4)
    | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=8,
)  # fmt: skip


@given(st.dictionaries(st.sampled_from([*NAMES, "x", "data2"]), VALUES, max_size=12))
@settings(max_examples=300, deadline=None)
def test_maps_of_anything_are_judged_as_plain_python_judges_them(drawn: dict) -> None:
    assert unpacked(msgpack.packb(drawn)) == plainly(drawn)


FLAGS = {"is_extended_id": EXTENDED, "is_remote_frame": REMOTE, "is_error_frame": ERROR, "is_fd": 1}


def plainly(message: dict) -> tuple[int, bytes] | None:
    """What a map means, written down once more without the bytes."""
    flags = {
        "is_extended_id": EXTENDED,
        "is_remote_frame": REMOTE,
        "is_error_frame": ERROR,
        "is_fd": 1,
    }
    bits = EXTENDED
    for key, bit in flags.items():
        value = message.get(key, key == "is_extended_id")
        if not isinstance(value, bool | int | float | None):
            return None
        bits = bits | bit if value else bits & ~bit
    identifier, data, dlc = (message.get(key) for key in ("arbitration_id", "data", "dlc"))
    if isinstance(identifier, bool) or not isinstance(identifier, int) or bits & 1:
        return None
    if isinstance(data, list) and any(
        isinstance(each, bool) or not isinstance(each, int) or not 0 <= each <= 255 for each in data
    ):
        return None
    if not isinstance(data, list | bytes | str | None) or isinstance(
        dlc, bool | float | str | bytes | list | dict
    ):
        return None
    octets = b"" if data is None else data.encode() if isinstance(data, str) else bytes(data)
    if not 0 <= identifier <= (0x1FFFFFFF if bits & EXTENDED else 0x7FF) or len(octets) > 8:
        return None
    if bits & REMOTE:
        if octets or not 0 <= (dlc or 0) <= 8:
            return None
        return identifier | bits, bytes(dlc or 0)
    return None if dlc is not None and dlc != len(octets) else (identifier | bits, octets)


@given(st.binary(max_size=80))
@settings(max_examples=400, deadline=None)
@example(b"\xdf\xff\xff\xff\xff" + b"\xdd\xff\xff\xff\xff" * 8)
def test_any_bytes_are_skipped_as_msgpack_does(data: bytes) -> None:
    octets = np.frombuffer(data + bytes(GUARD), np.uint8).copy()
    end = behind(octets, 0, len(data))
    unpacker = msgpack.Unpacker(raw=True, strict_map_key=False, max_buffer_size=1 << 20)
    unpacker.feed(data)
    try:
        unpacker.skip()
        expected = unpacker.tell()
    except (msgpack.OutOfData, msgpack.FormatError, msgpack.StackError, ValueError):
        expected = -1
    assert end == expected
    unpacked(data)
    kind, *_ = item_at(octets, 0, len(data))
    assert (kind == BAD) <= (expected == -1)


def test_nothing_is_written_behind_the_last_row() -> None:
    messages, counts = CanMessages(8), np.zeros(2, np.int64)
    datagram = msgpack.packb(USUAL)
    octets = np.zeros((6, 256), np.uint8)
    octets[:, : len(datagram)] = np.frombuffer(datagram, np.uint8)
    lengths = np.full(6, len(datagram), np.int64)
    lengths[1:4] = 0, -1, 5  # an announcement, one that was cut, a broken one
    last = unpack_messages(
        octets.reshape(-1), 256, lengths, np.arange(6), np.zeros((6, 32), np.uint8),
        np.zeros(32, np.uint8), 6, 7, messages.ids[:8], messages.lengths, messages.data,
        messages.stamp_ns, counts,
    )  # fmt: skip
    assert last == 8
    assert counts.tolist() == [4, 0]
    assert messages.ids.tolist() == [0] * 7 + [0x4D5]
