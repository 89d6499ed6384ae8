"""CySkin's process data on EtherCAT: bytes written out by hand, and any bytes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.acquisition import Blocks, Channels, Count, blocks_of, counters
from skinfield.errors import InputError
from skinfield.protocols.cyskin import (
    CySkinBoard,
    CySkinEtherCat,
    CySkinModule,
    board_from_init,
)
from skinfield.protocols.cyskin.ethercat import PROCESS, data_from_responses, init_from_board

MODULES = (CySkinModule(0x5678), CySkinModule(7, 0x7FE), CySkinModule(9))
BOARD = CySkinBoard(300, MODULES)


def process(message: bytes) -> np.ndarray:
    return np.frombuffer(message.ljust(PROCESS, b"\xee"), np.uint8)


def test_golden_process_data() -> None:
    init = "01 aa 00 1f 2c010000 02 00 78560000 0c 00 ff0f 00 00 01 07000000 0a 00 fe07 00 00"
    assert init_from_board(CySkinBoard(300, MODULES[:2])) == bytes.fromhex(init)
    assert board_from_init(process(bytes.fromhex(init)).tobytes()) == CySkinBoard(300, MODULES[:2])
    data = "02 00 00 0c 00 0b 0102 0003 ffff"
    assert data_from_responses(0, 11, [258, 3, 65535]) == bytes.fromhex(data)
    slaves = CySkinEtherCat([CySkinBoard(1, (CySkinModule(1),)), BOARD])
    blocks, seen = Blocks(), counters()
    assert slaves.channels == 48
    long = init.replace("78560000", "78563412")  # a sui of 32 bits, of which uids have 16
    assert board_from_init(bytes.fromhex(long)) == CySkinBoard(300, MODULES[:2])
    assert slaves.decode(process(bytes.fromhex(data)), 1, blocks, 100, seen, 55)
    assert [(b.stamp_ns, b.channel, b.payload.tolist()) for b in blocks_of(blocks.data)] == [
        (55, 123, [258]),
        (55, 125, [3, 65535]),
    ]
    assert seen[Count.RECEIVED] == 1
    assert seen[Count.BYTES] == 12


@given(st.integers(0, 3), st.integers(0, 13), st.integers(0, 40))
def test_process_data_land_where_they_should(module: int, sensor: int, count: int) -> None:
    sensors = [12 * m + s for m, each in enumerate(MODULES) for s in each.sensors]
    begins = [0, 12, 22, 34]
    values = np.arange(count) * 7
    slaves, blocks, seen = CySkinEtherCat([BOARD]), Blocks(), counters()
    slaves.decode(process(data_from_responses(module, sensor, values)), 0, blocks, 0, seen, 5)
    there = module < 3 and sensor < begins[module + 1] - begins[module]
    if there and begins[module] + sensor + count <= 34:
        state, start = Channels(36), begins[module] + sensor
        state.apply(blocks)
        np.testing.assert_array_equal(state.counts[sensors[start : start + count]], values)
        assert np.isfinite(state.counts).sum() == count
    else:
        assert seen[Count.FOREIGN] == 1
        assert len(blocks.data) == 0


@given(st.binary(max_size=80))
def test_any_process_data_are_decoded_or_counted(data: bytes) -> None:
    slaves, blocks, seen = CySkinEtherCat([BOARD]), Blocks(4096), counters()
    for message in (data, b"\x02\0" + data, b"\x02\0\0" + data):
        slaves.decode(process(message), 0, blocks, 0, seen, 5)
    Channels(36).apply(blocks)
    for message in (data, b"\x01\xaa" + data):
        try:
            board_from_init(message)
        except InputError:
            continue


def test_mistakes_in_process_data_are_named() -> None:
    with pytest.raises(InputError, match="expected 01 aa"):
        board_from_init(bytes(40))
    with pytest.raises(InputError, match="say that 200 modules"):
        board_from_init(b"\x01\xaa" + bytes(6) + b"\xc8" + bytes(40))
    with pytest.raises(InputError, match="at most 1917"):
        data_from_responses(0, 0, np.zeros(1918))
    with pytest.raises(InputError, match="three segments"):
        CySkinEtherCat([BOARD]).decode(np.zeros(7, np.uint8), 0, Blocks(), 0, counters(), 5)
    slaves, seen = CySkinEtherCat([BOARD]), counters()
    full = Blocks(24)
    assert not slaves.decode(process(data_from_responses(0, 0, [1] * 9)), 0, full, 0, seen, 5)
    assert not seen.any()
