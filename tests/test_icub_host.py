"""What a host tells iCub's boards, what they make of it, and arrays of messages over Ethernet."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.acquisition import CanMessages, Count, counters
from skinfield.errors import InputError
from skinfield.protocols.icub import (
    BoardState,
    Firmware,
    MessageClass,
    SetBoard,
    SetOldBoard,
    SetOldSkin,
    SetTriangles,
    SkinType,
    Transmit,
    addressed_board,
    array_of_messages,
    command_from,
    host_message,
    messages_of_array,
)

COMMANDS = {
    "4d 00 28 f0": SetBoard(),
    "4d 08 32 f5": SetBoard(kind=SkinType.COMPENSATED_V2, period_ms=50, no_load=245),
    "50 00 0f 02 01 00 22": SetTriangles(),
    "50 03 06 01 00 34 12": SetTriangles(
        first=3, last=6, shift=1, enabled=False, cdc_offset=0x1234
    ),
    "07 00": Transmit(True),
    "07 01": Transmit(False),
    "4c 01 01 03 00 20 00 35": SetOldBoard(timer=3, cdc_offset=0x2000, time=0x3500),
    "4e 02 22 f0 00 ff ff 0a": SetOldSkin(),
}


@pytest.mark.parametrize("data", COMMANDS)
def test_commands_and_their_bytes(data):
    command, data = COMMANDS[data], bytes.fromhex(data)
    assert command.data == data
    assert command_from(data) == command
    assert host_message(13, command) == (0x20D, data)


def test_the_address_is_in_the_identifier():
    assert addressed_board(0x20D) == 13
    assert addressed_board(0x21D) is None  # of another sender
    assert addressed_board(0x4D5) is None
    assert addressed_board(0x8000020D) is None


@pytest.mark.parametrize(
    "data", ["", "07", "4d 00 28", "4d 00 00 f0", "50 04 03 02 01 00 22", "50 00 10 02 01 00 22"]
)
def test_what_makes_no_sense_is_no_command(data):
    assert command_from(bytes.fromhex(data)) is None


@given(st.binary(max_size=8), st.sampled_from(list(Firmware)))
def test_any_bytes_are_a_command_or_none(data, firmware):
    command, before = command_from(data), BoardState(firmware=firmware)
    after = before.after(data)
    assert after.ignored == (command is None)
    if command is not None:
        assert command_from(command.data) == command


def test_a_board_is_configured_and_started_as_a_robot_does():
    board = BoardState()
    assert (board.kind, board.period_ms, board.no_load, board.sending) == (0, 40, 240, False)
    board = board.after(SetBoard(kind=8, period_ms=50, no_load=245).data)
    assert (board.kind, board.period_ms, board.no_load) == (SkinType.COMPENSATED_V2, 50, 245)
    assert not any(each.enabled for each in board.triangles)
    board = board.after(SetTriangles(first=2, last=3, shift=1, cdc_offset=5).data)
    assert [t for t, each in enumerate(board.triangles) if each.enabled] == [2, 3]
    assert board.triangles[2].shift == 1
    assert board.triangles[3].cdc_offset == 5
    assert (board.sending, board.calibrations) == (False, 1)
    board = board.after(Transmit(True).data)
    assert board.sending
    assert not board.after(Transmit(False).data).sending
    stopped = board.after(SetTriangles().data)
    assert (stopped.sending, stopped.calibrations) == (False, 2)
    assert board.after(bytes([0x99])).ignored == 1


def test_the_older_generation_goes_on_sending():
    board = BoardState(firmware=Firmware.MTB3)
    assert board.message_class == MessageClass.ANALOG
    assert BoardState().message_class == MessageClass.SKIN
    board = board.after(SetBoard().data)
    assert all(each.enabled for each in board.triangles)
    assert board.message_class == MessageClass.SKIN
    board = board.after(Transmit(True).data).after(SetTriangles(first=0, last=0).data)
    assert board.sending


def test_the_old_setup_starts_a_board():
    board = BoardState(firmware=Firmware.MTB3, no_load=200)
    board = board.after(SetOldBoard(timer=3, cdc_offset=7, time=3125).data)
    assert (board.sending, board.calibrations, board.period_ms) == (True, 1, 10)
    assert (board.no_load, board.triangles[9].cdc_offset) == (200, 7)
    assert board.message_class == MessageClass.ANALOG
    board = board.after(SetOldSkin(shift=3, no_load=235, param=0x08, mask=0x8001).data)
    assert (board.kind, board.no_load) == (SkinType.COMPENSATED, 235)
    assert [t for t, each in enumerate(board.triangles) if each.enabled] == [0, 15]
    assert board.after(SetOldSkin().data).kind == SkinType.UNCOMPENSATED
    assert BoardState(no_load=200).after(SetOldBoard().data).no_load == 240  # its default


def test_what_a_board_does_not_know_switches_the_correction_off():
    assert BoardState().after(bytes.fromhex("4d 63 32 f0")).kind == SkinType.UNCOMPENSATED


def test_wrong_settings_are_said():
    with pytest.raises(InputError, match="period_ms is 0, expected a whole number from 1 to 255"):
        SetBoard(period_ms=0)
    with pytest.raises(InputError, match="first is 5, expected a whole number from 0 to 4"):
        SetTriangles(first=5, last=4)
    with pytest.raises(InputError, match="board is 16"):
        host_message(16, Transmit(True))
    with pytest.raises(InputError, match="triangles is 3"):
        BoardState(triangles=BoardState().triangles[:3])


ITEM = st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8))


def of_items(items):
    messages = CanMessages(max(len(items), 1))
    for row, (identifier, data) in enumerate(items):
        messages.ids[row], messages.lengths[row] = identifier, len(data)
        messages.data[row, : len(data)] = list(data)
    return messages


@given(st.lists(ITEM, max_size=24))
def test_arrays_hold_messages(items):
    array = array_of_messages(of_items(items), 0, len(items))
    assert array[:4] == bytes([24, 10, len(items), 0])
    assert len(array) == 244
    for k, (identifier, data) in enumerate(items):
        info, payload = struct.unpack_from("<H8s", array, 4 + 10 * k)
        assert (info & 0xFFF, info >> 12, payload) == (identifier, len(data), data.ljust(8, b"\0"))
    into, counts = CanMessages(30), counters()
    octets = np.frombuffer(array, np.uint8)
    assert messages_of_array(octets, len(array), into, 3, 77, counts) == 3 + len(items)
    for row, (identifier, data) in enumerate(items, 3):
        assert (into.ids[row], into.lengths[row], into.stamp_ns[row]) == (identifier, len(data), 77)
        assert into.data[row].tobytes() == data.ljust(8, b"\0")
    assert not counts.any()


@given(
    st.one_of(
        st.binary(max_size=300),
        st.builds(
            lambda size, rest: bytes([24, 10, size, 0]) + rest,
            st.integers(0, 24),
            st.binary(max_size=260),
        ),
    ),
    st.integers(0, 40),
)
def test_any_bytes_are_an_array_or_none(data, first):
    octets = np.frombuffer(data + b"\0", np.uint8)
    into, counts = CanMessages(40), counters()
    try:
        end = messages_of_array(octets, len(data), into, first, 0, counts)
    except InputError:
        assert data[2] > 40 - first
        return
    size = data[2] if len(data) > 3 else 0
    good = len(data) > 3 and data[1] == 10 and size <= data[0] and 4 + 10 * size <= len(data)
    good = good and all(data[5 + 10 * k] >> 4 <= 8 for k in range(size))
    assert end == first + (size if good else 0)
    assert counts[Count.MALFORMED] == (not good)
    assert not into.ids[end:].any()


def test_what_no_array_can_hold_is_said():
    with pytest.raises(InputError, match="count is 25"):
        array_of_messages(CanMessages(30), 0, 25)
    with pytest.raises(InputError, match="identifier 0x800 and 0 octets"):
        array_of_messages(of_items([(0x800, b"")]), 0, 1)
