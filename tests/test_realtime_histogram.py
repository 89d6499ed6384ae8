"""Histograms of times against sorted times, and what an engine counts against a plain loop."""

from multiprocessing import get_context
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.realtime import WORDS, TimeHistogram, Timing, TimingTable, quantiles
from skinfield.realtime.histogram import LAST_NS
from skinfield.realtime.layout import BINS, LONGEST, SUM, TOP
from skinfield.realtime.timing import FIELDS, TIMES, TOTALS

WIDTH = 1 / 64
NS = 1e-9


def counted(times: np.ndarray) -> TimeHistogram:
    found = TimeHistogram()
    for each in times:
        found.add(int(each))
    return found


@pytest.mark.parametrize("scale", [300.0, 20e3, 4e6, 1e9])
def test_quantiles_are_those_of_the_sorted_times_within_a_bin(scale: float) -> None:
    times = (scale * np.random.default_rng(1).lognormal(sigma=1.0, size=20_000)).astype(np.int64)
    times = np.minimum(times, TOP)
    found = counted(times).quantiles()
    ranked = np.sort(times)
    for thousandths, value in ((500, found.p50), (990, found.p99), (999, found.p999)):
        exact = ranked[thousandths * len(times) // 1000 - 1] * NS  # 20,000: without a remainder
        assert exact * (1 - 1e-12) <= value <= exact * (1 + WIDTH)
    assert found.max == pytest.approx(times.max() * NS, rel=1e-12)
    assert found.mean == pytest.approx(times.mean() * NS, rel=1e-12)
    assert found.count == len(times)


@given(st.integers(0, TOP))
def test_each_time_has_one_bin_that_holds_it(time: int) -> None:
    counts = np.zeros(WORDS, np.uint64)
    TimeHistogram(counts).add(time)
    (at,) = np.flatnonzero(counts[:BINS])
    first = LAST_NS[at - 1] + 1 if at else 0
    assert first <= time <= LAST_NS[at]
    assert LAST_NS[at] - first <= time * WIDTH
    assert counts[LONGEST] == counts[SUM] == time


def test_bins_follow_each_other_without_gaps() -> None:
    assert (np.diff(LAST_NS) > 0).all()
    assert (LAST_NS[0], LAST_NS[-1]) == (0, TOP)


@given(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=1, max_size=20))
def test_no_time_is_written_elsewhere(times: list[int]) -> None:
    memory = np.zeros(WORDS + 2, np.uint64)
    histogram = TimeHistogram(memory[1:-1])
    for each in times:
        histogram.add(each)
    assert memory[0] == memory[-1] == 0
    assert memory[1 : 1 + BINS].sum() == len(times)
    assert memory[1 + LONGEST] == max(0, *times)


def test_times_beyond_the_last_bin_keep_their_longest() -> None:
    found = counted(np.array([10**12])).quantiles()
    assert found.max == pytest.approx(1000.0)
    assert found.p50 == pytest.approx(TOP * NS)


def test_a_difference_has_the_times_since() -> None:
    rng = np.random.default_rng(2)
    early, late = rng.integers(10**6, 10**7, 5000), rng.integers(10**3, 10**5, 4000)
    histogram = counted(early)
    before = histogram.counts.copy()
    assert histogram.quantiles(before) is None
    for each in late:
        histogram.add(int(each))
    found = histogram.quantiles(before)
    exact = np.percentile(late, 99, method="inverted_cdf") * NS
    assert exact * (1 - 1e-12) <= found.p99 <= exact * (1 + WIDTH)
    assert late.max() * NS * (1 - 1e-12) <= found.max <= late.max() * NS * (1 + WIDTH)
    assert found.mean == pytest.approx(late.mean() * NS)
    assert found.count == len(late)


def test_a_copy_of_a_later_time_is_refused() -> None:
    histogram = counted(np.array([5]))
    with pytest.raises(InputError, match="earlier copy"):
        quantiles(np.zeros(WORDS, np.uint64), histogram.counts)


def test_nothing_counted_says_nothing() -> None:
    assert quantiles(np.zeros(WORDS, np.uint64)) is None


@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros(WORDS - 1, np.uint64),
        np.zeros(WORDS, np.int64),
        np.zeros(2 * WORDS, np.uint64)[::2],
        np.broadcast_to(np.uint64(0), WORDS),
    ],
)
def test_memory_that_cannot_be_counted_into_is_refused(wrong: np.ndarray) -> None:
    with pytest.raises(InputError, match="counts"):
        TimeHistogram(wrong)


def _count_elsewhere(name: str, times: list[int]) -> None:
    memory = SharedMemory(name)
    counts = np.ndarray(WORDS, np.uint64, memory.buf)
    histogram = TimeHistogram(counts)
    for each in times:
        histogram.add(each)
    del counts, histogram
    memory.close()


def test_another_process_counts_into_shared_memory() -> None:
    memory = SharedMemory(create=True, size=8 * WORDS)
    try:
        counts = np.ndarray(WORDS, np.uint64, memory.buf)
        counts[:] = 0
        child = get_context("spawn").Process(
            target=_count_elsewhere, args=(memory.name, [1000, 2000, 3000])
        )
        child.start()
        child.join(120)
        assert child.exitcode == 0
        assert quantiles(counts).count == 3
        assert quantiles(counts).max == pytest.approx(3e-6)
        del counts
    finally:
        memory.close()
        memory.unlink()


def cycles(count: int) -> np.ndarray:
    """Made-up times of cycles: due, wake, acquired, ready, done, latency (-1 in every third)."""
    steps = np.random.default_rng(3).integers(0, 600_000, (count, 4))
    due = 10**12 + 10**6 * np.arange(count)
    times = np.column_stack((due, due[:, None] + np.cumsum(steps, axis=1)))
    latency = np.where(np.arange(count) % 3, 2 * steps[:, 2], -1)
    return np.column_stack((times, latency))


def test_a_table_counts_the_times_and_what_came_late() -> None:
    rows, deadline, period = cycles(2000), 900_000, 10**6
    table = TimingTable(period, deadline)
    for row in rows:
        table.add(*map(int, row))
    table.set_skipped(5)
    after = TimingTable(period, deadline, table.times, table.totals)  # of an engine started again
    after.set_skipped(2)
    found = table.timing()
    due, wake, acquired, ready, done, latency = rows.T
    expected = {
        "wake": wake - due,
        "acquired": acquired - wake,
        "ready": ready - wake,
        "latency": latency[latency >= 0],
        "cycle": done - wake,
    }
    for name in TIMES:
        exact, quantile = expected[name], getattr(found, name)
        assert quantile.count == len(exact)
        assert quantile.max == pytest.approx(exact.max() * NS)
        assert quantile.mean == pytest.approx(exact.mean() * NS)
    assert found.cycles == len(rows)
    assert found.late == (ready - due > deadline).sum() > 0
    assert found.overrun == (done - due > period).sum() > 0
    assert found.skipped == 5 + 2


def test_a_table_counts_into_the_fields_of_a_ring() -> None:
    arrays = [np.zeros(shape, dtype) for _, dtype, shape in FIELDS]
    table = TimingTable(10**6, times=arrays[0], totals=arrays[1])
    assert not any(array.any() for array in arrays)  # the rehearsal counts nothing
    for row in cycles(10):
        table.add(*map(int, row))
    before = [array.copy() for array in arrays]
    for row in cycles(25):
        table.add(*map(int, row))
    last = Timing.of(*arrays, before=(before[0], before[1]))
    assert last.cycles == last.wake.count == 25
    assert Timing.of(*arrays).cycles == 35


def test_a_timing_is_plain_numbers_for_json() -> None:
    table = TimingTable(10**6)
    table.add(0, 12_000, 13_000, 95_000, 96_000)
    found = table.timing().as_dict()
    assert set(found) == {*TOTALS, *(f"{name}_us" for name in TIMES)}
    assert found["latency_us"] is None
    assert found["wake_us"]["max"] == 12.0
    assert found["ready_us"]["count"] == 1
