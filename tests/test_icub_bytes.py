"""iCub's boards to their bits: golden messages, and the firmware's formulas in plain Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.acquisition import CanMessages
from skinfield.conditioning import ICubByte
from skinfield.conditioning.firmware import firmware_drift
from skinfield.errors import InputError
from skinfield.protocols.icub import (
    BoardState,
    Firmware,
    ICubEncoder,
    MessageClass,
    SkinType,
    gains_of,
    message_id,
    triangle_payloads,
)

REST = np.full(12, 0x8000)
SHORT = st.integers(0, 0xFFFF)
COUNTS = st.one_of(  # any at all, and such as stay near the base
    st.lists(SHORT, min_size=12, max_size=12),
    st.lists(st.integers(0x7800, 0x8800), min_size=12, max_size=12),
    st.lists(st.sampled_from([0, 0xFFFF, 0x8000]), min_size=12, max_size=12),
)


def moved(**by):
    raw = REST.copy()
    for pad, difference in by.items():
        raw[int(pad[1:])] += difference
    return raw


def zeroed(pad):
    raw = REST.copy()
    raw[pad] = 0
    return raw


GOLDEN = {
    "rest": (REST, Firmware.MTB3, "40 f0f0f0f0f0f0f0", "c0 f0f0f0f0f0 0000"),
    "taxel 3": (moved(p3=400), Firmware.MTB3, "40 f0f0f08cf0f0f0", "c0 f0f0f0f0f0 0000"),
    "taxel 9": (moved(p9=2000), Firmware.MTB3, "40 f0f0f0f0f0f0f0", "c0 f0f000f0f0 2000"),
    "colder": (moved(p6=-200), Firmware.MTB3, "40 d5cbd0e2e2d5ff", "c0 dfd2b0f0d2 0400"),
    "no ack": (zeroed(0), Firmware.MTB3, "40 fff0f0f0f0f0f0", "c0 f0f0f0f0f0 0011"),
    "unplugged": (np.full(12, 0xFFFF), Firmware.MTB3, "40 00000000000000", "c0 0000ff0000 fff2"),
    # the other generation rounds the negative drift of pads 3 and 4 across a step of the byte
    "colder, mtb4": (moved(p6=-200), Firmware.MTB4, "40 d5cbd0e1e1d5ff", "c0 dfd2b0f0d2 0400"),
}


@pytest.mark.parametrize("case", GOLDEN)
def test_golden_messages(case):
    raw, firmware, head, tail = GOLDEN[case]
    made = triangle_payloads(raw, REST, firmware=firmware)
    assert made == (bytes.fromhex(head), bytes.fromhex(tail))


def test_the_identifier_holds_class_board_and_triangle():
    assert message_id(4, 13, 5) == 0x4D5
    assert message_id(MessageClass.ANALOG, 0, 15) == 0x30F
    with pytest.raises(InputError, match="board is 16, expected a whole number from 0 to 15"):
        message_id(4, 16, 0)


GAINS = {
    0: [70, 96, 83, 38, 38, 70, 0, 45, 77, 164, 0, 77],
    8: [58, 91, 39, 23, 35, 90, 0, 38, 68, 115, 0, 86],
}


def plain(raw, base, no_load, shift, kind, firmware):
    """Both payloads by the formulas, one taxel after the other."""
    if kind == 7:
        return bytes([0x40, *(r & 255 for r in raw[:7])]), bytes(
            [0xC0, *(r & 255 for r in raw[7:]), 0, 0]
        )
    up, bottom = (255 - no_load) << shift, no_load << shift
    pad = 11 if kind == 1 else 6
    away = raw[pad] - base[pad]
    taxels, beyond, flags = [], 0, 0
    for i in range(12):
        drift = 0
        if kind in GAINS:
            product = (abs(away) >> 2) * GAINS[kind][i]
            if away > 0:
                drift = product >> 5
            elif firmware == 3:
                drift = -(product >> 5)
            else:
                drift = -product >> 5
        v = raw[i] - base[i] - drift
        if v <= -up:
            taxels.append(255)
        elif v >= bottom:
            taxels.append(0)
        else:
            taxels.append(no_load - (v >> shift))
        if v <= -2 * up or v >= 2 * bottom:
            beyond |= 1 << i
        if raw[i] == 0 and base[i] != 0:
            flags |= 1
    if all(r == 0xFFFF for r in raw):
        flags = 2
    e0, e1 = beyond >> 4, (beyond & 0xF) << 4 | flags
    return bytes([0x40, *taxels[:7]]), bytes([0xC0, *taxels[7:], e0, e1])


@given(
    COUNTS,
    COUNTS,
    st.integers(0, 255),
    st.integers(0, 15),
    st.sampled_from([0, 1, 2, 7, 8]),
    st.sampled_from(list(Firmware)),
)
def test_the_boards_arithmetic(raw, base, no_load, shift, kind, firmware):
    made = triangle_payloads(
        raw, base, firmware=firmware, no_load=no_load, shift=shift, kind=SkinType(kind)
    )
    assert made == plain(raw, base, no_load, shift, kind, firmware)


@given(COUNTS, st.sampled_from(list(Firmware)), st.sampled_from([0, 2, 8]), st.integers(0, 6))
def test_agrees_with_the_conditioning_of_bytes(raw, firmware, kind, shift):
    head, tail = triangle_payloads(
        raw, REST, firmware=firmware, kind=SkinType(kind), shift=shift, no_load=245
    )
    away = np.array(raw) - REST
    drift = firmware_drift(
        away[6], gains_of(SkinType(kind)), negated_first=firmware == Firmware.MTB4
    )
    byte = ICubByte(no_load=245, shift=shift).counts_from_difference(away - drift)
    assert [*head[1:], *tail[1:6]] == byte.tolist()


def test_an_ergo_hand_has_fingertips_and_triangles():
    assert gains_of(SkinType.ERGO_HAND, 4) == (0,) * 12
    assert list(gains_of(SkinType.ERGO_HAND, 5)) == GAINS[8]
    encoder = ICubEncoder([(2, 4), (2, 5)], kind=SkinType.ERGO_HAND)
    encoder.raw[:, 6] += 200
    messages = CanMessages(4)
    assert encoder.encode(messages, 0, 7) == 4
    raw = moved(p6=200)
    assert messages.data[0].tobytes() == plain(raw.tolist(), REST.tolist(), 240, 2, 2, 4)[0]
    assert messages.data[2].tobytes() == plain(raw.tolist(), REST.tolist(), 240, 2, 8, 4)[0]


def test_many_triangles_in_one_call():
    encoder = ICubEncoder([(3, t) for t in range(16)] + [(4, 0)], firmware=Firmware.MTB3)
    rng = np.random.default_rng(1)
    encoder.raw[:] = rng.integers(0, 1 << 16, encoder.raw.shape)
    encoder.sends[5] = False
    settings = {"message_class": MessageClass.ANALOG, "kind": SkinType.PALM}
    encoder.configure(16, no_load=200, shift=3, **settings)
    messages = CanMessages(40)
    assert encoder.encode(messages, 2, 99) == 2 + 2 * 16
    row = 2
    for t in range(17):
        if t == 5:
            continue
        raw, base = encoder.raw[t].tolist(), encoder.base[t].tolist()
        numbers = (200, 3, 1) if t == 16 else (240, 2, 0)
        payloads = plain(raw, base, *numbers, 3)
        assert [messages.data[row + k].tobytes() for k in range(2)] == list(payloads)
        assert messages.ids[row] == messages.ids[row + 1] == (0x340 if t == 16 else 0x430 + t)
        assert messages.lengths[row] == 8
        assert messages.stamp_ns[row + 1] == 99
        row += 2
    assert not messages.data[:2].any()


def test_the_encoder_follows_a_board():
    encoder = ICubEncoder([(1, 0), (1, 7), (2, 0)])
    state = BoardState(firmware=Firmware.MTB3).after(bytes.fromhex("50 00 03 01 01 0022"))
    state = state.after(bytes.fromhex("50 04 0f 02 00 0022"))
    encoder.follow(1, state)
    assert encoder.sends.tolist() == [False, False, True]  # nobody started it
    encoder.follow(1, state.after(bytes.fromhex("07 00")))
    assert encoder.sends.tolist() == [True, False, True]
    encoder.raw[:, 0] += 100
    messages = CanMessages(6)
    assert encoder.encode(messages, 0, 0) == 4
    assert messages.data[0, 1] == 240 - 50  # shift 1
    assert messages.data[2, 1] == 240 - 25


def test_what_cannot_be_encoded_is_said():
    with pytest.raises(InputError, match="triangles are"):
        ICubEncoder([(0, 1), (0, 1)])
    with pytest.raises(InputError, match="messages have 3 rows, expected 4"):
        ICubEncoder([(0, 1), (0, 2)]).encode(CanMessages(3), 0, 0)
    with pytest.raises(InputError, match="skin type is 5, expected one of 0 \\(compensated\\)"):
        triangle_payloads(REST, REST, kind=5)
    with pytest.raises(InputError, match="shift is 16"):
        triangle_payloads(REST, REST, shift=16)
    with pytest.raises(InputError, match=r"raw is .*, expected whole numbers from 0 to 65535"):
        triangle_payloads(REST + 40000, REST)
