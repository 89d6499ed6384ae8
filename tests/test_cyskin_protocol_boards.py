"""CySkin's boards: modules, channels and layouts; boards in software that obey and answer."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.layout.generators import hexagon72
from skinfield.protocols.cyskin import (
    Assembler,
    Command,
    CySkinBoard,
    CySkinBoardState,
    CySkinModule,
    CySkinWire,
    Declaration,
    ModuleDetails,
    Refusal,
    boards_from_uids,
    on_boards,
    port_of,
    skin_on_boards,
    start_messages,
    uids_of,
)

MODULES = (CySkinModule(100), CySkinModule(101, 0b0111_1111_1110), CySkinModule(102))
BOARDS = (CySkinBoard(5, MODULES[:2]), CySkinBoard(9, MODULES[2:], bus=1))


def test_uids_channels_and_skins() -> None:
    uids, channels = uids_of(BOARDS)
    assert uids[:2].tolist() == [1600, 1601]
    assert channels.tolist() == [*range(12), *range(13, 23), *range(24, 36)]
    positions = np.array([[0.01 * i, 0.0] for i in range(4)] + [[0.0, 0.01]])
    patch = sf.Patch(positions, uid=[1619, 1601, 1632, 1611, 1643], name="p")
    skin = skin_on_boards(sf.Skin((patch,), "arm"), BOARDS)
    assert skin[0].channel.tolist() == [15, 1, 24, 11, 35]
    assert (skin[0].n_channels, skin.name, port_of("p", BOARDS).channels) == (36, "arm", 36)
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


def test_a_board_in_software_obeys_and_answers() -> None:
    wire = CySkinWire()
    state = CySkinBoardState(board=BOARDS[0], wire=wire)
    assembler = Assembler(wire)
    for identifier, data in start_messages(BOARDS[:1], wire, period_ms=20):
        packet = assembler.take(identifier, data)
        assert packet is not None
        state, answers = state.after(*wire.unpacked(packet[1]))
    assert (state.sending, state.period_ms, answers) == (True, 20, [])
    state, answers = state.after(Command.DECLARE, b"")
    assert Declaration.from_data(answers[0][1]) == Declaration(2, 0, (12, 10))
    state, answers = state.after(Command.MODULE_DETAILS, b"\xff")
    found = [ModuleDetails.from_data(data, "big").module for _, data in answers]
    assert tuple(found) == BOARDS[0].modules
    assert answers[0][1].hex(" ") == "00 00 00 00 64 0c 00 0f ff 00 00"
    state, answers = state.after(Command.MODULE_DETAILS, b"\x02")
    assert answers == [(Command.ERROR, bytes([Command.MODULE_DETAILS, Refusal.INVALID]))]
    state, answers = state.after(Command.COLD_REBOOT, b"")
    assert answers == [(Command.ERROR, bytes([0x32, 0xE2]))]
    state, answers = state.after(Command.UID, b"")
    assert answers == [(Command.UID, b"\0\0\0\x05")]
    state = state.after(Command.SYNC, b"")[0].after(Command.SET_AUTO_SYNC, b"\0")[0]
    assert (state.sending, state.syncs, state.ignored) == (False, 1, 2)
