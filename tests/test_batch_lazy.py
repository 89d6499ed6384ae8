"""Lazy arrays index as NumPy does, whatever the index."""

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from skinfield.pipeline.batch_lazy import ChunkCache, LazyArray, LazyList

SHAPE = (23, 4, 3)
EAGER = np.arange(np.prod(SHAPE), dtype=np.float32).reshape(SHAPE)
INDEX = hnp.basic_indices(SHAPE, allow_newaxis=True, max_dims=6)


def lazy(chunk: int = 5, most_bytes: int = 1 << 20, eager=EAGER) -> LazyArray:
    loads: list[tuple[int, int]] = []

    def load(first, last):
        loads.append((first, last))
        return eager[first:last].copy()

    def into(first, last, out):
        out[:] = load(first, last)

    direct = into if chunk % 2 else None
    array = LazyArray(eager.shape, eager.dtype, chunk, load, ChunkCache(most_bytes), direct)
    array.loads = loads
    return array


def check(index, chunk: int, eager=EAGER) -> None:
    try:
        wanted = eager[index]
    except IndexError:
        with pytest.raises(IndexError):
            lazy(chunk, eager=eager)[index]
        return
    found = lazy(chunk, eager=eager)[index]
    assert type(found) is type(wanted)
    assert found.dtype == wanted.dtype
    assert found.shape == wanted.shape
    np.testing.assert_array_equal(found, wanted)


@given(INDEX, st.integers(1, 30))
def test_basic_indices(index, chunk) -> None:
    check(index, chunk)


@given(
    hnp.integer_array_indices(SHAPE, result_shape=hnp.array_shapes(min_dims=0, max_dims=3)),
    st.integers(1, 30),
)
def test_arrays_on_all_axes(index, chunk) -> None:
    check(index, chunk)


ITEMS = st.one_of(
    st.integers(-25, 24),
    st.slices(25),
    st.lists(st.integers(-23, 22), max_size=6),
    hnp.arrays(np.int64, (2, 3), elements=st.integers(-4, 3)),
    hnp.arrays(np.bool_, st.sampled_from([(23,), (4,), (3,), (23, 4), (4, 3), SHAPE, (5,)])),
    st.sampled_from([None, Ellipsis]),
)


@pytest.mark.parametrize("chunk", [4, 5, 23, 30])
def test_whole_chunks_turned_round(chunk) -> None:
    for index in ((slice(None), slice(None, None, -1)), (..., slice(None, None, -1)),
                  (slice(None, None, -1), slice(None), slice(0, 3))):  # fmt: skip
        check(index, chunk)


@settings(max_examples=300)
@given(st.lists(ITEMS, max_size=4).map(tuple), st.integers(1, 30))
def test_any_mixture(index, chunk) -> None:
    check(index, chunk)


@pytest.mark.parametrize("index", [1.0, "a", [0.5], np.array([]), (0, 0, 0, 0), (..., ...), 23])
def test_what_is_no_index_is_refused(index) -> None:
    with pytest.raises(IndexError):
        EAGER[index]
    with pytest.raises(IndexError):
        lazy()[index]
    with pytest.raises(IndexError, match="single truth value"):
        lazy()[True]


def test_an_array_without_rows_or_of_one_axis() -> None:
    for eager in (EAGER[:0], np.arange(7)):
        for index in (slice(None), slice(None, None, -2), [], (..., None), 0):
            check(index, 3, eager)


def test_chunks_are_computed_once_and_where_they_are_needed() -> None:
    array = lazy(5)
    array[7], array[6:9], array[[9, 5]]
    assert array.loads == [(5, 10)]
    array[-1]
    assert array.loads == [(5, 10), (20, 23)]
    assert array.chunks == ((5, 5, 5, 5, 3), (4,), (3,))
    assert (array.ndim, array.size, array.nbytes, len(array)) == (3, 276, 1104, 23)


def test_whole_chunks_are_written_where_they_are_wanted_and_not_kept() -> None:
    array = lazy(5)
    np.testing.assert_array_equal(array[5:15], EAGER[5:15])
    assert array.loads == [(5, 10), (10, 15)]
    assert array._cache.nbytes == 0
    array[12]
    array[10:15]  # known by now
    assert array.loads == [(5, 10), (10, 15), (10, 15)]


def test_memory_is_bounded() -> None:
    array = lazy(5, most_bytes=2 * 5 * 12 * 4)
    cache = array._cache
    for row in (0, 5, 10):
        array[row]
        assert cache.nbytes <= cache.most_bytes
    array[10], array[5]
    assert len(array.loads) == 3
    array[0]  # the oldest was let go
    assert len(array.loads) == 4
    cache.clear()
    assert cache.nbytes == 0


def test_what_comes_out_is_ones_own() -> None:
    array = lazy()
    array[0:5][:] = 0
    array[2][:] = 0
    np.testing.assert_array_equal(array[:], EAGER)


def test_numpy_takes_it_whole_and_blocks_are_all_of_it() -> None:
    array = lazy()
    np.testing.assert_array_equal(np.asarray(array), EAGER)
    assert np.asarray(array, dtype=np.float64).dtype == np.float64
    np.testing.assert_array_equal(np.concatenate([b for _, b in array.blocks()]), EAGER)
    np.testing.assert_array_equal(np.stack(list(array)), EAGER)
    np.testing.assert_allclose(np.mean(array, axis=0), EAGER.mean(axis=0))


def test_threads_wait_for_one_another() -> None:
    inside, most = [], []

    def load(first, last):
        inside.append(first)
        most.append(len(inside))
        found = EAGER[first:last].copy()
        inside.remove(first)
        return found

    array = LazyArray(SHAPE, np.float32, 2, load, ChunkCache(100))
    wrong = []

    def work(seed):
        for row in np.random.default_rng(seed).integers(0, 23, 40):
            if not np.array_equal(array[int(row)], EAGER[row]):
                wrong.append(row)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
    assert max(most) == 1


def test_lists_are_lazy_too() -> None:
    loads = []

    def load(first, last):
        loads.append((first, last))
        return tuple(str(item) for item in range(first, last))

    made = LazyList(11, 4, load, ChunkCache())
    assert (made[2], made[-1]) == ("2", "10")
    assert made[3:5] == ("3", "4")
    assert made[::-5] == ("10", "5", "0")
    assert made[[1, -1]] == ("1", "10")
    assert list(made) == [str(item) for item in range(11)]
    assert len(loads) == 3
    for index in (11, -12, "a", [20], [[1]], 1.5):
        with pytest.raises(IndexError):
            made[index]
