"""Bottles as text and as bytes: golden examples of YARP's own, and what is written is read back."""

import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.wire.yarp import (
    Vocab,
    bottle_from_text,
    bytes_from_bottle,
    text_from_bottle,
)

GOLDEN = [  # as YARP's documentation of its data format and of its ports shows them
    ('0 "hello world"', [0, "hello world"]),
    ("[set] [poss] (10 10 -10 -10 5)", [Vocab("set"), Vocab("poss"), [10, 10, -10, -10, 5]]),
    ("10.0 10.0 -10.0 -10.0 5.0", [10.0, 10.0, -10.0, -10.0, 5.0]),
    ("[is] [enc] -10.0 [ok]", [Vocab("is"), Vocab("enc"), -10.0, Vocab("ok")]),
    ("true false ()", [True, False, []]),
    ('"say \\"hi\\"\\n\\\\" "" "5"', ['say "hi"\n\\', "", "5"]),
    ("inf -inf 1e-05 -9223372036854775808", [float("inf"), -float("inf"), 1e-05, -(1 << 63)]),
]


@pytest.mark.parametrize(("text", "values"), GOLDEN)
def test_golden_texts(text: str, values: list[object]) -> None:
    assert repr(bottle_from_text(text)) == repr(values)
    assert text_from_bottle(values) == text


def test_what_others_write_in_other_ways() -> None:
    assert bottle_from_text(" 0x1f,+3\t.5 1. null ok a-b 1-2 ") == [
        31, 3, 0.5, 1.0, Vocab("null"), "ok", "a-b", "1-2",
    ]  # fmt: skip
    assert bottle_from_text('(a (b "c d") [e]) f') == [["a", ["b", "c d"], Vocab("e")], "f"]


@pytest.mark.parametrize("text", ["(", ")", '"a', "[a", "[]", "[much too long]", "9" * 30])
def test_what_is_no_bottle_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="expected"):
        bottle_from_text(text)


def test_lists_are_not_endless() -> None:
    with pytest.raises(InputError, match="nested deeper"):
        bottle_from_text("(" * 40)
    with pytest.raises(InputError, match="expected 1048576 at most"):
        bottle_from_text("1 " * (1 << 20))


def ints(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}i", *numbers)


def test_golden_bytes() -> None:
    # a list of doubles: 256 + 20, two of them; then one of mixed types with a list of ints in it
    assert bytes_from_bottle([1.0, -2.5]) == ints(276, 2) + struct.pack("<2d", 1.0, -2.5)
    mixed = ints(256, 3) + ints(257, 2, 7, 8) + ints(4, 2) + b"ab" + ints(9) + b"add\0"
    assert bytes_from_bottle([[7, 8], "ab", Vocab("add")]) == mixed
    assert bytes_from_bottle([]) == ints(256, 0)


words = st.text(
    st.sampled_from([chr(n) for n in range(33, 127) if chr(n) not in '[](){}",\\']),
    min_size=1, max_size=8,
)  # fmt: skip
plain = st.one_of(
    st.booleans(),
    st.integers(-(1 << 63), (1 << 63) - 1),
    st.floats(),
    st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
    words.filter(lambda text: text != "1").map(Vocab),
)
bottles = st.lists(
    st.recursive(plain, lambda inner: st.lists(inner, max_size=3), max_leaves=5), max_size=5
)


@given(bottles)
@settings(max_examples=50, deadline=None)
def test_what_is_written_is_read_back(values: list[object]) -> None:
    text = text_from_bottle(values)
    assert "\n" not in text
    assert "\r" not in text
    assert repr(bottle_from_text(text)) == repr(values)
