"""Any bytes in the place of a ring: refused, or read without a fault."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from skinfield.ring import RingReader

FUZZ = Path(__file__).resolve().parents[1] / "fuzz"
CHANGES = st.tuples(
    st.integers(0, 0xFFFF),
    st.integers(0, 7),
    st.one_of(
        st.sampled_from([0, 1, 63, 64, 1 << 12, 1 << 31, 1 << 32, (1 << 63) - 1, (1 << 64) - 1]),
        st.integers(0, (1 << 64) - 1),
        st.integers(0, 1 << 16),
    ),
)
HEADER = st.tuples(st.integers(0, 15).map(lambda i: 8 * i), st.just(0), st.integers(0, 1 << 15))


@pytest.fixture(scope="module")
def fuzz() -> Iterator[ModuleType]:
    sys.path.insert(0, str(FUZZ))
    try:
        import fuzz_ring

        yield fuzz_ring
    finally:
        sys.path.remove(str(FUZZ))


def octets(change: tuple[int, int, int]) -> bytes:
    place, part, word = change
    return place.to_bytes(2, "little") + bytes([part]) + word.to_bytes(8, "little")


@settings(max_examples=400)
@given(st.lists(st.one_of(CHANGES, HEADER), max_size=6))
@example([(0xFFFF, 0, 4096)])
@example([(0, 6, 1 << 40)])  # a head that nothing bears out
@example([(128, 6, 1 << 63), (136, 6, (1 << 64) - 1)])  # a log that has no end
def test_changed_files(fuzz: ModuleType, changes: list[tuple[int, int, int]]) -> None:
    fuzz.read(fuzz.changed(b"".join(map(octets, changes))))


@given(st.binary(max_size=9000))
def test_any_bytes(fuzz: ModuleType, data: bytes) -> None:
    fuzz.one_input(data)


def test_the_sample_itself_is_read(fuzz: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "skinfield.whole").write_bytes(fuzz.GOOD)
    with RingReader("whole", folder=tmp_path) as reader:
        fuzz.look(reader)
        assert reader.latest()["words"].tolist() == [[7, 7]] * 3
