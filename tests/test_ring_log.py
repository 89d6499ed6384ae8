"""The log of a ring against a plain string of bytes that keeps everything."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ring_scenes import SLOT, bytes_of, own_name, write

from skinfield.errors import InputError
from skinfield.ring import Ring, RingReader

SIZE = 4096
RNG = np.random.default_rng(3)
TEXT = RNG.integers(0, 256, 1 << 20, dtype=np.uint8)  # what is appended, one piece after the other


@pytest.fixture
def ring(tmp_path: Path) -> Iterator[Ring]:
    with Ring.create("one", SLOT, log_bytes=SIZE, folder=tmp_path) as ring:
        yield ring


@pytest.fixture
def reader(ring: Ring, tmp_path: Path) -> Iterator[RingReader]:
    with RingReader("one", folder=tmp_path) as reader:
        yield reader


def append(ring: Ring, count: int) -> int:
    return ring.log(TEXT[ring.log_end :], count)


@given(
    steps=st.lists(
        st.one_of(
            st.tuples(st.just("append"), st.integers(0, SIZE)),
            st.tuples(st.just("append"), st.integers(0, 100)),
            st.tuples(st.just("read"), st.one_of(st.none(), st.integers(1, 2 * SIZE))),
        ),
        max_size=60,
    )
)
def test_whatever_is_read_was_appended(steps: list[tuple[str, int | None]]) -> None:
    with (
        own_name() as name,
        Ring.create(name, SLOT, log_bytes=SIZE) as ring,
        RingReader(name) as reader,
    ):
        log, ends, longest = reader.log_reader(), {0}, 0
        for what, count in [*steps, *[("read", 500)] * 20]:
            if what == "append":
                ends.add(append(ring, count))
                longest = max(longest, count)
                continue
            position, end = log.position, ring.log_end
            data, lost = log.read(count)
            assert (lost > 0) == (end - position > SIZE)
            start, stop = position + lost, position + lost + len(data)
            assert stop == log.position
            assert {start, stop} <= ends
            assert data == TEXT[start:stop].tobytes()
            assert stop > start or start == end
            assert len(data) <= (SIZE if count is None else max(count, longest + SIZE // 32))
        assert log.position == ring.log_end
        assert log.read() == (b"", 0)


def test_reading_begins_now_or_where_asked(ring: Ring, reader: RingReader) -> None:
    append(ring, 100)
    write(ring)
    append(ring, 50)
    behind = reader.latest().log_end
    assert reader.log_reader().read() == (b"", 0)
    assert reader.log_reader(behind).read() == (TEXT[100:150].tobytes(), 0)
    assert reader.log_reader(0).read() == (TEXT[:150].tobytes(), 0)
    for wrong in (-1, 151, 1.5):
        with pytest.raises(InputError, match="where a batch ended"):
            reader.log_reader(wrong)


def test_slow_reader_loses_the_oldest_and_is_told(ring: Ring, reader: RingReader) -> None:
    log, quick = reader.log_reader(), reader.log_reader()
    while ring.log_end <= SIZE:
        append(ring, 40)
        quick.read()
    data, lost = log.read()
    assert (lost + len(data), quick.lost) == (ring.log_end, 0)
    assert 0 < lost <= SIZE // 4 + 2 * SIZE // 64  # the newest three quarters are there still
    assert lost % 40 == 0
    assert data == TEXT[lost : lost + len(data)].tobytes()
    assert log.lost == lost
    append(ring, 40)
    assert log.read() == (TEXT[ring.log_end - 40 : ring.log_end].tobytes(), 0)


def test_overtaken_while_copying(ring: Ring, reader: RingReader) -> None:
    """The fence of other machines is called after the copy too: there the writer comes round."""
    append(ring, SIZE)
    log, calls = reader.log_reader(0), []

    def overtake() -> None:
        calls.append(1)
        if len(calls) == 2:  # 1: between end and copy; 2: between copy and check
            append(ring, 64)

    log._fence = overtake
    data, lost = log.read()
    assert lost > 0
    assert data == TEXT[lost : lost + len(data)].tobytes()
    assert lost + len(data) == ring.log_end
    log._fence = lambda: append(ring, SIZE)  # every time
    assert log.read()[0] == b""
    assert log.position == ring.log_end - SIZE  # once more behind, but not further
    assert log.lost == log.position - len(data)


def test_a_batch_that_is_being_written_counts_as_written(ring: Ring, reader: RingReader) -> None:
    append(ring, SIZE)
    log = reader.log_reader(0)
    ring._words[33] = SIZE + 8  # log reserved, as `Log.append` does before it copies
    data, lost = log.read()
    assert lost > 0
    assert lost + len(data) == SIZE
    ring._words[33] = SIZE


def test_a_dead_writers_batch_is_written_over(ring: Ring, reader: RingReader) -> None:
    append(ring, 1000)
    ring._words[33] = 1000 + 3500  # died while it copied 3500 bytes
    ring._log._octets[1000:] = 66
    ring.close()
    log = reader.log_reader(0)
    with Ring.reopen("one", SLOT, log_bytes=SIZE, folder=ring.path.parent) as again:
        data, lost = log.read()  # what those bytes would have taken the place of is lost
        assert (data, lost) == (b"", 1000)
        append(again, 200)
        assert log.read() == (TEXT[1000:1200].tobytes(), 0)
        assert again.log_end == reader.log_end == 1200


def test_batches_that_do_not_fit_change_nothing(ring: Ring, reader: RingReader) -> None:
    assert append(ring, 0) == 0
    for count in (SIZE + 1, -1):
        with pytest.raises(InputError, match=f"count is {count}, expected 0 to 4096"):
            append(ring, count)
    with pytest.raises(InputError, match="expected 0 to 3 bytes"):
        ring.log(bytes_of(b"abc"), 4)
    assert reader.log_reader(0).read() == (b"", 0)
    assert ring.log(TEXT[:SIZE]) == SIZE
    assert reader.log_reader(0).read() == (TEXT[:SIZE].tobytes(), 0)
