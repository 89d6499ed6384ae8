"""Bottles as text and as bytes: golden examples of YARP's own; words of commands."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from yarp_peers import values_of

from skinfield.wire.yarp import bytes_from_bottle, text_from_bottle
from skinfield.wire.yarp.carriers import words_from_text

GOLDEN = [  # as YARP's documentation of its data format and of its ports shows them
    ('0 "hello world"', [0, "hello world"]),
    ("set poss (10 10 -10 -10 5) ()", ["set", "poss", [10, 10, -10, -10, 5], []]),
    ("10.0 10.0 -10.0 -10.0 5.0", [10.0, 10.0, -10.0, -10.0, 5.0]),
    ('"say \\"hi\\"\\n\\\\" "" "5" "true"', ['say "hi"\n\\', "", "5", "true"]),
    ("inf -inf 1e-05 -9223372036854775808", [float("inf"), -float("inf"), 1e-05, -(1 << 63)]),
]


@pytest.mark.parametrize(("text", "values"), GOLDEN)
def test_golden_texts(text: str, values: list[object]) -> None:
    assert text_from_bottle(values) == text


numbers = st.one_of(st.integers(-(1 << 31), (1 << 31) - 1), st.floats())
bottles = st.lists(st.recursive(numbers, lambda inner: st.lists(inner, max_size=3)), max_size=5)


@given(bottles)
def test_numbers_are_read_as_what_they_are(values: list[object]) -> None:
    assert repr(values_of(text_from_bottle(values))) == repr(values)


def test_words_of_commands() -> None:
    assert words_from_text('[add] "tcp://reader" x') == ["add", "tcp://reader", "x"]
    assert words_from_text('add  "a b" [] "c\\"d" (') == ["add", "a b", "", 'c"d', "("]
    assert words_from_text('"open') == ["open"]


def ints(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}i", *numbers)


def test_golden_bytes() -> None:
    # a list of doubles: 256 + 20, two of them; then one of mixed types with a list of ints in it
    assert bytes_from_bottle([1.0, -2.5]) == ints(276, 2) + struct.pack("<2d", 1.0, -2.5)
    mixed = ints(256, 2) + ints(257, 2, 7, 8) + ints(4, 2) + b"ab"
    assert bytes_from_bottle([[7, 8], "ab"]) == mixed
    assert bytes_from_bottle([]) == ints(256, 0)
