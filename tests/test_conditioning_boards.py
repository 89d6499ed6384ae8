"""Bytes of iCub's boards, words of CySkin's, and parallel plates: eq. (1) and (2)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.elastic import Layer
from skinfield.errors import InputError
from skinfield.signal import CySkinCount, ICubByte, strain_from_relative_capacitance

boards = st.builds(ICubByte, no_load=st.sampled_from([235, 240, 244, 245]), shift=st.integers(0, 5))


def firmware(v: int, no_load: int, shift: int) -> int:
    """The published rule, in integers."""
    if v <= -((255 - no_load) << shift):
        return 255
    return 0 if v >= no_load << shift else no_load - (v >> shift)


@given(boards, st.integers(-40000, 40000))
def test_bytes_are_those_of_the_firmware(board, v):
    assert board.counts_from_difference(v) == firmware(v, board.no_load, board.shift)


def test_known_messages():
    board = ICubByte()  # rest, +400, and +2000 converter counts
    assert board.counts_from_difference([0, 400, 2000, -2000]).tolist() == [0xF0, 0x8C, 0, 255]
    assert board.saturated(np.array([0.0, 1.0, 240.0, 254.0, 255.0])).tolist() == [
        True, False, False, False, True,
    ]  # fmt: skip


def test_pressure_lowers_the_byte_and_the_gain_says_so():
    board = ICubByte()
    assert board.gain(0.167e-12, 16e-12 / 65536) == pytest.approx(-171, abs=1)
    assert np.sign(board.gain(0.167e-12, 1e-15)) == board.direction == -1


def test_wrong_settings_are_refused_and_nan_is_kept():
    with pytest.raises(InputError, match="no_load is 255"):
        ICubByte(no_load=255)
    with pytest.raises(InputError, match="shift is -1"):
        ICubByte(shift=-1)
    assert np.isnan(ICubByte().counts_from_difference([np.nan])).all()


@given(st.floats(-1e6, 1e6))
def test_words_clip_at_both_ends(difference):
    board = CySkinCount()
    word = board.counts_from_difference(difference)
    assert word == min(max(round(difference), 0), 65535)
    assert board.saturated(word) == (word == 65535)


def test_zero_is_the_floor_of_a_word_and_valid():
    assert not CySkinCount().saturated(np.array([0.0]))


def test_the_paper_pad_has_a_sixth_of_a_picofarad():
    # 8.8541878128e-12 * 3 * pi * (2e-3)^2 / 2e-3, by hand
    assert Layer().rest_capacitance(4e-3) == pytest.approx(1.66897e-13, rel=1e-5)
    with pytest.raises(InputError, match="pad_diameter is -1"):
        Layer().rest_capacitance(-1)


@given(st.floats(-5.0, 0.999))
def test_strain_is_that_of_a_plate_that_came_nearer(strain):
    rest, now = (Layer(thickness=h).rest_capacitance(4e-3) for h in (0.1, 0.1 * (1 - strain)))
    change = (now - rest) / rest
    assert strain_from_relative_capacitance(change) == pytest.approx(strain, rel=1e-9, abs=1e-12)


def test_invalid_stays_invalid_and_nonsense_is_refused():
    assert np.isnan(strain_from_relative_capacitance([0.1, np.nan])).tolist() == [False, True]
    with pytest.raises(InputError, match=r"relative_capacitance\[0\] is -1.0.*cannot lose"):
        strain_from_relative_capacitance([-1.0])
